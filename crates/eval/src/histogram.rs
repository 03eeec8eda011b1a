//! Counts of samples in narrow bins, wide enough apart to keep for every set of trees.

use serde::{Deserialize, Serialize};

use crate::metrics::Metric;
use crate::packed;

/// Bins a histogram has at most; what lies above is counted in the last.
const MOST_BINS: usize = 4096;

/// How many samples lie in each of the bins `[k w, (k + 1) w)`.
///
/// The bins start at 0, as all that is counted does; those after the last sample are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// w: width of a bin, in the samples' unit.
    pub width: f64,
    /// Samples in each bin.
    #[serde(with = "packed")]
    pub counts: Vec<u32>,
}

impl Histogram {
    /// No samples yet, in bins of this width.
    #[must_use]
    pub const fn new(width: f64) -> Self {
        Self { width, counts: Vec::new() }
    }

    /// No samples yet, in bins that are narrow for the metric.
    #[must_use]
    pub const fn of_metric(metric: Metric) -> Self {
        Self::new(match metric {
            Metric::BranchLength | Metric::BranchingDistance => 0.05,
            Metric::BranchNumber => 10.0,
            Metric::NodeNumber | Metric::NodeNumberWithEnds => 1.0,
            Metric::AngleChild1 | Metric::AngleChild2 | Metric::AngleChild3 => 0.005,
        })
    }

    /// Counts a sample; one below 0 as 0.
    pub fn add(&mut self, x: f64) {
        let bin = ((x / self.width) as usize).min(MOST_BINS - 1);
        if bin >= self.counts.len() {
            self.counts.resize(bin + 1, 0);
        }
        self.counts[bin] += 1;
    }

    /// Adds the counts of another histogram of the same bins.
    pub fn merge(&mut self, other: &Self) {
        if other.counts.len() > self.counts.len() {
            self.counts.resize(other.counts.len(), 0);
        }
        for (sum, count) in self.counts.iter_mut().zip(&other.counts) {
            *sum += count;
        }
    }

    /// How many samples were counted.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.counts.iter().map(|&count| u64::from(count)).sum()
    }

    /// The bin below which less than the share `q` of the samples lies, and that reaches it.
    #[must_use]
    pub fn quantile_bin(&self, q: f64) -> usize {
        let goal = q * self.total() as f64;
        let mut below = 0.0;
        for (bin, &count) in self.counts.iter().enumerate() {
            below += f64::from(count);
            if below >= goal {
                return bin;
            }
        }
        self.counts.len().saturating_sub(1)
    }

    /// Shares of all samples in `bins` wider bins of `merged` narrow ones each, from bin `first`
    /// on. What lies outside is in none of them.
    #[must_use]
    pub fn shares(&self, first: usize, merged: usize, bins: usize) -> Vec<f64> {
        let total = self.total().max(1) as f64;
        let share = |bin: usize| {
            let counts = self.counts.iter().skip(first + bin * merged).take(merged);
            counts.map(|&count| f64::from(count)).sum::<f64>() / total
        };
        (0..bins).map(share).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_counted_where_they_lie() {
        let mut histogram = Histogram::new(0.5);
        [0.0, 0.4, 0.5, 2.2, -1.0].into_iter().for_each(|x| histogram.add(x));
        assert_eq!(histogram.counts, [3, 1, 0, 0, 1]);
        let mut more = Histogram::new(0.5);
        more.add(3.1);
        more.merge(&histogram);
        assert_eq!((more.counts.as_slice(), more.total()), ([3, 1, 0, 0, 1, 0, 1].as_slice(), 6));
        histogram.add(1e300);
        assert_eq!(histogram.counts.len(), MOST_BINS);
    }

    #[test]
    fn wider_bins_have_the_shares_of_the_narrow_ones() {
        let histogram = Histogram { width: 1.0, counts: vec![1, 2, 3, 4] };
        assert_eq!(histogram.shares(1, 2, 2), [0.5, 0.4]);
        assert_eq!([0.0, 0.1, 0.3, 0.31, 1.0].map(|q| histogram.quantile_bin(q)), [0, 0, 1, 2, 3]);
    }
}
