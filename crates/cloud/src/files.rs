//! Clouds in files.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::error::ReadCloudError;
use crate::gather::{ReadOptions, Reading};
use crate::{las, ply, xyz};

/// Reads a cloud from a file, in the format that its first bytes tell.
///
/// # Errors
///
/// When the file cannot be opened, or its reader refuses it.
pub fn read_file(path: &Path, options: &ReadOptions) -> Result<Reading, ReadCloudError> {
    let open = |source| ReadCloudError::Open { path: path.to_owned(), source };
    let mut file = BufReader::with_capacity(1 << 16, File::open(path).map_err(open)?);
    match file.fill_buf()? {
        [b'p', b'l', b'y', b'\r' | b'\n', ..] => ply::read(file, options),
        [b'L', b'A', b'S', b'F', ..] => las::read(file, options),
        [b'P', b'A', b'R', b'1', ..] => table(file.into_inner(), options),
        _ => xyz::read(file, options),
    }
}

#[cfg(feature = "parquet")]
fn table(file: File, options: &ReadOptions) -> Result<Reading, ReadCloudError> {
    crate::table::read(file, options)
}

#[cfg(not(feature = "parquet"))]
fn table(_: File, _: &ReadOptions) -> Result<Reading, ReadCloudError> {
    Err(ReadCloudError::NoParquet)
}
