//! Branches and chains: the two ways to cut a tree into unbranched runs.

use crate::graph::{BranchGraph, NodeId};

/// A run of nodes from its start to its end, each the parent of the next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// The nodes; never empty.
    pub nodes: Vec<NodeId>,
}

impl Path {
    /// Length of the run's edges, the edge into its first node included, in metres.
    #[must_use]
    pub fn length(&self, tree: &BranchGraph) -> f32 {
        let last = tree.node(self.nodes[self.nodes.len() - 1]);
        let first = tree.node(self.nodes[0]);
        last.root_distance - first.root_distance + first.length
    }
}

/// The Gravelius branches: each starts at the root or at a lateral and follows apical children.
#[must_use]
pub fn branches(tree: &BranchGraph) -> Vec<Path> {
    runs(
        tree,
        |id| {
            let node = tree.node(id);
            node.parent.is_none() || node.slot > 0
        },
        |id| tree.node(id).children[0],
    )
}

/// The chains: maximal runs without a fork; each ends at a node with 0 or at least 2 children.
#[must_use]
pub fn chains(tree: &BranchGraph) -> Vec<Path> {
    runs(
        tree,
        |id| {
            let node = tree.node(id);
            node.parent.is_none() || node.sibling_count > 1
        },
        |id| {
            let node = tree.node(id);
            if node.child_count() == 1 {
                node.children.iter().flatten().next().copied()
            } else {
                None
            }
        },
    )
}

fn runs(
    tree: &BranchGraph,
    starts: impl Fn(NodeId) -> bool,
    next: impl Fn(NodeId) -> Option<NodeId>,
) -> Vec<Path> {
    (0..tree.len() as NodeId)
        .filter(|&id| starts(id))
        .map(|id| Path { nodes: std::iter::successors(Some(id), |&id| next(id)).collect() })
        .collect()
}
