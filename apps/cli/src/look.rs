//! What a tree is asked to look like: leaves, season, textures.

use std::sync::{Arc, Mutex, PoisonError};

use deeptree_graph::BranchGraph;
use deeptree_mesh::{Dressed, Look, LookError, Mesh, Season, Wardrobe};

use crate::args::UsageError;

/// Leaves and textures: for .glb, .gltf, .obj, .ply, .usda and .usdz.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Leaves and textures")]
pub(crate) struct LookArgs {
    /// Leaves or needles, and textures of leaves and bark, of the tree's own species or of another,
    /// such as --leaves=oak for a tree of a table [default: wood without a texture].
    #[arg(long, value_name = "SPECIES", num_args = 0..=1, require_equals = true)]
    leaves: Option<Option<String>>,
    /// Leaves and textures of a season; in winter all but pines are bare [default: summer].
    #[arg(long, value_name = "NAME", value_parser = season)]
    season: Option<Season>,
    /// How well the tree is, from 0 (dying: bare, yellow and dry) to 1; with leaves [default: 1].
    #[arg(long, value_name = "0..1", allow_negative_numbers = true)]
    health: Option<f32>,
    /// Leaf area as a multiple of the species' own, above 0 to 4; with leaves [default: 1].
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    leaf_density: Option<f32>,
    /// Side of the textures in pixels, 256 to 2048; without leaves, of the bark alone
    /// [default: 1024].
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true)]
    texture_size: Option<u32>,
}

impl LookArgs {
    /// What is asked for at a level of detail; none where wood alone is.
    ///
    /// # Errors
    ///
    /// When a number is out of its range.
    pub(crate) fn look(&self, lod: u8) -> Result<Option<Look>, UsageError> {
        let leaves = self.leaves.is_some()
            || self.season.is_some()
            || self.health.is_some()
            || self.leaf_density.is_some();
        let usual = Look::default();
        let look = Look {
            leaves,
            season: self.season.unwrap_or_default(),
            health: self.health.unwrap_or(usual.health),
            density: self.leaf_density.unwrap_or(usual.density),
            texture_size: self.texture_size.unwrap_or(usual.texture_size),
            lod,
            species: self.leaves.clone().flatten(),
            ..usual
        };
        look.validate().map_err(|error| UsageError(error.to_string()))?;
        Ok((leaves || self.texture_size.is_some()).then_some(look))
    }

    /// What is asked for of a picture, in which bark has a texture in any case.
    ///
    /// # Errors
    ///
    /// When a number is out of its range.
    pub(crate) fn pictured(&self, lod: u8) -> Result<Look, UsageError> {
        Ok(self.look(lod)?.unwrap_or(Look { leaves: false, lod, ..Look::default() }))
    }
}

/// So many wardrobes are kept: one of each species, each of about 20 MB.
const MOST: usize = 8;

/// Dresses a tree. The pictures of species and looks are kept: a batch paints them once.
///
/// # Errors
///
/// When a number of the look is out of its range.
pub(crate) fn dressed(tree: &BranchGraph, wood: Mesh, look: &Look) -> Result<Dressed, LookError> {
    Ok(wardrobe(&tree.info.species, look)?.dress(tree, wood, look.lod))
}

fn wardrobe(species: &str, look: &Look) -> Result<Arc<Wardrobe>, LookError> {
    static KEPT: Mutex<Vec<Arc<Wardrobe>>> = Mutex::new(Vec::new());
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = kept.iter().find(|wardrobe| wardrobe.fits(species, look)) {
        return Ok(Arc::clone(found));
    }
    let painted = Arc::new(Wardrobe::new(species, look)?);
    if kept.len() == MOST {
        kept.remove(0);
    }
    kept.push(Arc::clone(&painted));
    Ok(painted)
}

fn season(text: &str) -> Result<Season, String> {
    let named = |season: &Season| season.name() == text;
    Season::ALL
        .into_iter()
        .find(named)
        .ok_or_else(|| "the seasons are spring, summer, autumn and winter".to_owned())
}
