//! Trees that stand together, from a file or a folder of files.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use deeptree_graph::{BranchGraph, Vec3};
use deeptree_render::View;

use super::Ask;
use crate::args::{self, UsageError};
use crate::format::Format;
use crate::input;
use crate::stand::{MOST, NEAREST};

/// The trees of the input in their own spaces, with where their feet stand.
pub(super) fn read(
    verb: &args::Render,
    input: &Path,
    ask: &Ask,
) -> Result<Vec<(BranchGraph, Vec3)>> {
    if ask.views.contains(&View::Trunk) {
        bail!(UsageError("the view trunk is of one tree; name it with --tree".to_owned()));
    }
    let mut trees: Vec<(BranchGraph, Vec3)> = Vec::new();
    for file in files(input)? {
        input::read(&file, &verb.model, |_, made| {
            ensure!(trees.len() < MOST, "{} holds more than {MOST} trees", input.display());
            let foot = made.tree.node(0).base() * Vec3::new(1.0, 0.0, 1.0);
            trees.push((made.tree.moved(-foot), foot));
            Ok(true)
        })?;
    }
    ensure!(!trees.is_empty(), "{} holds no tree", input.display());
    if let Some((a, b)) = coinciding(&trees) {
        bail!(UsageError(format!(
            "{}: trees {a} and {b} stand at the same place, so it is no stand; choose one with --tree",
            input.display()
        )));
    }
    Ok(trees)
}

/// The file, or in a folder those that trees are read from, in the order of their names.
fn files(input: &Path) -> Result<Vec<PathBuf>> {
    if !input.is_dir() {
        return Ok(vec![input.to_owned()]);
    }
    let wrong = || format!("cannot read {}", input.display());
    let mut files = Vec::new();
    for entry in std::fs::read_dir(input).with_context(wrong)? {
        let path = entry.with_context(wrong)?.path();
        let format = Format::of_path(&path).ok().flatten();
        if path.is_file() && format.is_some_and(|format| !format.is_surface()) {
            files.push(path);
        }
    }
    ensure!(
        !files.is_empty(),
        "{} has no .tree .csv .parquet or .dtree in it, which trees are read from",
        input.display()
    );
    files.sort();
    Ok(files)
}

/// The numbers of two trees at the same place.
fn coinciding(trees: &[(BranchGraph, Vec3)]) -> Option<(usize, usize)> {
    trees.iter().enumerate().find_map(|(b, (_, at))| {
        let same = |(_, other): &(BranchGraph, Vec3)| other.distance(*at) < 0.5 * NEAREST;
        trees[..b].iter().position(same).map(|a| (a, b))
    })
}
