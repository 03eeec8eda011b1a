//! How different the trees of a set are from each other.

use serde::{Deserialize, Serialize};

/// What a feature of a set of trees is measured against: its mean and spread in another set.
#[derive(Clone, Debug, PartialEq)]
pub struct Yardstick {
    /// Index, mean and standard deviation of each feature that varies.
    features: Vec<(usize, f64, f64)>,
}

/// The mean distance between two trees of a set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The mean over all pairs.
    pub mean: f64,
    /// Its standard error; the trees are what was drawn, not the pairs.
    pub error: f64,
}

impl Yardstick {
    /// The yardstick of a set of trees, a row of features each. Features that are the same in all
    /// trees cannot be a measure and are left out.
    #[must_use]
    pub fn of(rows: &[Vec<f64>]) -> Self {
        let n = rows.len() as f64;
        let width = rows.first().map_or(0, Vec::len);
        let features = (0..width).filter_map(|i| {
            let mean = rows.iter().map(|row| row[i]).sum::<f64>() / n;
            let squares: f64 = rows.iter().map(|row| (row[i] - mean) * (row[i] - mean)).sum();
            let sd = (squares / (n - 1.0)).sqrt();
            (sd > 1e-9 * (1.0 + mean.abs())).then_some((i, mean, sd))
        });
        Self { features: features.collect() }
    }

    /// The mean over all pairs of trees of their distance
    ///
    /// `d(a, b) = √( Σ_k ((a_k − b_k) / s_k)² / 2K )`
    ///
    /// with the K features that vary and their standard deviations s. Where a set spreads as the
    /// yardstick's, d² is 1 on average. No feature counts for more than `LIMIT` deviations.
    ///
    /// The standard error is that of a U-statistic of two trees, `2 · sd(h) / √n`, with h the mean
    /// distance of a tree to all others (Hoeffding 1948).
    #[must_use]
    pub fn spread(&self, rows: &[Vec<f64>]) -> Spread {
        let n = rows.len();
        if n < 2 {
            return Spread::default();
        }
        let scores: Vec<Vec<f64>> = rows.iter().map(|row| self.scores(row)).collect();
        let to_others = |i: usize| {
            let others = (0..n).filter(|&j| j != i);
            others.map(|j| distance(&scores[i], &scores[j])).sum::<f64>() / (n - 1) as f64
        };
        let means: Vec<f64> = (0..n).map(to_others).collect();
        let mean = means.iter().sum::<f64>() / n as f64;
        let squares: f64 = means.iter().map(|h| (h - mean) * (h - mean)).sum();
        let error = 2.0 * (squares / (n - 1) as f64 / n as f64).sqrt();
        Spread { mean, error }
    }

    fn scores(&self, row: &[f64]) -> Vec<f64> {
        let score = |&(i, mean, sd): &(usize, f64, f64)| (row[i] - mean) / sd;
        self.features.iter().map(score).map(|z| z.clamp(-LIMIT, LIMIT)).collect()
    }
}

/// Deviations from the yardstick's mean beyond which a feature says no more: one that hardly varies
/// in the yardstick would decide alone.
const LIMIT: f64 = 5.0;

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / (2.0 * a.len().max(1) as f64)).sqrt()
}

#[cfg(test)]
mod tests {
    use deeptree_graph::{Lineage, Purpose, Seed};

    use super::*;

    #[test]
    fn distances_of_three_points_worked_out_by_hand() {
        // The first feature has mean 1 and variance 2 over the yardstick, the second never varies.
        let yardstick = Yardstick::of(&[vec![0.0, 7.0], vec![2.0, 7.0]]);
        // In units of √2 · √2: distances 1, 3 and 2.
        let spread = yardstick.spread(&[vec![1.0, 7.0], vec![3.0, 0.0], vec![-3.0, 9.0]]);
        assert!((spread.mean - (1.0 + 3.0 + 2.0) / 3.0).abs() < 1e-12, "{spread:?}");
        // Means to the others: 1.5, 2, 2.5; their variance is 0.25.
        assert!((spread.error - 2.0 * (0.25f64 / 3.0).sqrt()).abs() < 1e-12, "{spread:?}");
    }

    #[test]
    fn sets_of_one_law_spread_alike_and_copies_do_not_spread() {
        let mut draws = Seed(4).draws(Lineage::ROOT, Purpose::Evaluation);
        let mut set = |n: usize, sd: f64| -> Vec<Vec<f64>> {
            (0..n).map(|_| (0..40).map(|_| 3.0 + sd * draws.normal()).collect()).collect()
        };
        let (measure, same, half) = (set(400, 1.0), set(200, 1.0), set(200, 0.5));
        let yardstick = Yardstick::of(&measure);
        let (same, half) = (yardstick.spread(&same), yardstick.spread(&half));
        // The root mean square is 1, the mean a little less: 1 − 1/(4K) for K normal features.
        assert!((same.mean - 0.994).abs() < 2.0 * same.error, "{same:?}");
        assert!((half.mean - 0.497).abs() < 2.0 * half.error, "{half:?}");
        assert!((0.001..0.01).contains(&half.error) && same.error < 0.01);
        let copies = vec![measure[0].clone(); 10];
        assert_eq!(yardstick.spread(&copies), Spread::default());
    }
}
