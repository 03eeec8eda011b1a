//! The state of a growing tree: internodes and their buds.

use deeptree_graph::{Lineage, Quat, Vec3};

/// Slots of an internode: 0 for its apical bud, 1 and 2 for its lateral buds.
pub(crate) const SLOTS: usize = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bud {
    Dormant,
    Flushed,
    Dead,
}

/// One internode. Angles in radians, lengths in metres.
#[derive(Clone, Debug)]
pub(crate) struct Internode {
    pub(crate) parent: Option<u32>,
    pub(crate) children: [Option<u32>; SLOTS],
    pub(crate) lineage: Lineage,
    /// Gravelius order o.
    pub(crate) order: u16,
    /// Cycles since creation.
    pub(crate) age: u32,
    pub(crate) buds: [Bud; SLOTS],
    /// β of each lateral bud, drawn when the internode completes.
    pub(crate) branching_angles: [f32; SLOTS - 1],
    /// L.
    pub(crate) length: f32,
    /// Frame against the parent's, fixed at birth: front −z, up +y.
    pub(crate) desired: Quat,
    /// Frame in the world, with all bends.
    pub(crate) frame: Quat,
    pub(crate) base: Vec3,
    /// θ.
    pub(crate) thickness: f32,
    /// v: 0 along the largest subtrees, one more at each smaller one.
    pub(crate) level: u32,
    /// ρ: path length from the root to the base.
    pub(crate) root_path: f32,
    /// σ.
    pub(crate) sag: f32,
    /// A.
    pub(crate) auxin: f32,
    /// δ^L: the part of the auxin that passes this internode; known when it is complete.
    pub(crate) auxin_passed: f32,
    /// T: length of all internodes above.
    pub(crate) length_above: f32,
    /// M: Σ L·θ over all internodes above.
    pub(crate) biomass: f32,
    /// Is this the child with the largest subtree of its parent?
    pub(crate) is_largest: bool,
}

impl Internode {
    pub(crate) fn is_end(&self) -> bool {
        self.children == [None; SLOTS]
    }

    pub(crate) fn front(&self) -> Vec3 {
        self.frame * Vec3::NEG_Z
    }

    pub(crate) fn tip(&self) -> Vec3 {
        self.base + self.length * self.front()
    }

    /// A new internode of length 0 at the tip of its parent, with the given frame in the world.
    pub(crate) fn child(parent: &Self, index: u32, slot: u8, frame: Quat, radius: f32) -> Self {
        Self {
            parent: Some(index),
            lineage: parent.lineage.child(slot),
            order: parent.order + u16::from(slot > 0),
            desired: (parent.frame.inverse() * frame).normalize(),
            frame,
            base: parent.tip(),
            level: parent.level,
            ..Self::root(frame, radius)
        }
    }

    /// The first internode, at the foot of the tree.
    pub(crate) fn root(frame: Quat, radius: f32) -> Self {
        Self {
            parent: None,
            children: [None; SLOTS],
            lineage: Lineage::ROOT,
            order: 0,
            age: 0,
            buds: [Bud::Dormant; SLOTS],
            branching_angles: [0.0; SLOTS - 1],
            length: 0.0,
            desired: frame,
            frame,
            base: Vec3::ZERO,
            thickness: radius,
            level: 0,
            root_path: 0.0,
            sag: 0.0,
            auxin: 0.0,
            auxin_passed: 1.0,
            length_above: 0.0,
            biomass: 0.0,
            is_largest: true,
        }
    }
}
