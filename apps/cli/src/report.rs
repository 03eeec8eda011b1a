//! What a verb says on the terminal.

use std::time::Duration;

use deeptree_graph::BranchGraph;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use crate::args::Args;

/// A progress bar on a terminal; hidden where there is none, or nothing to say.
pub(crate) fn bar(args: &Args, len: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(len);
    if args.quiet || args.json || len < 2 {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    if let Ok(style) =
        ProgressStyle::with_template("{prefix:>12} {wide_bar} {pos}/{len} {eta} {msg}")
    {
        bar.set_style(style);
    }
    bar.set_prefix(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

/// Prints figures: as a line of JSON or as text, on standard error when standard output is taken.
pub(crate) fn say(args: &Args, figures: &Value, text: &str, stdout_taken: bool) {
    let line = match (args.json, args.quiet) {
        (true, _) => figures.to_string(),
        (false, true) => return,
        (false, false) => text.to_owned(),
    };
    if stdout_taken {
        eprintln!("{line}");
    } else {
        println!("{line}");
    }
}

/// What there is to say of one tree.
pub(crate) fn tree_figures(tree: &BranchGraph) -> Value {
    let height = tree.nodes().iter().map(|node| node.position.y).fold(0.0, f32::max);
    let radius =
        tree.nodes().iter().map(|node| node.position.x.hypot(node.position.z)).fold(0.0, f32::max);
    json!({
        "species": tree.info.species,
        "seed": tree.info.seed,
        "age": tree.info.age,
        "gravitropism": tree.info.gravitropism,
        "nodes": tree.len(),
        "branches": deeptree_graph::branches(tree).len(),
        "highest_order": tree.nodes().iter().map(|node| node.order).max(),
        "height_m": height,
        "crown_radius_m": radius,
        "trunk_radius_m": tree.root().thickness,
    })
}

/// The same in words.
pub(crate) fn tree_text(figures: &Value) -> String {
    let number = |key: &str| figures[key].as_f64().unwrap_or_default();
    format!(
        "{}, seed {}: {} nodes in {} branches, {:.1} m high, crown radius {:.1} m, trunk radius {:.2} m",
        figures["species"].as_str().unwrap_or_default(),
        figures["seed"],
        figures["nodes"],
        figures["branches"],
        number("height_m"),
        number("crown_radius_m"),
        number("trunk_radius_m"),
    )
}
