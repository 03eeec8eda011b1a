//! What each verb does.

mod convert;
mod dataset;
mod evaluate;
mod generate;
mod grow;
mod info;
mod making;
mod reconstruct;
mod regrow;
pub(crate) mod render;
mod scan;
mod train;

use anyhow::Result;
use deeptree_growth::{SPECIES, Species};

use crate::args::{Args, UsageError, Verb};

/// Runs the verb of the command line.
pub(crate) fn run(args: &Args) -> Result<()> {
    match &args.verb {
        Verb::Generate(verb) => generate::run(args, verb),
        Verb::Grow(verb) => grow::run(args, verb),
        Verb::Regrow(verb) => regrow::run(args, verb),
        Verb::Scan(verb) => scan::run(args, verb),
        Verb::Reconstruct(verb) => reconstruct::run(args, verb),
        Verb::Dataset(verb) => dataset::run(args, verb),
        Verb::Train(verb) => train::run(args, verb),
        Verb::Evaluate(verb) => evaluate::run(args, verb),
        Verb::Render(verb) => render::run(args, verb),
        Verb::Info(verb) => info::run(args, verb),
        Verb::Convert(verb) => convert::run(args, verb),
    }
}

/// A name that is no species, with the nearest that is.
pub(crate) fn unknown_species(name: &str, known: &[String]) -> UsageError {
    let nearest = known
        .iter()
        .min_by_key(|known| strsim::damerau_levenshtein(known, &name.to_lowercase()))
        .filter(|known| strsim::damerau_levenshtein(known, &name.to_lowercase()) <= 3);
    UsageError(match nearest {
        Some(nearest) => format!("there is no species '{name}'; did you mean {nearest}?"),
        None => format!("there is no species '{name}'; there are {}", known.join(", ")),
    })
}

/// A preset by its name.
fn preset(name: &str) -> Result<Species, UsageError> {
    Species::named(name).ok_or_else(|| unknown_species(name, &SPECIES.map(str::to_owned)))
}

/// The presets of a list of names separated by commas, or all.
fn presets(names: &str) -> Result<Vec<Species>, UsageError> {
    if names == "all" {
        return SPECIES.iter().map(|name| preset(name)).collect();
    }
    let mut list: Vec<Species> = Vec::new();
    for name in names.split(',') {
        if list.iter().any(|species| species.name == name) {
            return Err(UsageError(format!("the species {name} is named twice")));
        }
        list.push(preset(name)?);
    }
    Ok(list)
}
