//! How well forks and chains fit the botanical kinds of branching and ramification.

use super::chains::{Chain, is_above_epsilon};
use super::samples::Variables;
use super::variable::Variable;

/// Chains up to this share of the internode length are taken for a part of the fork below them.
const COMPACT: f32 = 0.001;

/// Chains merged into one: the first, and the very short ones that follow it.
#[derive(Clone, Debug, PartialEq)]
struct CompactChain {
    /// Indices of the merged chains.
    parts: Vec<usize>,
    /// Which part each child branches off, and the child's index among the *compact* chains.
    children: Vec<(usize, usize)>,
}

/// Adds the samples of compact chains with children.
pub(super) fn add(to: &mut Variables, chains: &[Chain]) {
    let internode = to.common().internode_length;
    let compact = merge(chains, internode * COMPACT);
    let forks: Vec<&CompactChain> =
        compact.iter().filter(|chain| !chain.children.is_empty()).collect();
    let counts: Vec<f32> =
        forks.iter().map(|fork| chains[fork.parts[0]].measures.fan_length / internode).collect();
    // The divisor is one more than the number, as in all means of the published implementation.
    let sum: f64 = counts.iter().copied().map(f64::from).sum();
    let mean = (sum / (counts.len() + 1) as f64) as f32;
    for (fork, count) in forks.into_iter().zip(counts) {
        to.add(Variable::ChainInternodeCount, count);
        add_kinds(to, &BRANCHING, Branches::of(fork, chains).fitness());
        add_kinds(to, &RAMIFICATION, ramification(count, mean));
    }
}

/// The variables of the three kinds, and the one that has all of them.
type Kinds = ([Variable; 3], Variable);

const BRANCHING: Kinds = (
    [
        Variable::ChainMonopodialBranchingFitness,
        Variable::ChainSympodialMonochasialBranchingFitness,
        Variable::ChainSympodialDichasialBranchingFitness,
    ],
    Variable::AggregateBranchingFitness,
);

const RAMIFICATION: Kinds = (
    [
        Variable::ChainContinuousRamificationFitness,
        Variable::ChainRhythmicRamificationFitness,
        Variable::ChainDiffuseRamificationFitness,
    ],
    Variable::AggregateRamificationFitness,
);

fn add_kinds(to: &mut Variables, (names, all): &Kinds, fitness: [f32; 3]) {
    for (kind, (&name, x)) in names.iter().zip(fitness).enumerate() {
        to.add(name, x);
        to.add_pair(*all, kind as f32, x);
    }
}

/// Merges chains that are at most `limit` metres long, leaves excepted, into those before them.
///
/// Length is here the sum of the distances of a chain's nodes from its first node, and adds up
/// over merged chains. Compact chains are numbered depth first, first children first; the plain
/// chains are not, so that the two numberings differ.
fn merge(chains: &[Chain], limit: f32) -> Vec<CompactChain> {
    let mut compact: Vec<CompactChain> = Vec::new();
    let mut open: Vec<(usize, Option<(usize, usize)>)> = vec![(0, None)];
    while let Some((first, parent)) = open.pop() {
        let own = compact.len();
        if let Some((parent, part)) = parent {
            compact[parent].children.push((part, own));
        }
        let mut parts = vec![first];
        let children_of = |chain: usize, part: usize, length: f32| {
            chains[chain].children.iter().map(move |&child| (child, part, length))
        };
        let mut candidates: Vec<(usize, usize, f32)> = children_of(first, 0, 0.0).collect();
        while let Some((chain, part, before)) = candidates.pop() {
            let length = before + chains[chain].measures.fan_length;
            if length <= limit && !chains[chain].children.is_empty() {
                candidates.extend(children_of(chain, parts.len(), length));
                parts.push(chain);
            } else {
                open.push((chain, Some((own, part))));
            }
        }
        compact.push(CompactChain { parts, children: Vec::new() });
    }
    compact
}

/// The children of a fork, as the measures of branching see them.
#[derive(Clone, Debug, PartialEq)]
struct Branches {
    /// Cosine between each child and the chain it branches off.
    continuation: Vec<f32>,
    /// Leaf chains above each child.
    size: Vec<f32>,
}

impl Branches {
    /// Looks the children up.
    ///
    /// Their indices are those of compact chains and are used as those of plain chains, as in the
    /// published implementation: of a fork high up, another chain may be measured than the child.
    fn of(fork: &CompactChain, chains: &[Chain]) -> Self {
        let ends = fork.children.iter().map(|&(part, child)| {
            let (parent, child) = (&chains[fork.parts[part]].measures, &chains[child].measures);
            (parent.last.dot(child.first), child.leaves_above)
        });
        let (continuation, size) = ends.unzip();
        Self { continuation, size }
    }

    /// Monopodial, sympodial monochasial, sympodial dichasial.
    fn fitness(&self) -> [f32; 3] {
        let smallest = self.size.iter().copied().fold(f32::MAX, f32::min);
        let largest = self.size.iter().copied().fold(f32::MIN, f32::max);
        let has_spread = is_above_epsilon(largest - smallest);
        let spread = if has_spread { largest - smallest } else { 1.0 };
        let by_size = last_of_largest(&self.size);
        let primary = if has_spread { by_size } else { last_of_largest(&self.continuation) };
        [
            self.dominance(primary, has_spread, spread, f32::max) * self.evenness(primary, spread),
            self.dominance(primary, has_spread, spread, f32::min)
                * self.loneliness(primary, spread, |_| 1.0),
            self.likeness(by_size)
                * self.loneliness(by_size, spread, |i| (self.continuation[i] + 1.0) / 2.0),
        ]
    }

    fn others(&self, primary: usize) -> impl Iterator<Item = usize> {
        (0..self.size.len()).filter(move |&i| i != primary)
    }

    /// How far the primary child outgrows the rival that `pick` finds among the others, times how
    /// straight it goes on. Among children of equal size it outgrows all.
    fn dominance(
        &self,
        primary: usize,
        has_spread: bool,
        spread: f32,
        pick: fn(f32, f32) -> f32,
    ) -> f32 {
        let rival = self.others(primary).map(|i| self.size[i]).reduce(pick);
        let lead = match rival {
            Some(rival) if has_spread => (self.size[primary] - rival) / spread,
            _ => 1.0,
        };
        lead * ((self.continuation[primary] + 1.0) / 2.0)
    }

    /// How equal the other children are; half as good where there is only one.
    fn evenness(&self, primary: usize, spread: f32) -> f32 {
        let count = self.size.len() - 1;
        let mean = self.others(primary).map(|i| self.size[i]).sum::<f32>() / count as f32;
        let even = |i: usize| {
            let distance = self.size[i] - mean;
            1.0 - (distance * distance) / (spread * spread)
        };
        self.others(primary).map(even).sum::<f32>() / count.max(2) as f32
    }

    /// How small the children are that are neither the primary nor the secondary.
    fn loneliness(&self, primary: usize, spread: f32, weight: impl Fn(usize) -> f32) -> f32 {
        let count = self.size.len() - 1;
        if count < 2 {
            return 1.0;
        }
        let secondary = self.secondary(primary);
        let rest = self.others(primary).filter(|&i| Some(i) != secondary);
        let penalty: f32 = rest.map(|i| self.size[i] / spread * weight(i)).sum();
        1.0 - penalty / (count - 1) as f32
    }

    /// How like the primary child its secondary is, in size and in continuation; 0 where there is
    /// none.
    fn likeness(&self, primary: usize) -> f32 {
        let Some(secondary) = self.secondary(primary) else { return 0.0 };
        let turn = (self.continuation[primary] - self.continuation[secondary]).abs();
        self.size[secondary] / self.size[primary] * (1.0 - turn / 2.0)
    }

    /// The smallest of the other children, the last of equals.
    fn secondary(&self, primary: usize) -> Option<usize> {
        self.others(primary).reduce(|a, b| if self.size[b] <= self.size[a] { b } else { a })
    }
}

/// Where the largest number is, the last of equals.
fn last_of_largest(numbers: &[f32]) -> usize {
    (1..numbers.len()).fold(0, |best, i| if numbers[i] >= numbers[best] { i } else { best })
}

/// Continuous, rhythmic, diffuse: of a chain of `count` internodes in a tree with that mean.
fn ramification(count: f32, mean: f32) -> [f32; 3] {
    let from_one = (1.0 - count).abs();
    let from_mean = (mean - count).abs();
    [
        smoothstep(1.0 - from_one),
        smoothstep(1.0 - from_mean) * smoothstep(from_one),
        smoothstep(from_mean),
    ]
}

/// `3 x² − 2 x³`, with x clamped to [0, 1].
fn smoothstep(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    3.0 * (x * x) - 2.0 * (x * x * x)
}
