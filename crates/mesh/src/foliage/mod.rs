//! Dressing a tree: leaves on its shoots, and what leaves and bark are made of.

mod bare;
mod blade;
mod habit;
mod shoots;

pub use habit::Phyllotaxis;

use deeptree_graph::BranchGraph;

use crate::dressed::{Dressed, Foliage, Leaf};
use crate::look::{Look, LookError, Season};
use crate::material::Material;
use crate::mesh::Mesh;
use crate::texture::atlas::{Card, cards};
use crate::texture::leaf::Ink;
use crate::texture::noise::Noise;
use crate::texture::{bark, leaf};
use habit::{Habit, habit};
use shoots::{KINDS, shoots};

/// Share of the light a leaf does not mirror that comes out below: of green light, a leaf reflects
/// and transmits about as much (Jacquemoud and Baret 1990, "PROSPECT").
const TRANSLUCENCY: f32 = 0.45;

/// Leaves that have lost their chlorophyll to sickness, linear.
const SALLOW: [f32; 3] = [0.46, 0.40, 0.07];

/// What trees of one species look like: their materials, painted once for as many as there are.
#[derive(Debug)]
pub struct Wardrobe {
    species: String,
    look: Look,
    habit: Habit,
    bark: Material,
    /// None where wood alone is looked at.
    shoots: Option<Shoots>,
}

/// What the shoots of a species look like.
#[derive(Debug)]
struct Shoots {
    /// The leaves; none on bare twigs.
    cards: Vec<Card>,
    noise: Noise,
    material: Material,
}

/// Gives a tree its leaves, and its leaves and wood their materials: see [`Wardrobe::dress`].
///
/// # Errors
///
/// When `look` does not pass [`Look::validate`].
pub fn dress(tree: &BranchGraph, wood: Mesh, look: &Look) -> Result<Dressed, LookError> {
    Ok(Wardrobe::new(&tree.info.species, look)?.dress(tree, wood, look.lod))
}

impl Wardrobe {
    /// Paints what trees of a species are made of, or those of `look.species`. Of a blend, such as `oak:0.7,willow:0.3`, the
    /// greatest share counts; an unknown species looks like the beech.
    ///
    /// # Errors
    ///
    /// When `look` does not pass [`Look::validate`].
    pub fn new(species: &str, look: &Look) -> Result<Self, LookError> {
        look.validate()?;
        let habit = habit(look.species.as_deref().unwrap_or(species));
        let bark = bark_material(&habit, look);
        let shoots = look.leaves.then(|| match habit.hanging(look.season) {
            0.0 => Shoots::bare(&habit, look),
            _ => Shoots::leafy(&habit, look),
        });
        Ok(Self { species: species.to_owned(), look: look.clone(), habit, bark, shoots })
    }

    /// Is it for this species and look? The level of detail does not matter.
    #[must_use]
    pub fn fits(&self, species: &str, look: &Look) -> bool {
        self.species == species && Look { lod: look.lod, ..self.look.clone() } == *look
    }

    /// Gives a tree its leaves, and its leaves and wood their materials.
    ///
    /// `wood` is the tree's surface by [`wood`](crate::wood()) or [`tubes`](crate::tubes()), meshed
    /// with a texture size of 1 m: that is what the pictures of bark show. `lod` is the level of
    /// detail of the leaves, as in [`Look::lod`].
    ///
    /// Leaves stand on *shoots*: twigs of a year, which the branch graph does not have. A
    /// [`Foliage`] is one kind of shoot with all its leaves, and its `leaves` are where such shoots
    /// stand: on the internodes next to the tips, in the species' phyllotaxis. What is drawn for a
    /// shoot is keyed by the tree's seed and the lineage of its node, so that pruning elsewhere
    /// changes none. In winter the shoots of all but evergreens are bare twigs. There is no foliage
    /// where the look wants none.
    #[must_use]
    pub fn dress(&self, tree: &BranchGraph, wood: Mesh, lod: u8) -> Dressed {
        let look = Look { lod, ..self.look.clone() };
        let foliage = self.shoots.as_ref().map(|shoots| shoots.foliage(tree, &self.habit, &look));
        Dressed { wood, bark: self.bark.clone(), foliage: foliage.unwrap_or_default() }
    }
}

fn bark_material(habit: &Habit, look: &Look) -> Material {
    let canvas = bark::paint(look.texture_size, &habit.bark, Noise::new(look.seed, 1));
    Material {
        name: format!("{} bark", habit.species),
        color: [1.0; 4],
        color_image: Some(canvas.color_image(false).into()),
        normal_image: Some(canvas.normal_image(true).into()),
        roughness: 1.0,
        roughness_image: Some(canvas.roughness_image().into()),
        translucency: 0.0,
        alpha_cutoff: None,
        double_sided: false,
    }
}

impl Shoots {
    fn bare(habit: &Habit, look: &Look) -> Self {
        let [red, green, blue] = habit.twig;
        let material = Material {
            name: format!("{} twigs", habit.species),
            color: [red, green, blue, 1.0],
            color_image: None,
            normal_image: None,
            roughness: 0.8,
            roughness_image: None,
            translucency: 0.0,
            alpha_cutoff: None,
            double_sided: false,
        };
        Self { cards: Vec::new(), noise: Noise::new(look.seed, 2), material }
    }

    fn leafy(habit: &Habit, look: &Look) -> Self {
        let noise = Noise::new(look.seed, 2);
        let cards = cards(habit.frond, noise);
        let canvas = leaf::paint(look.texture_size, &cards, &ink(habit, look), noise.other(7));
        let material = Material {
            name: format!("{} leaves", habit.species),
            color: [1.0; 4],
            color_image: Some(canvas.color_image(true).into()),
            normal_image: Some(canvas.normal_image(false).into()),
            roughness: 1.0,
            roughness_image: Some(canvas.roughness_image().into()),
            translucency: TRANSLUCENCY,
            alpha_cutoff: Some(0.5),
            double_sided: true,
        };
        Self { cards, noise, material }
    }

    fn foliage(&self, tree: &BranchGraph, habit: &Habit, look: &Look) -> Vec<Foliage> {
        let kind = |(kind, leaves): (usize, Vec<Leaf>)| {
            // Each kind shows every other card.
            let own: Vec<&Card> = self.cards.iter().skip(kind).step_by(KINDS).collect();
            let (noise, coarse) = (self.noise.other(20 + kind as u32), look.lod > 0);
            let woody = own.is_empty();
            let blade = if woody {
                bare::blade(habit, noise, coarse)
            } else {
                blade::blade(habit, &own, noise, coarse)
            };
            Foliage { blade, leaves, material: self.material.clone(), woody }
        };
        let kinds = shoots(tree, habit, look).into_iter().enumerate();
        kinds.filter(|(_, leaves)| !leaves.is_empty()).map(kind).collect()
    }
}

/// What leaves are painted with in a season.
fn ink(habit: &Habit, look: &Look) -> Ink {
    let tints = match look.season {
        Season::Spring => habit.spring,
        _ => habit.summer,
    };
    let (turning, turned) = match look.season {
        Season::Autumn if !habit.evergreen => (1.0, habit.autumn),
        // What ails yellows.
        _ => (0.8 * (1.0 - look.health), [SALLOW; 2]),
    };
    Ink {
        blade: tints.blade,
        mottle: tints.mottle,
        vein: tints.vein,
        turned,
        turning,
        dry: 0.35 * (1.0 - look.health),
        twig: habit.twig,
        roughness: habit.leaf_roughness,
    }
}
