//! `size`: how the nodes below a node are shared out among its children.

use burn::tensor::Tensor;
use deeptree_graph::signature::situated::{self, SPLIT_COMPONENTS, SPLIT_OUTPUTS};
use deeptree_graph::signature::size::{self, Bequest, SIZE_LEN};
use deeptree_graph::{Draws, MAX_CHILDREN};

use super::split::{bin_probability, logit, width};
use super::{Lesson, Task};
use crate::loss::{self, SPLIT_TARGETS};
use crate::report::Tally;
use crate::set::{Shares, Spot};

/// One sample a question: of the nodes that are left, how many grow below the child in a slot?
pub(crate) struct Size<'a> {
    lesson: &'a Lesson<'a>,
    questions: Vec<(Spot, u8)>,
}

/// What is known when the size of the child in `slot` is asked; `None` when there is no child.
fn known(shares: &Shares, slot: usize) -> Option<Bequest> {
    let branching = shares.branching();
    branching.has(slot).then_some(Bequest {
        branching,
        child_tips: shares.children,
        child_reaches: shares.reaches,
        nodes: shares.plan.nodes,
        slot,
        earlier: shares.nodes,
    })
}

/// Of how many equal bins which one stands for the size of the child in `slot`; `None` where
/// nothing is left to decide.
fn bin(shares: &Shares, slot: usize) -> Option<(u32, u32)> {
    match known(shares, slot)?.question() {
        size::Size::Settled(_) => None,
        size::Size::Open { least, most } => {
            Some((shares.nodes[slot].clamp(least, most) - least, most - least + 1))
        }
    }
}

impl<'a> Size<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>) -> Self {
        let forks = lesson.corpus.select(|node| node.child_count() > 1);
        let questions = forks.into_iter().flat_map(|spot| {
            let shares = lesson.corpus.shares(spot);
            let open = move |slot: &u8| bin(&shares, usize::from(*slot)).is_some();
            (0..MAX_CHILDREN as u8).filter(open).map(move |slot| (spot, slot))
        });
        Self { lesson, questions: questions.collect() }
    }
}

impl Task for Size<'_> {
    fn inputs(&self) -> usize {
        situated::len(self.lesson.species) + SIZE_LEN
    }

    fn outputs(&self) -> usize {
        SPLIT_OUTPUTS
    }

    fn targets(&self) -> usize {
        SPLIT_TARGETS
    }

    fn samples(&self) -> usize {
        self.questions.len()
    }

    fn species(&self, sample: usize) -> usize {
        self.lesson.conditions(self.questions[sample].0).species
    }

    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]) {
        let (spot, slot) = self.questions[sample];
        let shares = self.lesson.corpus.shares(spot);
        let (known, bin) = (known(&shares, usize::from(slot)), bin(&shares, usize::from(slot)));
        let (Some(known), Some((bin, bins))) = (known, bin) else { return };
        let rest = self.lesson.encode(spot, inputs);
        size::encode(&known, rest);
        let (lows, others) = targets.split_at_mut(SPLIT_COMPONENTS);
        let (highs, widths) = others.split_at_mut(SPLIT_COMPONENTS);
        lows.fill(logit(bin, bins));
        highs.fill(logit(bin + 1, bins));
        widths.fill(width(bin, bin + 1, bins));
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

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::Plan;

    #[test]
    fn bins_are_the_numbers_that_growth_can_draw() {
        // Two children of three tips over two levels, 2 to 6 nodes each; seven are left for them.
        let fork = |first: u32| Shares {
            tips: 6,
            plan: Plan { reach: 3, nodes: 9 },
            subset: 0b011,
            children: [3, 3, 0],
            reaches: [2, 2, 0],
            nodes: [first, 7 - first, 0],
        };
        for first in 2..=5 {
            assert_eq!(bin(&fork(first), 0), Some((first - 2, 4)));
            assert_eq!(bin(&fork(first), 1), None);
        }
    }
}
