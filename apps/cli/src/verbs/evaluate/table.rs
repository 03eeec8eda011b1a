//! Chapter 1: the metrics of the paper's appendix, and what a learner must show.

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_eval::{Metric, Moments, ORDERS, Row, Table, mean_and_sd, published};

use super::measure::{Measured, Set};
use super::study::Study;
use super::{criteria, histograms, termination};
use crate::report;

/// The sets of a species that were measured.
pub(super) struct Sets {
    pub(super) species: String,
    measured: Vec<(Set, Measured)>,
}

impl Sets {
    pub(super) fn get(&self, set: Set) -> Option<&Measured> {
        self.measured.iter().find(|(one, _)| *one == set).map(|(_, measured)| measured)
    }

    fn row(&self, set: Set) -> Option<Row> {
        let measured = self.get(set)?;
        let mut row = Row::new(&self.species, set.symbol());
        for tree in &measured.set.trees {
            row.add(&tree.metrics(), tree.hit_budget);
        }
        Some(row)
    }
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut wanted = Vec::new();
    if study.verb.side != "dt" {
        wanted.push(Set::Teacher);
    }
    if study.model.is_some() {
        wanted.push(Set::Learner);
    }
    if study.compares() {
        wanted.push(Set::Second);
    }
    if study.has_paper() {
        wanted.push(Set::Paper);
    }
    let mut sets = Vec::new();
    for species in &study.species {
        let measured: Result<Vec<(Set, Measured)>> =
            wanted.iter().map(|&set| Ok((set, study.measured(species, set)?))).collect();
        sets.push(Sets { species: species.name.clone(), measured: measured? });
    }
    let table = pooled(&sets, &[Set::Teacher, Set::Learner]);
    study.save("table.csv", table.csv().as_bytes())?;
    study.save("orders.csv", orders_csv(&sets).as_bytes())?;
    study.save("table.json", serde_json::to_string_pretty(&table)?.as_bytes())?;
    report::say(study.args, &serde_json::to_value(&table)?, table.text().trim_end(), false);

    let mut chapter = Chapter::new("table", "The appendix table");
    if study.compares() {
        criteria::write(study, &sets, &mut chapter)?;
    }
    appendix(&table, &pooled(&sets, &[Set::Paper]), &mut chapter);
    termination::write(study, &sets, &mut chapter)?;
    histograms::write(study, &sets, &mut chapter)?;
    Ok(chapter)
}

fn pooled(sets: &[Sets], of: &[Set]) -> Table {
    let rows = sets.iter().flat_map(|sets| of.iter().filter_map(|&set| sets.row(set)));
    let mut table = Table { rows: rows.collect() };
    table.add_totals();
    table
}

/// The metrics of every set order by order.
fn orders_csv(sets: &[Sets]) -> String {
    let mut out = "species,set,metric,order,mean,sd,samples\n".to_owned();
    for sets in sets {
        for (set, measured) in &sets.measured {
            for (metric, order) in
                Metric::ALL.into_iter().flat_map(|m| (0..ORDERS).map(move |o| (m, o)))
            {
                let m = measured.set.at_order(metric, order).moments();
                let (species, set, metric) = (&sets.species, set.symbol(), metric.symbol());
                let (mean, sd, count) = (m.mean, m.sd(), m.count);
                let _ = writeln!(out, "{species},{set},{metric},{order},{mean},{sd},{count}");
            }
        }
    }
    out
}

/// The table of the paper's appendix, metric by metric.
fn appendix(table: &Table, paper: &Table, chapter: &mut Chapter) {
    chapter.heading("The appendix table");
    chapter.text(
        "Mean ± standard deviation, of all branches, runs or nodes of all trees together; BN of the \
         trees. Lengths in metres, angles in radians. The paper's totals are left out: in print \
         some are swapped or repeat another column.",
    );
    let mut species: Vec<&str> = table.rows.iter().map(|row| row.species.as_str()).collect();
    let mut seen = std::collections::BTreeSet::new();
    species.retain(|name| seen.insert(*name));
    let header = [
        "species",
        "P published",
        "P",
        "Δ",
        "DT published",
        "Δ published",
        "DT",
        "DT − P",
        "paper",
    ];
    for metric in Metric::ALL {
        let of = |row: Option<&Row>| row.map(|row| row.moments[metric as usize]);
        let line = |name: &&str| {
            let moments = |set| of(table.row(name, set));
            line(name, metric, moments("P"), moments("DT"), of(paper.row(name, "paper")))
        };
        chapter.table(name(metric), &header, species.iter().map(line).collect());
    }
    let nodes = |table: &Table, name: &str, set: &str| table.row(name, set).map(|row| row.nodes);
    let line = |name: &&str| {
        let (p, dt) = (nodes(table, name, "P"), nodes(table, name, "DT"));
        let paper = nodes(paper, name, "paper");
        vec![Cell::from(*name), cell(p), cell(dt), difference(dt, p), cell(paper)]
    };
    let header = ["species", "P", "DT", "DT − P", "paper"];
    chapter.table("Nodes of each tree", &header, species.iter().map(line).collect());
}

fn line(
    species: &str,
    metric: Metric,
    p: Option<Moments>,
    dt: Option<Moments>,
    paper: Option<Moments>,
) -> Vec<Cell> {
    let row = published::find(species);
    let printed_p = row.and_then(|row| row.p.get(metric as usize).copied());
    let printed_dt = row.and_then(|row| row.dt.get(metric as usize).copied());
    let printed = |pair: Option<(f64, f64)>| {
        Cell::new(pair.map_or("–".to_owned(), |(mean, sd)| mean_and_sd(mean, sd)), Tone::Quiet)
    };
    let mut to_print = relative(p.map(|m| m.mean), printed_p.map(|pair| pair.0));
    let mut of_print = relative(printed_dt.map(|pair| pair.0), printed_p.map(|pair| pair.0));
    (to_print.tone, of_print.tone) = (Tone::Plain, Tone::Quiet);
    vec![
        Cell::from(species),
        printed(printed_p),
        cell(p),
        to_print,
        printed(printed_dt),
        of_print,
        cell(dt),
        difference(dt, p),
        cell(paper),
    ]
}

fn cell(moments: Option<Moments>) -> Cell {
    Cell::from(moments.map_or("–".to_owned(), |m| mean_and_sd(m.mean, m.sd())))
}

fn difference(a: Option<Moments>, b: Option<Moments>) -> Cell {
    relative(a.map(|m| m.mean), b.map(|m| m.mean))
}

fn relative(a: Option<f64>, b: Option<f64>) -> Cell {
    Cell::from(match (a, b) {
        (Some(a), Some(b)) if b != 0.0 => format!("{:+.1} %", 100.0 * (a - b) / b),
        _ => "–".to_owned(),
    })
}

const fn name(metric: Metric) -> &'static str {
    match metric {
        Metric::BranchLength => "BL: branch length, m",
        Metric::BranchNumber => "BN: branches of each tree",
        Metric::BranchingDistance => "BD: branching distance, m",
        Metric::NodeNumber => {
            "NN: children of each node that has any (the published values fit no definition tried)"
        }
        Metric::AngleChild1 => "A1: angle between parent and child 1, rad",
        Metric::AngleChild2 => "A2: angle between parent and child 2, rad",
        Metric::AngleChild3 => "A3: angle between parent and child 3, rad",
        Metric::NodeNumberWithEnds => "NN0: children of each node, ends included",
    }
}
