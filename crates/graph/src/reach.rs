//! The longest path below a node, counted in nodes: a plan that growth can follow.
//!
//! A node without children has reach 0; any other one more than the farthest reaching of its
//! children. A tree whose nodes inherit their reach so ends by construction, and its longest path
//! is as long as its root was told.

use crate::graph::{BranchGraph, MAX_CHILDREN};

/// The reach of each node, in the order of the nodes.
///
/// Reaches beyond 65535 are told as that.
#[must_use]
pub fn reaches(tree: &BranchGraph) -> Vec<u16> {
    let mut reaches = vec![0u16; tree.len()];
    // Children stand after their parents.
    for (id, node) in tree.nodes().iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            let over = reaches[id].saturating_add(1);
            let reach = &mut reaches[parent as usize];
            *reach = over.max(*reach);
        }
    }
    reaches
}

/// The most tips that a node of this reach can bear: `3^(reach + 1)`, as far as 32 bits go.
///
/// A node without children bears at most the three tips that an export dropped.
#[must_use]
pub const fn most_tips(reach: u16) -> u32 {
    (MAX_CHILDREN as u32).saturating_pow(reach as u32 + 1)
}

/// The least reach of a node that bears so many tips: the inverse of [`most_tips`].
#[must_use]
pub const fn least_reach(tips: u32) -> u16 {
    let mut reach = 0;
    while most_tips(reach) < tips {
        reach += 1;
    }
    reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random_tree;
    use crate::{ChildSignature, Quat, TreeInfo, Vec3};

    #[test]
    fn reaches_of_a_small_tree_are_those_worked_out_by_hand() {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let edge = ChildSignature { rotation: Quat::IDENTITY, thickness: 0.1, length: 1.0 };
        // 0 has the children 1 and 2; 1 has 3; 2 has 4 and 5; 5 has 6.
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge);
        tree.grow(0, [Some(edge), None, Some(edge)]);
        tree.grow(1, [None, Some(edge), None]);
        tree.grow(2, [Some(edge), Some(edge), None]);
        tree.grow(5, [Some(edge), None, None]);
        assert_eq!(reaches(&tree), [3, 1, 2, 0, 0, 1, 0]);
    }

    #[test]
    fn the_reach_of_a_node_is_the_depth_of_the_deepest_below_it() {
        for seed in 0..8 {
            let tree = random_tree(seed, 200);
            let mut depth = vec![0u16; tree.len()];
            for (id, node) in tree.nodes().iter().enumerate().skip(1) {
                depth[id] = depth[node.parent.unwrap() as usize] + 1;
            }
            let reaches = reaches(&tree);
            assert_eq!(Some(reaches[0]), depth.iter().copied().max());
            for (id, &reach) in reaches.iter().enumerate() {
                // One of the nodes so far below has this node as its ancestor, and none further.
                let below = |far: usize| {
                    let up = |id: usize| tree.nodes()[id].parent.map(|p| p as usize);
                    std::iter::successors(Some(far), |&id| up(id)).any(|ancestor| ancestor == id)
                };
                let deepest = (0..tree.len()).filter(|&far| below(far)).map(|far| depth[far]).max();
                assert_eq!(deepest, Some(depth[id] + reach));
            }
        }
    }

    #[test]
    fn tips_of_a_full_ternary_tree_bound_the_reach() {
        assert_eq!([0, 1, 2, 5].map(most_tips), [3, 9, 27, 729]);
        assert_eq!([1, 3, 4, 9, 10, 729, 730].map(least_reach), [0, 0, 1, 1, 2, 5, 6]);
        assert_eq!(most_tips(u16::MAX), u32::MAX);
        assert_eq!(least_reach(u32::MAX), 20);
    }
}
