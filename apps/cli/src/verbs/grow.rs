//! `grow`: trees from the procedural model.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use deeptree_graph::Seed;
use deeptree_growth::{Around, DEFAULT_BUDGET, Parameters, Planted, grow_around, grow_stand_in};

use super::making;
use crate::args::{self, Args, UsageError};
use crate::batch::Made;
use crate::format::Format;
use crate::output::{self, Target};
use crate::stand;

pub(crate) fn run(args: &Args, verb: &args::Grow) -> Result<()> {
    match (&verb.species, &verb.stand) {
        (_, Some(plan)) => together(args, verb, plan),
        (Some(species), None) => trees(args, verb, species),
        (None, None) => bail!(UsageError("name a species, or a plan with --stand".to_owned())),
    }
}

fn trees(args: &Args, verb: &args::Grow, species: &str) -> Result<()> {
    let which = &verb.which;
    let parameters = parameters(verb, species, verb.which.age)?;
    let environment = verb.place.load()?;
    let target = target(verb, u64::from(which.count))?;
    let one = |(): &mut (), seed| {
        let grown = grow_around(species, &parameters, Seed(seed), &environment)?;
        Ok(Made {
            seed,
            number: 0,
            tree: grown.tree,
            germ: None,
            hit_budget: grown.hit_budget,
            avoided: None,
        })
    };
    making::run(args, species, which, &verb.out, &target, || Ok(()), one)
}

/// Trees that grow together.
fn together(args: &Args, verb: &args::Grow, plan: &Path) -> Result<()> {
    let rows = stand::read(plan, verb.species.as_deref())?;
    let numbers: Vec<Parameters> = rows
        .iter()
        .map(|row| parameters(verb, &row.species, row.age.or(verb.which.age)))
        .collect::<Result<_>>()?;
    let target = target(verb, rows.len() as u64)?;
    if target.folder {
        stand::check_names(&rows)?;
    }
    let environments = stand::environments(&rows, &verb.place.load()?.scene)?;
    let surroundings: Vec<Around<'_>> = environments.iter().map(Around::new).collect();
    let planted: Vec<Planted<'_>> = rows
        .iter()
        .zip(&numbers)
        .map(|(row, parameters)| Planted {
            species: &row.species,
            parameters,
            seed: Seed(row.seed),
            at: row.at,
        })
        .collect();
    let start = Instant::now();
    let grown = grow_stand_in(&planted, &surroundings, DEFAULT_BUDGET)?;
    let took = start.elapsed();
    let made = grown.into_iter().zip(&rows).enumerate().map(|(k, (grown, row))| Made {
        seed: row.seed,
        number: k as u32,
        tree: grown.tree.moved(row.at),
        germ: None,
        hit_budget: grown.hit_budget,
        avoided: None,
    });
    making::write(args, &verb.out, &target, made.collect(), took)
}

fn target(verb: &args::Grow, count: u64) -> Result<Target> {
    let target = Target::new(&verb.out.output, verb.out.format, count, &verb.out.mesh)?;
    if target.format == Format::Dtree {
        bail!(output::seed_files_are_generated());
    }
    Ok(target)
}

/// The numbers of the species, with what the command line overrides.
fn parameters(verb: &args::Grow, species: &str, age: Option<f32>) -> Result<Parameters> {
    let mut parameters = super::preset(species)?.parameters(verb.profile).clone();
    if let Some(age) = age {
        parameters.age = age;
    }
    if let Some(gravitropism) = verb.which.gravitropism {
        parameters.gravitropism = gravitropism;
    }
    parameters.validate().map_err(|error| UsageError(error.to_string()))?;
    Ok(parameters)
}
