//! Universal Scene Description: text (`.usda`) with pictures beside it, or everything in one
//! package (`.usdz`).
//!
//! The tree is an `Xform` and the default prim: below it the wood as a `Mesh`, each kind of leaf
//! as a `PointInstancer` of its blade, and the materials as `UsdPreviewSurface`.
//!
//! # Source
//!
//! OpenUSD: UsdGeom and UsdShade schemas, `UsdPreviewSurface` proposal 2.6, `usdz` file format
//! specification 1.3 (stored, the contents of each file at a multiple of 64 bytes).

mod materials;
mod stage;
mod text;

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use deeptree_graph::TreeInfo;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::atomic::{WriteError, write_atomically};
use crate::beside::{Beside, NameError, slug};
use crate::images::{self, ImageError};
use crate::subject::Subject;
use materials::Picture;

/// Where the contents of files in a package begin: at multiples of so many bytes.
const ALIGNMENT: u16 = 64;

/// Why a USD file was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UsdError {
    /// Files beside it cannot be named after it.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A picture of a material is not sound.
    #[error("the material '{material}' cannot be written")]
    Image {
        /// The name of the material.
        material: String,
        /// What is wrong with the picture.
        source: ImageError,
    },
    /// A file was not written.
    #[error(transparent)]
    File(#[from] WriteError),
    /// The package could not be written.
    #[error("the package was not written; above 4 GiB, take .usda or a coarser level of detail")]
    Package(#[from] zip::result::ZipError),
    /// The output failed.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Writes a tree as `.usda`, and its pictures as PNG beside it, named after it. Each file appears
/// whole or not at all, the `.usda` last.
///
/// # Errors
///
/// When the name is no UTF-8, a picture is not sound, or a file cannot be written.
pub fn save<'a>(
    subject: impl Into<Subject<'a>>,
    info: &TreeInfo,
    path: &Path,
) -> Result<(), UsdError> {
    let subject = subject.into();
    let beside = Beside::new(path)?;
    for picture in materials::pictures(subject) {
        let png = encode(&picture)?;
        let place = beside.path(&beside.picture(&picture.name));
        write_atomically(&place, |out| out.write_all(&png))?;
    }
    let file = |name: &str| format!("./{}", beside.picture(name));
    write_atomically(path, |out| stage::write(subject, info, &file, out))?;
    Ok(())
}

/// Writes a tree as a `.usdz` package. The same tree gives the same bytes.
///
/// # Errors
///
/// When a picture is not sound, or the output fails.
pub fn write_usdz<'a>(
    subject: impl Into<Subject<'a>>,
    info: &TreeInfo,
    out: &mut (impl Write + Seek),
) -> Result<(), UsdError> {
    let subject = subject.into();
    let mut package = ZipWriter::new(out);
    let stored = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .with_alignment(ALIGNMENT);
    let file = |name: &str| format!("textures/{}.png", slug(name));
    // The first file is the one that is opened.
    package.start_file("tree.usda", stored)?;
    let mut text = BufWriter::with_capacity(1 << 16, &mut package);
    stage::write(subject, info, &file, &mut text)?;
    text.flush()?;
    drop(text);
    for picture in materials::pictures(subject) {
        package.start_file(file(&picture.name), stored)?;
        package.write_all(&encode(&picture)?)?;
    }
    package.finish()?.flush()?;
    Ok(())
}

fn encode(picture: &Picture<'_>) -> Result<Vec<u8>, UsdError> {
    images::png(picture.image)
        .map_err(|source| UsdError::Image { material: picture.material.to_owned(), source })
}
