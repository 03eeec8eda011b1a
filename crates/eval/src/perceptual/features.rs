//! From samples to vectors of fixed length.

use super::samples::{Samples, Variables};
use super::variable::{VARIABLES, Variable};

/// The statistics of each variable, in order.
pub const STATISTICS: [&str; 5] = ["count", "min", "max", "mean", "var"];

/// Length of [`Variables::statistics`].
pub const STATISTICS_LEN: usize = VARIABLES * STATISTICS.len();

/// Bins of each histogram.
pub const BINS: usize = 8;

/// Length of [`BinEdges::histograms`].
pub const HISTOGRAMS_LEN: usize = VARIABLES * BINS;

/// Samples below this quantile of the reference share the first bin.
const LOWER_QUANTILE: f64 = 0.001;

/// Samples above this quantile of the reference share the last bin.
const UPPER_QUANTILE: f64 = 0.999;

impl Variables {
    /// The [`STATISTICS`] of each variable in turn; [`STATISTICS_LEN`] numbers.
    ///
    /// Variances are of the population. Samples that are not finite are dropped; all statistics
    /// of a variable without samples are 0. The minimum, maximum, mean and variance of pairs are
    /// of positions and weights taken together, the count is that of the pairs.
    ///
    /// # Source
    ///
    /// Polasek et al. 2021, ICTreeF. Deviation: samples are not standardised, and the count is in
    /// addition.
    #[must_use]
    pub fn statistics(&self) -> Vec<f32> {
        Variable::ALL.iter().flat_map(|&variable| statistics(self.get(variable))).collect()
    }
}

fn statistics(samples: &Samples) -> [f32; STATISTICS.len()] {
    let is_paired = matches!(samples, Samples::Pairs(_));
    let numbers: Vec<f64> = samples
        .weighted()
        .flat_map(|(x, weight)| [Some(x), is_paired.then_some(weight)])
        .flatten()
        .map(f64::from)
        .collect();
    if numbers.is_empty() {
        return [0.0; STATISTICS.len()];
    }
    let n = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / n;
    let variance = numbers.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
    let min = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let max = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    [samples.weighted().count() as f32, min as f32, max as f32, mean as f32, variance as f32]
}

/// The edges of the bins of each variable: a property of a reference set of trees.
#[derive(Clone, Debug, PartialEq)]
pub struct BinEdges {
    edges: Vec<[f64; BINS + 1]>,
}

impl BinEdges {
    /// Takes the edges from the pooled samples of a reference set.
    ///
    /// Bins are of equal width between the 0.1 % and the 99.9 % quantile. Where there are samples
    /// below or above, the first or the last bin reaches from there to the extreme, and is one of
    /// the eight. All edges of a variable without samples are 0.
    ///
    /// # Source
    ///
    /// Polasek et al. 2021, ICTreeF
    #[must_use]
    pub fn fit(reference: &[Variables]) -> Self {
        let edges = Variable::ALL.iter().map(|&variable| {
            let samples = reference.iter().map(|tree| tree.get(variable));
            edges(samples.flat_map(Samples::positions).map(f64::from).collect())
        });
        Self { edges: edges.collect() }
    }

    /// The edges of a variable's bins, ascending.
    #[must_use]
    pub fn get(&self, variable: Variable) -> &[f64; BINS + 1] {
        &self.edges[variable as usize]
    }

    /// The densities of each variable in its bins, in turn; [`HISTOGRAMS_LEN`] numbers.
    ///
    /// A density is the share of the samples (of their weights, for pairs) in a bin over its
    /// width. Samples outside the bins do not count. Bins without width, and those of a tree
    /// without samples, have density 0.
    #[must_use]
    pub fn histograms(&self, tree: &Variables) -> Vec<f32> {
        let all = Variable::ALL.iter();
        all.flat_map(|&variable| densities(self.get(variable), tree.get(variable))).collect()
    }
}

fn edges(mut samples: Vec<f64>) -> [f64; BINS + 1] {
    samples.sort_unstable_by(f64::total_cmp);
    let (Some(&min), Some(&max)) = (samples.first(), samples.last()) else {
        return [0.0; BINS + 1];
    };
    let lower = quantile(&samples, LOWER_QUANTILE);
    let upper = quantile(&samples, UPPER_QUANTILE);
    // The uniform bins: all but those that reach to the extremes.
    let first = usize::from(min < lower);
    let last = BINS - usize::from(max > upper);
    std::array::from_fn(|i| match i {
        i if i < first => min,
        i if i > last => max,
        i if i == last => upper,
        i => lower + (upper - lower) * ((i - first) as f64 / (last - first) as f64),
    })
}

/// The quantile of sorted samples, linear between them.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let at = q * (sorted.len() - 1) as f64;
    let below = at.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (sorted[above] - sorted[below]) * at.fract()
}

fn densities(edges: &[f64; BINS + 1], samples: &Samples) -> [f32; BINS] {
    let mut sums = [0.0; BINS];
    for (x, weight) in samples.weighted() {
        let x = f64::from(x);
        if edges[0] <= x && x <= edges[BINS] {
            // The last bin has its upper edge, too.
            let bin = edges[1..BINS].partition_point(|&edge| edge <= x);
            sums[bin] += f64::from(weight);
        }
    }
    let total: f64 = sums.iter().sum();
    std::array::from_fn(|i| {
        let density = sums[i] / (edges[i + 1] - edges[i]) / total;
        if density.is_finite() { density as f32 } else { 0.0 }
    })
}
