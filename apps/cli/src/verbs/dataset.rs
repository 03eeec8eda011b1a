//! `dataset`: a corpus to train on.

use anyhow::Result;
use deeptree_dataset::{CorpusPlan, build};
use deeptree_graph::Seed;
use deeptree_growth::{GrowError, grow};
use serde_json::json;

use super::presets;
use crate::args::{self, Args};
use crate::report;

/// Why a tree cannot go into a corpus.
#[derive(Debug)]
enum CutOff {
    Grow(GrowError),
    Budget,
}

impl From<GrowError> for CutOff {
    fn from(error: GrowError) -> Self {
        Self::Grow(error)
    }
}

impl std::fmt::Display for CutOff {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Grow(error) => error.fmt(f),
            Self::Budget => f.write_str("it hit the node budget; a corpus holds whole trees only"),
        }
    }
}

impl std::error::Error for CutOff {}

pub(crate) fn run(args: &Args, verb: &args::Dataset) -> Result<()> {
    let species = presets(&verb.species)?;
    let names = species.iter().map(|species| species.name.clone()).collect();
    let plan = CorpusPlan::new(names, verb.trees, Seed(verb.seed), verb.profile.name());
    let bar = report::bar(args, u64::from(plan.trees) * species.len() as u64, "trees");
    let built = build(
        &plan,
        &verb.output,
        |name, seed| {
            let preset = species.iter().find(|species| species.name == name);
            let preset = preset.unwrap_or(&species[0]);
            let grown = grow(name, preset.parameters(verb.profile), seed)?;
            if grown.hit_budget { Err(CutOff::Budget) } else { Ok(grown.tree) }
        },
        |progress| {
            bar.set_position(progress.trees_done);
            bar.set_message(progress.species.to_owned());
        },
    )?;
    bar.finish_and_clear();
    let text = format!(
        "{} trees of {} species in {}: {} shards written, {} there already",
        u64::from(plan.trees) * species.len() as u64,
        species.len(),
        verb.output.display(),
        built.written,
        built.kept
    );
    let figures = json!({
        "species": plan.species,
        "trees": plan.trees,
        "training_trees": plan.training_trees,
        "shards_written": built.written,
        "shards_kept": built.kept,
    });
    report::say(args, &figures, &text, false);
    Ok(())
}
