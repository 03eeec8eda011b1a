//! `info`: what is in a file.

use std::path::Path;

use anyhow::{Context, Result};
use deeptree_dataset::Corpus;
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

fn trees(verb: &args::Info) -> Result<(Value, String)> {
    let mut trees = Vec::new();
    let mut lines = Vec::new();
    input::read(&verb.file, &verb.model, |number, made| {
        let figures = report::tree_figures(&made.tree);
        lines.push(format!("tree {number}: {}", report::tree_text(&figures)));
        trees.push(figures);
        Ok(true)
    })?;
    Ok((json!({ "trees": trees }), lines.join("\n")))
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
