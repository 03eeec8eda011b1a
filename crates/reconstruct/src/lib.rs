//! From a point cloud to a branch graph, and how well the two agree.
//!
//! ```
//! use deeptree_graph::Vec3;
//! use deeptree_reconstruct::{Options, reconstruct};
//!
//! // A stem of 10 cm radius, seen from one side.
//! let at = |i: u16| {
//!     let (sin, cos) = (f32::from(i % 20) * 0.15).sin_cos();
//!     Vec3::new(7.0 + 0.1 * cos, f32::from(i / 20) * 0.02, 0.1 * sin - 3.0)
//! };
//! let cloud: Vec<Vec3> = (0..4000).map(at).collect();
//! let made = reconstruct(&cloud, &Options::default()).unwrap();
//! assert!(made.foot.distance(Vec3::new(7.0, 0.0, -3.0)) < 0.02);
//! assert!((made.tree.root().thickness - 0.1).abs() < 0.01);
//! ```
//!
//! Geometry says where wood is: limbs are traced along the shortest ways through the cloud to the
//! foot of the tree and straightened as much as wood of their thickness is straight, then what they
//! leave uncovered is traced from them; radii are those of circles around the axis where the points
//! show one, and follow the pipe model elsewhere. Networks say what points do not: of which species
//! the tree is, which twigs go on where their points end, which child of a fork its branch goes on
//! with, and, where that is asked for, what grows where the scanner saw nothing.
//!
//! The same cloud, options and model give the same bits on every machine.

#![forbid(unsafe_code)]

mod assemble;
mod circle;
mod complete;
mod figures;
pub mod fit;
mod foot;
mod forks;
mod kdtree;
mod levels;
mod links;
mod place;
mod prepare;
mod prior;
mod scaffold;
mod shape;
mod skeleton;
mod steps;
mod table;
mod thickness;
mod tips;
mod trace;
mod ways;

use deeptree_graph::{BranchGraph, Seed, Vec3};
use deeptree_infer::{Overflow, Predictor};
use deeptree_mesh::WoodOptions;

pub use figures::{BREAST_HEIGHT, Figures};
pub use fit::Fit;
pub use kdtree::KdTree;
pub use place::placed;
pub use prepare::MOST_POINTS;
pub use steps::reconstruct;
pub use table::write_cylinders;

/// Why no tree can be made of a cloud.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReconstructError {
    #[error("none of the cloud's {given} points has finite coordinates; a tree needs at least two")]
    NoPoints { given: usize },
    #[error("the cloud has points at one place only; a tree needs an extent")]
    OnePlace,
    #[error("the root is at {x}, {y}, {z}; give three finite numbers")]
    Root { x: f32, y: f32, z: f32 },
    #[error(
        "the root is {distance} m from the nearest point of the cloud, which is {side} m wide; give \
         a place at the foot of the stem, in the cloud's own coordinates"
    )]
    FarRoot { distance: f32, side: f32 },
    #[error("{what} is {value}; it must be a number above 0")]
    NotPositive { what: &'static str, value: f32 },
    #[error("the model knows no species '{name}'; it knows {}", known.join(", "))]
    UnknownSpecies { name: String, known: Vec<String> },
    #[error(transparent)]
    Overflow(#[from] Overflow),
}

/// How a cloud is read. The default is geometry alone.
#[derive(Clone)]
pub struct Options<'a> {
    /// Where the tree stands, in the cloud's frame; found when none is given.
    pub root: Option<Vec3>,
    /// Points this near to a branch need no branch of their own, in metres; 0.26 % of the cloud's
    /// longest side when none is given. Less gives more and finer branches.
    pub cover: Option<f32>,
    /// Points that are worked on at most; a cloud of more is thinned. Default [`MOST_POINTS`].
    pub most_points: usize,
    /// The networks that decide what the points leave open; none for geometry alone.
    pub prior: Option<&'a dyn Predictor>,
    /// The species that the networks take the tree for; the likeliest when none is given.
    pub species: Option<String>,
    /// Let the networks grow branches of which the scanner saw nothing, too.
    pub complete: bool,
    /// Let the networks that grow it hear the points around each node, if they have learned to.
    pub hear: bool,
    /// The seed of what is drawn.
    pub seed: Seed,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            root: None,
            cover: None,
            most_points: MOST_POINTS,
            prior: None,
            species: None,
            complete: false,
            hear: true,
            seed: Seed(0),
        }
    }
}

/// A tree made of a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The tree, its foot at the origin. Its species, age and gravitropism are what the networks took
    /// it for; without them the species has no name.
    pub tree: BranchGraph,
    /// Where the foot stands in the cloud's frame: add it to a position of the tree.
    pub foot: Vec3,
    /// Points that were worked on.
    pub points: usize,
    /// Points without finite coordinates.
    pub not_finite: usize,
    /// Points of the ground, by their voxels.
    pub ground: usize,
    /// Points, of those worked on, that no branch was made for: alone, or across too wide a gap.
    pub left_out: usize,
    /// Side of the voxels whose points were merged, in metres.
    pub voxel: f32,
    /// Nodes that the networks grew where no points are.
    pub completed: usize,
}

/// How reconstructed trees are meshed: as the points show them, without the flare at the foot and
/// the flutes that grown trees get.
#[must_use]
pub fn wood_options() -> WoodOptions {
    WoodOptions { foot_flare: 1.0, fluting: 0.0, ..WoodOptions::default() }
}
