//! The evaluation table: one column of metrics a set of trees, species by species.

use std::fmt::Write as _;

use serde::Serialize;

use crate::metrics::{Metric, Moments, TreeMetrics};
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
    pub moments: [Moments; 7],
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

/// Rows of several species and sets, in the order they were measured.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Table {
    /// The rows.
    pub rows: Vec<Row>,
}

impl Table {
    fn row(&self, species: &str, set: &str) -> Option<&Row> {
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
            if let Some(row) = dt {
                let _ = writeln!(
                    out,
                    "       {} of {} DT hit the node budget",
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
            |pair: Option<(f64, f64)>| pair.map_or("–".to_owned(), |(m, s)| pair_cell(m, s));
        let measured = |m: Option<&Moments>| m.map_or("–".to_owned(), cell);
        let published_p = published.map(|row| row.p[metric as usize]);
        let difference = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => format!("{:+.1}%", 100.0 * (a - b) / b),
            _ => "–".to_owned(),
        };
        format!(
            "{:>17} {:>17} {:>8} {:>17} {:>17} {:>8}",
            printed(published_p),
            measured(p),
            difference(p.map(|m| m.mean), published_p.map(|pair| pair.0)),
            printed(published.map(|row| row.dt[metric as usize])),
            measured(dt),
            difference(dt.map(|m| m.mean), p.map(|m| m.mean)),
        )
    }

    /// The table as CSV: one line a species, set and metric.
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
        out
    }
}

fn cell(moments: &Moments) -> String {
    pair_cell(moments.mean, moments.sd())
}

fn pair_cell(mean: f64, sd: f64) -> String {
    let digits = if mean.abs() < 1.5 {
        3
    } else if mean.abs() < 20.0 {
        2
    } else {
        0
    };
    format!("{mean:.digits$} ± {sd:.digits$}")
}
