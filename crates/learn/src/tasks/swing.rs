//! How the swing of a child is told to [`crate::loss::rotation`], and judged.

use deeptree_graph::signature::situated::{Alignment, LOG_SCALE, ROTATION_COMPONENTS, Slot, Turn};
use deeptree_graph::{Node, Vec2};

/// The swing of a child in deviations of its slot, how it could be aligned, and whether it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SwingTarget {
    pub(crate) swing: Vec2,
    pub(crate) alignment: Alignment,
    pub(crate) is_aligned: bool,
}

impl SwingTarget {
    /// That of a child in a slot which is turned so against its parent.
    pub(crate) fn of(slot: &Slot, turn: Turn, parent: &Node) -> Self {
        let alignment = slot.alignment(turn.roll, parent);
        Self { swing: turn.swing, alignment, is_aligned: slot.is_aligned(alignment, turn) }
    }

    /// Writes it as the loss reads it: x and y once for each component, then whether it is aligned,
    /// and whether that would be straight on.
    ///
    /// # Shapes  targets: `[ROTATION_TARGETS]`
    pub(crate) fn write(self, targets: &mut [f32]) {
        let (x, rest) = targets.split_at_mut(ROTATION_COMPONENTS);
        let (y, flags) = rest.split_at_mut(ROTATION_COMPONENTS);
        x.fill(self.swing.x);
        y.fill(self.swing.y);
        flags[0] = f32::from(u8::from(self.is_aligned));
        flags[1] = f32::from(u8::from(self.alignment == Alignment::Straight));
    }

    /// The inverse of [`Self::write`], of a child in slot number `slot`.
    pub(crate) fn read(targets: &[f32], slot: usize) -> Self {
        let [is_aligned, is_straight] =
            [0, 1].map(|flag| targets[2 * ROTATION_COMPONENTS + flag] > 0.5);
        let alignment = match is_straight {
            _ if slot > 0 => Alignment::Bud,
            true => Alignment::Straight,
            false => Alignment::Gravity,
        };
        Self { swing: Vec2::new(targets[0], targets[ROTATION_COMPONENTS]), alignment, is_aligned }
    }

    /// Negative log-likelihood under what a network says.
    pub(crate) fn nll(self, outputs: &[f32]) -> f64 {
        const K: usize = ROTATION_COMPONENTS;
        let [x, y] = self.swing.to_array().map(f64::from);
        let out = |i: usize| f64::from(outputs[i]);
        let log_scale =
            |i: usize| f64::from(outputs[i].clamp(*LOG_SCALE.start(), *LOG_SCALE.end()));
        let normal = |e: f64| -0.5 * e * e - 0.5 * core::f64::consts::TAU.ln();
        let total: f64 = (0..=K).map(|i| out(i).exp()).sum();
        if self.is_aligned {
            let weight = out(K) - total.ln();
            let of_x = |mean: usize, log: usize| {
                let log = log_scale(log);
                normal((x - out(mean)) / log.exp()) - log
            };
            let density = match self.alignment {
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loss::ROTATION_TARGETS;
    use deeptree_graph::signature::situated::ROTATION_OUTPUTS;

    fn nll(outputs: &[f32], alignment: Alignment, x: f32, y: f32, is_aligned: bool) -> f64 {
        SwingTarget { swing: Vec2::new(x, y), alignment, is_aligned }.nll(outputs)
    }

    #[test]
    fn targets_are_read_as_they_were_written() {
        use Alignment::{Bud, Gravity, Straight};
        for (slot, alignment) in [(0, Straight), (0, Gravity), (1, Bud), (2, Bud)] {
            for is_aligned in [false, true] {
                let target = SwingTarget { swing: Vec2::new(0.5, -2.0), alignment, is_aligned };
                let mut targets = [0.0; ROTATION_TARGETS];
                target.write(&mut targets);
                assert_eq!(SwingTarget::read(&targets, slot), target);
            }
        }
    }

    #[test]
    fn equal_components_are_one_gaussian() {
        // Mean (1, −2), deviation 2 in x, and 2 · √(1 + 0.5²) in y of which 1 comes with x.
        const K: usize = ROTATION_COMPONENTS;
        let mut outputs = vec![0.7, -0.2, 0.0, 3.0, -60.0, 0.0, 0.0];
        for value in [1.0, -2.0, 2f32.ln(), 2f32.ln(), 0.5] {
            outputs.extend([value; K]);
        }
        // One deviation off in x, and in y one and a half of its own after what comes with x.
        let found = nll(&outputs, Alignment::Bud, 3.0, -2.0 + 2.0 * (0.5 + 1.5), false);
        let closed = 0.5 + 1.125 + 2.0 * 2f64.ln() + core::f64::consts::TAU.ln();
        assert!((found - closed).abs() < 1e-6, "{found} {closed}");
    }

    #[test]
    fn what_goes_straight_on_has_a_probability_of_its_own() {
        let mut outputs = vec![0.0; ROTATION_OUTPUTS];
        outputs[ROTATION_COMPONENTS] = 4f32.ln();
        // Odds of 4 against four components of 1.
        let straight = nll(&outputs, Alignment::Straight, 0.0, 0.0, true);
        assert!((straight - 2f64.ln()).abs() < 1e-6);
        // About the level axis, and there one deviation off all components.
        let level = nll(&outputs, Alignment::Gravity, 1.0, 0.0, true);
        assert!((level - straight - 0.5 - 0.5 * core::f64::consts::TAU.ln()).abs() < 1e-6);
    }
}
