//! `joint`: which children a node has and what they are like, from one network.
//!
//! Source: DeepTree §6, "Network Comparison": the classifier's layers with two additional heads,
//! "with the same setup for loss functions and data processing".

use burn::tensor::Tensor;
use deeptree_graph::signature::paper::{self, CHILD_LEN, JOINT_LEN};
use deeptree_graph::{Draws, MAX_CHILDREN};

use super::classifier::{self, Classifier};
use super::{Lesson, Task, regressor};
use crate::loss;
use crate::order::Order;
use crate::report::Tally;

/// One sample a node, drawn as the classifier's are.
pub(crate) struct Joint<'a> {
    lesson: &'a Lesson<'a>,
    nodes: Classifier<'a>,
}

impl<'a> Joint<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>) -> Self {
        Self { lesson, nodes: Classifier::new(lesson) }
    }
}

impl Task for Joint<'_> {
    fn inputs(&self) -> usize {
        self.nodes.inputs()
    }

    fn outputs(&self) -> usize {
        JOINT_LEN
    }

    fn targets(&self) -> usize {
        JOINT_LEN
    }

    fn samples(&self) -> usize {
        self.nodes.samples()
    }

    fn pick(&self, position: u64, order: &mut Order) -> usize {
        self.nodes.pick(position, order)
    }

    fn species(&self, sample: usize) -> usize {
        self.nodes.species(sample)
    }

    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]) {
        let (exists, signatures) = targets.split_at_mut(MAX_CHILDREN);
        self.nodes.encode(sample, inputs, exists);
        let spot = self.nodes.spot(sample);
        for (slot, out) in signatures.chunks_exact_mut(CHILD_LEN).enumerate() {
            let child = self.lesson.corpus.child(spot, slot).map(regressor::signature);
            paper::encode_child(child.as_ref(), out);
        }
    }

    fn disturb(&self, draws: Draws, inputs: &mut [f32]) {
        self.nodes.disturb(draws, inputs);
    }

    fn is_disturbed(&self) -> bool {
        self.nodes.is_disturbed()
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::joint(outputs, targets)
    }

    fn measures(&self) -> &'static [&'static str] {
        &[
            "existence_mse",
            "accuracy",
            "accuracy_all_three",
            "children_excess",
            "mse",
            "cosine_distance",
        ]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        let (logits, children) = outputs.split_at(MAX_CHILDREN);
        let (exists, truths) = targets.split_at(MAX_CHILDREN);
        let node = classifier::judge(logits, exists, tally);
        let pairs = children.chunks_exact(CHILD_LEN).zip(truths.chunks_exact(CHILD_LEN));
        let judged: Vec<[f64; 2]> = pairs
            .zip(exists)
            .filter(|(_, exists)| **exists > 0.5)
            .map(|((child, truth), _)| regressor::judge(child, truth))
            .collect();
        tally.count(&node);
        tally.count_parts(node.len(), &judged);
    }
}
