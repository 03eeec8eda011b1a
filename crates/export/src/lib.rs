//! Trees in the file formats of other programs.
//!
//! Surfaces: [`gltf`] (glTF 2.0, binary and not), [`obj`] (Wavefront) and [`ply`] (Stanford). They
//! take a [`Subject`], which a bare mesh and a dressed tree are. Writers take any `Write` and
//! buffer by themselves; [`write_atomically`] gives them a file that appears under its name only
//! when it is complete.
//!
//! Everything is in metres, y up, counter-clockwise from outside, as in memory.

#![forbid(unsafe_code)]

mod atomic;
mod beside;
pub mod gltf;
mod images;
mod numbers;
pub mod obj;
pub mod ply;
mod subject;
mod surface;
#[cfg(feature = "parquet")]
pub mod tables;
mod unfolding;
pub mod usd;

pub use atomic::{Spool, WriteError, write_atomically};
pub use beside::NameError;
pub use images::ImageError;
pub use subject::Subject;
pub use unfolding::Unfolding;
