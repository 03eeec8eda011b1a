//! Universal Scene Description: text (`.usda`) with pictures beside it, or everything in one
//! package (`.usdz`).
//!
//! The tree is an `Xform` and the default prim: below it the wood as a `Mesh`, each kind of leaf
//! as a `PointInstancer` of its blade, and the materials as `UsdPreviewSurface`.
//!
//! # Source
//!
//! OpenUSD: UsdGeom and UsdShade schemas, `UsdPreviewSurface` specification 2.6.

mod materials;
mod package;
mod stage;
mod text;

use std::io::{self, Seek, Write};
use std::path::Path;

use deeptree_graph::TreeInfo;

use crate::atomic::{WriteError, write_atomically};
use crate::beside::{Beside, NameError, slug};
use crate::images::{self, ImageError};
use crate::subject::Subject;
use materials::Picture;
use package::Package;

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
/// When a picture is not sound, the package would pass the 4 GiB that the format can count, or the
/// output fails.
pub fn write_usdz<'a>(
    subject: impl Into<Subject<'a>>,
    info: &TreeInfo,
    out: &mut (impl Write + Seek),
) -> Result<(), UsdError> {
    let subject = subject.into();
    let mut package = Package::new(out)?;
    let file = |name: &str| format!("textures/{}.png", slug(name));
    // The first file is the one that is opened.
    package.add("tree.usda".to_owned(), |out| stage::write(subject, info, &file, out))?;
    for picture in materials::pictures(subject) {
        let png = encode(&picture)?;
        package.add(file(&picture.name), |out| out.write_all(&png))?;
    }
    Ok(package.finish()?)
}

fn encode(picture: &Picture<'_>) -> Result<Vec<u8>, UsdError> {
    images::png(picture.image)
        .map_err(|source| UsdError::Image { material: picture.material.to_owned(), source })
}
