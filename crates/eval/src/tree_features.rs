//! A tree as one row of numbers, for classifiers and distances between trees.
//!
//! The features are the paper's metrics with their whole distributions, and what a metric averaged
//! over all branches hides: how a tree is built order by order, where in the crown it is dense,
//! how it leans and twists, and what neighbours in the graph have to do with each other. None tells
//! which way the tree faces: turned about the vertical it has the same features (widths and
//! roundness are taken along 16 directions, and change a little in between).

mod crown;
mod orders;
mod recorder;
mod shape;

use std::sync::OnceLock;

use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};

use recorder::Recorder;
pub(crate) use recorder::quantile;

/// What features are rounded to.
const RESOLUTION: f64 = 1e-5;

/// The features of a tree, in the order of [`names`].
///
/// All are finite; what a tree has none of (a second order, a fork) is 0. They are rounded to
/// hundred-thousandths: below lies what rounding in the positions and rotations leaves, which tells
/// how a tree was computed, not what it is like.
///
/// # Units   metres and radians, or none; shares and ratios lie in [0, 1]
#[must_use]
pub fn tree_features(tree: &BranchGraph) -> Vec<f64> {
    let values = measure(tree).values;
    values.into_iter().map(|value| (value / RESOLUTION).round() * RESOLUTION).collect()
}

/// The names of the features.
///
/// `<what>/<statistic>`: of distributions `mean`, `sd`, `skewness` and the quantiles `q10`, `q50`,
/// `q90`; of angles on a circle `cos`, `sin` and `cos2`, the mean cosine and sine and that of twice
/// the angle; `o0` … `o4` is a Gravelius order. `roll/mean` and its like are of the twist's size
/// without its sign.
#[must_use]
pub fn names() -> &'static [String] {
    static NAMES: OnceLock<Vec<String>> = OnceLock::new();
    NAMES.get_or_init(|| measure(&stump()).names)
}

fn measure(tree: &BranchGraph) -> Recorder {
    let mut recorder = Recorder::default();
    crown::size(tree, &mut recorder);
    crown::lean(tree, &mut recorder);
    crown::histograms(tree, &mut recorder);
    shape::distributions(tree, &mut recorder);
    shape::angles(tree, &mut recorder);
    shape::forks(tree, &mut recorder);
    orders::orders(tree, &mut recorder);
    recorder
}

/// The smallest tree: it has every feature's name.
fn stump() -> BranchGraph {
    let info = TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: 0 };
    let root = ChildSignature { rotation: Quat::IDENTITY, thickness: 0.0, length: 0.0 };
    BranchGraph::new(info, Vec3::ZERO, root)
}

#[cfg(test)]
mod tests;
