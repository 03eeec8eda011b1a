//! The evaluation table: one column of metrics a set of trees, species by species.

use std::fmt::Write as _;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::metrics::{METRICS, Metric, Moments, TreeMetrics};
use crate::published;

/// The pooled metrics of one set of trees of one species.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// Name of the species.
    pub species: String,
    /// Which set: `P` grown by the procedural model, `DT` by the networks.
    pub set: String,
    /// Trees measured.
    pub trees: u64,
    /// Trees that were cut off by a node budget.
    pub hit_budget: u64,
    /// Nodes of each tree.
    pub nodes: Moments,
    /// Moments of each of [`Metric::ALL`].
    #[serde(rename = "metrics", serialize_with = "by_symbol")]
    pub moments: [Moments; METRICS],
}

/// Metrics under their symbols.
fn by_symbol<S: Serializer>(
    moments: &[Moments; METRICS],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(METRICS))?;
    for (metric, moments) in Metric::ALL.iter().zip(moments) {
        map.serialize_entry(metric.symbol(), moments)?;
    }
    map.end()
}

impl Row {
    /// An empty row.
    #[must_use]
    pub fn new(species: &str, set: &str) -> Self {
        Self { species: species.to_owned(), set: set.to_owned(), ..Self::default() }
    }

    /// Pools one more tree.
    pub fn add(&mut self, tree: &TreeMetrics, hit_budget: bool) {
        self.trees += 1;
        self.hit_budget += u64::from(hit_budget);
        self.nodes.add(tree.nodes as f64);
        for (pooled, one) in self.moments.iter_mut().zip(&tree.moments) {
            pooled.merge(one);
        }
    }
}

impl Row {
    /// The row in words, each metric beside what the paper printed for the species.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out =
            format!("{}: {} trees, {} nodes each\n", self.species, self.trees, cell(&self.nodes));
        let published = published::find(&self.species);
        for (metric, moments) in Metric::ALL.into_iter().zip(&self.moments) {
            let _ = write!(out, "  {:<4} {:>17}", metric.symbol(), cell(moments));
            let printed = |row: &published::PublishedSpecies| {
                Some([*row.p.get(metric as usize)?, *row.dt.get(metric as usize)?])
            };
            if let Some([p, dt]) = published.and_then(printed) {
                let (p, dt) = (mean_and_sd(p.0, p.1), mean_and_sd(dt.0, dt.1));
                let _ = write!(out, "   published: P {p}, DT {dt}");
            }
            out.push('\n');
        }
        out
    }
}

/// The species of the rows that pool all.
const TOTAL: &str = "total";

/// Rows of several species and sets, in the order they were measured.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Table {
    /// The rows.
    pub rows: Vec<Row>,
}

impl Table {
    /// Adds a row `total` for each set: the trees of all species together.
    pub fn add_totals(&mut self) {
        let mut sets: Vec<String> = Vec::new();
        for row in &self.rows {
            if !sets.contains(&row.set) {
                sets.push(row.set.clone());
            }
        }
        for set in sets {
            let mut total = Row::new(TOTAL, &set);
            for row in self.rows.iter().filter(|row| row.set == set) {
                total.trees += row.trees;
                total.hit_budget += row.hit_budget;
                total.nodes.merge(&row.nodes);
                for (all, one) in total.moments.iter_mut().zip(&row.moments) {
                    all.merge(one);
                }
            }
            self.rows.push(total);
        }
    }

    /// The row of a species and set.
    #[must_use]
    pub fn row(&self, species: &str, set: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.species == species && row.set == set)
    }

    fn species(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !names.contains(&row.species.as_str()) {
                names.push(&row.species);
            }
        }
        names
    }

    /// The table as text: published and measured P and DT side by side, and what they differ by.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out = String::new();
        for species in self.species() {
            let (p, dt) = (self.row(species, "P"), self.row(species, "DT"));
            let count = |row: Option<&Row>| row.map_or(0, |row| row.trees);
            let _ = writeln!(out, "{species}: {} trees P, {} trees DT", count(p), count(dt));
            let _ = writeln!(
                out,
                "       {:>17} {:>17} {:>8} {:>17} {:>17} {:>8}",
                "P published", "P", "Δ", "DT published", "DT", "DT − P"
            );
            for metric in Metric::ALL {
                let _ = writeln!(out, "  {:<4} {}", metric.symbol(), self.line(species, metric));
            }
            let nodes = |row: Option<&Row>| row.map_or("–".to_owned(), |row| cell(&row.nodes));
            let _ = writeln!(out, "  {:<4} {:>35} {:>44}", "N", nodes(p), nodes(dt));
            for (set, row) in [("P", p), ("DT", dt)] {
                let Some(row) = row else { continue };
                let _ = writeln!(
                    out,
                    "       {} of {} {set} hit the node budget",
                    row.hit_budget, row.trees
                );
            }
        }
        out
    }

    fn line(&self, species: &str, metric: Metric) -> String {
        let moments = |set| self.row(species, set).map(|row| &row.moments[metric as usize]);
        let published = published::find(species);
        let (p, dt) = (moments("P"), moments("DT"));
        let printed =
            |pair: Option<(f64, f64)>| pair.map_or("–".to_owned(), |(m, s)| mean_and_sd(m, s));
        let measured = |m: Option<&Moments>| m.map_or("–".to_owned(), cell);
        let published_p = published.and_then(|row| row.p.get(metric as usize).copied());
        let published_dt = published.and_then(|row| row.dt.get(metric as usize).copied());
        let difference = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => format!("{:+.1}%", 100.0 * (a - b) / b),
            _ => "–".to_owned(),
        };
        format!(
            "{:>17} {:>17} {:>8} {:>17} {:>17} {:>8}",
            printed(published_p),
            measured(p),
            difference(p.map(|m| m.mean), published_p.map(|pair| pair.0)),
            printed(published_dt),
            measured(dt),
            difference(dt.map(|m| m.mean), p.map(|m| m.mean)),
        )
    }

    /// The table as CSV: one line a species, set and metric; the paper's as `P published` and
    /// `DT published`, without counts.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut out = "species,set,trees,hit_budget,metric,mean,sd,samples\n".to_owned();
        for row in &self.rows {
            let named = Metric::ALL.iter().map(|metric| metric.symbol()).zip(&row.moments);
            for (name, m) in named.chain([("nodes", &row.nodes)]) {
                let Row { species, set, trees, hit_budget, .. } = row;
                let (mean, sd, n) = (m.mean, m.sd(), m.count);
                let _ =
                    writeln!(out, "{species},{set},{trees},{hit_budget},{name},{mean},{sd},{n}");
            }
        }
        for species in self.species() {
            let Some(row) = published::find(species) else { continue };
            for (set, values) in [("P published", row.p), ("DT published", row.dt)] {
                for (metric, (mean, sd)) in Metric::ALL.iter().zip(values) {
                    let _ = writeln!(out, "{species},{set},,,{},{mean},{sd},", metric.symbol());
                }
            }
        }
        out
    }
}

fn cell(moments: &Moments) -> String {
    mean_and_sd(moments.mean, moments.sd())
}

/// A mean with its standard deviation, to as many digits as such figures deserve.
#[must_use]
pub fn mean_and_sd(mean: f64, sd: f64) -> String {
    let digits = if mean.abs() < 1.5 {
        3
    } else if mean.abs() < 20.0 {
        2
    } else {
        0
    };
    format!("{mean:.digits$} ± {sd:.digits$}")
}
