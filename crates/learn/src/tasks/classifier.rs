//! `classifier`: which children a node has, as published.

use burn::tensor::Tensor;
use deeptree_graph::signature::paper;
use deeptree_graph::{Draws, Lineage, MAX_CHILDREN, Purpose, Seed};

use super::{Lesson, Task};
use crate::loss;
use crate::order::Order;
use crate::report::Tally;
use crate::set::Spot;

/// One sample a node; nodes with 0, 1, 2 and 3 children are drawn equally often.
///
/// # Source
///
/// DeepTree §5.2: "we balance the number of nodes of each type".
pub(crate) struct Classifier<'a> {
    lesson: &'a Lesson<'a>,
    /// The nodes, by how many children they have.
    groups: Vec<Vec<Spot>>,
}

impl<'a> Classifier<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>) -> Self {
        let group = |count| lesson.corpus.select(|node| usize::from(node.child_count()) == count);
        Self { lesson, groups: (0..=MAX_CHILDREN).map(group).collect() }
    }

    /// The node of a sample.
    pub(super) fn spot(&self, sample: usize) -> Spot {
        let mut index = sample;
        for group in &self.groups {
            match group.get(index) {
                Some(&spot) => return spot,
                None => index -= group.len(),
            }
        }
        unreachable!("sample {sample} of {}", self.samples())
    }
}

impl Task for Classifier<'_> {
    fn inputs(&self) -> usize {
        paper::len(self.lesson.species)
    }

    fn outputs(&self) -> usize {
        MAX_CHILDREN
    }

    fn targets(&self) -> usize {
        MAX_CHILDREN
    }

    fn samples(&self) -> usize {
        self.lesson.corpus.nodes()
    }

    fn pick(&self, position: u64, order: &mut Order) -> usize {
        let mut draws = order.draws(position);
        let filled: usize = self.groups.iter().filter(|group| !group.is_empty()).count();
        let mut chosen = draws.index(filled);
        let mut start = 0;
        for group in &self.groups {
            if !group.is_empty() {
                if chosen == 0 {
                    return start + draws.index(group.len());
                }
                chosen -= 1;
            }
            start += group.len();
        }
        unreachable!("a corpus has nodes")
    }

    fn species(&self, sample: usize) -> usize {
        self.lesson.conditions(self.spot(sample)).species
    }

    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]) {
        let spot = self.spot(sample);
        let node = self.lesson.corpus.node(spot);
        paper::encode(node, self.lesson.conditions(spot), self.lesson.species, inputs);
        for (target, child) in targets.iter_mut().zip(node.children) {
            *target = f32::from(u8::from(child.is_some()));
        }
    }

    fn disturb(&self, draws: Draws, inputs: &mut [f32]) {
        disturb_position(self.lesson.position_noise, draws, inputs);
    }

    fn is_disturbed(&self) -> bool {
        self.lesson.position_noise > 0.0
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::classifier(outputs, targets)
    }

    fn measures(&self) -> &'static [&'static str] {
        &["mse", "accuracy", "accuracy_all_three", "children_excess"]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        let values = judge(outputs, targets, tally);
        tally.count(&values);
    }
}

/// The measures of one answer: squared error, share of children told right, whether all three are,
/// and how many children too many.
pub(super) fn judge(outputs: &[f32], targets: &[f32], tally: &mut Tally) -> [f64; 4] {
    let (mut squares, mut right, mut excess) = (0.0, 0.0, 0.0);
    for (&logit, &target) in outputs.iter().zip(targets) {
        let p = 1.0 / (1.0 + (-f64::from(logit)).exp());
        let actual = target > 0.5;
        tally.rely(p, actual);
        squares += (p - f64::from(target)).powi(2);
        right += f64::from(u8::from((p > 0.5) == actual));
        excess += p - f64::from(target);
    }
    let slots = MAX_CHILDREN as f64;
    let all = f64::from(u8::from(right >= slots));
    [squares / slots, right / slots, all, excess]
}

/// Adds Gaussian noise to the position.
///
/// # Source
///
/// DeepTree §5.2: mean 0, standard deviation 1e-4, in the unit cube.
pub(super) fn disturb_position(deviation: f64, mut draws: Draws, inputs: &mut [f32]) {
    for x in &mut inputs[paper::POSITION] {
        *x += (deviation * draws.normal()) as f32;
    }
}

/// The draws of the noise on the sample at `position`.
pub(crate) fn noise_draws(seed: Seed, network: u64, position: u64) -> Draws {
    seed.draws(Lineage::ROOT, Purpose::TrainingNoise).at(network).at(position)
}
