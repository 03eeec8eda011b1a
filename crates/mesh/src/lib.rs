//! Surfaces of branch graphs.
//!
//! [`wood`] turns a tree into one closed surface, its branches growing out of one another:
//!
//! ```
//! use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
//! use deeptree_mesh::{WoodOptions, wood};
//!
//! let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
//! let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
//! let edge = ChildSignature { rotation: upright, thickness: 0.1, length: 2.0 };
//! let mesh = wood(&BranchGraph::new(info, Vec3::ZERO, edge), &WoodOptions::default());
//! assert!(mesh.volume() > 0.06 && mesh.volume() < 0.08);
//! ```
//!
//! [`tubes`] is the simple way: tubes pushed into one another.
//!
//! The same tree gives the same bits on every machine: no platform mathematics, no threads, and
//! draws that are keyed by the tree's seed.

#![forbid(unsafe_code)]

mod area;
mod budget;
mod circle;
mod dressed;
mod foliage;
mod internode;
mod look;
mod material;
mod mesh;
mod options;
mod texture;
mod tubes;
mod wood;

pub use budget::{BudgetError, within};
pub use dressed::{Blade, Dressed, Foliage, Leaf};
pub use foliage::{Phyllotaxis, Wardrobe, dress};
pub use internode::Internode;
pub use look::{Look, LookError, MAX_LEAF_DENSITY, SPECIES, Season, TEXTURE_SIZES};
pub use material::{Image, Material};
pub use mesh::{Mesh, Tube};
pub use options::{MAX_SIDES, WoodOptions, WoodOptionsError};
pub use tubes::{MIN_EDGE, MIN_RADIUS, tubes};
pub use wood::wood;
