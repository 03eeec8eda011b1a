//! `rotation1` … `rotation3`: how the child in a slot is turned against its parent.

use burn::tensor::Tensor;
use deeptree_graph::MAX_CHILDREN;
use deeptree_graph::signature::situated::{
    self, LOG_SCALE, ROTATION_COMPONENTS, ROTATION_OUTPUTS, Sibling, rotation_len,
};

use super::{Lesson, Task};
use crate::loss::{self, ROTATION_TARGETS};
use crate::report::Tally;
use crate::set::Spot;
use crate::tables::Rotations;

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
        let species = self.species(sample);
        let shares = self.lesson.corpus.shares(spot);
        let sibling = |slot: usize| {
            let child = self.lesson.corpus.child(spot, slot)?;
            let turn = self.rotations.turn(species, child);
            Some(Sibling { tips: shares.children[slot], turn })
        };
        let siblings: [_; MAX_CHILDREN] =
            std::array::from_fn(|slot| if slot <= self.slot { sibling(slot) } else { None });
        let Some(Sibling { tips, turn }) = siblings[self.slot] else { return };
        let rest = self.lesson.encode(spot, inputs);
        let earlier = &siblings[..self.slot];
        situated::encode_rotation(shares.branching(), shares.tips, tips, earlier, rest);
        inputs[situated::traits(self.lesson.species)].fill(0.0);
        for component in targets.chunks_exact_mut(3) {
            component.copy_from_slice(&turn.to_array());
        }
    }

    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        loss::rotation(outputs, targets)
    }

    fn measures(&self) -> &'static [&'static str] {
        &["nll", "residual"]
    }

    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally) {
        let turn: [f64; 3] = std::array::from_fn(|j| f64::from(targets[j]));
        let (nll, residual) = judge(outputs, turn);
        tally.count(&[nll, residual]);
    }
}

/// Negative log-likelihood of a turn, and its mean distance from the mixture's mean by component.
pub(crate) fn judge(outputs: &[f32], turn: [f64; 3]) -> (f64, f64) {
    const K: usize = ROTATION_COMPONENTS;
    let out = |i: usize| f64::from(outputs[i]);
    let weights: [f64; K] = std::array::from_fn(|i| out(i).exp());
    let total: f64 = weights.iter().sum();
    let (mut density, mut mean) = (0.0, [0.0; 3]);
    for (i, weight) in weights.iter().map(|w| w / total).enumerate() {
        let mut log = weight.ln();
        for j in 0..3 {
            let log_deviation =
                outputs[4 * K + 3 * i + j].clamp(*LOG_SCALE.start(), *LOG_SCALE.end());
            let residual = (turn[j] - out(K + 3 * i + j)) / f64::from(log_deviation).exp();
            log -= 0.5 * residual * residual
                + f64::from(log_deviation)
                + 0.5 * core::f64::consts::TAU.ln();
            mean[j] += weight * out(K + 3 * i + j);
        }
        density += log.exp();
    }
    let residual = (0..3).map(|j| (turn[j] - mean[j]).abs()).sum::<f64>() / 3.0;
    (-density.max(f64::MIN_POSITIVE).ln(), residual)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_components_are_one_gaussian() {
        // Mean (1, −2, 0.5), deviation 2 in each of three components, whatever the weights.
        const K: usize = ROTATION_COMPONENTS;
        let mut outputs = vec![0.7, -0.2, 0.0, 3.0];
        outputs.extend([1.0, -2.0, 0.5].repeat(K));
        outputs.extend([2f32.ln(); 3 * K]);
        let (nll, residual) = judge(&outputs, [3.0, -2.0, -1.5]);
        let squares = (1.0 + 0.0 + 1.0) / 2.0;
        let closed = squares + 3.0 * 2f64.ln() + 1.5 * core::f64::consts::TAU.ln();
        assert!((nll - closed).abs() < 1e-6, "{nll} {closed}");
        assert!((residual - 4.0 / 3.0).abs() < 1e-6);
    }
}
