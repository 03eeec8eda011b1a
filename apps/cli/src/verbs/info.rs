//! `info`: what is in a file.

use std::path::Path;

use anyhow::{Context, Result};
use deeptree_dataset::Corpus;
use deeptree_eval::{Row, TreeMetrics};
use deeptree_infer::{Model, Predictor};
use serde_json::{Value, json};

use crate::args::{self, Args};
use crate::{input, output, report};

pub(crate) fn run(args: &Args, verb: &args::Info) -> Result<()> {
    let path = &verb.file;
    let (figures, text) = if path.is_dir() {
        corpus(path)?
    } else if path.extension().is_some_and(|extension| extension == "safetensors") {
        model(path)?
    } else {
        trees(verb)?
    };
    report::say(args, &figures, &text, false);
    Ok(())
}

/// A table of more trees than this is told in sums only.
const LISTED: usize = 8;

fn trees(verb: &args::Info) -> Result<(Value, String)> {
    let mut figures = Vec::new();
    let mut lines = Vec::new();
    let mut sums: Vec<Row> = Vec::new();
    input::read(&verb.file, &verb.model, |number, made| {
        let tree = &made.tree;
        if figures.len() < LISTED {
            let figure = report::tree_figures(tree);
            lines.push(format!("tree {number}: {}", report::tree_text(&figure)));
            figures.push(figure);
        }
        let known = sums.iter().position(|row| row.species == tree.info.species);
        let row = known.unwrap_or_else(|| {
            sums.push(Row::new(&tree.info.species, "file"));
            sums.len() - 1
        });
        sums[row].add(&TreeMetrics::of(tree), made.hit_budget);
        Ok(true)
    })?;
    if sums.iter().map(|row| row.trees).sum::<u64>() > LISTED as u64 {
        let text: Vec<String> = sums.iter().map(Row::text).collect();
        return Ok((json!({ "sums": sums }), text.join("").trim_end().to_owned()));
    }
    Ok((json!({ "trees": figures }), lines.join("\n")))
}

fn model(path: &Path) -> Result<(Value, String)> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let model =
        Model::from_bytes(&bytes).with_context(|| format!("{} is no model", path.display()))?;
    let roots: Vec<usize> = (0..model.species().len()).map(|s| model.roots(s).len()).collect();
    let figures = json!({
        "kind": model.kind().name(),
        "species": model.species(),
        "roots": roots,
        "weights": model.weight_count(),
        "bytes": bytes.len(),
        "hash": output::hex(model.hash()),
    });
    let text = format!(
        "model of kind {}: {} weights, {} bytes, hash {}\nspecies: {}\nroots to start from: {}",
        model.kind(),
        model.weight_count(),
        bytes.len(),
        output::hex(model.hash()),
        model.species().join(", "),
        roots.iter().sum::<usize>()
    );
    Ok((figures, text))
}

fn corpus(path: &Path) -> Result<(Value, String)> {
    let corpus = Corpus::open(path).with_context(|| format!("{} is no corpus", path.display()))?;
    let plan = corpus.plan();
    let hash = corpus.hash()?;
    let figures = json!({
        "species": plan.species,
        "trees": plan.trees,
        "training_trees": plan.training_trees,
        "first_seed": plan.first_seed,
        "profile": plan.profile,
        "ages": plan.ages,
        "gravitropisms": plan.gravitropisms,
        "hash": hash,
    });
    let text = format!(
        "corpus of {} trees of each of {} ({} for training), seeds from {}, profile {}, hash {hash}",
        plan.trees,
        plan.species.join(", "),
        plan.training_trees,
        plan.first_seed,
        plan.profile,
    );
    Ok((figures, text))
}
