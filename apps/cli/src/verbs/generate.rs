//! `generate`: trees from the networks.

use anyhow::Result;
use deeptree_generate::{GenerateError, Limits, Request, Wishes, clamp_wishes, generate, germ};
use deeptree_graph::Seed;
use deeptree_infer::{Model, Predictor, Workspace};

use super::making::{self, whole_age};
use super::unknown_species;
use crate::args::{self, Args, UsageError};
use crate::batch::Made;
use crate::output::Target;

pub(crate) fn run(args: &Args, verb: &args::Generate) -> Result<()> {
    let model = verb.model.load()?;
    verb.model.workspace()?;
    if !model.species().contains(&verb.which.species) {
        return Err(unknown_species(&verb.which.species, model.species()).into());
    }
    let count = u64::from(verb.which.count);
    let mut target = Target::new(&verb.out.output, verb.out.format, count, verb.out.lod)?;
    target.model = Some(model.hash());
    let age = verb.which.age.map(whole_age).transpose()?;
    let wishes = wishes(args, verb, &model)?;
    let request = |seed| Request {
        age,
        gravitropism: verb.which.gravitropism,
        wishes,
        ..Request::new(&verb.which.species, Seed(seed))
    };
    // A bad age or gravitropism is told before anything is made.
    germ(&model, &request(verb.which.seed)).map_err(asked_too_much)?;

    let limits = Limits { budget: verb.budget as usize, batch: verb.batch as usize };
    making::run(
        args,
        &verb.which,
        &verb.out,
        &target,
        || verb.model.workspace(),
        |work, seed| one(&model, &request(seed), limits, work),
    )
}

fn one(model: &Model, request: &Request, limits: Limits, work: &mut Workspace) -> Result<Made> {
    let grown = generate(model, request, limits, work)?;
    Ok(Made {
        seed: request.seed.0,
        number: 0,
        tree: grown.tree,
        germ: Some(grown.germ),
        hit_budget: grown.hit_budget,
    })
}

/// What is asked of each tree as a whole; with `--force` within what the model has seen.
fn wishes(args: &Args, verb: &args::Generate, model: &Model) -> Result<Wishes> {
    let asked = Wishes {
        height: verb.height,
        crown_radius: verb.crown_radius,
        branches: verb.branches,
        trunk_length: verb.trunk,
    };
    if !verb.force {
        return Ok(asked);
    }
    let granted = clamp_wishes(model, &verb.which.species, asked)?;
    if granted != asked && !args.quiet {
        eprintln!("deeptree: asked for {asked:?}, the nearest the model has seen is {granted:?}");
    }
    Ok(granted)
}

/// What the model cannot do is a wrong request.
fn asked_too_much(error: GenerateError) -> anyhow::Error {
    match error {
        GenerateError::OutOfRange { .. } | GenerateError::NotFinite { .. } => {
            UsageError(error.to_string()).into()
        }
        error => error.into(),
    }
}
