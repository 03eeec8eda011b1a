//! What stands around a tree: obstacles, the sky between them, and volumes that growth is kept in.
//!
//! | what | type |
//! |---|---|
//! | obstacles: boxes and triangle meshes, from a TOML file | [`Scene`] |
//! | where growth is kept in: a cone, a cube, a ring or a closed mesh | [`Volume`] |
//! | both, as a tree meets them | [`Environment`] |
//! | both, as growth by network asks them | [`Site`] |
//!
//! Metres, y up, the foot of the tree at the origin. All answers are the same bits on every
//! machine: sums and products of IEEE 754 numbers in a fixed order, and `libm` for the rest.

#![forbid(unsafe_code)]

mod boxes;
mod environment;
mod error;
mod files;
mod guard;
mod index;
mod mesh;
mod random;
mod scene;
mod site;
mod sky;
mod text;
mod triangle;
mod volume;
mod voxels;

pub use boxes::{BoxProblem, BoxShape, Cuboid};
pub use environment::Environment;
pub use error::SceneError;
pub use guard::Guard;
pub use mesh::{MAX_FACES, MeshError, TriangleMesh};
pub use scene::{FOOT, Scene, SceneMesh};
pub use site::Site;
pub use sky::{SKY_RAYS, Sky};
pub use volume::Volume;
