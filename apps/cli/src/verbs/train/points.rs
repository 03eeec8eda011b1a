//! `train --only points`: networks that hear of the points around a node, from scans of a corpus.

use anyhow::Result;
use deeptree_dataset::{Corpus, Split};
use deeptree_graph::Vec3;
use deeptree_learn::{Scan, Scans, TrainOptions, train_points};

use super::training::{Bars, beside, of_nodes, read, read_model, refuse, write};
use crate::args::{self, Args, UsageError};
use crate::report;

pub(super) fn run(args: &Args, verb: &args::Train) -> Result<()> {
    refuse("points", &of_nodes(verb))?;
    let path = verb.model.as_deref();
    let path =
        path.ok_or_else(|| UsageError("name the --model that is to hear of points".into()))?;
    let (weights, report) = read_model(path)?;
    let mut options =
        TrainOptions { seed: verb.seed, device: verb.device.parse()?, ..TrainOptions::points() };
    options.epochs = verb.epochs.unwrap_or(options.epochs);
    if let Some(samples) = verb.samples {
        options.steps_per_epoch = Some(samples.div_ceil(options.batch as u64));
    }
    let (set, scans) = (read(args, verb)?, scans(args, verb)?);
    let bars = Bars::new(args);
    let checkpoints = beside(&verb.output, "checkpoint");
    let progress = |event| bars.show(event);
    let (bytes, report) =
        train_points(&set, &scans, (&weights, &report), &options, &checkpoints, &progress)?;
    write(args, verb, &bytes, &report)
}

/// The scans of the trees that are learned from and judged by, in their order.
fn scans(args: &Args, verb: &args::Train) -> Result<Scans> {
    let bar = report::bar(args, 0, "reading scans");
    let mut scans = Scans::default();
    for path in &verb.data {
        let corpus = Corpus::open(path)?;
        let most = verb.trees.unwrap_or(u32::MAX);
        for (split, all) in
            [(Split::Train, &mut scans.train), (Split::Validation, &mut scans.validation)]
        {
            for scan in corpus.scans(split) {
                let scan = scan?;
                if split == Split::Validation || scan.number < most {
                    let origin = Vec3::from_array(scan.cloud.origin.map(|x| x as f32));
                    let points = scan.cloud.points.iter().map(|&point| point + origin).collect();
                    let nodes = scan.cloud.columns.node.unwrap_or_default();
                    all.push(Scan { points, nodes });
                    bar.inc(1);
                }
            }
        }
    }
    bar.finish_and_clear();
    Ok(scans)
}
