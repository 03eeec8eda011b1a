//! Which runs of nodes are swept as one tube.

use deeptree_graph::{BranchGraph, Node, NodeId};

/// A lateral this much thicker than the apical child carries the tube on in its place.
const TAKES_OVER: f32 = 1.3;

const NONE: u32 = u32::MAX;

/// The limbs of a tree: runs of nodes swept as one tube each.
///
/// A limb follows the Gravelius branch, but where that ends below a fork, or goes on as a mere
/// twig, the thickest lateral carries it on: the tube then bends, where it would have to end in
/// the middle of the wood.
pub(crate) struct Limbs {
    /// The first node of each limb; a limb comes after the one that it leaves from.
    pub(crate) starts: Vec<NodeId>,
    /// The limb that starts at a node, or none.
    starting: Vec<u32>,
    /// The node after each on its limb, or none.
    next: Vec<u32>,
}

impl Limbs {
    /// The limbs of a tree, without laterals thinner than `min_radius` and what they carry.
    pub(crate) fn of(tree: &BranchGraph, min_radius: f32) -> Self {
        let mut limbs = Self {
            starts: vec![0],
            starting: vec![NONE; tree.len()],
            next: vec![NONE; tree.len()],
        };
        limbs.starting[0] = 0;
        let mut kept = vec![false; tree.len()];
        kept[0] = true;
        // Level order: a node comes after its parent.
        for (id, node) in tree.nodes().iter().enumerate() {
            if !kept[id] {
                continue;
            }
            let goes_on = goes_on(tree, node);
            for child in node.children.iter().flatten().copied() {
                if Some(child) == goes_on {
                    limbs.next[id] = child;
                } else if tree.node(child).thickness < min_radius {
                    continue;
                } else {
                    limbs.starting[child as usize] = limbs.starts.len() as u32;
                    limbs.starts.push(child);
                }
                kept[child as usize] = true;
            }
        }
        limbs
    }

    /// The nodes of a limb from `start` to its tip.
    pub(crate) fn nodes(&self, start: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        let next = |&id: &NodeId| Some(self.next[id as usize]).filter(|&id| id != NONE);
        core::iter::successors(Some(start), next)
    }

    /// The limbs that leave from a node.
    pub(crate) fn leaving<'a>(&'a self, node: &'a Node) -> impl Iterator<Item = u32> + 'a {
        let children = node.children.iter().flatten();
        children.map(|&child| self.starting[child as usize]).filter(|&limb| limb != NONE)
    }
}

/// The child that carries on the tube of its parent.
pub(crate) fn goes_on(tree: &BranchGraph, node: &Node) -> Option<NodeId> {
    let thickness = |id: NodeId| tree.node(id).thickness;
    let [apical, laterals @ ..] = node.children;
    // The first of two that are equally thick.
    let lateral = laterals
        .into_iter()
        .flatten()
        .reduce(|best, other| if thickness(other) > thickness(best) { other } else { best });
    match (apical, lateral) {
        (Some(apical), Some(lateral)) if thickness(lateral) > TAKES_OVER * thickness(apical) => {
            Some(lateral)
        }
        (apical, lateral) => apical.or(lateral),
    }
}
