//! `reach`: how the children of a node inherit the longest path below it.

use burn::tensor::Tensor;
use deeptree_graph::signature::inheritance::{
    self, Inheritance, Question, REACH_LEN, REACH_OUTPUTS,
};
use deeptree_graph::signature::situated::{self, SPLIT_COMPONENTS};
use deeptree_graph::{Draws, MAX_CHILDREN};

use super::split::{bin_probability, logit, width};
use super::{Lesson, Task};
use crate::loss::{self, OPEN_END, REACH_TARGETS};
use crate::report::Tally;
use crate::set::{Shares, Spot};

/// One sample a question: is the child in a slot the heir, and if not, how far does it reach?
pub(crate) struct Reach<'a> {
    lesson: &'a Lesson<'a>,
    questions: Vec<(Spot, u8)>,
}

/// The true answer to a question.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Answer {
    /// Where it was asked whether the child is the heir.
    is_heir: Option<bool>,
    /// Logits of the ends of its bin, the outermost possible ones open; all is open for an heir.
    ends: (f32, f32),
    /// Difference of the ends.
    width: f32,
}

impl Answer {
    const HEIR: Self = Self { is_heir: Some(true), ends: (-OPEN_END, OPEN_END), width: OPEN_END };

    /// The answer for the child in `slot`; `None` where nothing is left to decide.
    fn of(shares: &Shares, slot: usize) -> Option<Self> {
        let Question::Open { asks_heir, bins, least } = known(shares, slot)?.question() else {
            return None;
        };
        let reach = shares.reaches[slot];
        if asks_heir && reach + 1 == shares.plan.reach {
            return Some(Self::HEIR);
        }
        let (bins, bin) = (u32::from(bins), u32::from(reach));
        // A share below what the tips need counts for the least that they do.
        let first = if reach == least { 0 } else { bin };
        let ends = (logit(first, bins), logit(bin + 1, bins));
        let is_heir = asks_heir.then_some(false);
        Some(Self { is_heir, ends, width: width(first, bin + 1, bins) })
    }
}

/// What is known of the reach of the child in `slot`; `None` when there is no child.
fn known(shares: &Shares, slot: usize) -> Option<Inheritance> {
    let branching = shares.branching();
    branching.has(slot).then_some(Inheritance {
        branching,
        child_tips: shares.children,
        reach: shares.plan.reach,
        slot,
        earlier: shares.reaches,
    })
}

impl<'a> Reach<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>) -> Self {
        let forks = lesson.corpus.select(|node| node.child_count() > 1);
        let questions = forks.into_iter().flat_map(|spot| {
            let shares = lesson.corpus.shares(spot);
            let open = move |slot: &u8| Answer::of(&shares, usize::from(*slot)).is_some();
            (0..MAX_CHILDREN as u8).filter(open).map(move |slot| (spot, slot))
        });
        Self { lesson, questions: questions.collect() }
    }
}

impl Task for Reach<'_> {
    fn inputs(&self) -> usize {
        situated::len(self.lesson.species) + REACH_LEN
    }

    fn outputs(&self) -> usize {
        REACH_OUTPUTS
    }

    fn targets(&self) -> usize {
        REACH_TARGETS
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
        let (known, answer) =
            (known(&shares, usize::from(slot)), Answer::of(&shares, usize::from(slot)));
        let (Some(known), Some(answer)) = (known, answer) else { return };
        let rest = self.lesson.encode(spot, inputs);
        inheritance::encode(&known, rest);
        let (heir, bin) = targets.split_at_mut(1);
        heir[0] = match answer.is_heir {
            None => 0.0,
            Some(is_heir) => f32::from(i8::from(is_heir) * 2 - 1),
        };
        let (lows, others) = bin.split_at_mut(SPLIT_COMPONENTS);
        let (highs, widths) = others.split_at_mut(SPLIT_COMPONENTS);
        lows.fill(answer.ends.0);
        highs.fill(answer.ends.1);
        widths.fill(answer.width);
    }

    fn disturb(&self, draws: Draws, inputs: &mut [f32]) {
        self.lesson.blur(draws, inputs);
    }

    fn is_disturbed(&self) -> bool {
        true
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::reach(outputs, targets)
    }

    fn measures(&self) -> &'static [&'static str] {
        &["nll", "heir_predicted", "heir_actual"]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        let p = 1.0 / (1.0 + f64::from(-outputs[0]).exp());
        let (is_asked, is_heir) = (targets[0] != 0.0, targets[0] > 0.0);
        let odds = match (is_asked, is_heir) {
            (false, _) => 1.0,
            (true, true) => p,
            (true, false) => 1.0 - p,
        };
        if is_asked {
            tally.rely(p, is_heir);
        }
        let bin = bin_probability(&outputs[1..], targets[1], targets[1 + SPLIT_COMPONENTS]);
        tally.count(&[
            -(odds * bin).max(f64::MIN_POSITIVE).ln(),
            if is_asked { p } else { 0.0 },
            f64::from(u8::from(is_heir)),
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::Plan;

    fn fork(reach: u16, reaches: [u16; MAX_CHILDREN]) -> Shares {
        let plan = Plan { reach, nodes: 0 };
        let (subset, children) = (0b111, [5, 2, 2]);
        Shares { tips: 9, plan, subset, children, reaches, ..Shares::default() }
    }

    #[test]
    fn answers_are_of_the_questions_that_growth_asks() {
        let near = |answer: Option<Answer>, is_heir, low: f32, high: f32, width: f32| {
            let answer = answer.unwrap();
            assert_eq!(answer.is_heir, is_heir);
            for (a, b) in [(answer.ends.0, low), (answer.ends.1, high), (answer.width, width)] {
                assert!((a - b).abs() < 1e-6, "{answer:?}");
            }
        };
        // Of reach 6, five bins before the heir and six after it.
        let late = fork(6, [2, 0, 5]);
        let ln = f32::ln;
        near(Answer::of(&late, 0), Some(false), ln(2.0 / 3.0), ln(3.0 / 2.0), ln(9.0 / 4.0));
        near(Answer::of(&late, 1), Some(false), -OPEN_END, ln(1.0 / 4.0), OPEN_END);
        assert_eq!(Answer::of(&late, 2), None);
        let early = fork(6, [5, 5, 2]);
        assert_eq!(Answer::of(&early, 0), Some(Answer::HEIR));
        near(Answer::of(&early, 1), None, ln(5.0), OPEN_END, OPEN_END);
        // Five tips need a reach of 1: what lies below counts for it.
        let least = Answer::of(&fork(6, [1, 5, 0]), 0);
        near(least, Some(false), -OPEN_END, ln(2.0 / 3.0), OPEN_END);
    }

    #[test]
    fn probabilities_of_all_answers_add_up_to_one() {
        let outputs = [0.4, 0.3, -1.0, 0.5, -2.0, 0.1, 2.0, 0.5, 0.3, 1.5];
        let p = 1.0 / (1.0 + f64::from(-outputs[0]).exp());
        for reach in 3..20 {
            let probability = |own| {
                // The heir in slot 0, or if it is not, in slot 2.
                let answer = Answer::of(&fork(reach, [own, 0, reach - 1]), 0).unwrap();
                let bin = bin_probability(&outputs[1..], answer.ends.0, answer.ends.1);
                if answer == Answer::HEIR { p } else { (1.0 - p) * bin }
            };
            let sum: f64 = (1..reach).map(probability).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{reach}: {sum}");
        }
    }
}
