//! The laws of the model that hear of points: what they read and say of a node as it is told, and how
//! that is judged.

use burn::tensor::Tensor;
use deeptree_graph::signature::situated::{self, Branching, RotationContext, rotation_len};
use deeptree_graph::{BranchGraph, MAX_CHILDREN};
use deeptree_infer::{Mlp, ReadWeightsError, Scratch, SimdPath, Weights};

use super::told::Told;
use crate::loss::{self, EXISTENCE_TARGETS, ROTATION_TARGETS};
use crate::rotations::Rotations;
use crate::tasks::{SwingTarget, ln_class, tell_branching};

/// Laws that hear of points: existence, and the swing of each slot.
pub(super) const LAWS: usize = 1 + MAX_CHILDREN;

/// Their names among the tensors.
pub(super) const NAMES: [&str; LAWS] = ["existence", "rotation1", "rotation2", "rotation3"];

/// The laws as the model knows them, which are to be corrected.
pub(super) struct Laws {
    networks: [Mlp; LAWS],
    pub(super) rotations: Rotations,
    pub(super) species: usize,
    path: SimdPath,
}

impl Laws {
    /// The networks of the laws, and what their turns are told in.
    ///
    /// # Errors
    ///
    /// When the model lacks a network or table of kind `situated`.
    pub(super) fn new(weights: &Weights) -> Result<Self, ReadWeightsError> {
        let network = |i: usize| weights.mlp(NAMES[i]);
        Ok(Self {
            networks: [network(0)?, network(1)?, network(2)?, network(3)?],
            rotations: Rotations::of(weights)?,
            species: weights.species().len(),
            path: SimdPath::detect(),
        })
    }

    /// What a law's network says of rows that it reads.
    pub(super) fn say(&self, law: usize, rows: &[f32]) -> Vec<f32> {
        self.networks[law].forward(self.path, rows, &mut Scratch::new()).to_vec()
    }

    pub(super) fn outputs(&self, law: usize) -> usize {
        self.networks[law].outputs()
    }

    /// Values that a law's network reads.
    pub(super) fn inputs(&self, law: usize) -> usize {
        situated::len(self.species) + law.checked_sub(1).map_or(0, rotation_len)
    }

    /// Values that its loss compares with.
    pub(super) fn targets(&self, law: usize) -> usize {
        if law == 0 { EXISTENCE_TARGETS } else { ROTATION_TARGETS }
    }

    /// Writes what a law's network reads of a node as it is told, and what is true.
    pub(super) fn encode(
        &self,
        law: usize,
        tree: &BranchGraph,
        told: &Told,
        id: usize,
        inputs: &mut [f32],
        targets: &mut [f32],
    ) {
        let (node, plan, tips) = (&told.nodes[id], told.plans[id], told.tips[id]);
        let (own, rest) = inputs.split_at_mut(situated::len(self.species));
        situated::encode(node, &told.conditions, plan, &told.senses[id], self.species, own);
        let truth = told.branchings[id];
        let Some(slot) = law.checked_sub(1) else {
            // What was told of the plan is a guess.
            return tell_branching(truth, Branching::is_ever_possible, targets);
        };
        let siblings: [_; MAX_CHILDREN] = std::array::from_fn(|slot| told.sibling(tree, id, slot));
        let (Some(child), Some(child_id)) = (siblings[slot], tree.nodes()[id].children[slot])
        else {
            return;
        };
        let species = told.conditions.species;
        let (tips, plan) = plan.bent_to(truth, tips);
        let context = RotationContext {
            branching: truth,
            parent_tips: tips,
            tips: child.tips,
            parent_reach: plan.reach,
            plan: told.plans[child_id as usize],
            slot: self.rotations.slots[species][slot],
            roll: child.turn.roll,
            own: told.own_turn(id),
            earlier: &siblings[..slot],
        };
        situated::encode_rotation(node, &told.conditions, &context, rest);
        SwingTarget::of(&context.slot, child.turn, node).write(targets);
    }

    /// The mean loss of what a law says in a batch.
    pub(super) fn loss(law: usize, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        match law.checked_sub(1) {
            None => loss::existence(outputs, targets),
            Some(slot) => loss::rotation(outputs, targets, slot),
        }
    }

    /// −ln p of what happened.
    pub(super) fn judge(law: usize, outputs: &[f32], targets: &[f32]) -> f64 {
        match law.checked_sub(1) {
            None => -ln_class(outputs, targets),
            Some(slot) => SwingTarget::read(targets, slot).nll(outputs),
        }
    }
}
