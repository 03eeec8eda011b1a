//! What the vertices of an internode inherit from it: labels, and how it moves in the wind.

use deeptree_graph::{BranchGraph, Lineage, Purpose, Seed, Vec3};

use crate::tubes::MIN_RADIUS;

/// What the vertices of an internode inherit from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Internode {
    /// Its Gravelius branch, as an index into [`deeptree_graph::branches`].
    pub branch: u32,
    /// Gravelius order; the trunk has 0.
    pub order: u16,
    /// Where its branch starts: the point it swings about in the wind, in metres.
    pub pivot: Vec3,
    /// When its branch swings, as a share of a period in [0, 1): one draw a branch.
    pub phase: f32,
    /// Its radius as a share of the root's, in (0, 1]: stiff wood is thick. The stiffness of a
    /// beam grows with the fourth power of its radius.
    pub stiffness: f32,
}

impl Internode {
    /// The internodes of a tree, one for each node.
    pub(crate) fn all(tree: &BranchGraph) -> Vec<Self> {
        let seed = Seed(tree.info.seed);
        let foot = tree.root().thickness.max(MIN_RADIUS);
        let mut branches = 0;
        let mut lineages: Vec<Lineage> = Vec::with_capacity(tree.len());
        let mut all: Vec<Self> = Vec::with_capacity(tree.len());
        for node in tree.nodes() {
            let lineage = node
                .parent
                .map_or(Lineage::ROOT, |parent| lineages[parent as usize].child(node.slot));
            lineages.push(lineage);
            let stiffness = (node.thickness.max(MIN_RADIUS) / foot).min(1.0);
            let order = node.order;
            all.push(match node.parent {
                Some(parent) if node.slot == 0 => Self { stiffness, ..all[parent as usize] },
                parent => {
                    branches += 1;
                    let pivot = parent.map_or(node.base(), |parent| tree.node(parent).position);
                    let phase = seed.draws(lineage, Purpose::WindPhase).uniform() as f32;
                    // Rounding to f32 may reach 1, which is no share of a period.
                    let phase = if phase < 1.0 { phase } else { 0.0 };
                    Self { branch: branches - 1, order, pivot, phase, stiffness }
                }
            });
        }
        all
    }
}
