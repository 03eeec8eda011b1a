//! What a learner must show: its trees beside the teacher's, quantity by quantity.

use serde::Serialize;

use crate::jackknife::{Difference, Estimate};
use crate::metrics::{Metric, Moments};
use crate::set::{TreeRecord, TreeSet};

/// How far the means may be apart, beyond the sampling error.
pub const MEAN_GOAL: f64 = 0.02;

/// How far the standard deviations may be apart, beyond the sampling error.
pub const SD_GOAL: f64 = 0.05;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A metric of the paper's table.
    Metric(Metric),
    /// Nodes of each tree.
    Nodes,
    /// Height of each tree, in metres.
    Height,
    /// Distance of the outermost branch of each tree from the axis, in metres.
    CrownRadius,
}

impl Quantity {
    /// All, in the order of tables.
    pub const ALL: [Self; 10] = [
        Self::Metric(Metric::BranchNumber),
        Self::Metric(Metric::BranchLength),
        Self::Metric(Metric::BranchingDistance),
        Self::Metric(Metric::NodeNumber),
        Self::Metric(Metric::AngleChild1),
        Self::Metric(Metric::AngleChild2),
        Self::Metric(Metric::AngleChild3),
        Self::Nodes,
        Self::Height,
        Self::CrownRadius,
    ];

    /// The name used in tables.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Metric(metric) => metric.symbol(),
            Self::Nodes => "nodes",
            Self::Height => "height",
            Self::CrownRadius => "crown",
        }
    }

    /// The samples of one tree.
    fn of(self, tree: &TreeRecord) -> Moments {
        let one = |x: f64| {
            let mut moments = Moments::default();
            moments.add(x);
            moments
        };
        match self {
            Self::Metric(metric) => tree.get(metric),
            Self::Nodes => one(f64::from(tree.nodes)),
            Self::Height => one(f64::from(tree.height)),
            Self::CrownRadius => one(f64::from(tree.crown_radius)),
        }
    }

    /// Mean and standard deviation over a set, with their errors.
    #[must_use]
    pub fn estimate(self, set: &TreeSet) -> Estimate {
        Estimate::of(&set.trees.iter().map(|tree| self.of(tree)).collect::<Vec<_>>())
    }
}

/// One quantity of a set beside the teacher's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the species.
    pub species: String,
    /// What is compared.
    pub quantity: &'static str,
    /// The teacher's.
    pub teacher: Estimate,
    /// The set's.
    pub other: Estimate,
    /// How far the means are apart.
    pub mean: Difference,
    /// How far the standard deviations are apart.
    pub sd: Difference,
}

/// Compares all quantities of a set with the teacher's.
#[must_use]
pub fn compare(species: &str, teacher: &TreeSet, other: &TreeSet) -> Vec<Comparison> {
    let one = |quantity: Quantity| {
        let (p, x) = (quantity.estimate(teacher), quantity.estimate(other));
        Comparison {
            species: species.to_owned(),
            quantity: quantity.symbol(),
            mean: Difference::of_means(&p, &x, MEAN_GOAL),
            sd: Difference::of_sds(&p, &x, SD_GOAL),
            teacher: p,
            other: x,
        }
    };
    Quantity::ALL.into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};

    /// A pole of `nodes` internodes of 1 m.
    fn pole(nodes: u32) -> TreeSet {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let edge = |degrees: f32| ChildSignature {
            rotation: Quat::from_rotation_x(degrees.to_radians()),
            thickness: 0.1,
            length: 1.0,
        };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(90.0));
        (1..nodes).for_each(|id| {
            tree.grow(id - 1, [Some(edge(0.0)), None, None]);
        });
        TreeSet::of(&tree, false)
    }

    fn poles(heights: &[u32]) -> TreeSet {
        let mut set = TreeSet::default();
        heights.iter().for_each(|&nodes| set.merge(pole(nodes)));
        set
    }

    #[test]
    fn poles_differ_by_what_their_heights_differ_by() {
        // Means 4 and 5 m; standard deviations √2 and √(14/3) = 2.160.
        let comparisons = compare("oak", &poles(&[2, 4, 4, 6]), &poles(&[2, 6, 7]));
        let find = |name| comparisons.iter().find(|one| one.quantity == name).unwrap();
        for name in ["nodes", "height", "BL", "BD"] {
            let Comparison { mean, sd, teacher, .. } = find(name);
            assert!((mean.relative - 0.25).abs() < 1e-6, "{name}: {mean:?}");
            assert!((sd.relative - ((14.0f64 / 6.0).sqrt() - 1.0)).abs() < 1e-6, "{name}: {sd:?}");
            // s² = 8/3 of four trees; sets of four and three: √(1 + 4/3).
            let error = (8.0f64 / 3.0 / 4.0).sqrt();
            assert!((teacher.mean_error - error).abs() < 1e-6);
            assert!((mean.error - error / 4.0 * (7.0f64 / 3.0).sqrt()).abs() < 1e-6);
        }
        assert_eq!(find("BN").mean.relative, 0.0);
    }
}
