//! Trees in the file formats of other programs.
//!
//! Meshes: [`glb`] (binary glTF 2.0), [`obj`] (Wavefront) and [`ply`] (Stanford). All writers take
//! any `Write` and buffer by themselves; [`write_atomically`] gives them a file that appears
//! under its name only when it is complete.
//!
//! Everything is in metres, y up, counter-clockwise from outside, as in memory.

#![forbid(unsafe_code)]

mod atomic;
pub mod glb;
mod numbers;
pub mod obj;
pub mod ply;
#[cfg(feature = "parquet")]
pub mod tables;

pub use atomic::{WriteError, write_atomically};
