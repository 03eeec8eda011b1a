//! The variables of many trees together: thinned to quantiles, and how far chance moves them.

use deeptree_graph::{Lineage, Purpose, Seed};
use serde::{Deserialize, Serialize};

use super::samples::Variables;
use super::variable::Variable;
use crate::auc::shuffle;
use crate::distances::Distances;
use crate::packed;

/// Quantiles that pooled samples are thinned to.
const QUANTILES: usize = 1024;

/// Times a set of trees is halved to see how far chance moves a variable.
const HALVINGS: usize = 39;

/// Of 39 halvings and the distance in question, two are the largest 5 %.
const BEYOND: usize = 2;

/// The samples of one variable of all trees of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pooled {
    /// How many samples there are.
    pub samples: u64,
    /// Their mean, by weight.
    pub mean: f64,
    /// The quantiles (i + ½) / 1024, fewer only when there are no samples.
    ///
    /// Their distribution function is within 1/2048 of that of the samples.
    #[serde(with = "packed")]
    pub quantiles: Vec<f32>,
}

/// A sample with the number of its tree.
#[derive(Clone, Copy)]
struct Sample {
    x: f32,
    weight: f32,
    tree: u32,
}

impl Pooled {
    /// Pools a variable of a set of trees.
    #[must_use]
    pub fn of(trees: &[Variables], variable: Variable) -> Self {
        Self::all(&sorted(trees, variable))
    }

    fn all(samples: &[Sample]) -> Self {
        let weight: f64 = samples.iter().map(|sample| f64::from(sample.weight)).sum();
        let sum: f64 = samples.iter().map(|s| f64::from(s.x) * f64::from(s.weight)).sum();
        Self {
            samples: samples.len() as u64,
            mean: if weight > 0.0 { sum / weight } else { 0.0 },
            quantiles: thin(samples, |_| true),
        }
    }

    /// Kolmogorov–Smirnov and Wasserstein distance of two sets; none where one has no samples.
    ///
    /// Exact but for the thinning: the first to 1/1024.
    #[must_use]
    pub fn distances(&self, other: &Self) -> Option<[f64; 2]> {
        distances(&self.quantiles, &other.quantiles)
    }
}

/// How far apart two sets of trees of one law are in one variable.
///
/// Samples of one tree are alike, so no formula for independent samples tells; a set's own halves
/// do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Trees of the two halves.
    halves: [usize; 2],
    /// What 5 % of the halvings exceed: Kolmogorov–Smirnov, Wasserstein.
    limits: [f64; 2],
}

impl Scatter {
    /// Halves a set of trees at random, again and again, and pools it on the way.
    ///
    /// No scatter of fewer than two trees, or of trees without samples.
    #[must_use]
    pub fn of(trees: &[Variables], variable: Variable, seed: Seed) -> (Pooled, Option<Self>) {
        let samples = sorted(trees, variable);
        let pooled = Pooled::all(&samples);
        let half = trees.len() / 2;
        let split = |halving: usize| {
            let draws = seed.draws(Lineage::ROOT, Purpose::Evaluation);
            let mut order: Vec<usize> = (0..trees.len()).collect();
            shuffle(&mut order, &mut draws.at(variable as u64).at(halving as u64));
            let mut is_first = vec![false; trees.len()];
            order[..half].iter().for_each(|&tree| is_first[tree] = true);
            let of = |first: bool| thin(&samples, |tree| is_first[tree as usize] == first);
            distances(&of(true), &of(false))
        };
        let seen: Option<Vec<[f64; 2]>> = (0..HALVINGS).map(split).collect();
        let limit = |seen: &[[f64; 2]], kind: usize| {
            let mut values: Vec<f64> = seen.iter().map(|both| both[kind]).collect();
            values.sort_by(f64::total_cmp);
            values[HALVINGS - BEYOND]
        };
        let scatter = seen.filter(|_| half > 0).map(|seen| Self {
            halves: [half, trees.len() - half],
            limits: [limit(&seen, 0), limit(&seen, 1)],
        });
        (pooled, scatter)
    }

    /// The distances that two sets of `n` and `m` trees of one law exceed in 5 % of all cases.
    ///
    /// Distances of sets of one law go with `√(1/n + 1/m)`.
    #[must_use]
    pub fn limits(&self, n: usize, m: usize) -> [f64; 2] {
        let spread = |[n, m]: [usize; 2]| (1.0 / n as f64 + 1.0 / m as f64).sqrt();
        self.limits.map(|limit| limit * spread([n, m]) / spread(self.halves))
    }
}

fn distances(a: &[f32], b: &[f32]) -> Option<[f64; 2]> {
    let wide = |samples: &[f32]| samples.iter().copied().map(f64::from).collect::<Vec<_>>();
    let Distances { ks, wasserstein, .. } = Distances::between(&wide(a), &wide(b))?;
    Some([ks, wasserstein])
}

fn sorted(trees: &[Variables], variable: Variable) -> Vec<Sample> {
    let of = |(tree, variables): (usize, &'_ Variables)| {
        let samples = variables.get(variable).weighted();
        samples.map(|(x, weight)| Sample { x, weight, tree: tree as u32 }).collect::<Vec<_>>()
    };
    let mut samples: Vec<Sample> = trees.iter().enumerate().flat_map(of).collect();
    samples.sort_by(|a, b| a.x.total_cmp(&b.x));
    samples
}

/// The [`QUANTILES`] of the sorted samples of some trees, by weight.
fn thin(samples: &[Sample], keep: impl Fn(u32) -> bool) -> Vec<f32> {
    // The weight at each place: one of the kinds of branching may weigh less than nothing in one
    // tree, but not in all.
    let mut places: Vec<(f32, f64)> = Vec::new();
    for sample in samples.iter().filter(|sample| keep(sample.tree)) {
        match places.last_mut() {
            Some((x, weight)) if *x == sample.x => *weight += f64::from(sample.weight),
            _ => places.push((sample.x, f64::from(sample.weight))),
        }
    }
    let total: f64 = places.iter().map(|place| place.1.max(0.0)).sum();
    let mut quantiles = Vec::with_capacity(QUANTILES);
    let mut below = 0.0;
    for (x, weight) in places {
        below += weight.max(0.0);
        while quantiles.len() < QUANTILES
            && below >= (quantiles.len() as f64 + 0.5) / QUANTILES as f64 * total
            && total > 0.0
        {
            quantiles.push(x);
        }
    }
    quantiles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples 1, 2, … of as many trees, each of weight 1.
    fn ramp(n: u32) -> Vec<Sample> {
        (0..n).map(|k| Sample { x: k as f32 + 1.0, weight: 1.0, tree: k }).collect()
    }

    #[test]
    fn quantiles_of_a_ramp_are_the_ramp() {
        let all = Pooled::all(&ramp(2048));
        assert_eq!((all.samples, all.quantiles.len()), (2048, QUANTILES));
        assert!((all.mean - 1024.5).abs() < 1e-9);
        // Quantile (i + ½)/1024 of 1 … 2048 is 2 i + 1.
        assert!(all.quantiles.iter().enumerate().all(|(i, &x)| x == 2.0 * i as f32 + 1.0));
        let shifted: Vec<Sample> =
            ramp(2048).iter().map(|s| Sample { x: s.x + 512.0, ..*s }).collect();
        let [ks, wasserstein] = all.distances(&Pooled::all(&shifted)).unwrap();
        assert!((ks - 0.25).abs() <= 1.0 / 1024.0 && (wasserstein - 512.0).abs() < 1e-6);
    }

    #[test]
    fn a_sample_of_weight_three_counts_as_three() {
        let sample = |x, weight| Sample { x, weight, tree: 0 };
        let weighted = Pooled::all(&[sample(1.0, 3.0), sample(2.0, 1.0)]);
        assert_eq!(weighted.mean, 1.25);
        let at_one = weighted.quantiles.iter().filter(|&&x| x == 1.0).count();
        assert_eq!((at_one, weighted.quantiles.len()), (QUANTILES / 4 * 3, QUANTILES));
        assert_eq!(Pooled::all(&[]).distances(&weighted), None);
    }

    #[test]
    fn limits_shrink_with_the_root_of_the_trees() {
        let scatter = Scatter { halves: [25, 25], limits: [0.2, 3.0] };
        let close = |found: [f64; 2], ks: f64| (found[0] - ks).abs() < 1e-12;
        assert!(close(scatter.limits(25, 25), 0.2) && close(scatter.limits(100, 100), 0.1));
        // 1/40 + 1/40 = 1/100 + 1/(200/3) = 0.05 against 0.08.
        assert!(close(scatter.limits(40, 40), 0.2 * (0.05f64 / 0.08).sqrt()));
        assert!((scatter.limits(100, 100)[1] - 1.5).abs() < 1e-12);
    }
}
