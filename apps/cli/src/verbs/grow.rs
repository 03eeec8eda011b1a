//! `grow`: trees from the procedural model.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use deeptree_graph::Seed;
use deeptree_growth::{Parameters, grow};

use super::generate::Seen;
use crate::args::{self, Args, UsageError};
use crate::batch::{self, Made};
use crate::format::Format;
use crate::output::Target;
use crate::report;

pub(crate) fn run(args: &Args, verb: &args::Grow) -> Result<()> {
    let args::Which { species, seed, count, threads, .. } = &verb.which;
    let count = u64::from(*count);
    let parameters = parameters(verb)?;
    let target = Target::new(&verb.out.output, verb.out.format, count, verb.out.lod)?;
    if target.format == Format::Dtree {
        bail!(UsageError(
            "a .dtree file is a seed of the networks; only generate writes one".into()
        ));
    }
    let mut seen = Seen::default();
    batch::on_threads(*threads, || {
        target.write(|take| {
            let bar = report::bar(args, count, species);
            batch::make(
                *seed,
                count,
                || Ok(()),
                |(), seed| one(species, &parameters, seed),
                |(made, took)| {
                    seen.add(&made, took);
                    bar.inc(1);
                    take(&made)
                },
            )?;
            bar.finish_and_clear();
            Ok(())
        })
    })?;
    seen.say(args, &verb.out);
    Ok(())
}

fn one(species: &str, parameters: &Parameters, seed: u64) -> Result<(Made, Duration)> {
    let start = Instant::now();
    let grown = grow(species, parameters, Seed(seed))?;
    let made = Made { seed, tree: grown.tree, germ: None, hit_budget: grown.hit_budget };
    Ok((made, start.elapsed()))
}

/// The numbers of the species, with what the command line overrides.
fn parameters(verb: &args::Grow) -> Result<Parameters> {
    let mut parameters = super::preset(&verb.which.species)?.parameters(verb.profile).clone();
    if let Some(age) = verb.which.age {
        parameters.age = age;
    }
    if let Some(gravitropism) = verb.which.gravitropism {
        parameters.gravitropism = gravitropism;
    }
    parameters.validate().map_err(|error| UsageError(error.to_string()))?;
    Ok(parameters)
}
