//! From a skeleton to a branch graph: at most three children a node, the apical one first.

use deeptree_graph::{
    BranchGraph, ChildSignature, MAX_CHILDREN, Node, NodeId, Quat, TreeInfo, Vec3,
};

use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// Part of an edge at which a node stands that takes the children for which there is no slot left.
const SPLIT: f32 = 0.15;

/// What is to stand at a node, and the children it shall have.
struct Open {
    node: NodeId,
    /// The child that carries the most, or [`NONE`].
    heir: u32,
    others: Vec<u32>,
}

/// The branch graph of a skeleton, its foot where the skeleton's root is.
///
/// The apical child of each joint is its heir; where there are more than two others, the edge to the apical
/// child is split near its start by nodes that take them.
pub(crate) fn assemble(skeleton: &Skeleton, heirs: &[u32], info: TreeInfo) -> BranchGraph {
    let children = skeleton.children();
    let open = |node: NodeId, joint: u32| {
        let heir = heirs[joint as usize];
        let others = children[joint as usize].iter().copied().filter(|&c| c != heir).collect();
        Open { node, heir, others }
    };
    let root = &skeleton.joints[0];
    // The root's edge has no length: a tree starts at its foot, not below it.
    let upright = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let foot = ChildSignature { rotation: upright, thickness: root.radius, length: 0.0 };
    let mut tree = BranchGraph::new(info, root.position, foot);
    // Level by level, so that the graph is in level order.
    let mut level = vec![open(0, 0)];
    while !level.is_empty() {
        let mut next = Vec::new();
        for Open { node, heir, mut others } in level {
            if heir == NONE {
                continue;
            }
            let rest = others.split_off(others.len().min(MAX_CHILDREN - 1));
            let parent = tree.node(node).clone();
            let apical = skeleton.joints[heir as usize];
            let split = parent.position.lerp(apical.position, SPLIT);
            let towards = if rest.is_empty() { apical.position } else { split };
            // As thick as the thickest that it carries.
            let radius = |&i: &u32| skeleton.joints[i as usize].radius;
            let thickness = rest.iter().map(radius).fold(apical.radius, f32::max);
            let mut signatures = [None; MAX_CHILDREN];
            signatures[0] = Some(signature(&parent, towards, thickness));
            for (slot, &other) in (1..).zip(&others) {
                let Joint { position, radius, .. } = skeleton.joints[other as usize];
                signatures[slot] = Some(signature(&parent, position, radius));
            }
            let ids = tree.grow(node, signatures).map(Option::unwrap_or_default);
            if rest.is_empty() {
                next.push(open(ids[0], heir));
            } else {
                next.push(Open { node: ids[0], heir, others: rest });
            }
            for (slot, &other) in (1..).zip(&others) {
                next.push(open(ids[slot], other));
            }
        }
        level = next;
    }
    tree
}

/// What brings a child of a node to a place: the smallest turn, and the distance.
fn signature(parent: &Node, place: Vec3, thickness: f32) -> ChildSignature {
    let edge = place - parent.position;
    let local = edge.try_normalize().map(|front| parent.orientation.inverse() * front);
    let rotation = match local {
        // The smallest turn from −z loses its digits towards +z.
        Some(front) if front.z > 0.9 => {
            let about = Quat::from_rotation_y(core::f32::consts::PI);
            Quat::from_rotation_arc(Vec3::Z, front) * about
        }
        Some(front) => Quat::from_rotation_arc(Vec3::NEG_Z, front),
        None => Quat::IDENTITY,
    };
    ChildSignature { rotation: rotation.normalize(), thickness, length: edge.length() }
}
