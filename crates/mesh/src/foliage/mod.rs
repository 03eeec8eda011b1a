//! Dressing a tree: leaves on its shoots, and what leaves and bark are made of.

mod blade;
mod habit;
mod shoots;

pub use habit::Phyllotaxis;

use deeptree_graph::BranchGraph;

use crate::dressed::{Dressed, Foliage};
use crate::look::{Look, LookError, Season};
use crate::material::Material;
use crate::mesh::Mesh;
use crate::texture::atlas::cards;
use crate::texture::leaf::Ink;
use crate::texture::noise::Noise;
use crate::texture::{bark, leaf};
use habit::{Habit, habit};

/// Share of the light a leaf does not mirror that comes out below: of green light, a leaf reflects
/// and transmits about as much (Jacquemoud and Baret 1990, "PROSPECT").
const TRANSLUCENCY: f32 = 0.45;

/// Gives a tree its leaves, and its leaves and wood their materials.
///
/// `wood` is the tree's surface by [`wood`](crate::wood()) or [`tubes`](crate::tubes()), meshed with
/// a texture size of 1 m: that is what the pictures of bark show. The species is that of
/// `tree.info`; of a blend, that of its greatest share; of an unknown one, the beech.
///
/// Leaves stand on *shoots*: twigs of a year, which the branch graph does not have. A [`Foliage`] is
/// one shoot with all its leaves, and its `leaves` are where shoots stand: on the internodes next to
/// the tips, in the species' phyllotaxis. What is drawn for a shoot is keyed by the tree's seed and
/// the lineage of its node, so that pruning elsewhere changes none. No foliage where `look` wants
/// none, and none in winter but of evergreens.
///
/// # Errors
///
/// When `look` does not pass [`Look::validate`].
pub fn dress(tree: &BranchGraph, wood: Mesh, look: &Look) -> Result<Dressed, LookError> {
    look.validate()?;
    let habit = habit(&tree.info.species);
    let bark = bark_material(&habit, look);
    let bare = !look.leaves || habit.hanging(look.season) <= 0.0;
    let foliage = if bare { Vec::new() } else { foliage(tree, &habit, look) };
    Ok(Dressed { wood, bark, foliage })
}

fn bark_material(habit: &Habit, look: &Look) -> Material {
    let canvas = bark::paint(look.texture_size, &habit.bark, Noise::new(look.seed, 1));
    Material {
        name: format!("{} bark", habit.species),
        color: [1.0; 4],
        color_image: Some(canvas.color_image(false)),
        normal_image: Some(canvas.normal_image(true)),
        roughness: 1.0,
        roughness_image: Some(canvas.roughness_image()),
        translucency: 0.0,
        alpha_cutoff: None,
        double_sided: false,
    }
}

fn foliage(tree: &BranchGraph, habit: &Habit, look: &Look) -> Vec<Foliage> {
    let noise = Noise::new(look.seed, 2);
    let cards = cards(habit.frond, noise);
    let canvas = leaf::paint(look.texture_size, &cards, &ink(habit, look), noise.other(7));
    let material = Material {
        name: format!("{} leaves", habit.species),
        color: [1.0; 4],
        color_image: Some(canvas.color_image(true)),
        normal_image: Some(canvas.normal_image(false)),
        roughness: 1.0,
        roughness_image: Some(canvas.roughness_image()),
        translucency: TRANSLUCENCY,
        alpha_cutoff: Some(0.5),
        double_sided: true,
    };
    let blade = blade::blade(habit, &cards, noise.other(8), look.lod > 0);
    vec![Foliage { blade, leaves: shoots::shoots(tree, habit, look), material }]
}

/// What leaves are painted with in a season.
fn ink(habit: &Habit, look: &Look) -> Ink {
    let tints = match look.season {
        Season::Spring => habit.spring,
        _ => habit.summer,
    };
    let turning = match look.season {
        Season::Autumn if !habit.evergreen => 1.0,
        _ => 0.8 * (1.0 - look.health),
    };
    Ink {
        blade: tints.blade,
        mottle: tints.mottle,
        vein: tints.vein,
        turned: habit.autumn[0],
        turning,
        dry: 0.35 * (1.0 - look.health),
        twig: habit.twig,
        roughness: habit.leaf_roughness,
    }
}
