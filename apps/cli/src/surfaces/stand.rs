//! The surfaces of trees that stand together, as one file.

use std::io::{Cursor, Read, Seek, Write};
use std::path::Path;

use anyhow::Result;
use deeptree_export::gltf::{GltfError, Stand};
use deeptree_export::write_atomically;
use rayon::prelude::*;

use super::{Shape, is_stream, levels, options, shapes};
use crate::args::{Lods, MeshArgs, UsageError};
use crate::batch::Made;
use crate::format::Format;

/// Refuses what a file of many trees cannot have.
pub(crate) fn check(args: &MeshArgs) -> Result<(), UsageError> {
    let refused = [
        (args.impostor.is_some(), "--impostor"),
        (args.animate_growth.is_some(), "--animate-growth"),
        (args.lods == Some(Lods::Files), "--lods=files"),
    ];
    match refused.iter().find(|(asked, _)| *asked) {
        Some((_, option)) => Err(UsageError(format!(
            "{option} is for one tree a file, not for a stand as one; name a folder with -o"
        ))),
        None => Ok(()),
    }
}

/// Writes the trees, each at its place, to a file and what belongs to it.
pub(crate) fn save(trees: &[Made], args: &MeshArgs, format: Format, path: &Path) -> Result<()> {
    if is_stream(path) {
        write_atomically(path, |out| write(trees, args, out))?;
        return Ok(());
    }
    let mut stand = Stand::beside(path, options(args))?;
    fill(&mut stand, trees, args, format)?;
    match format {
        Format::Gltf => stand.save(path)?,
        _ => stand.save_glb(path)?,
    }
    Ok(())
}

/// Writes the trees as .glb to a stream; what is written waits in memory.
pub(crate) fn write(trees: &[Made], args: &MeshArgs, out: &mut impl Write) -> Result<()> {
    let mut stand = Stand::new(Cursor::new(Vec::new()), options(args));
    fill(&mut stand, trees, args, Format::Glb)?;
    Ok(stand.write_glb(out)?)
}

/// Adds the trees; the surfaces of no more trees than there are threads are in memory at once.
fn fill<S: Read + Write + Seek>(
    stand: &mut Stand<S>,
    trees: &[Made],
    args: &MeshArgs,
    format: Format,
) -> Result<()> {
    let surfaces = |made: &Made| match args.lods {
        None => Ok(vec![Shape::new(&made.tree, args, args.lod)?]),
        Some(_) => shapes(&made.tree, args),
    };
    for some in trees.chunks(rayon::current_num_threads()) {
        let shapes: Vec<Result<Vec<Shape>>> = some.par_iter().map(surfaces).collect();
        for (made, shapes) in some.iter().zip(shapes) {
            stand.add(&levels(&shapes?), &made.tree.info, made.at)?;
            let bytes = stand.bytes();
            if format == Format::Glb && bytes > u64::from(u32::MAX) {
                // Not only when all trees are made.
                return Err(GltfError::TooLarge { bytes }.into());
            }
        }
    }
    Ok(())
}
