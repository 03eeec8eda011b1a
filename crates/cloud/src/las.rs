//! LAS 1.0 to 1.4 and its compressed form LAZ, the exchange formats of laser scanning.
//!
//! Of each point the place, intensity, classification and point source (as the station) are read,
//! and extra bytes named `branch`, `order` and `node`; colours, times and returns are skipped.
//! Written is LAS 1.4 with point format 6.
//!
//! # Source
//!
//! ASPRS, "LAS Specification 1.4 – R15" (2019).

mod extra;
mod header;
#[cfg(feature = "laz")]
mod packed;
mod read;
mod write;

use std::io;

pub use read::read;
pub use write::write;

/// Why a file is no LAS file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum LasError {
    #[error("it does not begin with `LASF`")]
    Magic,
    #[error("it ends within its header; is it cut off?")]
    CutOff,
    #[error("its header says what cannot be: {field} is {value}")]
    Header { field: &'static str, value: u64 },
    #[error("it is compressed, and this build reads uncompressed files only")]
    NoLaz,
    #[error("it is compressed in a way that is not known")]
    Packing,
    #[error("its compressed points are damaged")]
    Damaged,
}

/// Why no LAS file could be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteLasError {
    /// The output failed.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Compressed output was asked of a build that has none.
    #[error("this build writes no compressed files; write .las")]
    NoLaz,
    /// The compressor failed.
    #[error("the points cannot be compressed")]
    Packing,
}

/// User and number of the record that says how points are packed.
const LAZ_RECORD: (&[u8], u16) = (b"laszip encoded", 22204);
/// User and number of the record that names extra bytes.
const EXTRA_RECORD: (&[u8], u16) = (b"LASF_Spec", 4);

#[cfg(test)]
mod tests;
