//! Surfaces of branch graphs.
//!
//! [`wood`] turns a tree into closed tubes, one along each Gravelius branch:
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
//! The same tree gives the same bits on every machine: no platform mathematics, no threads, no
//! draws.

#![forbid(unsafe_code)]

mod mesh;
mod options;
mod stations;
mod tube;
mod wood;

pub use mesh::{Mesh, Tube};
pub use options::{MAX_SIDES, WoodOptions, WoodOptionsError};
pub use stations::{MIN_EDGE, MIN_RADIUS};
pub use wood::wood;
