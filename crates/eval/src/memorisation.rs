//! Does a set of generated trees repeat the trees that the networks were trained on?

use serde::Serialize;

use crate::tree_features::quantile;

/// Distances to the nearest training tree.
///
/// # Units   standard deviations of the training trees: the root of the mean square difference of
/// two trees over all features, `√(Σ_k ((x_k − y_k) / sd_k)² / K)`
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nearest {
    /// Trees measured.
    pub trees: usize,
    /// The closest of all.
    pub min: f64,
    /// 5 % of the trees are closer.
    pub q05: f64,
    /// 25 % of the trees are closer.
    pub q25: f64,
    /// The median.
    pub median: f64,
    /// 75 % of the trees are closer.
    pub q75: f64,
    /// 95 % of the trees are closer.
    pub q95: f64,
}

/// How near generated trees are to the training trees, beside trees that were never trained on.
///
/// A model that copies is nearer to its training trees than the teacher's other trees are; one
/// whose trees are of another kind is further off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Memorisation {
    /// Features that vary among the training trees; the others are left out.
    pub features: usize,
    /// From each generated tree to the nearest training tree.
    pub generated: Nearest,
    /// From each fresh tree of the teacher to the nearest training tree.
    pub teacher: Nearest,
    /// From each training tree to the nearest other one.
    pub training: Nearest,
    /// Share of the generated trees nearer than [`Nearest::q05`] of the teacher's; 0.05 if alike.
    pub share_below_q05: f64,
    /// Share of the generated trees nearer than the teacher's median; 0.5 if alike.
    pub share_below_median: f64,
    /// From each generated tree, in their order, to the nearest training tree.
    pub generated_distances: Vec<f64>,
    /// From each fresh tree of the teacher, in their order, to the nearest training tree.
    pub teacher_distances: Vec<f64>,
    /// Indices of the generated and the training tree that are nearest to each other.
    pub closest: (usize, usize),
}

impl Memorisation {
    /// Compares sets of rows of [`crate::tree_features::tree_features`].
    ///
    /// `teacher` holds trees that the networks were not trained on. `None` when a set is empty,
    /// there are fewer than two training trees, the rows differ in length, or no feature varies.
    #[must_use]
    pub fn of(training: &[Vec<f64>], generated: &[Vec<f64>], teacher: &[Vec<f64>]) -> Option<Self> {
        let width = training.first()?.len();
        let mut all = training.iter().chain(generated).chain(teacher);
        if training.len() < 2 || all.any(|row| row.len() != width) {
            return None;
        }
        let scale = Scale::of(training);
        if scale.kept.is_empty() {
            return None;
        }
        let [training, generated, teacher] =
            [training, generated, teacher].map(|set| scale.apply(set));
        let hits: Vec<_> = generated.iter().map(|row| nearest(row, &training, None)).collect();
        let distances: Vec<f64> = hits.iter().map(|hit| hit.0).collect();
        let fresh_distances: Vec<f64> =
            teacher.iter().map(|row| nearest(row, &training, None).0).collect();
        let other = |(i, row): (usize, &Vec<f64>)| nearest(row, &training, Some(i)).0;
        let others = training.iter().enumerate().map(other).collect();
        let (fresh, training) = (Nearest::of(fresh_distances.clone())?, Nearest::of(others)?);
        let below = |limit: f64| {
            distances.iter().filter(|&&x| x < limit).count() as f64 / distances.len() as f64
        };
        let closest = (0..hits.len()).min_by(|&i, &j| hits[i].0.total_cmp(&hits[j].0))?;
        Some(Self {
            features: scale.kept.len(),
            share_below_q05: below(fresh.q05),
            share_below_median: below(fresh.median),
            closest: (closest, hits[closest].1),
            generated: Nearest::of(distances.clone())?,
            teacher: fresh,
            generated_distances: distances,
            teacher_distances: fresh_distances,
            training,
        })
    }
}

impl Nearest {
    fn of(mut distances: Vec<f64>) -> Option<Self> {
        distances.sort_by(f64::total_cmp);
        let at = |q| quantile(&distances, q);
        Some(Self {
            trees: distances.len(),
            min: at(0.0)?,
            q05: at(0.05)?,
            q25: at(0.25)?,
            median: at(0.5)?,
            q75: at(0.75)?,
            q95: at(0.95)?,
        })
    }
}

/// The features that vary, with their mean and standard deviation.
struct Scale {
    kept: Vec<(usize, f64, f64)>,
}

impl Scale {
    fn of(rows: &[Vec<f64>]) -> Self {
        let n = rows.len() as f64;
        let spread = |k: usize| {
            let mean = rows.iter().map(|row| row[k]).sum::<f64>() / n;
            let sd = (rows.iter().map(|row| (row[k] - mean).powi(2)).sum::<f64>() / n).sqrt();
            // A spread of rounding errors is none: positions are in float32.
            (sd > 1e-6 * (1.0 + mean.abs())).then_some((k, mean, sd))
        };
        Self { kept: (0..rows[0].len()).filter_map(spread).collect() }
    }

    fn apply(&self, rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let standard =
            |row: &Vec<f64>| self.kept.iter().map(|&(k, mean, sd)| (row[k] - mean) / sd).collect();
        rows.iter().map(standard).collect()
    }
}

/// Distance and index of the row nearest to `row`, `skip` left out.
fn nearest(row: &[f64], among: &[Vec<f64>], skip: Option<usize>) -> (f64, usize) {
    let square = |other: &[f64]| -> f64 {
        row.iter().zip(other).map(|(x, y)| (x - y).powi(2)).sum::<f64>() / row.len() as f64
    };
    let others = among.iter().enumerate().filter(|(i, _)| Some(*i) != skip);
    others
        .map(|(i, other)| (square(other).sqrt(), i))
        .fold((f64::INFINITY, 0), |best, next| if next.0 < best.0 { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    fn normals(seed: u64, rows: usize, width: usize) -> Vec<Vec<f64>> {
        let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::Evaluation);
        (0..rows).map(|_| (0..width).map(|_| draws.normal()).collect()).collect()
    }

    #[test]
    fn distances_on_a_line_are_those_worked_out_by_hand() {
        // 0, 2, 4 and 10 have the mean 4 and the variance (16 + 4 + 0 + 36) / 4 = 14; the second
        // feature does not vary.
        let set = |values: &[f64]| values.iter().map(|&x| vec![x, 7.0]).collect::<Vec<_>>();
        let training = set(&[0.0, 2.0, 4.0, 10.0]);
        let result = Memorisation::of(&training, &set(&[9.0]), &set(&[5.0, 7.5])).unwrap();
        let sd = 14f64.sqrt();
        assert_eq!(result.features, 1);
        assert!((result.generated.median - 1.0 / sd).abs() < 1e-12);
        assert!((result.teacher.min - 1.0 / sd).abs() < 1e-12);
        assert!((result.teacher.median - 1.75 / sd).abs() < 1e-12);
        // Others are 2, 2, 2 and 6 away.
        assert!((result.training.median - 2.0 / sd).abs() < 1e-12);
        assert_eq!((result.closest, result.share_below_median), ((0, 3), 1.0));
        assert!((result.teacher_distances[1] - 2.5 / sd).abs() < 1e-12);
    }

    #[test]
    fn copies_of_training_trees_are_found() {
        let (training, fresh) = (normals(1, 100, 8), normals(2, 100, 8));
        let result = Memorisation::of(&training, &training[40..60], &fresh).unwrap();
        assert_eq!((result.generated.q95, result.share_below_q05), (0.0, 1.0));
        assert_eq!(result.closest, (0, 40));
    }

    #[test]
    fn fresh_trees_of_the_same_law_are_as_near_as_the_teachers() {
        let sets = [1, 2, 3].map(|seed| normals(seed, 400, 8));
        let result = Memorisation::of(&sets[0], &sets[1], &sets[2]).unwrap();
        // Five standard errors of a share of 400, and of the difference of two such.
        assert!((result.share_below_median - 0.5).abs() < 5.0 * (0.5f64 / 400.0).sqrt());
        assert!((result.share_below_q05 - 0.05).abs() < 5.0 * (0.095f64 / 400.0).sqrt());
    }

    #[test]
    fn sets_that_cannot_be_compared_give_nothing() {
        let rows = normals(1, 4, 3);
        assert_eq!(Memorisation::of(&rows, &[], &rows), None);
        assert_eq!(Memorisation::of(&rows[..1], &rows, &rows), None);
        assert_eq!(Memorisation::of(&rows, &normals(2, 4, 2), &rows), None);
        assert_eq!(Memorisation::of(&vec![vec![1.0]; 4], &[vec![1.0]], &[vec![1.0]]), None);
    }
}
