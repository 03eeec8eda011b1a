//! Laser scans of trees, simulated: rays cast from a scanner's places against the surface of a tree,
//! each point labelled with what it lies on.
//!
//! ```
//! use deeptree_graph::{BranchGraph, ChildSignature, Quat, Seed, TreeInfo, Vec3};
//! use deeptree_mesh::{WoodOptions, wood};
//! use deeptree_scan::{Pattern, Target, scan};
//!
//! let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
//! let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
//! let edge = ChildSignature { rotation: upright, thickness: 0.1, length: 2.0 };
//! let tree = BranchGraph::new(info, Vec3::ZERO, edge);
//! let target = Target::new(&tree, &wood(&tree, &WoodOptions::default()), &[]);
//! let cloud = scan(&target, &Pattern { points: Some(500), ..Pattern::paper() }, Seed(1));
//! assert_eq!(cloud.len(), 500);
//! ```
//!
//! Metres, y up, as the tree; [`deeptree_cloud::Cloud::with_up`] turns a cloud for a scanner's file.
//!
//! The same target, pattern and seed give the same bits on every machine and for any number of
//! threads: IEEE 754 arithmetic in a fixed order, `libm` for the rest, and draws that are keyed by
//! the seed and the number of the beam.

#![forbid(unsafe_code)]

mod beam;
mod cutout;
mod fans;
mod hierarchy;
mod pattern;
mod random_rays;
mod scanning;
mod target;
mod triangle;
mod window;

pub use pattern::{Kind, Pattern, PatternError};
pub use scanning::scan;
pub use target::Target;
