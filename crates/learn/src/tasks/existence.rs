//! `existence`: which children a node has, and how many of its tips were dropped.

use burn::tensor::Tensor;
use deeptree_graph::signature::situated::{self, Branching, CLASSES};
use deeptree_graph::{Draws, MAX_CHILDREN};

use super::classifier::Classifier;
use super::{Lesson, Task};
use crate::loss::{self, EXISTENCE_TARGETS, IMPOSSIBLE};
use crate::order::Order;
use crate::report::Tally;

/// One sample a node, without balancing: a balanced classifier makes trees that are too large.
pub(crate) struct Existence<'a> {
    lesson: &'a Lesson<'a>,
    /// What picks the nodes where they are balanced after all.
    balanced: Option<Classifier<'a>>,
}

impl<'a> Existence<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>) -> Self {
        let balanced = lesson.balanced_existence.then(|| Classifier::new(lesson));
        Self { lesson, balanced }
    }
}

impl Task for Existence<'_> {
    fn inputs(&self) -> usize {
        situated::len(self.lesson.species)
    }

    fn outputs(&self) -> usize {
        CLASSES
    }

    fn targets(&self) -> usize {
        EXISTENCE_TARGETS
    }

    fn samples(&self) -> usize {
        self.lesson.corpus.nodes()
    }

    fn pick(&self, position: u64, order: &mut Order) -> usize {
        match &self.balanced {
            None => order.sample(position),
            Some(nodes) => self.lesson.corpus.number(nodes.spot(nodes.pick(position, order))),
        }
    }

    fn species(&self, sample: usize) -> usize {
        self.lesson.conditions(self.lesson.corpus.spot(sample)).species
    }

    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]) {
        let spot = self.lesson.corpus.spot(sample);
        self.lesson.encode(spot, inputs);
        let shares = self.lesson.corpus.shares(spot);
        let allows = |branching| shares.plan.allows(branching, shares.tips);
        tell_branching(shares.branching(), allows, targets);
    }

    fn disturb(&self, draws: Draws, inputs: &mut [f32]) {
        self.lesson.blur(draws, inputs);
    }

    fn is_disturbed(&self) -> bool {
        true
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::existence(outputs, targets)
    }

    fn measures(&self) -> &'static [&'static str] {
        &["cross_entropy", "accuracy", "children_predicted", "children_actual", "children_excess"]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        let (label, possible) = targets.split_at(CLASSES);
        let probabilities = probabilities(outputs, possible);
        let class = label.iter().position(|&x| x > 0.5).unwrap_or(0);
        let guess = (0..CLASSES).max_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]));
        let (mut predicted, actual) = (0.0, Branching::from_class(class));
        for slot in 0..MAX_CHILDREN {
            let has = |class: &usize| Branching::from_class(*class).has(slot);
            let p: f64 = (0..CLASSES).filter(has).map(|class| probabilities[class]).sum();
            tally.rely(p, actual.has(slot));
            predicted += p;
        }
        let children = f64::from(actual.children());
        tally.count(&[
            -probabilities[class].max(f64::MIN_POSITIVE).ln(),
            f64::from(u8::from(guess == Some(class))),
            predicted,
            children,
            predicted - children,
        ]);
    }
}

/// Writes how a node branches as [`loss::existence`] reads it: the class that is the case, and those
/// that could be.
///
/// # Shapes  targets: `[EXISTENCE_TARGETS]`
pub(crate) fn tell_branching(
    truth: Branching,
    is_possible: impl Fn(Branching) -> bool,
    targets: &mut [f32],
) {
    let (label, possible) = targets.split_at_mut(CLASSES);
    label.fill(0.0);
    label[truth.class()] = 1.0;
    for (class, possible) in possible.iter_mut().enumerate() {
        *possible = if is_possible(Branching::from_class(class)) { 0.0 } else { IMPOSSIBLE };
    }
}

/// ln p of the class that is the case.
pub(crate) fn ln_class(outputs: &[f32], targets: &[f32]) -> f64 {
    let (label, possible) = targets.split_at(CLASSES);
    let class = label.iter().position(|&x| x > 0.5).unwrap_or(0);
    probabilities(outputs, possible)[class].max(f64::MIN_POSITIVE).ln()
}

/// Softmax of the possible classes.
fn probabilities(outputs: &[f32], possible: &[f32]) -> [f64; CLASSES] {
    let mut p: [f64; CLASSES] =
        std::array::from_fn(|class| f64::from(outputs[class]) + f64::from(possible[class]));
    let peak = p.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    p.iter_mut().for_each(|p| *p = (*p - peak).exp());
    let sum: f64 = p.iter().sum();
    p.map(|p| p / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_classes_have_probability_zero_and_the_rest_is_a_softmax() {
        let mut possible = [IMPOSSIBLE; CLASSES];
        possible[3] = 0.0;
        possible[4] = 0.0;
        let mut outputs = [50.0; CLASSES];
        outputs[3] = 1.0;
        outputs[4] = 1.0 + 3f32.ln();
        let p = probabilities(&outputs, &possible);
        assert!((p[3] - 0.25).abs() < 1e-7 && (p[4] - 0.75).abs() < 1e-7);
        assert_eq!(p.iter().filter(|&&p| p == 0.0).count(), CLASSES - 2);
    }
}
