//! glTF 2.0: binary (`.glb`) with everything in one file, or `.gltf` with its numbers and pictures
//! in files beside it.
//!
//! A [`Document`] is made of a [`Subject`](crate::Subject) and written once. The numbers of the
//! geometry are not copied for that: they go from where they are into the output.
//!
//! ```
//! use deeptree_export::gltf::{Document, Options};
//! use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
//! use deeptree_mesh::{WoodOptions, wood};
//!
//! let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
//! let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
//! let edge = ChildSignature { rotation: upright, thickness: 0.1, length: 2.0 };
//! let mesh = wood(&BranchGraph::new(info.clone(), Vec3::ZERO, edge), &WoodOptions::default());
//! let mut file = Vec::new();
//! Document::new((&mesh).into(), &info, Options::default())?.write_glb(&mut file)?;
//! assert!(file.starts_with(b"glTF"));
//! # Ok::<(), deeptree_export::gltf::GltfError>(())
//! ```
//!
//! # Source
//!
//! glTF 2.0 specification, Khronos Group, §3.6 (binary data), §3.7 (geometry), §3.9 (materials), §4
//! (container).

mod container;
mod document;
mod instances;
mod json;
mod levels;
mod materials;
mod parts;
mod save;
mod skin;
mod stand;

use std::io;

pub use document::{Document, Options};
pub use levels::{COVERAGE, COVERAGE_BEFORE_CARDS, Level};
pub use parts::Attributes;
pub use stand::Stand;

use crate::atomic::WriteError;
use crate::beside::NameError;
use crate::images::ImageError;

/// Why a glTF file was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GltfError {
    /// The format counts its bytes with 32 bits.
    #[error(
        "the file would have {bytes} bytes and GLB ends at 4294967295; \
         take a coarser level of detail, copies of leaves (instancing), or .gltf"
    )]
    TooLarge {
        /// How many bytes it would have had.
        bytes: u64,
    },
    /// A picture of a material is not sound.
    #[error("the material '{material}' cannot be written")]
    Image {
        /// The name of the material.
        material: String,
        /// What is wrong with the picture.
        source: ImageError,
    },
    /// Files beside it cannot be named after it.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A file was not written.
    #[error(transparent)]
    File(#[from] WriteError),
    /// The output failed.
    #[error(transparent)]
    Io(#[from] io::Error),
}
