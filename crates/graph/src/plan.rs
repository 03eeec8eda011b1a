//! What growth keeps to below a node, beside its tips: how far, and how many nodes.

use crate::graph::{BranchGraph, MAX_CHILDREN};
use crate::reach::{least_reach, reaches};
use crate::signature::TreeConditions;
use crate::signature::situated::Branching;

/// Reach that is guessed at most, in nodes.
const MOST_GUESSED: f32 = 60.0;

/// What is to grow below a node that bears some tips. A tree whose nodes inherit it grows to the
/// size its root was told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// Nodes on the longest path below.
    pub reach: u16,
    /// All nodes below.
    pub nodes: u32,
}

impl Plan {
    /// The fewest and the most nodes below a node of so many tips and this reach.
    ///
    /// Each node has at most three children and dropped tips together, so n nodes below leave room
    /// for `2 n + 3` tips; the longest path alone has as many as the reach; and at every depth, each
    /// node bears one of the tips.
    #[must_use]
    pub const fn nodes_between(tips: u32, reach: u16) -> (u32, u32) {
        let for_tips = tips.saturating_sub(MAX_CHILDREN as u32).div_ceil(2);
        let least = if for_tips > reach as u32 { for_tips } else { reach as u32 };
        let most = tips.saturating_mul(reach as u32);
        (least, if most > least { most } else { least })
    }

    /// The nearest plan that a node of so many tips can keep.
    #[must_use]
    pub fn kept(self, tips: u32) -> Self {
        let reach = self.reach.max(least_reach(tips));
        let (least, most) = Self::nodes_between(tips, reach);
        Self { reach, nodes: self.nodes.clamp(least, most) }
    }

    /// The tips and the plan of a node of which only this is known: its `share` of the tree's wood,
    /// 0 to 1, and the longest way beyond it, `longest` metres of the growth space, which are as many
    /// nodes ([`TreeTraits::reach`](crate::TreeTraits::reach)), 60 at most.
    #[must_use]
    pub fn guessed(tree: &TreeConditions, share: f32, longest: f32) -> (u32, Self) {
        let tips = libm::roundf(share * tree.root_tips as f32).max(1.0) as u32;
        let reach = libm::roundf(longest).clamp(1.0, MOST_GUESSED) as u16;
        let nodes = (share * tree.traits.nodes) as u32;
        (tips, Self { reach, nodes }.kept(tips))
    }

    /// The nearest tips and plan that a node can have which branches so: for where tips and plan are
    /// guessed. [`Plan::allows`] the branching then, if it [is ever
    /// possible](Branching::is_ever_possible).
    #[must_use]
    pub fn bent_to(self, branching: Branching, tips: u32) -> (u32, Self) {
        let (children, dropped) = (branching.children(), u32::from(branching.dropped));
        if children == 0 {
            return (dropped, Self::default());
        }
        let tips = tips.max(children + dropped);
        let mut reach = self.reach.max(1);
        while !branching.fits(tips, reach) && reach < u16::MAX {
            reach += 1;
        }
        let (borne, further) = (tips - dropped, u32::from(reach) - 1);
        let for_tips = borne.saturating_sub(children * MAX_CHILDREN as u32).div_ceil(2);
        let least = further.max(for_tips);
        let most = borne.saturating_mul(further).max(least);
        let left = self.nodes.saturating_sub(children).clamp(least, most);
        (tips, Self { reach, nodes: left.saturating_add(children) })
    }

    /// Can a node of this plan and so many tips branch so? Beside what [`Branching::fits`] says: its
    /// children are among the nodes below it, one of them reaches as far as is left, and together
    /// they can bear the tips and the nodes.
    #[must_use]
    pub const fn allows(self, branching: Branching, tips: u32) -> bool {
        if !branching.fits(tips, self.reach) {
            return false;
        }
        let children = branching.children();
        if children == 0 {
            return self.nodes == 0;
        }
        if self.nodes < children {
            return false;
        }
        let (left, further) = (self.nodes - children, self.reach as u32 - 1);
        let borne = tips - branching.dropped as u32;
        let room = children * MAX_CHILDREN as u32;
        further <= left
            && borne.saturating_sub(room).div_ceil(2) <= left
            && left <= borne.saturating_mul(further)
    }
}

/// The plan that each node of a tree has kept, in the order of the nodes.
#[must_use]
pub fn plans(tree: &BranchGraph) -> Vec<Plan> {
    let plan = |reach| Plan { reach, nodes: 0 };
    let mut plans: Vec<Plan> = reaches(tree).into_iter().map(plan).collect();
    // Children stand after their parents.
    for (id, node) in tree.nodes().iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            plans[parent as usize].nodes += 1 + plans[id].nodes;
        }
    }
    plans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signature::situated::CLASSES;
    use crate::testing::random_tree;

    #[test]
    fn a_plan_that_is_bent_allows_the_branching() {
        for class in 0..CLASSES {
            let branching = Branching::from_class(class);
            assert_eq!(
                branching.is_ever_possible(),
                (1..10).any(|tips| branching.is_possible(tips)),
                "{branching:?}"
            );
            if !branching.is_ever_possible() {
                continue;
            }
            for tips in [1, 2, 5, 30, 4000] {
                for (reach, nodes) in [(0, 0), (1, 1), (1, 50), (3, 4), (9, 2000), (60, 3)] {
                    let (tips, plan) = Plan { reach, nodes }.bent_to(branching, tips);
                    assert!(plan.allows(branching, tips), "{branching:?} {tips} {plan:?}");
                }
            }
            let (tips, plan) = (1000, Plan { reach: 12, nodes: 900 });
            if plan.allows(branching, tips) {
                assert_eq!(plan.bent_to(branching, tips), (tips, plan));
            }
        }
    }

    #[test]
    fn what_is_guessed_of_a_whole_tree_is_its_own_and_of_a_part_its_share() {
        let tree = random_tree(3, 300);
        let all = TreeConditions { root_tips: 240, ..TreeConditions::of(&tree, 0, 0.01, None) };
        let (tips, plan) = Plan::guessed(&all, 1.0, 20.4);
        assert_eq!((tips, plan), (240, Plan { reach: 20, nodes: tree.len() as u32 }));
        let (tips, plan) = Plan::guessed(&all, 0.25, 9.5);
        assert_eq!((tips, plan), (60, Plan { reach: 10, nodes: tree.len() as u32 / 4 }));
        // Never nothing, never without end, and always what a node can keep.
        let (tips, plan) = Plan::guessed(&all, 0.0, 1e9);
        assert_eq!((tips, plan), (1, Plan { reach: 60, nodes: 60 }));
    }

    #[test]
    fn nodes_below_are_those_that_have_the_node_as_ancestor() {
        for seed in 0..6 {
            let tree = random_tree(seed, 200);
            let plans = plans(&tree);
            let mut below = vec![0; tree.len()];
            for start in 0..tree.len() {
                let up = |id: &usize| tree.nodes()[*id].parent.map(|parent| parent as usize);
                std::iter::successors(Some(start), up).skip(1).for_each(|id| below[id] += 1);
            }
            assert_eq!(plans.iter().map(|plan| plan.nodes).collect::<Vec<u32>>(), below);
        }
    }

    /// All (reach, nodes) that a node of so many tips can have, by trying every way to branch.
    fn possible(tips: u32, depth: u16, memo: &mut Memo) -> std::collections::BTreeSet<(u16, u32)> {
        if let Some(known) = memo.get(&(tips, depth)) {
            return known.clone();
        }
        let mut all = std::collections::BTreeSet::new();
        for branching in (0..CLASSES).map(Branching::from_class) {
            if !branching.is_possible(tips) {
                continue;
            }
            let children = branching.children();
            if children == 0 {
                all.insert((0, 0));
            } else if depth > 0 {
                let borne = tips - u32::from(branching.dropped);
                // What so many children can have together, one after the other.
                let mut sums = std::collections::BTreeSet::from([(0u32, 0u16, 0u32)]);
                for child in 0..children {
                    let mut next = std::collections::BTreeSet::new();
                    for &(used, reach, nodes) in &sums {
                        let after = children - child - 1;
                        let shares = if after == 0 {
                            borne - used..=borne - used
                        } else {
                            1..=borne.saturating_sub(used + after)
                        };
                        for own in shares.filter(|&own| own > 0) {
                            for (r, n) in possible(own, depth - 1, memo) {
                                next.insert((used + own, reach.max(r), nodes + n));
                            }
                        }
                    }
                    sums = next;
                }
                all.extend(sums.into_iter().map(|(_, reach, n)| (reach + 1, n + children)));
            }
        }
        memo.insert((tips, depth), all.clone());
        all
    }

    type Memo = std::collections::BTreeMap<(u32, u16), std::collections::BTreeSet<(u16, u32)>>;

    #[test]
    fn bounds_hold_for_every_way_to_grow() {
        let mut memo = Memo::new();
        for tips in 1..10 {
            for (reach, nodes) in possible(tips, 4, &mut memo) {
                let (least, most) = Plan::nodes_between(tips, reach);
                assert!((least..=most).contains(&nodes), "{tips} tips, {reach}: {nodes}");
                let plan = Plan { reach, nodes };
                assert_eq!(plan.kept(tips), plan);
                // Some way to branch is allowed where one exists.
                let allowed = |class| plan.allows(Branching::from_class(class), tips);
                assert!((0..CLASSES).any(allowed), "{tips} tips, {plan:?}");
            }
        }
    }

    #[test]
    fn a_node_of_one_tip_has_one_chain_below() {
        let far = Plan { reach: 5, nodes: 90 }.kept(1);
        assert_eq!(far, Plan { reach: 5, nodes: 5 });
        let forks = (0..CLASSES).map(Branching::from_class).filter(|b| far.allows(*b, 1));
        assert!(forks.into_iter().all(|branching| branching.children() == 1));
    }
}
