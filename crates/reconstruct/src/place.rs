//! The same tree elsewhere.

use deeptree_graph::{BranchGraph, ChildSignature, NodeId, Quat, Vec3};

/// The tree turned about its foot, then moved: same nodes, same numbers, other places.
#[must_use]
pub fn placed(tree: &BranchGraph, turn: Quat, by: Vec3) -> BranchGraph {
    let root = tree.root();
    let foot = turn * root.base() + by;
    let rotation = (turn * root.rotation).normalize();
    let signature = ChildSignature { rotation, ..root.as_child() };
    let mut placed = BranchGraph::new(tree.info.clone(), foot, signature);
    for (id, node) in (0..).zip(tree.nodes()) {
        let child = |id: NodeId| tree.node(id).as_child();
        placed.grow(id, node.children.map(|id| id.map(child)));
    }
    placed
}
