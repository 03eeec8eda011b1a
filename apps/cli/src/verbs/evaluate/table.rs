//! Chapter 1: the metrics of the paper's appendix.

use anyhow::Result;
use deeptree_eval::report::Chapter;
use deeptree_eval::{Row, Table, TreeMetrics};
use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::Seed;
use deeptree_growth::{Species, grow};
use deeptree_infer::Model;

use super::study::Study;
use crate::{batch, report};

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let Study { args, verb, .. } = *study;
    let mut table = Table::default();
    for species in &study.species {
        if verb.side != "dt" {
            table.rows.push(measure_grown(study, species)?);
        }
        if let Some(model) = &study.model {
            table.rows.push(measure_generated(study, model, &species.name)?);
        }
    }
    table.add_totals();
    study.save("table.csv", table.csv().as_bytes())?;
    study.save("table.json", serde_json::to_string_pretty(&table)?.as_bytes())?;
    report::say(args, &serde_json::to_value(&table)?, table.text().trim_end(), false);
    Ok(Chapter::new("table", "The appendix table"))
}

/// Pools the metrics of trees made by `one`, which also says whether a budget cut one off.
fn measure<W>(
    study: &Study<'_>,
    mut row: Row,
    worker: impl Fn() -> Result<W> + Sync,
    one: impl Fn(&mut W, u64) -> Result<(TreeMetrics, bool)> + Sync,
) -> Result<Row> {
    let trees = u64::from(study.trees());
    let bar = report::bar(study.args, trees, &format!("{} {}", row.species, row.set));
    batch::make(study.verb.seed, trees, worker, one, |_, (metrics, hit_budget), _| {
        row.add(&metrics, hit_budget);
        bar.inc(1);
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(row)
}

fn measure_grown(study: &Study<'_>, species: &Species) -> Result<Row> {
    let parameters = species.parameters(study.verb.profile);
    measure(
        study,
        Row::new(&species.name, "P"),
        || Ok(()),
        |(), seed| {
            let grown = grow(&species.name, parameters, Seed(seed))?;
            Ok((TreeMetrics::of(&grown.tree), grown.hit_budget))
        },
    )
}

fn measure_generated(study: &Study<'_>, model: &Model, species: &str) -> Result<Row> {
    measure(
        study,
        Row::new(species, "DT"),
        || study.verb.model.workspace(),
        |work, seed| {
            let grown =
                generate(model, &Request::new(species, Seed(seed)), Limits::default(), work)?;
            Ok((TreeMetrics::of(&grown.tree), grown.hit_budget))
        },
    )
}
