//! Wavefront OBJ (`.obj`): text that every modelling program reads, with its materials in an `.mtl`
//! file beside it.
//!
//! # Source
//!
//! The physically based entries of `.mtl` (`Pr`, `norm`, `map_Pr`, and `map_Bump` for a normal map): the extension of the format that
//! Blender, Assimp and others read.

use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use deeptree_graph::TreeInfo;
use deeptree_mesh::{Image, Material};

use crate::atomic::{WriteError, write_atomically};
use crate::beside::{Beside, NameError, slug};
use crate::images::{self, ImageError, Use};
use crate::numbers::one_line;
use crate::subject::Subject;
use crate::surface::Surface;

/// Why an OBJ file or what stands beside it was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjError {
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
}

/// Writes a tree as Wavefront OBJ: `v`, `vt`, `vn` and triangles `f v/vt/vn`, one object for the
/// wood and one for each kind of leaf.
///
/// The comments at the top name the tree. Numbers have as many digits as it takes to read the same
/// floats again. No materials are named: [`save`] does, and writes them.
///
/// # Errors
///
/// When the output fails.
pub fn write<'a>(
    subject: impl Into<Subject<'a>>,
    info: &TreeInfo,
    out: &mut impl Write,
) -> io::Result<()> {
    write_text(subject.into(), info, None, out)
}

/// Writes a tree as `.obj`, its materials as `.mtl` and their pictures as PNG beside it, named after
/// it. Each of them appears whole or not at all, the `.obj` last.
///
/// # Errors
///
/// When the name is no UTF-8, or a file cannot be written.
pub fn save<'a>(
    subject: impl Into<Subject<'a>>,
    info: &TreeInfo,
    path: &Path,
) -> Result<(), ObjError> {
    let subject = subject.into();
    let beside = Beside::new(path)?;
    let mut text = format!("# DeepTree {}\n", env!("CARGO_PKG_VERSION"));
    for material in subject.materials() {
        let mut pictures = Vec::new();
        for (image, of) in [
            (&material.color_image, Use::Color),
            (&material.normal_image, Use::Normal),
            (&material.roughness_image, Use::Roughness),
        ] {
            let Some(image) = image else { continue };
            let name = beside.picture(&format!("{} {}", material.name, of.name()));
            save_picture(image, material, &beside.path(&name))?;
            pictures.push((of, name));
        }
        describe(material, &pictures, &mut text);
    }
    let library = beside.name(".mtl");
    write_atomically(&beside.path(&library), |out| out.write_all(text.as_bytes()))?;
    write_atomically(path, |out| write_text(subject, info, Some(&library), out))?;
    Ok(())
}

fn save_picture(image: &Image, material: &Material, path: &Path) -> Result<(), ObjError> {
    let png = images::png(image)
        .map_err(|source| ObjError::Image { material: material.name.clone(), source })?;
    Ok(write_atomically(path, |out| out.write_all(&png))?)
}

/// The entries of a material. A picture of four channels is the opacity, too, by its alpha.
fn describe(material: &Material, pictures: &[(Use, String)], text: &mut String) {
    let [red, green, blue, alpha] = material.color;
    let mut line = |entry: std::fmt::Arguments<'_>| {
        // A String takes all that is written to it.
        let _ = writeln!(text, "{entry}");
    };
    line(format_args!("\nnewmtl {}", slug(&material.name)));
    line(format_args!("Kd {red} {green} {blue}"));
    line(format_args!("d {alpha}\nillum 2\nKs 0 0 0"));
    line(format_args!("Pr {}\nPm 0", material.roughness));
    for (of, name) in pictures {
        match of {
            Use::Color => {
                line(format_args!("map_Kd {name}"));
                if material.alpha_cutoff.is_some() {
                    line(format_args!("map_d {name}"));
                }
            }
            // Some readers know the one entry, some the other.
            Use::Normal => line(format_args!("norm {name}\nmap_Bump {name}")),
            Use::Roughness => line(format_args!("map_Pr {name}")),
        }
    }
}

fn write_text(
    subject: Subject<'_>,
    info: &TreeInfo,
    library: Option<&str>,
    out: &mut impl Write,
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let species = one_line(&info.species);
    writeln!(out, "# DeepTree {}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "# species {species}")?;
    writeln!(out, "# age {}", info.age)?;
    writeln!(out, "# gravitropism {}", info.gravitropism)?;
    writeln!(out, "# seed {}", info.seed)?;
    writeln!(out, "# metres, y up")?;
    if let Some(library) = library {
        writeln!(out, "mtllib {library}")?;
    }
    let material = |material: &Material| library.map(|_| slug(&material.name));
    let mut first = 1;
    write_object("wood", material(subject.bark), subject.wood, &mut first, &mut out)?;
    for (name, kind) in subject.named_leaves() {
        write_object(&slug(&name), material(&kind.material), kind, &mut first, &mut out)?;
    }
    out.flush()
}

/// Writes an object whose vertices are counted from `first` on.
fn write_object(
    name: &str,
    material: Option<String>,
    surface: &impl Surface,
    first: &mut u64,
    out: &mut impl Write,
) -> io::Result<()> {
    writeln!(out, "o {name}")?;
    if let Some(material) = material {
        writeln!(out, "usemtl {material}")?;
    }
    for p in surface.positions() {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for [u, v] in surface.uvs() {
        writeln!(out, "vt {u} {v}")?;
    }
    for n in surface.normals() {
        writeln!(out, "vn {} {} {}", n.x, n.y, n.z)?;
    }
    for corners in surface.triangles() {
        let [a, b, c] = corners.map(|i| u64::from(i) + *first);
        writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
    }
    *first += surface.vertex_count() as u64;
    Ok(())
}
