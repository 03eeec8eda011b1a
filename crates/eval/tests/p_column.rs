//! The growth model against the paper's P column.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_eval::{Metric, Row, TreeMetrics, published};
use deeptree_graph::Seed;
use deeptree_growth::{Profile, Species, grow};

/// Trees a species; the tolerances below widen by the sampling error of so few.
const TREES: u64 = 40;

/// Relative tolerance of the means of BN, BL and BD.
fn tolerance(species: &str, metric: Metric) -> f64 {
    match (species, metric) {
        ("beech", Metric::BranchingDistance) => 0.10,
        ("willow" | "oak", Metric::BranchNumber) => 0.10,
        _ => 0.05,
    }
}

/// Mean and standard error of a metric's mean, from the scatter between trees.
fn mean_and_error(trees: &[TreeMetrics], metric: Metric) -> (f64, f64) {
    let mut pooled = Row::default();
    trees.iter().for_each(|tree| pooled.add(tree, false));
    let mean = pooled.moments[metric as usize].mean;
    // A ratio estimate: each tree's sum of samples less the mean times their number.
    let total: f64 = trees.iter().map(|tree| tree.get(metric).count as f64).sum();
    let squares: f64 = trees
        .iter()
        .map(|tree| tree.get(metric))
        .map(|m| (m.count as f64 * (m.mean - mean)).powi(2))
        .sum();
    (mean, squares.sqrt() / total)
}

fn check(name: &str) {
    let species = Species::named(name).unwrap();
    let parameters = species.parameters(Profile::Reference);
    let trees: Vec<TreeMetrics> = (0..TREES)
        .map(|seed| TreeMetrics::of(&grow(name, parameters, Seed(seed)).unwrap().tree))
        .collect();
    let published = published::find(name).unwrap().p;
    for metric in [Metric::BranchNumber, Metric::BranchLength, Metric::BranchingDistance] {
        let (mean, error) = mean_and_error(&trees, metric);
        let target = published[metric as usize].0;
        let allowed = tolerance(name, metric) * target + 3.0 * error;
        assert!(
            (mean - target).abs() < allowed,
            "{name} {}: {mean:.3} ± {error:.3}, published {target}",
            metric.symbol()
        );
    }
    for metric in [Metric::AngleChild1, Metric::AngleChild2, Metric::AngleChild3] {
        let (mean, error) = mean_and_error(&trees, metric);
        let target = published[metric as usize].0;
        assert!(
            (mean - target).abs() < 0.01 + 3.0 * error,
            "{name} {}: {mean:.4} ± {error:.4} rad, published {target}",
            metric.symbol()
        );
    }
}

macro_rules! reproduces_the_published_column {
    ($($name:ident)*) => { $(
        #[test]
        fn $name() {
            check(stringify!($name));
        }
    )* };
}

reproduces_the_published_column!(beech corkscrew maple oak pine tulip walnut willow);
