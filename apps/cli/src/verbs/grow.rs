//! `grow`: trees from the procedural model.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use deeptree_graph::{Seed, Vec3};
use deeptree_growth::{Around, DEFAULT_BUDGET, Parameters, Planted, grow_around, grow_stand_in};

use super::making;
use super::render::preview;
use crate::args::{self, Args, UsageError};
use crate::batch::{self, Made};
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
    let out = &verb.out;
    let target = Target::new(&out.output, out.format, u64::from(which.count), &out.mesh)?;
    refuse_seed_file(&target)?;
    let one = |(): &mut (), seed| {
        let grown = grow_around(species, &parameters, Seed(seed), &environment)?;
        Ok(Made {
            seed,
            number: 0,
            tree: grown.tree,
            at: Vec3::ZERO,
            germ: None,
            hit_budget: grown.hit_budget,
            avoided: None,
        })
    };
    making::run(args, species, which, &verb.out, &target, || Ok(()), one)
}

/// Trees that grow together.
fn together(args: &Args, verb: &args::Grow, plan: &Path) -> Result<()> {
    preview::check(&verb.out)?;
    let rows = stand::read(plan, verb.species.as_deref())?;
    let numbers: Vec<Parameters> = rows
        .iter()
        .map(|row| parameters(verb, &row.species, row.age.or(verb.which.age)))
        .collect::<Result<_>>()?;
    let out = &verb.out;
    let target = Target::for_stand(&out.output, out.format, rows.len() as u64, &out.mesh)?;
    refuse_seed_file(&target)?;
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
        tree: grown.tree,
        at: row.at,
        germ: None,
        hit_budget: grown.hit_budget,
        avoided: None,
    });
    let made: Vec<Made> = made.collect();
    batch::on_threads(verb.which.threads, || making::write(args, out, &target, &made, took))
}

fn refuse_seed_file(target: &Target) -> Result<(), UsageError> {
    match target.format {
        Format::Dtree => Err(output::seed_files_are_generated()),
        _ => Ok(()),
    }
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
