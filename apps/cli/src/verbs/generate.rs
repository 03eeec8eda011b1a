//! `generate`: trees from the networks.

use anyhow::Result;
use deeptree_generate::{GenerateError, Limits, Request, Wishes, generate, germ};
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
    // A bad age or gravitropism is told before anything is made.
    germ(&model, &request(verb, age, verb.which.seed)).map_err(asked_too_much)?;

    let limits = Limits { budget: verb.budget as usize, batch: verb.batch as usize };
    making::run(
        args,
        &verb.which,
        &verb.out,
        &target,
        || verb.model.workspace(),
        |work, seed| one(&model, &request(verb, age, seed), limits, work),
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

fn request(verb: &args::Generate, age: Option<u16>, seed: u64) -> Request {
    Request {
        species: verb.which.species.clone(),
        seed: Seed(seed),
        age,
        gravitropism: verb.which.gravitropism,
        wishes: Wishes {
            height: verb.height,
            crown_radius: verb.crown_radius,
            branches: verb.branches,
            trunk_length: verb.trunk,
        },
    }
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
