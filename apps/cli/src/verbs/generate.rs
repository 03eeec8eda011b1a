//! `generate`: trees from the networks.

mod stand;

use anyhow::{Result, bail};
use deeptree_generate::{
    GenerateError, Limits, Request, Wishes, clamp_wishes, generate, generate_in, germ,
};
use deeptree_graph::{Seed, Vec3};
use deeptree_infer::{Model, Predictor, Workspace};
use deeptree_scene::Site;

use super::making::{self, whole_age};
use super::unknown_species;
use crate::args::{self, Args, UsageError};
use crate::batch::Made;
use crate::blend;
use crate::format::Format;
use crate::output::Target;

pub(crate) fn run(args: &Args, verb: &args::Generate) -> Result<()> {
    let (model, blend) = match &verb.blend {
        None => (verb.model.load()?, Vec::new()),
        Some(list) => {
            let weights = verb.model.weights()?;
            let shares = blend::shares(list, weights.species())?;
            (blend::model(&weights, &shares)?, shares)
        }
    };
    verb.model.workspace()?;
    if let Some(plan) = &verb.stand {
        return stand::run(args, verb, &model, plan);
    }
    let species = match &verb.species {
        Some(name) => name,
        // A blend is the only species of its model.
        None => &model.species()[0],
    };
    if !model.species().contains(species) {
        return Err(unknown_species(species, model.species()).into());
    }
    let count = u64::from(verb.which.count);
    let mut target = Target::new(&verb.out.output, verb.out.format, count, &verb.out.mesh)?;
    target.model = Some(model.hash());
    target.blend = blend;
    let site = verb.place.site()?;
    if site.is_some() && target.format == Format::Dtree {
        bail!(UsageError(
            "a .dtree holds no obstacles and no form; write .csv, .parquet or a mesh".to_owned()
        ));
    }
    let asked = asked(args, verb, &model, species, verb.which.seed, verb.which.age)?;
    let request = |seed| Request { seed: Seed(seed), ..asked.clone() };
    // A bad age or gravitropism is told before anything is made.
    germ(&model, &request(verb.which.seed)).map_err(asked_too_much)?;

    let limits = Limits { budget: verb.budget as usize, batch: verb.batch as usize };
    making::run(
        args,
        species,
        &verb.which,
        &verb.out,
        &target,
        || verb.model.workspace(),
        |work, seed| one(&model, &request(seed), site.as_ref(), limits, work),
    )
}

/// What is asked of one tree.
fn asked(
    args: &Args,
    verb: &args::Generate,
    model: &Model,
    species: &str,
    seed: u64,
    age: Option<f32>,
) -> Result<Request> {
    let asked = Request {
        age: age.map(whole_age).transpose()?,
        gravitropism: verb.which.gravitropism,
        wishes: wishes(verb),
        ..Request::new(species, Seed(seed))
    };
    if verb.force { within_reach(args, model, asked) } else { Ok(asked) }
}

fn one(
    model: &Model,
    request: &Request,
    site: Option<&Site>,
    limits: Limits,
    work: &mut Workspace,
) -> Result<Made> {
    let grown = match site {
        None => generate(model, request, limits, work)?,
        Some(site) => generate_in(model, request, site, limits, work)?,
    };
    Ok(Made {
        seed: request.seed.0,
        number: 0,
        tree: grown.tree,
        at: Vec3::ZERO,
        germ: Some(grown.germ),
        hit_budget: grown.hit_budget,
        avoided: site.map(|_| grown.avoided),
    })
}

/// What is asked of each tree as a whole.
fn wishes(verb: &args::Generate) -> Wishes {
    Wishes {
        height: verb.height,
        crown_radius: verb.crown_radius,
        branches: verb.branches,
        trunk_length: verb.trunk,
    }
}

/// The request with its wishes within what the model has seen, and a warning where they were not.
fn within_reach(args: &Args, model: &Model, asked: Request) -> Result<Request> {
    let wishes = clamp_wishes(model, &asked).map_err(asked_too_much)?;
    if wishes != asked.wishes && !args.quiet {
        let asked = asked.wishes;
        eprintln!("deeptree: asked for {asked:?}, the nearest the model has seen is {wishes:?}");
    }
    Ok(Request { wishes, ..asked })
}

/// What the model cannot do is a wrong request.
fn asked_too_much(error: GenerateError) -> anyhow::Error {
    match error {
        GenerateError::OutOfRange { .. }
        | GenerateError::NotFinite { .. }
        | GenerateError::NotSeen { .. }
        | GenerateError::NotTogether { .. } => UsageError(error.to_string()).into(),
        error => error.into(),
    }
}
