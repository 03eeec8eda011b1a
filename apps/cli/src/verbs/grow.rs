//! `grow`: trees from the procedural model.

use anyhow::{Result, bail};
use deeptree_graph::Seed;
use deeptree_growth::{Parameters, grow};

use super::making;
use crate::args::{self, Args, UsageError};
use crate::batch::Made;
use crate::format::Format;
use crate::output::{self, Target};

pub(crate) fn run(args: &Args, verb: &args::Grow) -> Result<()> {
    let which = &verb.which;
    let parameters = parameters(verb)?;
    let target =
        Target::new(&verb.out.output, verb.out.format, u64::from(which.count), &verb.out.mesh)?;
    if target.format == Format::Dtree {
        bail!(output::seed_files_are_generated());
    }
    let one = |(): &mut (), seed| {
        let grown = grow(&verb.species, &parameters, Seed(seed))?;
        Ok(Made { seed, number: 0, tree: grown.tree, germ: None, hit_budget: grown.hit_budget })
    };
    making::run(args, &verb.species, which, &verb.out, &target, || Ok(()), one)
}

/// The numbers of the species, with what the command line overrides.
fn parameters(verb: &args::Grow) -> Result<Parameters> {
    let mut parameters = super::preset(&verb.species)?.parameters(verb.profile).clone();
    if let Some(age) = verb.which.age {
        parameters.age = age;
    }
    if let Some(gravitropism) = verb.which.gravitropism {
        parameters.gravitropism = gravitropism;
    }
    parameters.validate().map_err(|error| UsageError(error.to_string()))?;
    Ok(parameters)
}
