//! The surfaces of trees as they are asked for, and their files.

pub(crate) mod stand;

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use deeptree_export::gltf::{self, Document, Level};
use deeptree_export::{Subject, Unfolding, obj, ply, usd, write_atomically};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_mesh::{Dressed, Mesh, WoodOptions, tubes, within, wood};
use deeptree_render::impostor;

use crate::args::{Attribute, Lods, MeshArgs, UsageError};
use crate::format::Format;
use crate::look::dressed;

/// The levels of detail that there are.
const LEVELS: [u8; 4] = [0, 1, 2, 3];

/// Height in pixels of an impostor's cards, several times that at which they are looked at, and
/// light paths a pixel.
const CARD_HEIGHT: u32 = 256;
const CARD_PATHS: u32 = 16;

/// What is to be seen of a tree.
pub(crate) enum Shape {
    Bare(Mesh),
    Dressed(Box<Dressed>),
}

impl Shape {
    /// A tree at a level of detail, as it is asked for.
    fn new(tree: &BranchGraph, args: &MeshArgs, lod: u8) -> Result<Self> {
        let wood = mesh(tree, args, lod)?;
        Ok(match args.look.look(lod)? {
            None => Self::Bare(wood),
            Some(look) => Self::Dressed(Box::new(dressed(tree, wood, &look)?)),
        })
    }

    /// Cards with pictures of it.
    fn impostor(&self, tree: &BranchGraph, cards: u32) -> Result<Self> {
        let bare;
        let dressed = match self {
            Self::Dressed(dressed) => &**dressed,
            Self::Bare(wood) => {
                let (wood, bark) = (wood.clone(), deeptree_render::plain_bark());
                bare = Dressed { wood, bark, foliage: Vec::new() };
                &bare
            }
        };
        let painted = impostor(dressed, cards, CARD_HEIGHT, CARD_PATHS, Seed(0))?;
        let internodes = dressed.wood.internodes.clone();
        Ok(Self::Dressed(Box::new(painted.into_dressed(&tree.info.species, internodes))))
    }

    fn subject(&self) -> Subject<'_> {
        match self {
            Self::Bare(mesh) => mesh.into(),
            Self::Dressed(dressed) => (&**dressed).into(),
        }
    }
}

/// Refuses what no file of this format can have, and what a stream cannot take: it has no place for
/// files beside it.
pub(crate) fn check(args: &MeshArgs, format: Format, stream: bool) -> Result<(), UsageError> {
    wood_options(args, args.lod)?;
    args.look.look(args.lod)?;
    if !format.is_surface() {
        return Ok(());
    }
    let extension = format.extension();
    let refused = |why: String| Err(UsageError(why));
    if args.animate_growth.is_some() && !format.is_gltf() {
        return refused(format!("--animate-growth is for .glb and .gltf, not for .{extension}"));
    }
    let package = match format {
        Format::Gltf => "glb",
        Format::Usda => "usdz",
        _ if args.lods.is_some() && (args.lods == Some(Lods::Files) || format != Format::Glb) => {
            "glb with --lods"
        }
        _ => return Ok(()),
    };
    if stream {
        return refused(format!(
            "a .{extension} file has others beside it; name a file with -o, or take .{package}"
        ));
    }
    Ok(())
}

/// Writes the surfaces of a tree to a file, or to several that belong together.
pub(crate) fn save(tree: &BranchGraph, args: &MeshArgs, format: Format, path: &Path) -> Result<()> {
    if is_stream(path) {
        write_atomically(path, |out| write(tree, args, format, out))?;
        return Ok(());
    }
    let Some(lods) = args.lods else {
        return save_shape(tree, &Shape::new(tree, args, args.lod)?, args, format, path);
    };
    if format.is_gltf() && lods == Lods::One {
        let shapes = shapes(tree, args)?;
        return save_document(with_levels(tree, &shapes, args)?, format, path);
    }
    if args.impostor.is_some() && format == Format::Ply {
        bail!(UsageError(
            "a .ply has no pictures; take .obj, .usda, .usdz or .glb for --impostor".into()
        ));
    }
    for lod in LEVELS {
        let shape = Shape::new(tree, args, lod)?;
        save_shape(tree, &shape, args, format, &level_path(path, &format!("lod{lod}")))?;
    }
    if let Some(cards) = args.impostor {
        let shape = Shape::new(tree, args, LEVELS[0])?.impostor(tree, cards)?;
        save_shape(tree, &shape, args, format, &level_path(path, "impostor"))?;
    }
    Ok(())
}

fn save_shape(
    tree: &BranchGraph,
    shape: &Shape,
    args: &MeshArgs,
    format: Format,
    path: &Path,
) -> Result<()> {
    let (subject, info) = (shape.subject(), &tree.info);
    match format {
        Format::Obj => obj::save(subject, info, path)?,
        Format::Usda => usd::save(subject, info, path)?,
        Format::Usdz => write_atomically(path, |out| usd::write_usdz(subject, info, out))?,
        Format::Ply => write_atomically(path, |out| ply::write(subject, info, out))?,
        _ => {
            let unfolding = args.animate_growth.map(|seconds| Unfolding::new(tree, seconds));
            let document = document(tree, subject, unfolding.as_ref(), args)?;
            return save_document(document, format, path);
        }
    }
    Ok(())
}

fn save_document(document: Document<'_>, format: Format, path: &Path) -> Result<()> {
    if format == Format::Gltf {
        document.save(path)?;
    } else {
        write_atomically(path, |out| document.write_glb(out))?;
    }
    Ok(())
}

/// Writes the surfaces of a tree to a stream.
pub(crate) fn write(
    tree: &BranchGraph,
    args: &MeshArgs,
    format: Format,
    out: &mut impl Write,
) -> Result<()> {
    check(args, format, true)?;
    let info = &tree.info;
    if args.lods.is_some() {
        let shapes = shapes(tree, args)?;
        return Ok(with_levels(tree, &shapes, args)?.write_glb(out)?);
    }
    let shape = Shape::new(tree, args, args.lod)?;
    let subject = shape.subject();
    match format {
        Format::Obj => obj::write(subject, info, out)?,
        Format::Ply => ply::write(subject, info, out)?,
        Format::Usdz => {
            // A package is written forwards and backwards.
            let mut bytes = Cursor::new(Vec::new());
            usd::write_usdz(subject, info, &mut bytes)?;
            out.write_all(bytes.get_ref())?;
        }
        _ => {
            let unfolding = args.animate_growth.map(|seconds| Unfolding::new(tree, seconds));
            document(tree, subject, unfolding.as_ref(), args)?.write_glb(out)?;
        }
    }
    Ok(())
}

fn document<'a>(
    tree: &BranchGraph,
    subject: Subject<'a>,
    unfolding: Option<&'a Unfolding>,
    args: &MeshArgs,
) -> Result<Document<'a>> {
    Ok(match unfolding {
        Some(unfolding) => Document::unfolding(subject, unfolding, &tree.info, options(args))?,
        None => Document::new(subject, &tree.info, options(args))?,
    })
}

/// A tree at all levels of detail that are asked for.
fn shapes(tree: &BranchGraph, args: &MeshArgs) -> Result<Vec<Shape>> {
    let wood = LEVELS.into_iter().map(|lod| Shape::new(tree, args, lod));
    let mut shapes = wood.collect::<Result<Vec<_>>>()?;
    if let Some(cards) = args.impostor {
        shapes.push(shapes[0].impostor(tree, cards)?);
    }
    Ok(shapes)
}

fn with_levels<'a>(
    tree: &BranchGraph,
    shapes: &'a [Shape],
    args: &MeshArgs,
) -> Result<Document<'a>> {
    Ok(Document::with_levels(&levels(shapes), &tree.info, options(args))?)
}

/// When each of the levels of detail is shown.
fn levels(shapes: &[Shape]) -> Vec<Level<'_>> {
    let mut coverage = gltf::COVERAGE.to_vec();
    if shapes.len() > coverage.len() {
        coverage.pop();
        coverage.extend(gltf::COVERAGE_BEFORE_CARDS);
    }
    let level = |(shape, coverage)| Level { subject: Shape::subject(shape), coverage };
    shapes.iter().zip(coverage).map(level).collect()
}

/// `tree.glb` at `lod2` is `tree_lod2.glb`.
fn level_path(path: &Path, level: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{level}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Is it something that is no file and has no folder, such as a pipe or a device?
pub(crate) fn is_stream(path: &Path) -> bool {
    path.metadata().is_ok_and(|old| !old.is_file() && !old.is_dir())
}

/// The options of wood that are asked for.
fn wood_options(args: &MeshArgs, lod: u8) -> Result<WoodOptions, UsageError> {
    let mut options = WoodOptions {
        bark: args.bark.unwrap_or(0.0),
        even_texels: args.even_texels,
        ..WoodOptions::lod(lod)
    };
    if args.as_scanned {
        let WoodOptions { foot_flare, fluting, .. } = deeptree_reconstruct::wood_options();
        (options.foot_flare, options.fluting) = (foot_flare, fluting);
    }
    options.validate().map_err(|error| UsageError(error.to_string()))?;
    Ok(options)
}

/// The wood of a tree as it is asked for.
fn mesh(tree: &BranchGraph, args: &MeshArgs, lod: u8) -> Result<Mesh> {
    let options = wood_options(args, lod)?;
    let make = if args.tubes { tubes } else { wood };
    Ok(match args.max_triangles {
        Some(most) => within(tree, most as usize, &options, make)?,
        None => make(tree, &options),
    })
}

fn options(args: &MeshArgs) -> gltf::Options {
    let has = |wanted| args.attributes.iter().any(|&one| one == wanted || one == Attribute::All);
    let attributes = gltf::Attributes {
        tangents: has(Attribute::Tangents),
        labels: has(Attribute::Labels),
        wind: has(Attribute::Wind),
    };
    gltf::Options { attributes, instancing: args.instancing }
}
