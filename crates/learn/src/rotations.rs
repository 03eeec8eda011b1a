//! How the rotations of a corpus lie, by species and slot.

use deeptree_graph::signature::TreeConditions;
use deeptree_graph::signature::situated::{ALIGNED, Slot, Turn, sag, wrapped};
use deeptree_graph::{MAX_CHILDREN, Node, Quat, Vec2};
use deeptree_infer::{ReadWeightsError, Weights};

use crate::set::Corpus;

/// Least deviation of a swing and least usual sag, in radians: some directions are the same in all trees of a species,
/// and a law must have a width.
const LEAST_DEVIATION: f64 = 1e-4;

/// Least share of exactly aligned swings in a slot where that is a law: shoots with an angle of their own
/// are within [`ALIGNED`] of none, too, but seldom.
const LEAST_ALIGNED: f64 = 1e-3;

/// Centre and deviations of the rotations in each slot.
#[derive(Clone, Debug)]
pub(crate) struct Rotations {
    /// By species; a slot without children is [`Slot::PLAIN`].
    pub(crate) slots: Vec<[Slot; MAX_CHILDREN]>,
}

impl Rotations {
    pub(crate) fn new(corpus: &Corpus<'_>, species: usize) -> Self {
        let mut sums = vec![[Sums::default(); MAX_CHILDREN]; species];
        corpus.each_child(|conditions, _, child| {
            let slot = usize::from(child.slot);
            sums[conditions.species][slot].add(slot, child.rotation);
        });
        let centre =
            |sums: [Sums; MAX_CHILDREN]| std::array::from_fn(|slot| sums[slot].centre(slot));
        let mut rotations = Self { slots: sums.into_iter().map(centre).collect() };
        let mut squares = vec![[Squares::default(); MAX_CHILDREN]; species];
        corpus.each_child(|conditions, parent, child| {
            let turn = rotations.turn(conditions, parent, child);
            squares[conditions.species][usize::from(child.slot)].add(child.slot, turn);
        });
        for (slots, squares) in rotations.slots.iter_mut().zip(squares) {
            for (slot, squares) in slots.iter_mut().zip(squares) {
                squares.scale(slot);
            }
        }
        rotations
    }

    /// Those that a model was trained with.
    pub(crate) fn of(weights: &Weights) -> Result<Self, ReadWeightsError> {
        Ok(Self { slots: weights.slots()? })
    }

    /// The turn of a child, in deviations of its slot.
    pub(crate) fn turn(&self, tree: &TreeConditions, parent: &Node, child: &Node) -> Turn {
        let slot = &self.slots[tree.species][usize::from(child.slot)];
        slot.turn(child.rotation, parent, tree.gravitropism)
    }
}

/// Sums over the turns of a slot, of all and of the aligned ones.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    all: Roll,
    aligned: Roll,
    swing: [f64; 2],
}

/// Sum of directions.
#[derive(Clone, Copy, Debug, Default)]
struct Roll {
    count: f64,
    cos: f64,
    sin: f64,
}

impl Roll {
    fn add(&mut self, angle: f32) {
        self.count += 1.0;
        self.cos += libm::cos(f64::from(angle));
        self.sin += libm::sin(f64::from(angle));
    }

    /// In [−3π/2, π/2), far from whose ends 0 and −π lie, where laterals are: rolls go round as in the
    /// growth model, so that quaternions have its signs, which networks read.
    fn mean(&self) -> f32 {
        use core::f32::consts::FRAC_PI_2;
        wrapped(libm::atan2(self.sin, self.cos) as f32 + FRAC_PI_2) - FRAC_PI_2
    }
}

impl Sums {
    fn add(&mut self, slot: usize, rotation: Quat) {
        let (roll, swing) = Slot::PLAIN.split(rotation);
        self.all.add(roll);
        let is_aligned = match slot {
            0 => swing.length() < ALIGNED,
            _ => swing.y.abs() < ALIGNED,
        };
        if is_aligned {
            self.aligned.add(roll);
        }
        self.swing[0] += f64::from(swing.x);
        self.swing[1] += f64::from(swing.y);
    }

    /// The centre of the slot. What is exactly aligned stays so: a slot where shoots go straight on
    /// has no mean swing, and laterals that nothing bends give the plane of the bud.
    fn centre(&self, slot: usize) -> Slot {
        if self.all.count == 0.0 {
            return Slot::PLAIN;
        }
        let [x, y] = self.swing.map(|sum| (sum / self.all.count) as f32);
        let is_exact = self.aligned.count >= LEAST_ALIGNED * self.all.count;
        let (mean, roll) = match (slot, is_exact) {
            (0, true) => (Vec2::ZERO, self.all.mean()),
            (0, false) => (Vec2::new(x, y), self.all.mean()),
            (_, true) => (Vec2::new(x, 0.0), self.aligned.mean()),
            (_, false) => (Vec2::new(x, y), self.all.mean()),
        };
        let roll_scale = if slot == 0 { 1.0 } else { 0.0 };
        Slot { mean, roll, scale: Vec2::ONE, roll_scale }
    }
}

/// Sums of squares of turns about their centre.
#[derive(Clone, Copy, Debug, Default)]
struct Squares {
    count: f64,
    sum: [f64; 3],
}

impl Squares {
    fn add(&mut self, slot: u8, turn: Turn) {
        self.count += 1.0;
        let y = if slot > 0 { sag::heard(turn.swing.y, 1.0) } else { turn.swing.y };
        for (sum, x) in self.sum.iter_mut().zip([turn.swing.x, y, turn.roll]) {
            *sum += f64::from(x) * f64::from(x);
        }
    }

    /// Sets the deviations of a slot that has children.
    fn scale(&self, slot: &mut Slot) {
        if self.count > 0.0 {
            let [x, y, roll] =
                self.sum.map(|sum| (sum / self.count).sqrt().max(LEAST_DEVIATION) as f32);
            slot.scale = Vec2::new(x, y);
            slot.roll_scale *= roll;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    /// Shoots that swing about y by an angle of their own, and of 10 000 so many straight ones.
    fn centre(straight: usize) -> Slot {
        let mut draws = Seed(1).draws(Lineage::ROOT, Purpose::ApicalAngles);
        let mut sums = Sums::default();
        for i in 0..10_000 {
            let angle = if i < straight { 0.0 } else { 0.07 * draws.normal() };
            sums.add(0, Quat::from_rotation_y(angle as f32));
        }
        sums.centre(0)
    }

    #[test]
    fn a_shoot_straight_by_chance_makes_no_law() {
        let mean = centre(1).mean;
        // The mean of 10 000 angles about none, of a deviation of 0.07.
        assert!(mean != Vec2::ZERO && mean.length() < 4.0 * 0.07 / 100.0, "{mean}");
        assert_eq!(centre(200).mean, Vec2::ZERO);
    }
}
