//! Points as text, one a line: `.xyz`, `.txt`, `.csv`, `.asc`, `.pts`.
//!
//! Columns are separated by blanks, tabs, commas or semicolons, in any mixture. `#` and `//` start a
//! comment. A first line of names, in a comment or not, says which column is which (`x y z` and
//! those of [`Columns::NAMES`]; others are skipped); without one, the first three columns are the
//! place and the rest is skipped. A first line of one number is the count of points, as in `.pts`.

mod read;
mod tokens;
mod write;

#[cfg(doc)]
use crate::columns::Columns;

pub use read::read;
pub use write::write;

#[cfg(test)]
mod tests;
