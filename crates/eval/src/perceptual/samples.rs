//! From a tree to the samples of its variables.

use deeptree_graph::{BranchGraph, Vec3};

use super::chains::{Chain, Measures, angle, cut, is_above_epsilon, unit};
use super::variable::Variable;
use super::{fitness, forks};

/// The samples of a variable, in the order they were taken.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Numbers.
    Values(Vec<f32>),
    /// Positions, each with its weight.
    Pairs(Vec<(f32, f32)>),
}

impl Samples {
    /// Numbers beyond this are taken for overflown and dropped.
    const OVERFLOW: f32 = 3.4e38;

    fn new(variable: Variable) -> Self {
        if variable.is_paired() { Self::Pairs(Vec::new()) } else { Self::Values(Vec::new()) }
    }

    /// How many samples there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Values(values) => values.len(),
            Self::Pairs(pairs) => pairs.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Positions and weights of the samples that are finite; numbers weigh 1.
    pub fn weighted(&self) -> impl Iterator<Item = (f32, f32)> + '_ {
        let (values, pairs): (&[f32], &[(f32, f32)]) = match self {
            Self::Values(values) => (values, &[]),
            Self::Pairs(pairs) => (&[], pairs),
        };
        let is_kept = |x: f32| x.abs() < Self::OVERFLOW;
        let all = values.iter().map(|&x| (x, 1.0)).chain(pairs.iter().copied());
        all.filter(move |&(x, weight)| is_kept(x) && is_kept(weight))
    }

    /// Positions of the samples that are finite.
    pub fn positions(&self) -> impl Iterator<Item = f32> + '_ {
        self.weighted().map(|(position, _)| position)
    }
}

/// Scalars of a whole tree.
///
/// # Source
///
/// Polasek et al. 2021, ICTreeF. Deviation: the age is 0 where there is no internode length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Common {
    /// Length of the first chain that has any, in metres.
    pub trunk_length: f32,
    /// Mean length of the other chains, in metres: their sum over one more than their number.
    pub internode_length: f32,
    /// Mean squared distance from that mean, in square metres, by the same divisor.
    pub internode_variance: f32,
    /// Chains that end in a node without children.
    pub leaf_count: f32,
    /// Forks below the deepest leaf chain, less one, and the trunk in internodes, rounded up.
    pub tree_age: f32,
    /// Kind of branching with most fitness: 0 monopodial, 1 and 2 sympodial (mono-, dichasial).
    pub branching: f32,
    /// Kind of ramification with most fitness: 0 continuous, 1 rhythmic, 2 diffuse.
    pub ramification: f32,
}

impl Common {
    /// The published names, in the order of [`Self::values`].
    pub const NAMES: [&'static str; 7] = [
        "trunkLength",
        "interNodeLength",
        "interNodeVariance",
        "leafCount",
        "treeAge",
        "branching",
        "ramification",
    ];

    /// The scalars in order.
    #[must_use]
    pub fn values(&self) -> [f32; 7] {
        [
            self.trunk_length,
            self.internode_length,
            self.internode_variance,
            self.leaf_count,
            self.tree_age,
            self.branching,
            self.ramification,
        ]
    }

    /// Measures all but branching and ramification.
    fn of(chains: &[Chain], lengths: &[f32]) -> Self {
        let (trunk_length, others) =
            lengths.split_first().map_or((0.0, [].as_slice()), |(&trunk, others)| (trunk, others));
        let (internode_length, internode_variance) = biased_moments(others);
        let leaves = || chains.iter().filter(|chain| chain.is_end);
        let deepest = leaves().map(|chain| chain.depth).max().unwrap_or(0);
        let tree_age = deepest as f32 - 1.0 + (trunk_length / internode_length).ceil();
        Self {
            trunk_length,
            internode_length,
            internode_variance,
            leaf_count: leaves().count() as f32,
            tree_age: if tree_age.is_finite() { tree_age } else { 0.0 },
            ..Self::default()
        }
    }
}

/// Mean and variance with n + 1 in place of n; zeros of no samples.
fn biased_moments(samples: &[f32]) -> (f32, f32) {
    let count = (samples.len() + 1) as f32;
    let mean = samples.iter().sum::<f32>() / count;
    let squares: f32 = samples.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, squares / count)
}

/// The kind 0, 1 or 2 with the largest sum of weights, the last of equals; 0 where no sum is
/// positive.
fn fullest(kinds: &Samples) -> f32 {
    let Samples::Pairs(pairs) = kinds else { return 0.0 };
    let mut best = (0.0, 0.0);
    for kind in [0.0, 1.0, 2.0] {
        let of_kind = pairs.iter().filter(|pair| pair.0 == kind);
        let sum: f32 = of_kind.map(|pair| pair.1).sum();
        if sum > 0.0 && sum >= best.0 {
            best = (sum, kind);
        }
    }
    best.1
}

/// The samples of all variables of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Variables {
    samples: Vec<Samples>,
    common: Common,
}

impl Variables {
    /// Measures a tree.
    ///
    /// # Source
    ///
    /// Polasek et al. 2021, ICTreeF
    #[must_use]
    pub fn of(tree: &BranchGraph) -> Self {
        let samples = Variable::ALL.map(Samples::new).into();
        let mut variables = Self { samples, common: Common::default() };
        let chains = cut(tree);
        for chain in &chains {
            variables.add_chain(chain);
            variables.add_thickness(&chain.measures);
            if let Some(parent) = chain.parent {
                variables.add_child(&chain.measures, &chains[parent].measures);
            }
            if chain.children.len() > 1 {
                forks::add(&mut variables, chain, &chains);
            }
        }
        variables.common = Common::of(&chains, variables.values(Variable::ChainLength));
        fitness::add(&mut variables, &chains);
        variables.common.branching = fullest(variables.get(Variable::AggregateBranchingFitness));
        variables.common.ramification =
            fullest(variables.get(Variable::AggregateRamificationFitness));
        variables
    }

    /// The samples of a variable.
    #[must_use]
    pub fn get(&self, variable: Variable) -> &Samples {
        &self.samples[variable as usize]
    }

    /// The scalars.
    #[must_use]
    pub fn common(&self) -> &Common {
        &self.common
    }

    pub(super) fn values(&self, variable: Variable) -> &[f32] {
        match self.get(variable) {
            Samples::Values(values) => values,
            Samples::Pairs(_) => &[],
        }
    }

    /// Adds a sample to a variable of numbers.
    pub(super) fn add(&mut self, variable: Variable, x: f32) {
        if let Samples::Values(values) = &mut self.samples[variable as usize] {
            values.push(x);
        }
    }

    /// Adds a sample to a variable of pairs.
    pub(super) fn add_pair(&mut self, variable: Variable, position: f32, weight: f32) {
        if let Samples::Pairs(pairs) = &mut self.samples[variable as usize] {
            pairs.push((position, weight));
        }
    }

    fn add_chain(&mut self, chain: &Chain) {
        let own = &chain.measures;
        self.add(Variable::SegmentsPerChain, own.segments.len() as f32);
        self.add(Variable::ChainsPerDepth, chain.depth as f32);
        self.add(Variable::ChainDeformation, own.angle_sum);
        if is_above_epsilon(own.length) {
            self.add(Variable::ChainLength, own.length);
        }
        let span = own.span.length();
        if is_above_epsilon(span) {
            self.add(Variable::ChainTotalLength, span);
            self.add(Variable::ChainSlope, angle(own.span, Vec3::Y));
            if chain.nodes.len() > 2 && is_above_epsilon(own.length) {
                self.add(Variable::ChainStraightness, span / own.length);
            }
        }
    }

    fn add_thickness(&mut self, own: &Measures) {
        for segment in &own.segments {
            self.add(Variable::SegmentThickness, segment.end);
            self.add_pair(Variable::SegmentVolume, segment.start, segment.volume());
            self.add_pair(Variable::SegmentVolume, segment.end, segment.volume());
        }
        let (min, max) = (own.min_thickness, own.max_thickness);
        let (has_min, has_max) = (min < f32::MAX, max > f32::MIN_POSITIVE);
        if has_min {
            self.add(Variable::ChainMinThickness, min);
        }
        if has_max {
            self.add(Variable::ChainMaxThickness, max);
        }
        if has_min && has_max {
            self.add(Variable::ChainMinMaxThicknessRatio, min / max);
        }
    }

    fn add_child(&mut self, own: &Measures, parent: &Measures) {
        if is_above_epsilon(own.length) && is_above_epsilon(parent.length) {
            self.add(Variable::ChainLengthRatio, own.length / parent.length);
        }
        if is_above_epsilon(own.angle_sum) && is_above_epsilon(parent.angle_sum) {
            self.add(Variable::ChainAngleSumDelta, own.angle_sum - parent.angle_sum);
        }
        self.add(Variable::ChainParentChildAngle, angle(parent.span, own.span));
        let up = unit(Vec3::Y);
        self.add(Variable::ChainTropismBranch, unit(own.span - own.first).dot(up));
        self.add(Variable::ChainTropismHorizon, unit(own.first).dot(up));
        self.add(Variable::ChainTropismParent, unit(parent.last).dot(unit(own.span)));
    }
}
