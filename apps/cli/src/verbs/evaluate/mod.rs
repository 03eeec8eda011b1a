//! `evaluate`: teacher beside learner, beside the paper, chapter by chapter.

#[cfg(feature = "train")]
mod ablation;
mod around;
mod compression;
mod criteria;
mod diversity;
mod environment;
mod estimate;
mod forms;
mod histograms;
#[cfg(feature = "train")]
mod joint;
#[cfg(feature = "train")]
mod lab;
mod measure;
mod memorisation;
mod open_loop;
mod perceptual;
#[cfg(feature = "train")]
mod points;
mod priors;
mod reconstruction;
mod regrowth;
mod runtime;
mod stands;
mod study;
mod table;
mod termination;
mod trees;
mod two_sample;
#[cfg(not(feature = "train"))]
mod untrained;
mod wishes;

use std::fs;
use std::time::Instant;

use anyhow::{Context, Result};
use deeptree_eval::report::{Chapter, Report};
use serde_json::json;

use crate::args::{self, Args, UsageError};
use crate::report;
use study::Study;
#[cfg(not(feature = "train"))]
use untrained::{ablation, joint};

/// What a chapter is called, and what makes it.
type Maker = fn(&Study<'_>) -> Result<Chapter>;

/// The chapters of a report, in their order.
const CHAPTERS: [(&str, Maker); 17] = [
    ("table", table::chapter),
    ("perceptual", perceptual::chapter),
    ("two-sample", two_sample::chapter),
    ("memorisation", memorisation::chapter),
    ("open-loop", open_loop::chapter),
    ("ablation", ablation::chapter),
    ("joint", joint::chapter),
    ("priors", priors::chapter),
    ("wishes", wishes::chapter),
    ("runtime", runtime::chapter),
    ("compression", compression::chapter),
    ("diversity", diversity::chapter),
    ("regrowth", regrowth::chapter),
    ("environment", environment::chapter),
    ("forms", forms::chapter),
    ("stands", stands::chapter),
    ("reconstruction", reconstruction::chapter),
];

/// Runs the chapters asked for. The page is written anew after each, so that a run that is cut off
/// leaves what it had; the next one goes on from the parts that are done.
pub(crate) fn run(args: &Args, verb: &args::Evaluate) -> Result<()> {
    let chosen = chosen(&verb.chapters)?;
    let study = Study::new(args, verb)?;
    fs::create_dir_all(&verb.output)
        .with_context(|| format!("cannot create the folder {}", verb.output.display()))?;
    let mut page =
        Report { title: "DeepTree: evaluation".to_owned(), facts: study.facts(), chapters: vec![] };
    let start = Instant::now();
    for (name, make) in chosen {
        let chapter = make(&study).with_context(|| format!("chapter {name}"))?;
        page.chapters.push(chapter);
        study.save("report.html", page.html().as_bytes())?;
    }
    let path = verb.output.join("report.html");
    let text = format!("{} in {:.0} s", path.display(), start.elapsed().as_secs_f64());
    report::say(args, &json!({ "report": path }), &text, false);
    Ok(())
}

/// The chapters of a list of names separated by commas, or all.
fn chosen(names: &str) -> Result<Vec<(&'static str, Maker)>, UsageError> {
    if names == "all" {
        return Ok(CHAPTERS.to_vec());
    }
    let known = || CHAPTERS.map(|(name, _)| name).join(", ");
    if let Some(name) = names.split(',').find(|name| CHAPTERS.iter().all(|(n, _)| n != name)) {
        let text = format!("there is no chapter '{name}'; there are {}", known());
        return Err(UsageError(text));
    }
    let asked: Vec<&str> = names.split(',').collect();
    Ok(CHAPTERS.into_iter().filter(|(name, _)| asked.contains(name)).collect())
}
