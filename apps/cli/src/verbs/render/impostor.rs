//! Cards that stand in for a tree from afar.

use std::time::Instant;

use anyhow::{Result, bail};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_render::impostor;
use serde_json::json;

use super::{FileKind, beside, usage, write_image};
use crate::args::{self, Args, UsageError};
use crate::dressing::dressed;
use crate::report;

pub(super) fn run(
    args: &Args,
    verb: &args::Render,
    tree: &BranchGraph,
    count: u32,
    kind: FileKind,
) -> Result<()> {
    if kind == FileKind::Exr {
        bail!(UsageError("an impostor has an alpha and normals of 8 bits; name a .png".to_owned()));
    }
    let start = Instant::now();
    let height = verb.size.map_or(512, |[_, height]| height);
    let tree = dressed(tree, &verb.look.pictured(verb.lod)?)?;
    let cards = impostor(&tree, count, height, verb.spp, Seed(verb.seed)).map_err(usage)?;
    write_image(&verb.output, &cards.color)?;
    let normals = beside(&verb.output, "normal");
    write_image(&normals, &cards.normal)?;
    let seconds = start.elapsed().as_secs_f64();
    let corners: Vec<_> =
        cards.cards.iter().map(|card| card.corners.map(|p| p.to_array())).collect();
    let (width, height) = (cards.color.width, cards.color.height);
    let figures = json!({ "cards": corners, "size": [width, height], "seconds": seconds });
    let text = format!(
        "{count} cards on {width} × {height} pixels in {seconds:.1} s → {} and {}",
        verb.output.display(),
        normals.display()
    );
    report::say(args, &figures, &text, false);
    Ok(())
}
