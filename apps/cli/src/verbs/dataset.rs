//! `dataset`: a corpus to train on.

mod stands;

use anyhow::Result;
use deeptree_dataset::{BuildReport, Corpus, CorpusPlan, build, build_scans};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::{GrowError, grow_around, parameters};
use deeptree_mesh::{WoodOptions, wood};
use deeptree_scan::{Pattern, Target, scan};
use serde_json::json;

use super::presets;
use crate::args::{self, Args, UsageError};
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

/// Ranges that nothing can be drawn from, or nothing can grow at, are a wrong request.
fn check(plan: &CorpusPlan) -> Result<(), UsageError> {
    plan.check().map_err(|error| UsageError(error.to_string()))?;
    let ages = plan.ages.iter().flatten().flat_map(|span| [span.0 as f32, span.1 as f32]);
    let values = plan.gravitropisms.iter().flatten();
    let values = values.flat_map(|span| [span.0 as f32, span.1 as f32]);
    let ages = ages.map(|age| ("age", age));
    for (key, value) in ages.chain(values.map(|value| ("gravitropism", value))) {
        let row = parameters::find(key).map_or(Ok(()), |row| row.check(value));
        row.map_err(|error| UsageError(error.to_string()))?;
    }
    Ok(())
}

pub(crate) fn run(args: &Args, verb: &args::Dataset) -> Result<()> {
    if let Some(count) = verb.stands {
        return stands::run(args, verb, count);
    }
    let species = presets(&verb.species)?;
    let names = species.iter().map(|species| species.name.clone()).collect();
    let forms: Option<Vec<String>> =
        verb.form.as_ref().map(|list| list.split(',').map(|name| name.trim().to_owned()).collect());
    let trees = verb.scenes.unwrap_or(verb.trees);
    let trees = trees.saturating_mul(forms.as_ref().map_or(1, |forms| forms.len() as u32));
    let plan = CorpusPlan {
        ages: verb.ages.clone().map(|spans| spans.0),
        gravitropisms: verb.gravitropisms.clone().map(|spans| spans.0),
        scenes: verb.scenes.is_some(),
        forms: forms.clone(),
        ..CorpusPlan::new(names, trees, Seed(verb.seed), verb.profile.name())
    };
    check(&plan)?;
    let bar = report::bar(args, u64::from(plan.trees) * species.len() as u64, "trees");
    let built = build(
        &plan,
        &verb.output,
        |name, seed, priors, environment| {
            let preset = species.iter().find(|species| species.name == name);
            let preset = preset.unwrap_or(&species[0]);
            let mut parameters = preset.parameters(verb.profile).clone();
            parameters.age = priors.age.map_or(parameters.age, |age| age as f32);
            parameters.gravitropism = priors.gravitropism.unwrap_or(parameters.gravitropism);
            let grown = grow_around(name, &parameters, seed, environment)?;
            if grown.hit_budget { Err(CutOff::Budget) } else { Ok(grown.tree) }
        },
        |progress| {
            bar.set_position(progress.trees_done);
            bar.set_message(progress.species.to_owned());
        },
    )?;
    bar.finish_and_clear();
    let scanned = if verb.scans { Some(scans(args, verb)?) } else { None };
    let mut text = format!(
        "{} trees of {} species in {}: {} shards written, {} there already",
        u64::from(plan.trees) * species.len() as u64,
        species.len(),
        verb.output.display(),
        built.written,
        built.kept
    );
    if let Some(scanned) = &scanned {
        let (written, kept) = (scanned.written, scanned.kept);
        text.push_str(&format!("; tables of scans: {written} written, {kept} there already"));
    }
    let figures = json!({
        "species": plan.species,
        "trees": plan.trees,
        "training_trees": plan.training_trees,
        "scenes": plan.scenes,
        "forms": plan.forms,
        "shards_written": built.written,
        "shards_kept": built.kept,
        "scan_tables_written": scanned.map(|scanned| scanned.written),
        "scan_tables_kept": scanned.map(|scanned| scanned.kept),
    });
    report::say(args, &figures, &text, false);
    Ok(())
}

/// A scan of each tree after the paper, keyed by the tree's seed.
fn scans(args: &Args, verb: &args::Dataset) -> Result<BuildReport> {
    let corpus = Corpus::open(&verb.output)?;
    let plan = corpus.plan();
    let bar = report::bar(args, u64::from(plan.trees) * plan.species.len() as u64, "scans");
    let scan_one = |tree: &BranchGraph, seed: Seed| {
        let target = Target::new(tree, &wood(tree, &WoodOptions::default()), &[]);
        scan(&target, &Pattern::paper(), seed)
    };
    let built = build_scans(&corpus, scan_one, |progress| {
        bar.set_position(progress.trees_done);
        bar.set_message(progress.species.to_owned());
    })?;
    bar.finish_and_clear();
    Ok(built)
}
