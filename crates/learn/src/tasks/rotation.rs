//! `rotation1` … `rotation3`: how the child in a slot is turned against its parent.

use burn::tensor::Tensor;
use deeptree_graph::signature::situated::{
    self, ROTATION_COMPONENTS, ROTATION_OUTPUTS, RotationContext, Sibling, Turn, rotation_len,
};
use deeptree_graph::{Draws, MAX_CHILDREN, Plan};

use super::swing::SwingTarget;
use super::{Lesson, Task};
use crate::loss::{self, ROTATION_TARGETS};
use crate::report::Tally;
use crate::rotations::Rotations;
use crate::set::Spot;

/// Standard deviation of the noise on the traits and on where the tree stands; between trees they
/// spread by about 1.
const TRAIT_NOISE: f64 = 0.3;

/// One sample a child in the slot.
pub(crate) struct Rotation<'a> {
    lesson: &'a Lesson<'a>,
    rotations: &'a Rotations,
    slot: usize,
    parents: Vec<Spot>,
}

impl<'a> Rotation<'a> {
    pub(crate) fn new(lesson: &'a Lesson<'a>, rotations: &'a Rotations, slot: usize) -> Self {
        let parents = lesson.corpus.select(|node| node.children[slot].is_some());
        Self { lesson, rotations, slot, parents }
    }
}

impl Task for Rotation<'_> {
    fn inputs(&self) -> usize {
        situated::len(self.lesson.species) + rotation_len(self.slot)
    }

    fn outputs(&self) -> usize {
        ROTATION_OUTPUTS
    }

    fn targets(&self) -> usize {
        ROTATION_TARGETS
    }

    fn samples(&self) -> usize {
        self.parents.len()
    }

    fn species(&self, sample: usize) -> usize {
        self.lesson.conditions(self.parents[sample]).species
    }

    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]) {
        let spot = self.parents[sample];
        let (node, tree) = (self.lesson.corpus.node(spot), self.lesson.conditions(spot));
        let shares = self.lesson.corpus.shares(spot);
        let sibling = |slot: usize| {
            let child = self.lesson.corpus.child(spot, slot)?;
            let turn = self.rotations.turn(tree, node, child);
            Some(Sibling { tips: shares.children[slot], turn })
        };
        let siblings: [_; MAX_CHILDREN] =
            std::array::from_fn(|slot| if slot <= self.slot { sibling(slot) } else { None });
        let Some(Sibling { tips, turn }) = siblings[self.slot] else { return };
        let parent = self.lesson.corpus.parent(spot);
        let own = parent.map_or_else(Turn::default, |up| self.rotations.turn(tree, up, node));
        let rest = self.lesson.encode(spot, inputs);
        let context = RotationContext {
            branching: shares.branching(),
            parent_tips: shares.tips,
            tips,
            parent_reach: shares.plan.reach,
            plan: Plan { reach: shares.reaches[self.slot], nodes: shares.nodes[self.slot] },
            slot: self.rotations.slots[tree.species][self.slot],
            roll: turn.roll,
            own,
            earlier: &siblings[..self.slot],
        };
        situated::encode_rotation(node, tree, &context, rest);
        SwingTarget::of(&context.slot, turn, node).write(targets);
    }

    /// More noise than [`Lesson::blur`], since there are fewer samples, and on the traits as well.
    fn disturb(&self, mut draws: Draws, inputs: &mut [f32]) {
        let (traits, standing) =
            (situated::traits(self.lesson.species), situated::standing(self.lesson.species));
        for x in &mut inputs[traits.start..standing.end] {
            *x += (TRAIT_NOISE * draws.normal()) as f32;
        }
    }

    fn is_disturbed(&self) -> bool {
        true
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::rotation(outputs, targets, self.slot)
    }

    fn measures(&self) -> &'static [&'static str] {
        &["nll", "aligned_predicted", "aligned_actual"]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        let target = SwingTarget::read(targets, self.slot);
        let weights = &outputs[..=ROTATION_COMPONENTS];
        let total: f64 = weights.iter().map(|&w| f64::from(w).exp()).sum();
        let p = f64::from(weights[ROTATION_COMPONENTS]).exp() / total;
        tally.rely(p, target.is_aligned);
        tally.count(&[target.nll(outputs), p, f64::from(u8::from(target.is_aligned))]);
    }
}
