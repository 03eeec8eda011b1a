//! Clouds in files.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::error::ReadCloudError;
use crate::gather::{ReadOptions, Reading};
use crate::{ply, xyz};

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
        _ => xyz::read(file, options),
    }
}
