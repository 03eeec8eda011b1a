//! How well a skeleton agrees with the true one.

use deeptree_graph::{BranchGraph, Vec3};

use crate::kdtree::KdTree;

/// Orders that recall is told of by itself; deeper ones share the last.
pub const ORDERS: usize = 5;

/// The agreement of two skeletons within a tolerance, by metres of branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkeletonFit {
    /// Share of the made skeleton that is within the tolerance of the true one.
    pub precision: f64,
    /// Share of the true skeleton that is within it of the made one.
    pub recall: f64,
    /// The same, by Gravelius order of the true branches; none where there is no such branch.
    pub recall_of_order: [Option<f64>; ORDERS],
    /// Of the recalled part, the share whose way to the foot is as long as in truth, to within
    /// [`SAME_WAY`]: branches that are there, and hang where they belong.
    pub same_way: f64,
    /// Of the recalled part, the share whose order is the true one.
    pub same_order: f64,
}

/// How much the length of a way may differ and still be the same, as a share of it.
pub const SAME_WAY: f32 = 0.05;

impl SkeletonFit {
    /// Compares a skeleton with the true one in the same frame; tolerance in metres, above 0.
    ///
    /// Both are cut into steps of a quarter of the tolerance; a step is where its middle is.
    #[must_use]
    pub fn new(made: &BranchGraph, truth: &BranchGraph, tolerance: f32) -> Self {
        let [made, truth] = [made, truth].map(|tree| Steps::of(tree, tolerance / 4.0));
        let [near_made, near_truth] = [&made, &truth].map(|steps| KdTree::new(&steps.places));
        let within = |index: &KdTree, place: Vec3| {
            index.nearest(place).is_some_and(|(_, squared)| squared <= tolerance * tolerance)
        };
        let share = |steps: &Steps, index: &KdTree, order: Option<usize>| {
            let (mut all, mut found) = (0.0, 0.0);
            for (i, &place) in steps.places.iter().enumerate() {
                if order.is_none_or(|order| order == steps.orders[i]) {
                    all += steps.lengths[i];
                    found += if within(index, place) { steps.lengths[i] } else { 0.0 };
                }
            }
            (all > 0.0).then(|| found / all)
        };
        let (mut all, mut same, mut order) = (0.0, 0.0, 0.0);
        for (i, &place) in truth.places.iter().enumerate() {
            let near = near_made.nearest(place);
            if let Some((k, _)) = near.filter(|(_, squared)| *squared <= tolerance * tolerance) {
                let (own, other) = (truth.ways[i], made.ways[k as usize]);
                all += truth.lengths[i];
                let is_same = (own - other).abs() <= SAME_WAY * own + tolerance;
                same += if is_same { truth.lengths[i] } else { 0.0 };
                let is_same = truth.orders[i] == made.orders[k as usize];
                order += if is_same { truth.lengths[i] } else { 0.0 };
            }
        }
        Self {
            same_way: if all > 0.0 { same / all } else { 0.0 },
            same_order: if all > 0.0 { order / all } else { 0.0 },
            precision: share(&made, &near_truth, None).unwrap_or(0.0),
            recall: share(&truth, &near_made, None).unwrap_or(0.0),
            recall_of_order: std::array::from_fn(|order| share(&truth, &near_made, Some(order))),
        }
    }

    /// The harmonic mean of precision and recall.
    #[must_use]
    pub fn f_score(&self) -> f64 {
        let sum = self.precision + self.recall;
        if sum > 0.0 { 2.0 * self.precision * self.recall / sum } else { 0.0 }
    }
}

/// A skeleton in short pieces.
struct Steps {
    places: Vec<Vec3>,
    lengths: Vec<f64>,
    orders: Vec<usize>,
    /// Lengths of the ways to the foot.
    ways: Vec<f32>,
}

impl Steps {
    fn of(tree: &BranchGraph, step: f32) -> Self {
        let mut steps =
            Self { places: Vec::new(), lengths: Vec::new(), orders: Vec::new(), ways: Vec::new() };
        for node in tree.nodes() {
            let pieces = libm::ceilf(node.length / step).clamp(1.0, 1e6) as u32;
            for piece in 0..pieces {
                let share = (piece as f32 + 0.5) / pieces as f32;
                steps.places.push(node.base().lerp(node.position, share));
                steps.ways.push(node.root_distance - node.length * (1.0 - share));
                steps.lengths.push(f64::from(node.length) / f64::from(pieces));
                steps.orders.push(usize::from(node.order).min(ORDERS - 1));
            }
        }
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{ChildSignature, Quat, TreeInfo};

    fn column(foot: Vec3, height: f32) -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let rotation = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        BranchGraph::new(info, foot, ChildSignature { rotation, thickness: 0.1, length: height })
    }

    #[test]
    fn a_stem_half_as_high_recalls_half() {
        let fit = SkeletonFit::new(&column(Vec3::ZERO, 5.0), &column(Vec3::ZERO, 10.0), 0.1);
        assert!((fit.precision - 1.0).abs() < 1e-6);
        assert!((fit.recall - 0.51).abs() < 0.005, "{fit:?}");
        assert_eq!(fit.recall_of_order[0], Some(fit.recall));
        assert_eq!(fit.recall_of_order[1], None);
        assert!((fit.f_score() - 1.02 / 1.51).abs() < 0.01);
    }

    #[test]
    fn a_stem_beside_the_true_one_is_right_within_the_tolerance_only() {
        let aside = column(Vec3::X * 0.2, 10.0);
        let truth = column(Vec3::ZERO, 10.0);
        assert_eq!(SkeletonFit::new(&aside, &truth, 0.25).f_score(), 1.0);
        assert_eq!(SkeletonFit::new(&aside, &truth, 0.15).f_score(), 0.0);
    }
}
