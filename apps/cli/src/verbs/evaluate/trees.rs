//! Trees of both sides, as the chapters ask for them.

use anyhow::Result;
use deeptree_generate::{Generated, Limits, Request, generate};
use deeptree_graph::Seed;
use deeptree_growth::{Grown, Species, grow};
use deeptree_infer::{Model, Workspace};

use super::study::Study;
use crate::{batch, report};

/// The growth model's tree of a species and seed.
pub(super) fn grown(study: &Study<'_>, species: &Species, seed: u64) -> Result<Grown> {
    Ok(grow(&species.name, species.parameters(study.verb.profile), Seed(seed))?)
}

/// The model's tree of a species and seed.
pub(super) fn generated(
    model: &Model,
    species: &str,
    seed: u64,
    work: &mut Workspace,
) -> Result<Generated> {
    Ok(generate(model, &Request::new(species, Seed(seed)), Limits::default(), work)?)
}

/// What `one` makes of each of `count` seeds from `first` on, in their order, on all threads.
pub(super) fn many<T: Send>(
    study: &Study<'_>,
    what: &str,
    first: u64,
    count: u32,
    one: impl Fn(&mut Workspace, u64) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let bar = report::bar(study.args, u64::from(count), what);
    let mut all = Vec::with_capacity(count as usize);
    let worker = || study.verb.model.workspace();
    batch::make(first, u64::from(count), worker, one, |_, made, _| {
        all.push(made);
        bar.inc(1);
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(all)
}
