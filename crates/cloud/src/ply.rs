//! Stanford PLY: the vertices of an ascii or binary file as points.
//!
//! The element `vertex` has `x`, `y`, `z` and perhaps those of [`Columns::NAMES`], of any type and in
//! any order; a prefix `scalar_`, as `CloudCompare` writes it, does not count. Other properties, lists
//! and elements are skipped. A comment that says `y up` or `z up` is believed.

mod header;
mod read;
mod write;

#[cfg(doc)]
use crate::columns::Columns;

pub use header::PlyError;
pub use read::read;
pub use write::write;

#[cfg(test)]
mod tests;
