//! What `generate` and `grow` share: many trees, made on all threads, written and summed up.

use std::time::Duration;

use anyhow::Result;
use deeptree_generate::Avoided;
use serde_json::{Value, json};

use super::render::preview;
use crate::args::{self, Args, UsageError};
use crate::batch::{self, Made};
use crate::output::{Target, is_stdout};
use crate::report;

/// Makes the trees that `which` asks for and writes them to the target.
pub(super) fn run<W>(
    args: &Args,
    species: &str,
    which: &args::Which,
    out: &args::Out,
    target: &Target,
    worker: impl Fn() -> Result<W> + Sync + Send,
    one: impl Fn(&mut W, u64) -> Result<Made> + Sync + Send,
) -> Result<()> {
    let count = u64::from(which.count);
    preview::check(out)?;
    let mut seen = Seen::default();
    let mut first = None;
    let bar = report::bar(args, count, species);
    batch::on_threads(which.threads, || {
        target.write(|take| {
            batch::make(which.seed, count, worker, one, |k, mut made, took| {
                // A file of its own numbers its tree 0.
                made.number = if target.folder { 0 } else { k as u32 };
                seen.add(&made, took);
                if k == 0 && out.preview.is_some() {
                    first = Some(made.tree.clone());
                }
                bar.inc(1);
                take(&made)
            })
        })
    })?;
    bar.finish_and_clear();
    if let Some(tree) = first {
        batch::on_threads(which.threads, || preview::take(out, &tree))?;
    }
    seen.say(args, out);
    Ok(())
}

/// Writes trees that were made together, in `took`, to the target.
pub(super) fn write(
    args: &Args,
    out: &args::Out,
    target: &Target,
    made: &[Made],
    took: Duration,
) -> Result<()> {
    let mut seen = Seen { together: true, ..Seen::default() };
    let share = took / made.len().max(1) as u32;
    made.iter().for_each(|made| seen.add(made, share));
    if target.stand {
        target.write_stand(made)?;
    } else {
        target.write(|take| {
            made.iter().try_for_each(|made| {
                let number = if target.folder { 0 } else { made.number };
                take(&Made { number, ..made.clone().placed() })
            })
        })?;
    }
    preview::take_stand(out, made)?;
    seen.say(args, out);
    Ok(())
}

/// An age in whole growth cycles.
pub(super) fn whole_age(age: f32) -> Result<u16, UsageError> {
    if (0.0..=f32::from(u16::MAX)).contains(&age) && age.fract() == 0.0 {
        Ok(age as u16)
    } else {
        Err(UsageError(format!("the age is {age}; it must be a whole number of growth cycles")))
    }
}

/// What was made, for the report at the end.
#[derive(Default)]
struct Seen {
    trees: u64,
    nodes: u64,
    branches: u64,
    took: Duration,
    /// All at once, in the time they took.
    together: bool,
    hit_budget: Vec<u64>,
    avoided: Option<Avoided>,
    first: Option<Value>,
}

impl Seen {
    fn add(&mut self, made: &Made, took: Duration) {
        self.trees += 1;
        self.nodes += made.tree.len() as u64;
        self.branches += deeptree_graph::branches(&made.tree).len() as u64;
        self.took += took;
        if made.hit_budget {
            self.hit_budget.push(made.seed);
        }
        if let Some(own) = made.avoided {
            let all = self.avoided.get_or_insert_default();
            all.redrawn += own.redrawn;
            all.given_up += own.given_up;
        }
        self.first.get_or_insert_with(|| report::tree_figures(&made.tree));
    }

    fn say(self, args: &Args, out: &args::Out) {
        let Some(first) = self.first else { return };
        if !args.quiet && !self.hit_budget.is_empty() {
            eprintln!(
                "deeptree: {} of {} trees hit the node budget and are cut off (seeds {:?} …)",
                self.hit_budget.len(),
                self.trees,
                &self.hit_budget[..self.hit_budget.len().min(5)]
            );
        }
        if let (Some(Avoided { redrawn, given_up }), false) = (self.avoided, args.quiet) {
            eprintln!(
                "deeptree: of {} nodes, {redrawn} were drawn again and {given_up} given up where \
                 no branch can go",
                self.nodes
            );
        }
        let milliseconds = self.took.as_secs_f64() * 1e3 / self.trees as f64;
        let place = out.output.display();
        let (text, mut figures) = if self.trees == 1 {
            let tree = report::tree_text(&first);
            (format!("{tree}; grown in {milliseconds:.1} ms → {place}"), first)
        } else {
            let nodes = self.nodes as f64 / self.trees as f64;
            let branches = self.branches as f64 / self.trees as f64;
            let time = if self.together {
                format!("grown together in {:.0} ms", 1e3 * self.took.as_secs_f64())
            } else {
                format!("each grown in {milliseconds:.1} ms on one thread")
            };
            let text = format!(
                "{} trees of {nodes:.0} nodes in {branches:.0} branches, {time} → {place}",
                self.trees
            );
            (text, json!({ "trees": self.trees, "nodes": nodes, "branches": branches }))
        };
        figures["milliseconds_a_tree"] = json!(milliseconds);
        figures["hit_budget"] = json!(self.hit_budget);
        if let Some(Avoided { redrawn, given_up }) = self.avoided {
            figures["redrawn"] = json!(redrawn);
            figures["given_up"] = json!(given_up);
        }
        report::say(args, &figures, &text, is_stdout(&out.output));
    }
}
