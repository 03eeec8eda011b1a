//! A set of trees, measured once for all that is asked of it later.

use deeptree_graph::{BranchGraph, TreeTraits};
use serde::{Deserialize, Serialize};

use crate::histogram::Histogram;
use crate::metrics::{METRICS, Metric, Moments, TreeMetrics, visit};
use crate::packed;
use crate::tree_features::tree_features;

/// Branch orders that are told apart; the last is that and all above.
pub const ORDERS: usize = 5;

/// What is kept of one tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeRecord {
    /// The tree's seed.
    pub seed: u64,
    /// Was it cut off by a node budget?
    pub hit_budget: bool,
    /// Nodes of the tree.
    pub nodes: u32,
    /// Height of the highest node, in metres.
    pub height: f32,
    /// Distance of the outermost node from the axis, in metres.
    pub crown_radius: f32,
    /// [`Moments::parts`] of each of [`Metric::ALL`].
    #[serde(with = "packed")]
    moments: Vec<f64>,
    /// [`tree_features`] to five places: what is smaller is rounding of positions in float32, and no
    /// classifier shall tell trees by that.
    #[serde(with = "packed")]
    pub features: Vec<f32>,
}

impl TreeRecord {
    /// The moments of a metric.
    #[must_use]
    pub fn get(&self, metric: Metric) -> Moments {
        let parts = self.moments.chunks_exact(3).nth(metric as usize);
        Moments::from_parts(parts.map_or([0.0; 3], |parts| [parts[0], parts[1], parts[2]]))
    }

    /// The metrics of the table.
    #[must_use]
    pub fn metrics(&self) -> TreeMetrics {
        let moments = Metric::ALL.map(|metric| self.get(metric));
        TreeMetrics { nodes: u64::from(self.nodes), moments }
    }

    /// The features, for classifiers and distances.
    #[must_use]
    pub fn row(&self) -> Vec<f64> {
        self.features.iter().copied().map(f64::from).collect()
    }
}

/// One metric at one branch order, of all trees of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slice {
    /// [`Moments::parts`].
    parts: [f64; 3],
    /// How the samples are spread.
    pub histogram: Histogram,
}

impl Slice {
    /// Count, mean and standard deviation.
    #[must_use]
    pub const fn moments(&self) -> Moments {
        Moments::from_parts(self.parts)
    }
}

/// What is kept of a set of trees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TreeSet {
    /// Each tree.
    pub trees: Vec<TreeRecord>,
    /// All trees together, metric by metric and order by order.
    slices: Vec<Slice>,
}

impl Default for TreeSet {
    fn default() -> Self {
        let empty = |metric: &Metric| {
            let histogram = Histogram::of_metric(*metric);
            std::iter::repeat_n(Slice { parts: [0.0; 3], histogram }, ORDERS)
        };
        Self { trees: Vec::new(), slices: Metric::ALL.iter().flat_map(empty).collect() }
    }
}

impl TreeSet {
    /// Measures a tree: a set of one.
    #[must_use]
    pub fn of(tree: &BranchGraph, hit_budget: bool) -> Self {
        let mut set = Self::default();
        let mut moments = [[Moments::default(); ORDERS]; METRICS];
        visit(tree, |metric, order, x| {
            let order = usize::from(order).min(ORDERS - 1);
            moments[metric as usize][order].add(x);
            set.slices[place(metric, order)].histogram.add(x);
        });
        for (slice, moments) in set.slices.iter_mut().zip(moments.as_flattened()) {
            slice.parts = moments.parts();
        }
        let TreeTraits { height, crown_radius, .. } = TreeTraits::of(tree);
        set.trees.push(TreeRecord {
            seed: tree.info.seed,
            hit_budget,
            nodes: tree.len() as u32,
            height,
            crown_radius,
            moments: TreeMetrics::of(tree).moments.iter().flat_map(Moments::parts).collect(),
            features: tree_features(tree).into_iter().map(rounded).collect(),
        });
        set
    }

    /// Adds the trees of another set.
    pub fn merge(&mut self, other: Self) {
        self.trees.extend(other.trees);
        for (slice, more) in self.slices.iter_mut().zip(&other.slices) {
            let mut moments = slice.moments();
            moments.merge(&more.moments());
            slice.parts = moments.parts();
            slice.histogram.merge(&more.histogram);
        }
    }

    /// A metric at a branch order below [`ORDERS`].
    #[must_use]
    pub fn at_order(&self, metric: Metric, order: usize) -> &Slice {
        &self.slices[place(metric, order)]
    }

    /// How a metric is spread over all orders.
    #[must_use]
    pub fn histogram(&self, metric: Metric) -> Histogram {
        let mut all = Histogram::of_metric(metric);
        (0..ORDERS).for_each(|order| all.merge(&self.at_order(metric, order).histogram));
        all
    }

    /// How many trees were cut off by a node budget.
    #[must_use]
    pub fn hit_budget(&self) -> usize {
        self.trees.iter().filter(|tree| tree.hit_budget).count()
    }

    /// The features of the trees.
    #[must_use]
    pub fn rows(&self) -> Vec<Vec<f64>> {
        self.trees.iter().map(TreeRecord::row).collect()
    }
}

fn rounded(feature: f64) -> f32 {
    ((feature * 1e5).round() / 1e5) as f32
}

const fn place(metric: Metric, order: usize) -> usize {
    metric as usize * ORDERS + order
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::Seed;
    use deeptree_growth::{Parameters, Profile, Species, grow};

    fn grown(seed: u64) -> BranchGraph {
        let parameters = Species::named("walnut").unwrap().parameters(Profile::Reference).clone();
        grow("walnut", &Parameters { age: 12.0, ..parameters }, Seed(seed)).unwrap().tree
    }

    #[test]
    fn orders_together_are_the_whole_tree() {
        let tree = grown(1);
        let (set, metrics) = (TreeSet::of(&tree, true), TreeMetrics::of(&tree));
        for metric in Metric::ALL {
            let mut all = Moments::default();
            (0..ORDERS).for_each(|order| all.merge(&set.at_order(metric, order).moments()));
            let whole = metrics.get(metric);
            assert_eq!((all.count, set.histogram(metric).total()), (whole.count, whole.count));
            assert!((all.mean - whole.mean).abs() < 1e-9 * (1.0 + whole.mean), "{metric:?}");
            assert!((all.sd() - whole.sd()).abs() < 1e-9 * (1.0 + whole.sd()), "{metric:?}");
        }
        assert_eq!(set.trees[0].metrics(), metrics);
        assert_eq!((set.hit_budget(), set.trees[0].seed), (1, 1));
    }

    #[test]
    fn sets_merge_tree_by_tree() {
        let mut set = TreeSet::of(&grown(1), false);
        let one = set.clone();
        set.merge(TreeSet::of(&grown(2), false));
        assert_eq!((set.trees.len(), &set.trees[0]), (2, &one.trees[0]));
        let branches = |set: &TreeSet| set.at_order(Metric::BranchLength, 0).moments().count;
        assert_eq!((branches(&one), branches(&set)), (1, 2));
    }
}
