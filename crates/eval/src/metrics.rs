//! The metrics of the paper's appendix, and the moments they are reported as.

use deeptree_graph::{BranchGraph, Vec3, branches, chains};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// A row of the paper's evaluation table.
///
/// All but [`Metric::BranchNumber`] are pooled: one sample a branch, chain or node of all trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// BL: length of each Gravelius branch, in metres.
    BranchLength,
    /// BN: Gravelius branches of each tree.
    BranchNumber,
    /// BD: length of each unbranched run, in metres.
    BranchingDistance,
    /// NN: children of each node that has any.
    ///
    /// The published values fit no definition tried; this one is the nearest.
    NodeNumber,
    /// Angle between a node's front and its first child's, in radians.
    AngleChild1,
    /// The same for the second child.
    AngleChild2,
    /// The same for the third child.
    AngleChild3,
    /// Children of each node, ends included. Of a whole tree its mean is (N − 1) / N; not published.
    NodeNumberWithEnds,
}

/// How many metrics there are.
pub const METRICS: usize = Metric::ALL.len();

impl Metric {
    /// All metrics, in the order of the published table; the last is not in it.
    pub const ALL: [Self; 8] = [
        Self::BranchLength,
        Self::BranchNumber,
        Self::BranchingDistance,
        Self::NodeNumber,
        Self::AngleChild1,
        Self::AngleChild2,
        Self::AngleChild3,
        Self::NodeNumberWithEnds,
    ];

    /// The abbreviation used in tables.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::BranchLength => "BL",
            Self::BranchNumber => "BN",
            Self::BranchingDistance => "BD",
            Self::NodeNumber => "NN",
            Self::AngleChild1 => "A1",
            Self::AngleChild2 => "A2",
            Self::AngleChild3 => "A3",
            Self::NodeNumberWithEnds => "NN0",
        }
    }
}

/// Count, mean and variance of a stream of samples, without keeping them.
///
/// Welford's recurrence; two streams merge after Chan, Golub and LeVeque 1979.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// How many samples.
    pub count: u64,
    /// Their mean.
    pub mean: f64,
    /// Sum of the squared distances from the mean.
    squares: f64,
}

impl Moments {
    /// Adds a sample.
    pub fn add(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.squares += delta * (x - self.mean);
    }

    /// Adds the samples of another stream.
    pub fn merge(&mut self, other: &Self) {
        let count = self.count + other.count;
        if count == 0 {
            return;
        }
        let delta = other.mean - self.mean;
        let (n, m) = (self.count as f64, other.count as f64);
        self.mean += delta * m / (n + m);
        self.squares += other.squares + delta * delta * n * m / (n + m);
        self.count = count;
    }

    /// Takes the samples of another stream out again, which must have been merged before.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        let count = self.count - other.count;
        if count == 0 {
            return Self::default();
        }
        let (n, m) = (count as f64, other.count as f64);
        let mean = self.mean + (self.mean - other.mean) * m / n;
        let delta = other.mean - mean;
        let squares = self.squares - other.squares - delta * delta * n * m / (n + m);
        Self { count, mean, squares: squares.max(0.0) }
    }

    /// The count, the mean and the sum of the squared distances from it: all there is.
    #[must_use]
    pub const fn parts(&self) -> [f64; 3] {
        [self.count as f64, self.mean, self.squares]
    }

    /// The inverse of [`Self::parts`].
    #[must_use]
    pub const fn from_parts([count, mean, squares]: [f64; 3]) -> Self {
        Self { count: count as u64, mean, squares }
    }

    /// Standard deviation of the population.
    #[must_use]
    pub fn sd(&self) -> f64 {
        if self.count == 0 { 0.0 } else { (self.squares / self.count as f64).sqrt() }
    }
}

impl Serialize for Moments {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Moments", 3)?;
        fields.serialize_field("count", &self.count)?;
        fields.serialize_field("mean", &self.mean)?;
        fields.serialize_field("sd", &self.sd())?;
        fields.end()
    }
}

impl Extend<f64> for Moments {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, samples: T) {
        samples.into_iter().for_each(|x| self.add(x));
    }
}

/// The metrics of one tree, ready to be pooled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TreeMetrics {
    /// Nodes of the tree.
    pub nodes: u64,
    /// Moments of each of [`Metric::ALL`].
    pub moments: [Moments; METRICS],
}

impl TreeMetrics {
    /// Measures a tree.
    #[must_use]
    pub fn of(tree: &BranchGraph) -> Self {
        let mut metrics = Self { nodes: tree.len() as u64, ..Self::default() };
        visit(tree, |metric, _, x| metrics.moments[metric as usize].add(x));
        metrics
    }

    /// The moments of one metric.
    #[must_use]
    pub fn get(&self, metric: Metric) -> &Moments {
        &self.moments[metric as usize]
    }
}

/// Hands every sample of a tree to `take`, with its metric and branch order: that of the node, of
/// the first node of a branch or run, of the parent of an angle. The tree's own number of branches
/// has the order 0.
pub(crate) fn visit(tree: &BranchGraph, mut take: impl FnMut(Metric, u16, f64)) {
    const ANGLES: [Metric; 3] = [Metric::AngleChild1, Metric::AngleChild2, Metric::AngleChild3];
    let branches = branches(tree);
    take(Metric::BranchNumber, 0, branches.len() as f64);
    for (metric, paths) in
        [(Metric::BranchLength, branches), (Metric::BranchingDistance, chains(tree))]
    {
        for path in &paths {
            take(metric, tree.node(path.nodes[0]).order, f64::from(path.length(tree)));
        }
    }
    for node in tree.nodes() {
        let children = f64::from(node.child_count());
        take(Metric::NodeNumberWithEnds, node.order, children);
        if children > 0.0 {
            take(Metric::NodeNumber, node.order, children);
        }
        for (metric, child) in ANGLES.into_iter().zip(node.children) {
            if let Some(child) = child {
                take(metric, node.order, angle(node.front(), tree.node(child).front()));
            }
        }
    }
}

/// The angle between two directions in radians; exact for small ones, unlike an arc cosine.
fn angle(a: Vec3, b: Vec3) -> f64 {
    f64::from(a.cross(b).length()).atan2(f64::from(a.dot(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{ChildSignature, Quat, TreeInfo};

    /// A trunk of three 1 m internodes; at the second, two laterals of 0.5 m at 30° and 60°, the
    /// second of which goes on straight for another 0.5 m.
    fn hand_made() -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 3, gravitropism: 0.0, seed: 0 };
        let edge = |degrees: f32, length| {
            let rotation = Quat::from_rotation_x(degrees.to_radians());
            Some(ChildSignature { rotation, thickness: 0.01, length })
        };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(90.0, 1.0).unwrap());
        let second = tree.grow(0, [edge(10.0, 1.0), None, None])[0].unwrap();
        let [_, _, third] = tree.grow(second, [edge(0.0, 1.0), edge(30.0, 0.5), edge(60.0, 0.5)]);
        tree.grow(third.unwrap(), [edge(0.0, 0.5), None, None]);
        tree
    }

    #[test]
    fn metrics_of_a_hand_made_tree_are_those_worked_out_by_hand() {
        let metrics = TreeMetrics::of(&hand_made());
        let mean = |metric| metrics.get(metric).mean;
        assert_eq!(metrics.nodes, 6);
        // Branches of 3, 0.5 and 1 m; chains of 2, 1, 0.5 and 1 m; nodes with 1, 3 and 1 children.
        assert_eq!(mean(Metric::BranchNumber), 3.0);
        assert!((mean(Metric::BranchLength) - 1.5).abs() < 1e-6);
        assert!((mean(Metric::BranchingDistance) - 4.5 / 4.0).abs() < 1e-6);
        assert!((mean(Metric::NodeNumber) - 5.0 / 3.0).abs() < 1e-12);
        assert!((mean(Metric::NodeNumberWithEnds) - 5.0 / 6.0).abs() < 1e-12);
        assert!((mean(Metric::AngleChild1).to_degrees() - 10.0 / 3.0).abs() < 1e-3);
        assert!((mean(Metric::AngleChild2).to_degrees() - 30.0).abs() < 1e-3);
        assert!((mean(Metric::AngleChild3).to_degrees() - 60.0).abs() < 1e-3);
    }

    #[test]
    fn samples_have_the_order_of_the_branch_they_are_taken_of() {
        let mut seen = [[0u32; 2]; METRICS];
        visit(&hand_made(), |metric, order, _| seen[metric as usize][usize::from(order)] += 1);
        // Trunk: one branch, chains of 2 and 1 m, nodes with 1 and 3 children, 2 apical angles.
        // Laterals: two branches, two chains, one node with a child, one angle.
        let [bl, _, bd, nn, a1, a2, a3, all] = seen;
        assert_eq!((bl, bd, nn), ([1, 2], [2, 2], [2, 1]));
        assert_eq!((a1, a2, a3, all), ([2, 1], [1, 0], [1, 0], [3, 3]));
    }

    #[test]
    fn what_was_merged_can_be_taken_out_again() {
        let (mut all, mut part) = (Moments::default(), Moments::default());
        all.extend([3.0, -1.0, 4.0, 1.5, 9.0]);
        part.extend([3.0, 9.0]);
        // −1, 4 and 1.5 are left: mean 1.5, squares 6.25 + 6.25.
        let rest = all.without(&part);
        assert_eq!(rest.count, 3);
        assert!((rest.mean - 1.5).abs() < 1e-12 && (rest.parts()[2] - 12.5).abs() < 1e-12);
        assert_eq!(all.without(&all), Moments::default());
        assert_eq!(Moments::from_parts(all.parts()), all);
    }

    #[test]
    fn merged_moments_are_those_of_all_samples() {
        let samples = [3.0, -1.0, 4.0, 1.5, 9.0];
        let (mut all, mut a, mut b) = (Moments::default(), Moments::default(), Moments::default());
        all.extend(samples);
        a.extend(samples[..2].iter().copied());
        b.extend(samples[2..].iter().copied());
        a.merge(&b);
        assert_eq!(a.count, 5);
        assert!((a.mean - 3.3).abs() < 1e-12 && (all.mean - 3.3).abs() < 1e-12);
        assert!((a.sd() - all.sd()).abs() < 1e-12);
        // Σ(x − 3.3)² = 0.09 + 18.49 + 0.49 + 3.24 + 32.49
        assert!((a.sd() - (54.8f64 / 5.0).sqrt()).abs() < 1e-12);
    }
}
