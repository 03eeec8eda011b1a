//! Trees that grow together.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use deeptree_generate::{Limits, Planted, Request, generate_stand, germ};
use deeptree_infer::{Model, Predictor};
use deeptree_scene::Site;

use super::{asked, asked_too_much, making, unknown_species};
use crate::args::{self, Args, UsageError};
use crate::batch::{self, Made};
use crate::format::Format;
use crate::output::Target;
use crate::stand;
use crate::verbs::render::preview;

pub(super) fn run(args: &Args, verb: &args::Generate, model: &Model, plan: &Path) -> Result<()> {
    preview::check(&verb.out)?;
    let rows = stand::read(plan, verb.species.as_deref())?;
    let known = model.species();
    if let Some(row) = rows.iter().find(|row| !known.contains(&row.species)) {
        return Err(unknown_species(&row.species, known).into());
    }
    let count = rows.len() as u64;
    let mut target = Target::for_stand(&verb.out.output, verb.out.format, count, &verb.out.mesh)?;
    target.model = Some(model.hash());
    if target.format == Format::Dtree {
        bail!(UsageError(
            "a .dtree holds a tree by itself, no stand; write .csv, .parquet or meshes".to_owned()
        ));
    }
    if target.folder {
        stand::check_names(&rows)?;
    }
    let requests: Vec<Request> = rows
        .iter()
        .map(|row| {
            let age = row.age.or(verb.which.age);
            let request = asked(args, verb, model, &row.species, row.seed, age)?;
            // A bad age or gravitropism is told before anything is made.
            germ(model, &request).map_err(asked_too_much)?;
            Ok(request)
        })
        .collect::<Result<_>>()?;
    let environments = stand::environments(&rows, &verb.place.load()?.scene)?;
    let sites: Vec<Option<Site>> = environments
        .into_iter()
        .map(|environment| (!environment.is_open()).then(|| Site::new(environment)))
        .collect();
    let planted: Vec<Planted<'_>> = rows
        .iter()
        .zip(requests.iter().zip(&sites))
        .map(|(row, (request, site))| Planted { request, at: row.at, site: site.as_ref() })
        .collect();
    let limits = Limits { budget: verb.budget as usize, batch: verb.batch as usize };
    let work = verb.model.workspace()?;
    let start = Instant::now();
    let grown = batch::on_threads(verb.which.threads, || {
        Ok(generate_stand(model, &planted, limits, &work)?)
    })?;
    let took = start.elapsed();
    let trees = grown.into_iter().zip(&rows).zip(&sites).enumerate();
    let made = trees.map(|(k, ((grown, row), site))| Made {
        seed: row.seed,
        number: k as u32,
        tree: grown.tree,
        at: row.at,
        germ: None,
        hit_budget: grown.hit_budget,
        avoided: site.as_ref().map(|_| grown.avoided),
    });
    let made: Vec<Made> = made.collect();
    batch::on_threads(verb.which.threads, || making::write(args, &verb.out, &target, &made, took))
}
