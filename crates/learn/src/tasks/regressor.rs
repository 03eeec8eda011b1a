//! `regressor1` … `regressor3`: the mean signature of the child in a slot, as published.

use burn::tensor::Tensor;
use deeptree_graph::signature::paper::{self, CHILD_LEN};
use deeptree_graph::{ChildSignature, Draws, Node};

use super::classifier::disturb_position;
use super::{Lesson, Task};
use crate::loss;
use crate::report::Tally;
use crate::set::Spot;

/// One sample a child in the slot.
pub(crate) struct Regressor<'a> {
    lesson: &'a Lesson<'a>,
    slot: usize,
    parents: Vec<Spot>,
}

impl<'a> Regressor<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>, slot: usize) -> Self {
        let parents = lesson.corpus.select(|node| node.children[slot].is_some());
        Self { lesson, slot, parents }
    }

    /// The child in `slot`, if there is one.
    fn child(&self, spot: Spot, slot: usize) -> Option<ChildSignature> {
        self.lesson.corpus.child(spot, slot).map(signature)
    }
}

/// The output signature of a child, its quaternion with the sign it has in the graph.
///
/// The cosine loss tells q from −q. The growth model composes the rotations of a slot in the same
/// way each time, so its signs agree; choosing by the sign of w would tear slot 2 apart, where w is
/// near 0.
pub(super) fn signature(child: &Node) -> ChildSignature {
    ChildSignature { rotation: child.rotation, thickness: child.thickness, length: child.length }
}

impl Task for Regressor<'_> {
    fn inputs(&self) -> usize {
        paper::len(self.lesson.species) + self.slot * CHILD_LEN
    }

    fn outputs(&self) -> usize {
        CHILD_LEN
    }

    fn targets(&self) -> usize {
        CHILD_LEN
    }

    fn samples(&self) -> usize {
        self.parents.len()
    }

    fn species(&self, sample: usize) -> usize {
        self.lesson.conditions(self.parents[sample]).species
    }

    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]) {
        let spot = self.parents[sample];
        let (own, earlier) = inputs.split_at_mut(paper::len(self.lesson.species));
        let (node, conditions) = (self.lesson.corpus.node(spot), self.lesson.conditions(spot));
        paper::encode(node, conditions, self.lesson.species, own);
        for (slot, out) in earlier.chunks_exact_mut(CHILD_LEN).enumerate() {
            paper::encode_child(self.child(spot, slot).as_ref(), out);
        }
        paper::encode_child(self.child(spot, self.slot).as_ref(), targets);
    }

    fn disturb(&self, draws: Draws, inputs: &mut [f32]) {
        disturb_position(self.lesson.position_noise, draws, inputs);
    }

    fn is_disturbed(&self) -> bool {
        self.lesson.position_noise > 0.0
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::regressor(outputs, targets)
    }

    fn measures(&self) -> &'static [&'static str] {
        &["mse", "cosine_distance"]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        tally.count(&judge(outputs, targets));
    }
}

/// Mean squared error of thickness and length, and cosine distance of the quaternions.
pub(super) fn judge(outputs: &[f32], targets: &[f32]) -> [f64; 2] {
    let f = |values: &[f32], i: usize| f64::from(values[i]);
    let dot = |a: &[f32], b: &[f32]| (0..4).map(|i| f(a, i) * f(b, i)).sum::<f64>();
    let norm = dot(outputs, outputs).sqrt().max(f64::MIN_POSITIVE);
    let squares: f64 = (4..6).map(|i| (f(outputs, i) - f(targets, i)).powi(2)).sum();
    [squares / 2.0, 1.0 - dot(outputs, targets) / norm]
}
