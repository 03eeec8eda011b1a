//! What of a branchlet is settled before it is drawn: that of a pruned node which has kept a child.

use deeptree_graph::signature::situated::Branching;
use deeptree_graph::signature::tip_count;
use deeptree_graph::{ChildSignature, MAX_CHILDREN, Plan};

use super::Branchlet;

/// A child that a node bore before it was pruned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Former {
    /// Its radius in metres, which says how many tips it bore.
    pub thickness: f32,
    /// What grew below it.
    pub plan: Plan,
    /// The child where it still stands; none where it was cut off, and how it lies is to be drawn.
    pub standing: Option<ChildSignature>,
}

/// The children that a pruned node bore, by slot.
///
/// Those that stand stay as they are. Those that were cut off come again, each in its slot and with
/// its tips and plan; only their rotations and lengths are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settled {
    /// The children.
    pub children: [Option<Former>; MAX_CHILDREN],
}

impl Settled {
    /// The children that still stand, by slot.
    #[must_use]
    pub fn standing(&self) -> [Option<ChildSignature>; MAX_CHILDREN] {
        self.children.map(|child| child?.standing)
    }

    /// Do all children still stand, so that nothing is to be drawn?
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.children.iter().flatten().all(|child| child.standing.is_some())
    }

    /// How a node of `tips` tips branches. What its children do not bear counts as dropped, as far
    /// as there are slots for it: more is missing where a branch has ended at the ground.
    pub(super) fn branching(&self, tips: u32, tip_radius: f32) -> Branching {
        let has = |slot: usize| u8::from(self.children[slot].is_some());
        let subset = (0..MAX_CHILDREN).fold(0, |subset, slot| subset | has(slot) << slot);
        let borne: u32 = self.child_tips(tip_radius).iter().sum();
        let free = MAX_CHILDREN as u32 - u8::count_ones(subset);
        Branching { subset, dropped: tips.saturating_sub(borne).min(free) as u8 }
    }

    /// Tips that each child bears; 0 where there is none.
    pub(super) fn child_tips(&self, tip_radius: f32) -> [u32; MAX_CHILDREN] {
        self.children.map(|child| child.map_or(0, |child| tip_count(child.thickness, tip_radius)))
    }

    /// What is to grow below each child; nothing where there is none.
    pub(super) fn child_plans(&self) -> [Plan; MAX_CHILDREN] {
        self.children.map(|child| child.map_or_else(Plan::default, |child| child.plan))
    }

    /// Puts the children that stand into the branchlet, and says in which slots others are to be
    /// drawn.
    pub(super) fn put_standing(&self, branchlet: &mut Branchlet) -> [bool; MAX_CHILDREN] {
        branchlet.children = self.standing();
        self.children.map(|child| child.is_some_and(|child| child.standing.is_none()))
    }
}
