//! `evaluate`: teacher beside learner, beside the paper.

use std::fs;

use anyhow::{Context, Result};
use deeptree_eval::{Row, Table, TreeMetrics};
use deeptree_export::write_atomically;
use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::Seed;
use deeptree_growth::{Species, grow};
use deeptree_infer::{Model, Predictor};
use std::io::Write;

use super::{presets, unknown_species};
use crate::args::{self, Args};
use crate::{batch, report};

pub(crate) fn run(args: &Args, verb: &args::Evaluate) -> Result<()> {
    let species = presets(&verb.species)?;
    let model = if verb.side == "p" { None } else { Some(verb.model.load()?) };
    verb.model.workspace()?;
    if let Some(model) = &model
        && let Some(missing) = species.iter().find(|s| !model.species().contains(&s.name))
    {
        return Err(unknown_species(&missing.name, model.species()).into());
    }
    fs::create_dir_all(&verb.output)
        .with_context(|| format!("cannot create the folder {}", verb.output.display()))?;

    let mut table = Table::default();
    for species in &species {
        if verb.side != "dt" {
            table.rows.push(measure_grown(args, verb, species)?);
        }
        if let Some(model) = &model {
            table.rows.push(measure_generated(args, verb, model, &species.name)?);
        }
    }
    table.add_totals();
    save(verb, "table.csv", &table.csv())?;
    save(verb, "table.json", &serde_json::to_string_pretty(&table)?)?;
    report::say(args, &serde_json::to_value(&table)?, table.text().trim_end(), false);
    Ok(())
}

fn save(verb: &args::Evaluate, name: &str, text: &str) -> Result<()> {
    Ok(write_atomically(&verb.output.join(name), |out| out.write_all(text.as_bytes()))?)
}

/// Pools the metrics of trees made by `one`, which also says whether a budget cut one off.
fn measure<W>(
    args: &Args,
    verb: &args::Evaluate,
    mut row: Row,
    worker: impl Fn() -> Result<W> + Sync,
    one: impl Fn(&mut W, u64) -> Result<(TreeMetrics, bool)> + Sync,
) -> Result<Row> {
    let bar = report::bar(args, u64::from(verb.trees), &format!("{} {}", row.species, row.set));
    batch::make(verb.seed, u64::from(verb.trees), worker, one, |_, (metrics, hit_budget), _| {
        row.add(&metrics, hit_budget);
        bar.inc(1);
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(row)
}

fn measure_grown(args: &Args, verb: &args::Evaluate, species: &Species) -> Result<Row> {
    let parameters = species.parameters(verb.profile);
    measure(
        args,
        verb,
        Row::new(&species.name, "P"),
        || Ok(()),
        |(), seed| {
            let grown = grow(&species.name, parameters, Seed(seed))?;
            Ok((TreeMetrics::of(&grown.tree), grown.hit_budget))
        },
    )
}

fn measure_generated(
    args: &Args,
    verb: &args::Evaluate,
    model: &Model,
    species: &str,
) -> Result<Row> {
    measure(
        args,
        verb,
        Row::new(species, "DT"),
        || verb.model.workspace(),
        |work, seed| {
            let grown =
                generate(model, &Request::new(species, Seed(seed)), Limits::default(), work)?;
            Ok((TreeMetrics::of(&grown.tree), grown.hit_budget))
        },
    )
}
