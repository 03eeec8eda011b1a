//! How far a mean and a standard deviation over the nodes of many trees can be trusted.
//!
//! Nodes of one tree are alike, so the trees are what is independent: the error is that of leaving
//! one tree out after the other.

use serde::{Deserialize, Serialize};

use crate::metrics::Moments;

/// A pooled mean and standard deviation, each with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Trees that went into it.
    pub trees: usize,
    /// Mean of all samples of all trees.
    pub mean: f64,
    /// Its standard error.
    pub mean_error: f64,
    /// Standard deviation of all samples of all trees.
    pub sd: f64,
    /// Its standard error.
    pub sd_error: f64,
}

impl Estimate {
    /// Pools the samples of trees, given the moments of each tree's own.
    ///
    /// The delete-one jackknife over trees: `se² = (n − 1)/n Σ_i (θ₍ᵢ₎ − θ̄)²`, where θ₍ᵢ₎ is the
    /// statistic without tree i. Of fewer than two trees the errors are infinite.
    ///
    /// # Source
    ///
    /// Tukey 1958; Efron and Tibshirani 1993, "An Introduction to the Bootstrap", ch. 11
    #[must_use]
    pub fn of(trees: &[Moments]) -> Self {
        let mut all = Moments::default();
        trees.iter().for_each(|tree| all.merge(tree));
        let left: Vec<Moments> = trees.iter().map(|tree| all.without(tree)).collect();
        Self {
            trees: trees.len(),
            mean: all.mean,
            mean_error: error(left.iter().map(|rest| rest.mean)),
            sd: all.sd(),
            sd_error: error(left.iter().map(Moments::sd)),
        }
    }
}

/// A statistic of blocks that are drawn independently, and its standard error by the jackknife:
/// `statistic` is asked for its value of all `count` blocks, and of all but one.
///
/// Of fewer than two blocks the error is infinite.
#[must_use]
pub fn leave_one_out(count: usize, statistic: impl Fn(Option<usize>) -> f64) -> (f64, f64) {
    (statistic(None), error((0..count).map(|i| statistic(Some(i)))))
}

fn error(left: impl Iterator<Item = f64>) -> f64 {
    let mut moments = Moments::default();
    moments.extend(left);
    let [n, _, squares] = moments.parts();
    if n < 2.0 { f64::INFINITY } else { ((n - 1.0) / n * squares).sqrt() }
}

/// How far a statistic of one set of trees is from the teacher's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// `(x − p) / p`
    pub relative: f64,
    /// The standard error that such a difference has if the set follows the teacher's law.
    ///
    /// `se_p √(1 + n_p / n) / p`: from the teacher's own scatter, so that a set does not buy itself
    /// room by scattering more.
    pub error: f64,
    /// How far the two may be apart.
    pub goal: f64,
}

/// Standard errors that a difference may be of chance.
pub const CHANCE: f64 = 2.0;

impl Difference {
    /// Of the means, to be within `goal` of each other.
    #[must_use]
    pub fn of_means(teacher: &Estimate, other: &Estimate, goal: f64) -> Self {
        Self::new((teacher.mean, teacher.mean_error), other.mean, ratio(teacher, other), goal)
    }

    /// Of the standard deviations, to be within `goal` of each other.
    #[must_use]
    pub fn of_sds(teacher: &Estimate, other: &Estimate, goal: f64) -> Self {
        Self::new((teacher.sd, teacher.sd_error), other.sd, ratio(teacher, other), goal)
    }

    fn new((p, error): (f64, f64), x: f64, ratio: f64, goal: f64) -> Self {
        Self { relative: (x - p) / p, error: error / p.abs() * (1.0 + ratio).sqrt(), goal }
    }

    /// What is left of the difference beyond [`CHANCE`] times its error.
    #[must_use]
    pub fn beyond_chance(&self) -> f64 {
        (self.relative.abs() - CHANCE * self.error).max(0.0)
    }

    /// Is it within the goal, beyond the sampling error?
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.beyond_chance() <= self.goal
    }
}

fn ratio(teacher: &Estimate, other: &Estimate) -> f64 {
    teacher.trees as f64 / other.trees as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    fn tree(samples: &[f64]) -> Moments {
        let mut moments = Moments::default();
        moments.extend(samples.iter().copied());
        moments
    }

    #[test]
    fn of_one_sample_a_tree_the_error_of_the_mean_is_the_textbooks() {
        let samples = [2.0, 3.0, 7.0, 1.0, 12.0];
        let estimate = Estimate::of(&samples.map(|x| tree(&[x])));
        // Mean 5, squares 9 + 4 + 4 + 16 + 49 = 82; s² = 82/4, se = s/√5, sd of the population.
        assert!((estimate.mean - 5.0).abs() < 1e-12);
        assert!((estimate.mean_error - (82.0f64 / 4.0 / 5.0).sqrt()).abs() < 1e-12);
        assert!((estimate.sd - (82.0f64 / 5.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn errors_of_trees_of_many_samples_are_those_worked_out_by_hand() {
        // Without each of {0, 2}, {4} and {6}: means 5, 8/3 and 2; variances 1, 56/9 and 8/3.
        let estimate = Estimate::of(&[tree(&[0.0, 2.0]), tree(&[4.0]), tree(&[6.0])]);
        let by_hand = |left: [f64; 3]| {
            let mean = left.iter().sum::<f64>() / 3.0;
            (2.0 / 3.0 * left.iter().map(|x| (x - mean).powi(2)).sum::<f64>()).sqrt()
        };
        assert!((estimate.mean_error - by_hand([5.0, 8.0 / 3.0, 2.0])).abs() < 1e-12);
        let sds = [1.0, (56.0f64 / 9.0).sqrt(), (8.0f64 / 3.0).sqrt()];
        assert!((estimate.sd_error - by_hand(sds)).abs() < 1e-12);
    }

    #[test]
    fn of_a_mean_leaving_out_one_gives_the_textbooks_error() {
        let samples = [2.0, 3.0, 7.0, 1.0, 12.0];
        let mean = |without: Option<usize>| {
            let left = (0..5).filter(|i| Some(*i) != without).map(|i| samples[i]);
            left.clone().sum::<f64>() / left.count() as f64
        };
        let (value, error) = leave_one_out(5, mean);
        // As above: s² = 82/4.
        assert!((value - 5.0).abs() < 1e-12 && (error - (82.0f64 / 20.0).sqrt()).abs() < 1e-12);
        assert!(leave_one_out(1, |_| 0.0).1.is_infinite());
    }

    #[test]
    fn the_error_of_a_normal_sd_is_sigma_by_the_root_of_two_n() {
        let mut draws = Seed(4).draws(Lineage::ROOT, Purpose::Evaluation);
        let trees: Vec<Moments> = (0..4000).map(|_| tree(&[3.0 * draws.normal()])).collect();
        let expected = 3.0 / 8000f64.sqrt();
        // The estimate of the error scatters by about √(1/n) of itself, 1.6 %; five of those.
        assert!((Estimate::of(&trees).sd_error / expected - 1.0).abs() < 0.08);
    }

    #[test]
    fn equal_sets_are_beyond_two_errors_as_often_as_the_normal_law_says() {
        // Trees of ten samples that share half of their variance.
        let set = |seed: u64| {
            let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::Evaluation);
            let mut one = || {
                let own = 20.0 + draws.normal();
                tree(&(0..10).map(|_| own + draws.normal()).collect::<Vec<_>>())
            };
            Estimate::of(&(0..100).map(|_| one()).collect::<Vec<_>>())
        };
        let beyond = |k: u64| {
            let (a, b) = (set(2 * k), set(2 * k + 1));
            let differences = [Difference::of_means(&a, &b, 0.0), Difference::of_sds(&a, &b, 0.0)];
            differences.map(|difference| usize::from(!difference.is_met()))
        };
        let counts = (0..400).map(beyond).fold([0, 0], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
        // 4.55 % of 400 are 18.2 ± 4.2; five deviations, and more for the skew of the sd.
        for count in counts {
            assert!((2..=42).contains(&count), "{counts:?} of 400");
        }
    }

    #[test]
    fn a_goal_is_met_up_to_itself_and_two_errors() {
        let estimate = |mean| Estimate { trees: 50, mean, mean_error: 1.0, ..Estimate::default() };
        let difference = |mean| Difference::of_means(&estimate(100.0), &estimate(mean), 0.02);
        // The error is √2 %, so 2 % + 2.83 % are allowed.
        assert!(difference(104.8).is_met() && !difference(104.9).is_met());
        assert!(difference(95.2).is_met() && !difference(95.1).is_met());
        assert!(Estimate::of(&[tree(&[1.0])]).mean_error.is_infinite());
    }
}
