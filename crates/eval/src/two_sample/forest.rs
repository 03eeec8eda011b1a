//! The random forest behind the test, of the crate `smartcore`.

use smartcore::ensemble::random_forest_regressor::{
    RandomForestRegressor, RandomForestRegressorParameters,
};
use smartcore::error::Failed;
use smartcore::linalg::basic::matrix::DenseMatrix;

use super::Options;

/// The rows that a forest is fitted to.
pub(super) struct Fold<'a> {
    pub(super) rows: &'a [&'a [f64]],
    pub(super) labels: &'a [bool],
    pub(super) members: &'a [usize],
}

/// A fitted forest, whose score of a tree is the mean label of the leaves it falls into.
///
/// Fitted as a regression on labels 0 and 1: of such labels the variance is half of Gini's
/// impurity, so the splits are a classifier's, and the mean is a finer score than a vote. The
/// forest draws from a generator of its own crate, which is seeded with one keyed draw.
pub(super) struct Forest {
    model: RandomForestRegressor<f64, f64, DenseMatrix<f64>, Vec<f64>>,
    /// Share of each feature in the impurity removed.
    pub(super) importances: Vec<f64>,
}

impl Forest {
    pub(super) fn fit(fold: &Fold, options: &Options, seed: u64) -> Result<Self, Failed> {
        let x = matrix(fold.rows, fold.members)?;
        let y = fold.members.iter().map(|&i| f64::from(u8::from(fold.labels[i]))).collect();
        // Breiman's choice for classification: the root of the number of features a split.
        let tried = (fold.rows[0].len() as f64).sqrt().round() as usize;
        let parameters = RandomForestRegressorParameters::default()
            .with_n_trees(options.forest_trees)
            .with_min_samples_leaf(options.leaf)
            .with_m(tried.max(1))
            .with_seed(seed);
        let model = RandomForestRegressor::fit(&x, &y, parameters)?;
        let importances = model.compute_feature_importances()?;
        // Without a single split the shares are 0 / 0.
        let importances = importances.into_iter().map(|x| if x.is_finite() { x } else { 0.0 });
        Ok(Self { importances: importances.collect(), model })
    }

    /// Scores of `members`: near 0 for set A, near 1 for set B.
    pub(super) fn scores(&self, rows: &[&[f64]], members: &[usize]) -> Result<Vec<f64>, Failed> {
        self.model.predict(&matrix(rows, members)?)
    }
}

fn matrix(rows: &[&[f64]], members: &[usize]) -> Result<DenseMatrix<f64>, Failed> {
    let picked: Vec<&[f64]> = members.iter().map(|&i| rows[i]).collect();
    DenseMatrix::from_2d_array(&picked)
}
