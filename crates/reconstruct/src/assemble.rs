//! From a skeleton to a branch graph: at most three children a node, the apical one first.

use deeptree_graph::{BranchGraph, GraphError, MAX_CHILDREN, Quat, Row, TreeInfo, Vec3};

use crate::skeleton::Skeleton;
use crate::ways::NONE;

/// Part of an edge at which a node stands that takes the children for which there is no slot left.
const SPLIT: f32 = 0.15;

/// The branch graph of a skeleton, and for each joint its node.
///
/// The apical child carries the most; where there are more than two others, the edge to the apical
/// child is split near its start by a node that takes them.
pub(crate) fn assemble(
    skeleton: &Skeleton,
    info: TreeInfo,
) -> Result<(BranchGraph, Vec<u32>), GraphError> {
    let (children, heirs) = (skeleton.children(), skeleton.heirs());
    let mut rows = Vec::with_capacity(skeleton.joints.len());
    let root = &skeleton.joints[0];
    let row = |id: usize, parent: i64, slot: usize, position: Vec3, radius: f32| Row {
        id: id as i64,
        parent,
        slot: Some(slot as u8),
        position,
        radius,
        edge: None,
    };
    // The root's edge is short: a tree starts at its foot, not below it.
    let upright = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let edge = Some((upright, 0.0));
    rows.push(Row { edge, ..row(0, -1, 0, root.position, root.radius) });
    let mut extra = skeleton.joints.len();
    for (id, joint) in skeleton.joints.iter().enumerate() {
        let heir = heirs[id];
        let mut others: Vec<u32> = children[id].iter().copied().filter(|&c| c != heir).collect();
        if heir == NONE {
            continue;
        }
        let apical = &skeleton.joints[heir as usize];
        let mut parent = id as i64;
        let mut share = SPLIT;
        loop {
            let rest = others.split_off(others.len().min(MAX_CHILDREN - 1));
            for (slot, &child) in (1..).zip(&others) {
                let child_joint = &skeleton.joints[child as usize];
                let at = child_joint.position;
                rows.push(row(child as usize, parent, slot, at, child_joint.radius));
            }
            if rest.is_empty() {
                break;
            }
            let at = joint.position.lerp(apical.position, share);
            rows.push(row(extra, parent, 0, at, apical.radius));
            parent = extra as i64;
            (extra, share, others) = (extra + 1, share + SPLIT * (1.0 - share), rest);
        }
        rows.push(row(heir as usize, parent, 0, apical.position, apical.radius));
    }
    let tree = BranchGraph::from_rows(info, &rows)?;
    Ok((tree, numbers(&rows, skeleton.joints.len())))
}

/// Where each joint stands in the level order of the graph.
fn numbers(rows: &[Row], joints: usize) -> Vec<u32> {
    let mut children = vec![[None; MAX_CHILDREN]; rows.len()];
    for row in rows.iter().filter(|row| row.parent >= 0) {
        children[row.parent as usize][usize::from(row.slot.unwrap_or(0))] = Some(row.id as usize);
    }
    let mut numbers = vec![0; rows.len()];
    let mut order = vec![0];
    let mut next = 0;
    while next < order.len() {
        numbers[order[next]] = next as u32;
        order.extend(children[order[next]].iter().flatten());
        next += 1;
    }
    numbers.truncate(joints);
    numbers
}
