//! `rotation1` … `rotation3`: how the child in a slot is turned against its parent.

use burn::tensor::Tensor;
use deeptree_graph::signature::situated::{
    self, Alignment, LOG_SCALE, ROTATION_COMPONENTS, ROTATION_OUTPUTS, RotationContext, Sibling,
    Turn, rotation_len,
};
use deeptree_graph::{Draws, MAX_CHILDREN, Plan};

use super::{Lesson, Task};
use crate::loss::{self, ROTATION_TARGETS};
use crate::report::Tally;
use crate::rotations::Rotations;
use crate::set::Spot;

/// Standard deviation of the noise on the traits; between trees they spread by about 1.
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
        let alignment = context.slot.alignment(turn.roll, node);
        let (x, rest) = targets.split_at_mut(ROTATION_COMPONENTS);
        let (y, rest) = rest.split_at_mut(ROTATION_COMPONENTS);
        x.fill(turn.swing.x);
        y.fill(turn.swing.y);
        rest[0] = f32::from(u8::from(context.slot.is_aligned(alignment, turn)));
        rest[1] = f32::from(u8::from(alignment == Alignment::Straight));
    }

    /// Noise on the traits: eight exact numbers name a training tree, and a network would learn its
    /// twigs by heart.
    fn disturb(&self, mut draws: Draws, inputs: &mut [f32]) {
        for x in &mut inputs[situated::traits(self.lesson.species)] {
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
        let (x, y) = (f64::from(targets[0]), f64::from(targets[ROTATION_COMPONENTS]));
        let is_aligned = targets[2 * ROTATION_COMPONENTS] > 0.5;
        let alignment = match targets[2 * ROTATION_COMPONENTS + 1] > 0.5 {
            _ if self.slot > 0 => Alignment::Bud,
            true => Alignment::Straight,
            false => Alignment::Gravity,
        };
        let weights = &outputs[..=ROTATION_COMPONENTS];
        let total: f64 = weights.iter().map(|&w| f64::from(w).exp()).sum();
        let p = f64::from(weights[ROTATION_COMPONENTS]).exp() / total;
        tally.rely(p, is_aligned);
        tally.count(&[
            judge(outputs, alignment, x, y, is_aligned),
            p,
            f64::from(u8::from(is_aligned)),
        ]);
    }
}

/// Negative log-likelihood of a swing that can be aligned so.
pub(crate) fn judge(
    outputs: &[f32],
    alignment: Alignment,
    x: f64,
    y: f64,
    is_aligned: bool,
) -> f64 {
    const K: usize = ROTATION_COMPONENTS;
    let out = |i: usize| f64::from(outputs[i]);
    let log_scale = |i: usize| f64::from(outputs[i].clamp(*LOG_SCALE.start(), *LOG_SCALE.end()));
    let normal = |e: f64| -0.5 * e * e - 0.5 * core::f64::consts::TAU.ln();
    let total: f64 = (0..=K).map(|i| out(i).exp()).sum();
    if is_aligned {
        let weight = out(K) - total.ln();
        let of_x = |mean: usize, log: usize| {
            let log = log_scale(log);
            normal((x - out(mean)) / log.exp()) - log
        };
        let density = match alignment {
            Alignment::Straight => 0.0,
            Alignment::Gravity => {
                let row = |r: usize, i: usize| K + 3 + r * K + i;
                let component = |i: usize| (out(i) + of_x(row(0, i), row(2, i))).exp();
                let (density, free): (f64, f64) =
                    ((0..K).map(component).sum(), (0..K).map(|i| out(i).exp()).sum());
                (density / free).max(f64::MIN_POSITIVE).ln()
            }
            Alignment::Bud => of_x(K + 1, K + 2),
        };
        return -weight - density;
    }
    let density: f64 = (0..K)
        .map(|i| {
            let row = |r: usize| K + 3 + r * K + i;
            let (log_x, log_y) = (log_scale(row(2)), log_scale(row(3)));
            let first = (x - out(row(0))) / log_x.exp();
            let second = (y - out(row(1))) / log_y.exp() - out(row(4)) * first;
            (out(i) + normal(first) + normal(second) - log_x - log_y).exp()
        })
        .sum();
    -(density / total).max(f64::MIN_POSITIVE).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_components_are_one_gaussian() {
        // Mean (1, −2), deviation 2 in x, and 2 · √(1 + 0.5²) in y of which 1 comes with x.
        const K: usize = ROTATION_COMPONENTS;
        let mut outputs = vec![0.7, -0.2, 0.0, 3.0, -60.0, 0.0, 0.0];
        for value in [1.0, -2.0, 2f32.ln(), 2f32.ln(), 0.5] {
            outputs.extend([value; K]);
        }
        // One deviation off in x, and in y one and a half of its own after what comes with x.
        let nll = judge(&outputs, Alignment::Bud, 3.0, -2.0 + 2.0 * (0.5 + 1.5), false);
        let closed = 0.5 + 1.125 + 2.0 * 2f64.ln() + core::f64::consts::TAU.ln();
        assert!((nll - closed).abs() < 1e-6, "{nll} {closed}");
    }

    #[test]
    fn what_goes_straight_on_has_a_probability_of_its_own() {
        let mut outputs = vec![0.0; ROTATION_OUTPUTS];
        outputs[ROTATION_COMPONENTS] = 4f32.ln();
        // Odds of 4 against four components of 1.
        let nll = judge(&outputs, Alignment::Straight, 0.0, 0.0, true);
        assert!((nll - 2f64.ln()).abs() < 1e-6);
        // About the level axis, and there one deviation off all components.
        let level = judge(&outputs, Alignment::Gravity, 1.0, 0.0, true);
        assert!((level - nll - 0.5 - 0.5 * core::f64::consts::TAU.ln()).abs() < 1e-6);
    }
}
