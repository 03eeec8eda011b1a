//! What branches that cannot grow leave to those that can.
//!
//! Where a child is given up at an obstacle, at the ground or beside the stem of a volume, the tips
//! and nodes that it was to have pass to the nodes of its level that are to grow on: a crown that is
//! stopped on one side grows on elsewhere. The pipe model is kept: what a branch has lost or gained, all
//! below it have lost or gained too, and the root bears what it bore.

use deeptree_graph::signature::{thickness_of, tip_count};
use deeptree_graph::{Balance, BranchGraph, NodeId};

/// What a node leaves that could not grow some of its children.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Legacy {
    pub(crate) node: NodeId,
    /// Tips the children were to bear.
    pub(crate) tips: u32,
    /// The children, and the nodes that were to grow below them.
    pub(crate) nodes: u32,
}

/// A node that is to grow on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heir {
    pub(crate) node: NodeId,
    /// Nodes that are to grow below it: what it inherits is in their proportion.
    pub(crate) nodes: u32,
}

/// Passes on what is left, and says by how many nodes the plan of each heir grows. Nothing changes
/// without heirs.
pub(crate) fn pass_on(
    legacies: &[Legacy],
    heirs: &[Heir],
    tree: &mut BranchGraph,
    balance: &mut Balance,
    tip_radius: f32,
) -> Vec<u32> {
    let weights: Vec<u64> = heirs.iter().map(|heir| u64::from(heir.nodes)).collect();
    if weights.iter().all(|&weight| weight == 0) {
        return vec![0; heirs.len()];
    }
    let (mut tips, mut nodes) = (0, 0);
    for legacy in legacies {
        let free = free_tips(tree, legacy.node, tip_radius).min(legacy.tips);
        let position = tree.node(legacy.node).position;
        balance.add_ended(position, -i64::from(free));
        add_tips(tree, legacy.node, -i64::from(free), tip_radius);
        tips += u64::from(free);
        nodes += u64::from(legacy.nodes);
    }
    for (heir, gained) in heirs.iter().zip(shares(tips, &weights)) {
        if let Some(parent) = tree.node(heir.node).parent {
            balance.add_ended(tree.node(parent).position, i64::from(gained));
        }
        add_tips(tree, heir.node, i64::from(gained), tip_radius);
    }
    shares(nodes, &weights).collect()
}

/// The tips of a node that none of its children bears, but for the one that is its own where it has
/// no children.
fn free_tips(tree: &BranchGraph, id: NodeId, tip_radius: f32) -> u32 {
    let tips = |id: NodeId| tip_count(tree.node(id).thickness, tip_radius);
    let borne: u32 = tree.node(id).children.iter().flatten().map(|&child| tips(child)).sum();
    tips(id).saturating_sub(borne.max(1))
}

/// Lets a node and all below it bear so many tips more.
fn add_tips(tree: &mut BranchGraph, id: NodeId, more: i64, tip_radius: f32) {
    let mut at = (more != 0).then_some(id);
    while let Some(id) = at {
        let tips = i64::from(tip_count(tree.node(id).thickness, tip_radius)) + more;
        tree.set_thickness(id, thickness_of(tips.max(1) as u32, tip_radius));
        at = tree.node(id).parent;
    }
}

/// A number shared out by weight, to the last one: `⌊n W_i / W⌋ − ⌊n W_{i−1} / W⌋` with sums W_i of
/// the weights. They must not all be 0.
fn shares(number: u64, weights: &[u64]) -> impl Iterator<Item = u32> {
    let total = u128::from(weights.iter().sum::<u64>());
    let up_to = move |sum: u64| (u128::from(number) * u128::from(sum) / total) as u64;
    let mut sum = 0;
    weights.iter().map(move |weight| {
        let before = up_to(sum);
        sum += weight;
        (up_to(sum) - before) as u32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{ChildSignature, Quat, TreeInfo, Vec3};

    const TIP: f32 = 0.01;

    fn child(tips: u32) -> Option<ChildSignature> {
        let thickness = thickness_of(tips, TIP);
        Some(ChildSignature { rotation: Quat::IDENTITY, thickness, length: 1.0 })
    }

    fn tips(tree: &BranchGraph) -> Vec<u32> {
        tree.nodes().iter().map(|node| tip_count(node.thickness, TIP)).collect()
    }

    #[test]
    fn shares_add_up_and_keep_to_the_weights() {
        for number in [0, 1, 7, 100, 1_000_003] {
            let weights = [3, 0, 1, 6, 0];
            let found: Vec<u32> = shares(number, &weights).collect();
            assert_eq!(found.iter().map(|&share| u64::from(share)).sum::<u64>(), number);
            for (share, weight) in found.into_iter().zip(weights) {
                assert!((f64::from(share) - number as f64 * weight as f64 / 10.0).abs() < 1.0);
            }
        }
    }

    #[test]
    fn what_a_branch_leaves_its_cousins_bear() {
        // A root of 12 tips, two children of 8 and 4; the first one's child of 7 cannot grow and
        // one tip was dropped, the second one has two children of 1 and 3.
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, child(12).unwrap());
        tree.grow(0, [child(8), child(4), None]);
        tree.grow(2, [child(1), child(3), None]);
        assert_eq!(tips(&tree), [12, 8, 4, 1, 3]);
        let legacy = Legacy { node: 1, tips: 7, nodes: 11 };
        let heirs = [Heir { node: 3, nodes: 0 }, Heir { node: 4, nodes: 5 }];
        let mut balance = Balance::default();
        let gained = pass_on(&[legacy], &heirs, &mut tree, &mut balance, TIP);
        assert_eq!(gained, [0, 11]);
        assert_eq!(tips(&tree), [12, 1, 11, 1, 10]);
        // Without heirs nothing changes.
        let again = Legacy { node: 4, tips: 5, nodes: 2 };
        assert_eq!(pass_on(&[again], &heirs[..1], &mut tree, &mut balance, TIP), [0]);
        assert_eq!(tips(&tree), [12, 1, 11, 1, 10]);
    }
}
