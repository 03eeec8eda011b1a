//! The area under the ROC curve of a score that should tell two sets apart.

use deeptree_graph::Draws;
use serde::{Deserialize, Serialize};

/// The chance that a random tree of set B scores above a random one of set A, with its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Auc {
    /// `P(b > a) + P(b = a) / 2`: 0.5 when the score cannot tell, 1 when it always can.
    pub value: f64,
    /// Its standard error for the sizes of the two sets.
    pub standard_error: f64,
    /// Lower end of the 95 % confidence interval.
    pub low: f64,
    /// Upper end of the 95 % confidence interval.
    pub high: f64,
}

/// The standard normal quantile of 0.975.
const TWO_SIDED_95: f64 = 1.959_963_984_540_054;

impl Auc {
    /// The area and DeLong's standard error of two lists of scores.
    ///
    /// The placements `V(a) = P(b > a) + P(b = a)/2` of the one set and `V(b)` of the other both
    /// have the mean AUC; its variance is `var V(a) / n_a + var V(b) / n_b`.
    ///
    /// `None` when a set has fewer than two scores.
    ///
    /// # Source
    ///
    /// DeLong, DeLong and Clarke-Pearson 1988, "Comparing the areas under two or more correlated
    /// receiver operating characteristic curves"; the mid-ranks after Mann and Whitney 1947.
    #[must_use]
    pub fn of(a: &[f64], b: &[f64]) -> Option<Self> {
        if a.len() < 2 || b.len() < 2 {
            return None;
        }
        let above: Vec<f64> = placements(a, b).iter().map(|share| 1.0 - share).collect();
        let (value, variance_a) = mean_and_variance(&above);
        let (_, variance_b) = mean_and_variance(&placements(b, a));
        let variance = variance_a / a.len() as f64 + variance_b / b.len() as f64;
        Some(Self::with_error(value, variance.sqrt()))
    }

    /// The mean of the areas of independent folds.
    ///
    /// `None` without folds.
    #[must_use]
    pub fn mean(folds: &[Self]) -> Option<Self> {
        let n = folds.len() as f64;
        let value = folds.iter().map(|fold| fold.value).sum::<f64>() / n;
        let variance: f64 = folds.iter().map(|fold| fold.standard_error.powi(2)).sum();
        (n > 0.0).then(|| Self::with_error(value, variance.sqrt() / n))
    }

    /// The same area with `factor` times the standard error.
    #[must_use]
    pub fn widened(self, factor: f64) -> Self {
        Self::with_error(self.value, factor * self.standard_error)
    }

    fn with_error(value: f64, standard_error: f64) -> Self {
        let reach = TWO_SIDED_95 * standard_error;
        let (low, high) = ((value - reach).max(0.0), (value + reach).min(1.0));
        Self { value, standard_error, low, high }
    }
}

/// For each score of `of`, the share of `among` below it, equal scores counting half.
fn placements(of: &[f64], among: &[f64]) -> Vec<f64> {
    let mut sorted = among.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = |x: &f64| {
        let below = sorted.partition_point(|y| y < x);
        let not_above = sorted.partition_point(|y| y <= x);
        (below + not_above) as f64 / (2 * sorted.len()) as f64
    };
    of.iter().map(place).collect()
}

/// Mean and unbiased variance.
fn mean_and_variance(samples: &[f64]) -> (f64, f64) {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let squares: f64 = samples.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, squares / (n - 1.0))
}

/// Shuffles in place (Fisher and Yates, after Durstenfeld 1964).
pub(crate) fn shuffle<T>(items: &mut [T], draws: &mut Draws) {
    for last in (1..items.len()).rev() {
        items.swap(last, draws.index(last + 1));
    }
}

/// Scores of held-out trees, set A and set B, of one fold.
pub type FoldScores = [Vec<f64>; 2];

/// The one-sided p-value of a mean area: how often it is as large when labels are drawn at random.
///
/// Labels change places among the held-out trees of a fold, whose scores come from one and the
/// same classifier and are exchangeable if the two sets follow one law. Exact for one fold; of
/// several it takes no notice of the trees that the folds' classifiers share, and is too small.
/// `p = (1 + #{permuted ≥ observed}) / (1 + permutations)`.
///
/// # Source
///
/// Phipson and Smyth 2010, "Permutation p-values should never be zero", for the two ones.
#[must_use]
pub fn permutation_p(folds: &[FoldScores], permutations: usize, draws: &Draws) -> f64 {
    let areas = |folds: &[FoldScores]| -> f64 { folds.iter().map(area).sum() };
    let observed = areas(folds);
    let mut reached = 0;
    for permutation in 0..permutations {
        let mut draws = draws.clone().at(permutation as u64);
        let permuted: Vec<_> = folds.iter().map(|fold| permute(fold, &mut draws)).collect();
        // Rounding may not decide between two equal sums of ranks.
        reached += usize::from(areas(&permuted) >= observed - 1e-12);
    }
    (1 + reached) as f64 / (1 + permutations) as f64
}

fn area([a, b]: &FoldScores) -> f64 {
    mean_and_variance(&placements(b, a)).0
}

fn permute([a, b]: &FoldScores, draws: &mut Draws) -> FoldScores {
    let mut all: Vec<f64> = a.iter().chain(b).copied().collect();
    shuffle(&mut all, draws);
    let rest = all.split_off(a.len());
    [all, rest]
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    fn draws(seed: u64) -> Draws {
        Seed(seed).draws(Lineage::ROOT, Purpose::Evaluation)
    }

    fn normals(n: usize, mean: f64, draws: &mut Draws) -> Vec<f64> {
        (0..n).map(|_| mean + draws.normal()).collect()
    }

    #[test]
    fn areas_of_hand_made_scores_count_the_pairs_and_half_the_ties() {
        let value = |a: &[f64], b: &[f64]| Auc::of(a, b).unwrap().value;
        assert_eq!(value(&[0.0, 1.0], &[2.0, 3.0]), 1.0);
        assert_eq!(value(&[2.0, 3.0], &[0.0, 1.0]), 0.0);
        assert_eq!(value(&[1.0; 4], &[1.0; 3]), 0.5);
        // Of six pairs, (1, 2), (1, 3), (2, 3) are won and (2, 2) is tied; 4 loses both.
        assert!((value(&[1.0, 2.0, 4.0], &[2.0, 3.0]) - 3.5 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn the_standard_error_is_delongs_on_scores_worked_out_by_hand() {
        // V(a) of 1, 2, 4: 1, 3/4, 0, with variance 13/48. V(b) of 2, 3: 1/2, 2/3, with 1/72.
        let auc = Auc::of(&[1.0, 2.0, 4.0], &[2.0, 3.0]).unwrap();
        let variance: f64 = 13.0 / 48.0 / 3.0 + 1.0 / 72.0 / 2.0;
        assert!((auc.standard_error - variance.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn shifted_normals_have_the_analytic_area_and_the_interval_its_coverage() {
        // Two unit normals d = 1 apart: AUC = Φ(d / √2) = 0.760 249 938 906 524.
        let truth = 0.760_249_938_906_524;
        let mut covered = 0u32;
        for seed in 0..400 {
            let mut draws = draws(seed);
            let (a, b) = (normals(100, 0.0, &mut draws), normals(80, 1.0, &mut draws));
            let auc = Auc::of(&a, &b).unwrap();
            covered += u32::from((auc.low..auc.high).contains(&truth));
        }
        // 380 ± 4.4 of 400 expected; five deviations.
        assert!((358..=400).contains(&covered), "{covered} of 400 intervals hold the area");
    }

    #[test]
    fn p_values_are_uniform_for_equal_sets_and_least_for_parted_ones() {
        let mut mean = 0.0;
        for seed in 0..200 {
            let mut draws = draws(seed);
            let fold = [normals(20, 0.0, &mut draws), normals(20, 0.0, &mut draws)];
            mean += permutation_p(&[fold], 99, &draws.at(1)) / 200.0;
        }
        assert!((mean - 0.5).abs() < 5.0 * (1.0f64 / 12.0 / 200.0).sqrt(), "mean p {mean}");
        let parted = [vec![0.0; 20], vec![1.0; 20]];
        assert!((permutation_p(&[parted], 99, &draws(1)) - 0.01).abs() < 1e-12);
    }

    #[test]
    fn a_mean_of_equal_folds_has_the_error_of_one_by_the_root_of_their_number() {
        let fold = Auc::of(&[1.0, 2.0, 4.0], &[2.0, 3.0]).unwrap();
        let mean = Auc::mean(&[fold; 4]).unwrap();
        assert!((mean.value - fold.value).abs() < 1e-12);
        assert!((mean.standard_error - fold.standard_error / 2.0).abs() < 1e-12);
        assert_eq!(Auc::mean(&[]), None);
    }
}
