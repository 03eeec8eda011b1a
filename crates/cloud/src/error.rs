//! Why a cloud cannot be read.

use std::io;
use std::path::PathBuf;

/// Why a cloud cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadCloudError {
    #[error("cannot open {}", path.display())]
    Open { path: PathBuf, source: io::Error },
    #[error("cannot read the points")]
    Read(#[from] io::Error),
    #[error("there are no points in it")]
    Empty,
    #[error("line {line} is not text; is this a binary file with the name of a text file?")]
    NotText { line: u64 },
    #[error("line {line} is longer than {} kB; a cloud has one point a line", most >> 10)]
    LongLine { line: u64, most: usize },
    #[error("line {line} is no point: three numbers or more are wanted, not `{text}`")]
    Row { line: u64, text: String },
    #[error(
        "line {line} has decimal commas and other separators too; write decimal points instead"
    )]
    DecimalComma { line: u64 },
    #[error("this is no readable PLY file")]
    Ply(#[from] crate::ply::PlyError),
    #[error("this is no readable LAS file")]
    Las(#[from] crate::las::LasError),
    #[cfg(feature = "parquet")]
    #[error("this is no Parquet table of points")]
    Table(#[from] crate::table::TableError),
    #[error("this build reads no Parquet tables")]
    NoParquet,
    #[error("more points than 2³² cannot be held; read with a limit")]
    TooMany,
}
