//! Can a classifier tell two sets of trees apart?
//!
//! A random forest is trained on some trees of both sets and scores the others. If the two sets
//! follow one law, no classifier does better than chance on trees it has not seen; so an area
//! under the curve beyond chance proves a difference, and the features that the forest splits on
//! say which.
//!
//! # Source
//!
//! Friedman 2003, "On multivariate goodness-of-fit and two-sample testing"; Lopez-Paz and Oquab
//! 2017, "Revisiting classifier two-sample tests"; the forest is Breiman's of 2001.

mod forest;
mod refit;

use deeptree_graph::{Draws, Lineage, Purpose, Seed};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::auc::{Auc, FoldScores, permutation_p, shuffle};
use crate::distances::Distances;
use crate::metrics::Moments;

use forest::{Fold, Forest};

/// How the test is run. The same options and rows give the same result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Options {
    /// What folds, forests and permutations are drawn from.
    #[serde(serialize_with = "as_number", deserialize_with = "of_number")]
    pub seed: Seed,
    /// Parts that the trees are split into; each is held out once.
    pub folds: usize,
    /// Trees of each forest.
    pub forest_trees: usize,
    /// Samples a leaf has at least: small leaves follow noise, large ones miss narrow differences.
    pub leaf: usize,
    /// Permutations of all labels, for each of which the forests are fitted anew; 0 for none.
    ///
    /// They take nearly all of the time: as many times what the forests of one test take.
    pub refits: usize,
    /// Permutations of the held-out labels alone.
    pub permutations: usize,
}

fn as_number<S: Serializer>(seed: &Seed, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u64(seed.0)
}

fn of_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Seed, D::Error> {
    u64::deserialize(deserializer).map(Seed)
}

impl Options {
    /// Five folds, forests of 200 trees, 99 refits and a thousand permutations.
    #[must_use]
    pub const fn new(seed: Seed) -> Self {
        Self { seed, folds: 5, forest_trees: 200, leaf: 3, refits: 99, permutations: 1000 }
    }
}

/// A feature that the forest told the sets apart by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Telltale {
    /// Its name.
    pub name: String,
    /// Its share of the impurity that all splits removed, mean of the folds' forests.
    pub importance: f64,
    /// Its mean in set A.
    pub mean_a: f64,
    /// Its mean in set B.
    pub mean_b: f64,
    /// Its standard deviation in set A.
    pub sd_a: f64,
    /// Its standard deviation in set B.
    pub sd_b: f64,
    /// How far apart its two samples are.
    pub distances: Distances,
}

/// How many features [`TwoSample::telltales`] lists.
pub const TELLTALES: usize = 10;

/// [`TwoSample::fold_inflation`] where it is not measured: the larger value of normal samples of
/// one law under forests of 60 trees: 1.50 (150 rows a set, 6 features), 1.36 (100 rows, 40).
pub const FOLD_INFLATION: f64 = 1.5;

/// Refits from which on the inflation is measured: its own error is then below a sixth.
pub const REFITS_FOR_INFLATION: usize = 19;

/// The result of a test of set A (label 0) against set B (label 1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TwoSample {
    /// How it was run.
    pub options: Options,
    /// Trees of the two sets.
    pub trees: [usize; 2],
    /// Features of a tree.
    pub features: usize,
    /// Mean area of the held-out folds; its error is DeLong's times [`Self::fold_inflation`].
    pub auc: Auc,
    /// How much more the mean area scatters than independent folds would.
    ///
    /// A tree that one fold holds out trains the forests of the others. Of the refits the root
    /// mean square of `(AUC − 1/2) / DeLong's error`, at least 1; [`FOLD_INFLATION`] with fewer
    /// refits than [`REFITS_FOR_INFLATION`].
    pub fold_inflation: f64,
    /// Chance of such an area if the sets follow one law, by refits: exact. `None` without refits.
    pub p_value: Option<f64>,
    /// The same by permuted held-out labels: too small, since it takes folds as independent.
    ///
    /// Of normal samples of one law, 9 % (100 rows a set, 40 features) and 14 % (150 rows, 6
    /// features) have a value of 0.05 or less.
    pub held_out_p_value: f64,
    /// The features with the highest importance, in its order.
    pub telltales: Vec<Telltale>,
}

/// Why two sets could not be tested.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TwoSampleError {
    /// Every fold needs two trees of each set, and there must be two folds.
    #[error("{trees} trees of a set are too few for {folds} folds: each needs two, and two folds")]
    TooFewTrees {
        /// Trees of the smaller set.
        trees: usize,
        /// Folds asked for.
        folds: usize,
    },
    /// A row is not as long as there are names.
    #[error("a tree has {found} features, not {expected}")]
    Width {
        /// Names given.
        expected: usize,
        /// Length of the row.
        found: usize,
    },
    /// A feature is NaN or infinite.
    #[error("feature {name} of a tree is not finite")]
    NotFinite {
        /// The feature.
        name: String,
    },
    /// The forest could not be fitted.
    #[error("the forest could not be fitted")]
    Forest(#[source] smartcore::error::Failed),
}

/// What a draw is for: coordinates below [`Purpose::Evaluation`].
#[derive(Clone, Copy)]
enum Step {
    Folds = 1,
    Forest = 2,
    Permutation = 3,
    Refit = 4,
}

impl Options {
    fn draws(&self, step: Step) -> Draws {
        self.seed.draws(Lineage::ROOT, Purpose::Evaluation).at(step as u64)
    }
}

/// Tests rows of set `a` against rows of set `b`; their columns are called `names`.
///
/// # Errors
///
/// When the sets are too small, rows differ from `names` in length, or a value is not finite.
pub fn two_sample(
    a: &[Vec<f64>],
    b: &[Vec<f64>],
    names: &[String],
    options: Options,
) -> Result<TwoSample, TwoSampleError> {
    check(a, b, names, &options)?;
    let rows: Vec<&[f64]> = a.iter().chain(b).map(Vec::as_slice).collect();
    let labels: Vec<bool> = (0..rows.len()).map(|i| i >= a.len()).collect();
    let (folds, importances) = cross_validate(&rows, &labels, &options, 0)?;
    let delong = mean_area(&folds);
    let refits = refit::areas(&rows, &labels, &options)?;
    let fold_inflation = refit::inflation(&refits);
    let draws = options.draws(Step::Permutation);
    Ok(TwoSample {
        options,
        trees: [a.len(), b.len()],
        features: names.len(),
        auc: delong.widened(fold_inflation),
        fold_inflation,
        p_value: refit::p_value(&refits, delong.value),
        held_out_p_value: permutation_p(&folds, options.permutations, &draws),
        telltales: telltales(a, b, names, &importances),
    })
}

fn check(
    a: &[Vec<f64>],
    b: &[Vec<f64>],
    names: &[String],
    options: &Options,
) -> Result<(), TwoSampleError> {
    let (trees, folds) = (a.len().min(b.len()), options.folds);
    if folds < 2 || trees < 2 * folds {
        return Err(TwoSampleError::TooFewTrees { trees, folds });
    }
    for row in a.iter().chain(b) {
        if row.len() != names.len() {
            return Err(TwoSampleError::Width { expected: names.len(), found: row.len() });
        }
        if let Some(k) = row.iter().position(|x| !x.is_finite()) {
            return Err(TwoSampleError::NotFinite { name: names[k].clone() });
        }
    }
    Ok(())
}

/// Held-out scores of each fold, and the mean importance of each feature.
fn cross_validate(
    rows: &[&[f64]],
    labels: &[bool],
    options: &Options,
    run: u64,
) -> Result<(Vec<FoldScores>, Vec<f64>), TwoSampleError> {
    let fold_of = assign(labels, options.folds, options.draws(Step::Folds).at(run));
    let mut importances = vec![0.0; rows[0].len()];
    let mut folds = Vec::new();
    for fold in 0..options.folds {
        let held_out = |i: &usize| fold_of[*i] == fold;
        let (test, train): (Vec<usize>, Vec<usize>) = (0..rows.len()).partition(held_out);
        let seed = options.draws(Step::Forest).at(run).at(fold as u64).bits();
        let forest = Forest::fit(&Fold { rows, labels, members: &train }, options, seed)
            .map_err(TwoSampleError::Forest)?;
        let scores = forest.scores(rows, &test).map_err(TwoSampleError::Forest)?;
        let of = |label: bool| {
            let mine = test.iter().zip(&scores).filter(|(i, _)| labels[**i] == label);
            mine.map(|(_, score)| *score).collect()
        };
        folds.push([of(false), of(true)]);
        for (sum, gain) in importances.iter_mut().zip(&forest.importances) {
            *sum += gain / options.folds as f64;
        }
    }
    Ok((folds, importances))
}

/// The fold of each row; every fold has as many rows of each label, but for one.
fn assign(labels: &[bool], folds: usize, mut draws: Draws) -> Vec<usize> {
    let mut fold_of = vec![0; labels.len()];
    for label in [false, true] {
        let mut members: Vec<usize> = (0..labels.len()).filter(|&i| labels[i] == label).collect();
        shuffle(&mut members, &mut draws);
        for (position, member) in members.into_iter().enumerate() {
            fold_of[member] = position % folds;
        }
    }
    fold_of
}

fn mean_area(folds: &[FoldScores]) -> Auc {
    let areas: Option<Vec<Auc>> = folds.iter().map(|[a, b]| Auc::of(a, b)).collect();
    let mean = areas.as_deref().and_then(Auc::mean);
    mean.expect("every fold has two trees of each set: checked")
}

fn telltales(
    a: &[Vec<f64>],
    b: &[Vec<f64>],
    names: &[String],
    importances: &[f64],
) -> Vec<Telltale> {
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&i, &j| importances[j].total_cmp(&importances[i]));
    let tell = |k: usize| {
        let column = |rows: &[Vec<f64>]| rows.iter().map(|row| row[k]).collect::<Vec<_>>();
        let moments = |samples: &[f64]| {
            let mut moments = Moments::default();
            moments.extend(samples.iter().copied());
            moments
        };
        let (a, b) = (column(a), column(b));
        let (of_a, of_b) = (moments(&a), moments(&b));
        Some(Telltale {
            name: names[k].clone(),
            importance: importances[k],
            mean_a: of_a.mean,
            mean_b: of_b.mean,
            sd_a: of_a.sd(),
            sd_b: of_b.sd(),
            distances: Distances::between(&a, &b)?,
        })
    };
    order.into_iter().take(TELLTALES).filter_map(tell).collect()
}

#[cfg(test)]
mod tests;
