//! `generate`: trees from the networks.

use std::time::{Duration, Instant};

use anyhow::Result;
use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::Seed;
use deeptree_infer::{Model, Predictor};
use serde_json::json;

use super::unknown_species;
use crate::args::{self, Args};
use crate::batch::{self, Made};
use crate::output::{Target, is_stdout};
use crate::report;

pub(crate) fn run(args: &Args, verb: &args::Generate) -> Result<()> {
    let args::Which { species, seed, count, threads, .. } = &verb.which;
    let count = u64::from(*count);
    let model = verb.model.load()?;
    verb.model.workspace()?;
    if !model.species().contains(species) {
        return Err(unknown_species(species, model.species()).into());
    }
    let mut target = Target::new(&verb.out.output, verb.out.format, count, verb.out.lod)?;
    target.model = Some(model.hash());
    // A bad age or gravitropism is told before anything is made.
    deeptree_generate::germ(&model, &request(verb, *seed))?;

    let mut seen = Seen::default();
    batch::on_threads(*threads, || {
        target.write(|take| make(args, verb, &model, *seed, count, &mut seen, take))
    })?;
    seen.say(args, &verb.out);
    Ok(())
}

fn make(
    args: &Args,
    verb: &args::Generate,
    model: &Model,
    first: u64,
    count: u64,
    seen: &mut Seen,
    take: &mut dyn FnMut(&Made) -> Result<()>,
) -> Result<()> {
    let limits = Limits { budget: verb.budget as usize, batch: verb.batch as usize };
    let bar = report::bar(args, count, &verb.which.species);
    batch::make(
        first,
        count,
        || verb.model.workspace(),
        |work, seed| {
            let start = Instant::now();
            let grown = generate(model, &request(verb, seed), limits, work)?;
            let made = Made {
                seed,
                tree: grown.tree,
                germ: Some(grown.germ),
                hit_budget: grown.hit_budget,
            };
            Ok((made, start.elapsed()))
        },
        |(made, took)| {
            seen.add(&made, took);
            bar.inc(1);
            take(&made)
        },
    )?;
    bar.finish_and_clear();
    Ok(())
}

fn request(verb: &args::Generate, seed: u64) -> Request {
    Request {
        species: verb.which.species.clone(),
        seed: Seed(seed),
        age: verb.which.age,
        gravitropism: verb.which.gravitropism,
    }
}

/// What was made, for the report at the end.
#[derive(Default)]
pub(super) struct Seen {
    trees: u64,
    nodes: u64,
    branches: u64,
    took: Duration,
    hit_budget: Vec<u64>,
    first: Option<serde_json::Value>,
}

impl Seen {
    pub(super) fn add(&mut self, made: &Made, took: Duration) {
        let figures = report::tree_figures(&made.tree);
        self.trees += 1;
        self.nodes += made.tree.len() as u64;
        self.branches += figures["branches"].as_u64().unwrap_or_default();
        self.took += took;
        if made.hit_budget {
            self.hit_budget.push(made.seed);
        }
        self.first.get_or_insert(figures);
    }

    pub(super) fn say(self, args: &Args, out: &args::Out) {
        let Some(first) = self.first else { return };
        let milliseconds = self.took.as_secs_f64() * 1e3 / self.trees as f64;
        let stdout_taken = is_stdout(&out.output);
        if !args.quiet && !self.hit_budget.is_empty() {
            eprintln!(
                "deeptree: {} of {} trees hit the node budget and are cut off (seeds {:?})",
                self.hit_budget.len(),
                self.trees,
                &self.hit_budget[..self.hit_budget.len().min(5)]
            );
        }
        let (text, mut figures) = if self.trees == 1 {
            let text = format!(
                "{}; grown in {milliseconds:.1} ms → {}",
                report::tree_text(&first),
                out.output.display()
            );
            (text, first)
        } else {
            let nodes = self.nodes as f64 / self.trees as f64;
            let branches = self.branches as f64 / self.trees as f64;
            let text = format!(
                "{} trees, {nodes:.0} nodes and {branches:.0} branches each, {milliseconds:.1} ms each \
                 on one thread → {}",
                self.trees,
                out.output.display()
            );
            (text, json!({ "trees": self.trees, "nodes": nodes, "branches": branches }))
        };
        figures["milliseconds_a_tree"] = json!(milliseconds);
        figures["hit_budget"] = json!(self.hit_budget);
        report::say(args, &figures, &text, stdout_taken);
    }
}
