//! Parquet tables of points (feature `parquet`): of one cloud, or of several numbered ones such as the
//! scans of a corpus.
//!
//! | column | as written | unit |
//! |---|---|---|
//! | `tree` | `INT32`, unsigned; missing in a table of one cloud | – |
//! | `x`, `y`, `z` | `FLOAT`; `DOUBLE` where the cloud has an origin | m |
//! | `intensity` | `FLOAT` | – |
//! | `class`, `branch`, `order`, `node`, `station` | `INT32`, unsigned | – |
//!
//! Which coordinate points upwards is in the file's metadata under [`UP_KEY`]. Tables written
//! elsewhere may have the columns in any order and others besides, in any type of number; a null
//! coordinate is as good as NaN.

mod read;
mod write;

pub use read::{Scans, TableError, holds_points, read, read_bytes};
pub use write::{ScanWriter, WriteCloudError, write};

/// Key of the coordinate that points upwards, `y` or `z`, in the metadata of the file.
pub const UP_KEY: &str = "deeptree.up";

#[cfg(test)]
mod tests;
