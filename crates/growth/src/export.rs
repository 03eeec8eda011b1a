//! From internodes to the branch graph.

use deeptree_graph::{BranchGraph, ChildSignature, TreeInfo, Vec3};

use crate::internode::Internode;

/// The branch graph of a grown tree: a node for each internode that bears others; the unfinished
/// tips are dropped. None when not even the first internode has any length.
///
/// A tree that is nothing but its first internode keeps it. The second value is the internode of
/// each node.
pub(crate) fn to_graph(
    internodes: &[Internode],
    info: TreeInfo,
) -> Option<(BranchGraph, Vec<u32>)> {
    let root = &internodes[0];
    if root.length == 0.0 {
        return None;
    }
    let signature = |internode: &Internode, parent: Option<&Internode>| ChildSignature {
        rotation: match parent {
            Some(parent) => (parent.frame.inverse() * internode.frame).normalize(),
            None => internode.frame,
        },
        thickness: internode.thickness,
        length: internode.length,
    };
    let mut tree = BranchGraph::new(info, Vec3::ZERO, signature(root, None));
    let mut internode_of: Vec<u32> = vec![0];
    let mut next = 0;
    while next < internode_of.len() {
        let parent = &internodes[internode_of[next] as usize];
        let exported =
            parent.children.map(|child| child.filter(|&c| !internodes[c as usize].is_end()));
        let branchlet =
            exported.map(|child| child.map(|c| signature(&internodes[c as usize], Some(parent))));
        tree.grow(next as u32, branchlet);
        internode_of.extend(exported.into_iter().flatten());
        next += 1;
    }
    Some((tree, internode_of))
}
