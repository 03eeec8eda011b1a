//! The laws that no network tells: rolls, lengths, and the angles of buds.

use deeptree_graph::signature::situated::{LENGTH_ORDERS, Slot};
use deeptree_graph::{MAX_CHILDREN, Purpose};

use super::Situated;
use crate::predictor::{Active, sampling};

impl Situated {
    /// The roll of the child in `slot`, in deviations of the slot. A lateral has none: its bud has
    /// its place on the shoot.
    pub(super) fn draw_roll(&self, slot: usize, active: &Active<'_>) -> f32 {
        let Slot { roll_scale, .. } = self.slots[active.tree.species][slot];
        if slot > 0 || roll_scale == 0.0 {
            return 0.0;
        }
        let mut draws = active.seed.draws(active.lineage.child(slot as u8), Purpose::ChildRotation);
        sampling::normal_score(self.rolls.row(active.tree.species), &mut draws) / roll_scale
    }

    /// The law of lengths of a species and order.
    pub(super) fn lengths_of(&self, species: usize, order: usize) -> &[f32] {
        let lengths = self.lengths.row(species);
        let values = lengths.len() / LENGTH_ORDERS;
        &lengths[order * values..][..values]
    }

    /// The law of the angle of the child in `slot`, in radians off its slot's, where it depends on
    /// nothing else. Where points are heard, they say it.
    pub(super) fn bud_law(&self, slot: usize, active: &Active<'_>) -> Option<&[f32]> {
        let Active { node, tree, points, .. } = active;
        let buds = self.buds.as_ref()?;
        let hears = points.is_some() && self.hears_points();
        let is_told = slot > 0 && !hears && self.slots[tree.species][slot].shows_bud(node);
        is_told.then(|| {
            let laws = buds.row(tree.species);
            let values = laws.len() / (MAX_CHILDREN - 1);
            &laws[(slot - 1) * values..][..values]
        })
    }
}
