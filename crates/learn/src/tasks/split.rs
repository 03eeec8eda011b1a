//! `split`: how the tips of a node are shared among its children.

use burn::tensor::Tensor;
use deeptree_graph::signature::inheritance::share_bounds;
use deeptree_graph::signature::situated::{
    self, LOG_SCALE, SPLIT_COMPONENTS, SPLIT_LEN, SPLIT_OUTPUTS,
};
use deeptree_graph::{Draws, MAX_CHILDREN};

use super::{Lesson, Task};
use crate::loss::{self, OPEN_END, SPLIT_TARGETS};
use crate::report::Tally;
use crate::set::{Shares, Spot};

/// One sample a decision: of the tips that are left, how many does the child in a slot bear, while
/// others come after it?
pub(crate) struct Split<'a> {
    lesson: &'a Lesson<'a>,
    decisions: Vec<(Spot, u8)>,
}

/// The child bears `tips` of the `left` tips, of which each of the `after` later children needs
/// one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Decision {
    left: u32,
    after: u32,
    tips: u32,
    /// Of the node.
    reach: u16,
}

impl Decision {
    /// The decision on the child in `slot`; `None` where nothing is left to decide.
    fn of(shares: &Shares, slot: usize) -> Option<Self> {
        let earlier: u32 = shares.children[..slot].iter().sum();
        let left = shares.tips - u32::from(shares.branching().dropped) - earlier;
        let after = (shares.subset >> (slot + 1)).count_ones();
        let decision = Self { left, after, tips: shares.children[slot], reach: shares.plan.reach };
        let is_open = |(least, most)| least < most;
        let open = shares.branching().has(slot)
            && after > 0
            && is_open(share_bounds(left, after + 1, shares.plan.reach));
        open.then_some(decision)
    }

    /// How many numbers of tips are possible.
    fn bins(&self) -> u32 {
        self.left - self.after
    }

    /// Which of the equal bins stand for these tips: what lies beyond what the reach of the node
    /// allows counts for the outermost that it does.
    fn span(&self) -> (u32, u32) {
        let (least, most) = share_bounds(self.left, self.after + 1, self.reach);
        let low = if self.tips == least { 0 } else { self.tips - 1 };
        let high = if self.tips == most { self.bins() } else { self.tips };
        (low, high)
    }

    /// Logits of the ends of the share that stands for these tips; the outermost are open.
    fn ends(&self) -> (f32, f32) {
        let (low, high) = self.span();
        (logit(low, self.bins()), logit(high, self.bins()))
    }

    /// Difference of the ends, without the error that each has on its own.
    fn width(&self) -> f32 {
        let (low, high) = self.span();
        width(low, high, self.bins())
    }
}

/// Logit of the share of `bin` bins of so many.
pub(crate) fn logit(bin: u32, bins: u32) -> f32 {
    let (bin, bins) = (f64::from(bin), f64::from(bins));
    ((bin / (bins - bin)).ln() as f32).clamp(-OPEN_END, OPEN_END)
}

/// Difference of the logits of two shares, without the error that each has on its own.
pub(crate) fn width(low: u32, high: u32, bins: u32) -> f32 {
    let (low, high, bins) = (f64::from(low), f64::from(high), f64::from(bins));
    let ratio = high * (bins - low) / (low * (bins - high));
    (ratio.ln() as f32).min(OPEN_END)
}

impl<'a> Split<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>) -> Self {
        let forks = lesson.corpus.select(|node| node.child_count() > 1);
        let decisions = forks.into_iter().flat_map(|spot| {
            let shares = lesson.corpus.shares(spot);
            let open = move |slot: &u8| Decision::of(&shares, usize::from(*slot)).is_some();
            (0..MAX_CHILDREN as u8).filter(open).map(move |slot| (spot, slot))
        });
        Self { lesson, decisions: decisions.collect() }
    }
}

impl Task for Split<'_> {
    fn inputs(&self) -> usize {
        situated::len(self.lesson.species) + SPLIT_LEN
    }

    fn outputs(&self) -> usize {
        SPLIT_OUTPUTS
    }

    fn targets(&self) -> usize {
        SPLIT_TARGETS
    }

    fn samples(&self) -> usize {
        self.decisions.len()
    }

    fn species(&self, sample: usize) -> usize {
        self.lesson.conditions(self.decisions[sample].0).species
    }

    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]) {
        let (spot, slot) = self.decisions[sample];
        let slot = usize::from(slot);
        let shares = self.lesson.corpus.shares(spot);
        let Some(decision) = Decision::of(&shares, slot) else { return };
        let rest = self.lesson.encode(spot, inputs);
        situated::encode_split(shares.branching(), slot, decision.left, rest);
        let (low, high) = decision.ends();
        let (lows, others) = targets.split_at_mut(SPLIT_COMPONENTS);
        let (highs, widths) = others.split_at_mut(SPLIT_COMPONENTS);
        lows.fill(low);
        highs.fill(high);
        widths.fill(decision.width());
    }

    fn disturb(&self, draws: Draws, inputs: &mut [f32]) {
        self.lesson.blur(draws, inputs);
    }

    fn is_disturbed(&self) -> bool {
        true
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::split(outputs, targets)
    }

    fn measures(&self) -> &'static [&'static str] {
        &["nll"]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        let p = bin_probability(outputs, targets[0], targets[SPLIT_COMPONENTS]);
        tally.count(&[-p.max(f64::MIN_POSITIVE).ln()]);
    }
}

/// Probability that the logit of the share lies between `low` and `high`.
pub(crate) fn bin_probability(outputs: &[f32], low: f32, high: f32) -> f64 {
    const K: usize = SPLIT_COMPONENTS;
    let weights: Vec<f64> = outputs[..K].iter().map(|&x| f64::from(x).exp()).collect();
    let mass = |i: usize| {
        let scale = f64::from(outputs[2 * K + i].clamp(*LOG_SCALE.start(), *LOG_SCALE.end())).exp();
        let below =
            |z: f32| 1.0 / (1.0 + (-(f64::from(z) - f64::from(outputs[K + i])) / scale).exp());
        below(high) - below(low)
    };
    (0..K).map(|i| weights[i] * mass(i)).sum::<f64>() / weights.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::Plan;

    fn decision(left: u32, after: u32, tips: u32) -> Decision {
        Decision { left, after, tips, reach: 9 }
    }

    #[test]
    fn bins_tile_the_share() {
        for (left, after) in [(3, 1), (10, 2), (1000, 1)] {
            let all: Vec<_> = (1..=left - after).map(|k| decision(left, after, k)).collect();
            assert_eq!(all[0].ends().0, -OPEN_END);
            assert_eq!(all[all.len() - 1].ends().1, OPEN_END);
            for pair in all.windows(2) {
                assert_eq!(pair[0].ends().1, pair[1].ends().0);
            }
            for inner in &all[1..all.len() - 1] {
                let (low, high) = inner.ends();
                assert!((high - low - inner.width()).abs() < 1e-5 * high.abs().max(1.0));
            }
        }
    }

    #[test]
    fn a_triple_fork_gives_two_decisions_and_a_forced_share_gives_none() {
        let plan = |reach| Plan { reach, nodes: 0 };
        let all = Shares { plan: plan(9), ..Shares::default() };
        let shares = Shares { tips: 10, subset: 0b111, children: [4, 3, 2], ..all };
        assert_eq!(Decision::of(&shares, 0), Some(decision(9, 2, 4)));
        assert_eq!(Decision::of(&shares, 1), Some(decision(5, 1, 3)));
        assert_eq!(Decision::of(&shares, 2), None);
        let forced = Shares { tips: 2, subset: 0b101, children: [1, 0, 1], ..all };
        assert_eq!(Decision::of(&forced, 0), None);
        // Children of reach 0 bear three tips at most.
        let short = Shares { plan: plan(1), tips: 5, children: [2, 0, 3], ..forced };
        let lower = Decision::of(&short, 0).unwrap();
        assert_eq!((lower, lower.span()), (Decision { reach: 1, ..decision(5, 1, 2) }, (0, 2)));
        assert_eq!(Decision { tips: 3, ..lower }.span(), (2, 4));
        let full = Shares { plan: plan(1), tips: 6, children: [3, 0, 3], ..forced };
        assert_eq!(Decision::of(&full, 0), None);
    }

    #[test]
    fn probabilities_of_all_bins_add_up_to_one() {
        let outputs = [0.3, -1.0, 0.5, -2.0, 0.1, 4.0, -5.0, 0.3, 1.5];
        for (left, after) in [(2, 1), (3, 1), (50, 2), (5000, 1)] {
            let bin = |k| {
                let (low, high) = decision(left, after, k).ends();
                bin_probability(&outputs, low, high)
            };
            let sum: f64 = (1..=left - after).map(bin).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        }
    }
}
