//! How the children of a node inherit its reach, and what the network that decides it reads.
//!
//! Of a node of reach R, one child has reach R − 1: the *heir*, the first that reaches so far. The
//! others reach 0 to R − 1, those before the heir at most R − 2. Slot by slot it is asked whether
//! the child is the heir, as long as there is none; and how far it reaches when it is not. So each
//! way to share out the reach has one probability, a product over the children, and the longest
//! path of a tree is that of its root.

use super::Writer;
use super::situated::{BRANCHING_LEN, Branching, SPLIT_OUTPUTS, TIPS_LEN, put_branching, put_tips};
use crate::graph::MAX_CHILDREN;
use crate::reach::{least_reach, most_tips};

/// What is known when the reach of the child in a slot is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inheritance {
    /// The branching of the parent.
    pub branching: Branching,
    /// Tips each child bears, by slot.
    pub child_tips: [u32; MAX_CHILDREN],
    /// Reach of the parent, at least 1.
    pub reach: u16,
    /// Slot of the child.
    pub slot: usize,
    /// Reaches of the children by slot; those in the slots before the child's are known.
    pub earlier: [u16; MAX_CHILDREN],
}

/// What is left to decide on the reach of a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Nothing: this is its reach.
    Settled(u16),
    /// How far it reaches.
    Open {
        /// The child may be the heir; otherwise one is before it.
        asks_heir: bool,
        /// A child that is not the heir reaches 0 to `bins` − 1.
        bins: u16,
        /// The least reach with which it can bear its tips.
        least: u16,
    },
}

impl Inheritance {
    /// What is left to decide.
    #[must_use]
    pub fn question(&self) -> Question {
        let heir = self.reach.saturating_sub(1);
        let least = least_reach(self.child_tips[self.slot]).min(heir);
        let is_last = self.branching.subset >> (self.slot + 1) == 0;
        if least == heir || (is_last && !self.has_heir()) {
            return Question::Settled(heir);
        }
        let asks_heir = !self.has_heir();
        Question::Open { asks_heir, bins: heir + u16::from(!asks_heir), least }
    }

    /// Is one of the children before the heir?
    fn has_heir(&self) -> bool {
        let before = |slot: &usize| self.branching.has(*slot);
        (0..self.slot).filter(before).any(|slot| self.earlier[slot] + 1 >= self.reach)
    }
}

/// How many of `tips` tips the first of `children` children of a node of this reach can bear, at
/// least and at most: each bears one, and none more than its reach allows.
///
/// The tips must be as many as the children, and no more than they can bear together.
#[must_use]
pub const fn share_bounds(tips: u32, children: u32, reach: u16) -> (u32, u32) {
    let most = most_tips(reach.saturating_sub(1));
    let others = children - 1;
    let (least, all) = (tips.saturating_sub(others.saturating_mul(most)), tips - others);
    (if least > 1 { least } else { 1 }, if all < most { all } else { most })
}

/// Outputs of the reach head: the logit that the child is the heir; then, as those of the split
/// head, a mixture of logistic laws over the logit of the share of the bins below.
pub const REACH_OUTPUTS: usize = 1 + SPLIT_OUTPUTS;

/// Number of features of [`encode`].
pub const REACH_LEN: usize = BRANCHING_LEN + MAX_CHILDREN + TIPS_LEN + 3 + 2 * MAX_CHILDREN + 2 * 2;

/// Encodes the question how far the child in a slot reaches, to follow the node's own features: the
/// branching and slot; its tips, as a share of all children's too, the least reach they need and
/// whether there is an heir; tips of all children; reaches of those before it, and whether each is
/// as long as can be.
///
/// # Panics
///
/// When `out` is shorter than [`REACH_LEN`].
pub fn encode(known: &Inheritance, out: &mut [f32]) {
    let Inheritance { branching, child_tips, reach, slot, earlier } = *known;
    let mut w = Writer { out, at: 0 };
    put_branching(&mut w, branching);
    w.one_hot(slot, MAX_CHILDREN);
    put_tips(&mut w, child_tips[slot]);
    let tips = |i: usize| if branching.has(i) { child_tips[i] } else { 0 };
    let all: u32 = (0..MAX_CHILDREN).map(tips).sum();
    w.put(child_tips[slot] as f32 / all as f32);
    w.put(f32::from(least_reach(child_tips[slot])) / 4.0);
    w.put(f32::from(u8::from(known.has_heir())));
    for i in 0..MAX_CHILDREN {
        w.put(libm::logf(tips(i).max(1) as f32) / 8.0);
        w.put(tips(i) as f32 / all as f32);
    }
    for (i, &before) in earlier.iter().enumerate().take(MAX_CHILDREN - 1) {
        let is_known = i < slot && branching.has(i);
        w.put(if is_known { f32::from(before) / 16.0 } else { 0.0 });
        w.put(f32::from(u8::from(is_known && before + 1 >= reach)));
    }
    debug_assert_eq!(w.at, REACH_LEN);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signature::situated::CLASSES;

    fn fork(reach: u16, slot: usize, earlier: [u16; MAX_CHILDREN]) -> Inheritance {
        let branching = Branching { subset: 0b111, dropped: 0 };
        Inheritance { branching, child_tips: [5, 2, 1], reach, slot, earlier }
    }

    #[test]
    fn questions_of_a_triple_fork_are_those_worked_out_by_hand() {
        use Question::{Open, Settled};
        // Five tips need a reach of 1; two and one need none.
        let first = fork(6, 0, [0; 3]).question();
        assert_eq!(first, Open { asks_heir: true, bins: 5, least: 1 });
        let after_another = fork(6, 1, [3, 0, 0]).question();
        assert_eq!(after_another, Open { asks_heir: true, bins: 5, least: 0 });
        let after_the_heir = fork(6, 1, [5, 0, 0]).question();
        assert_eq!(after_the_heir, Open { asks_heir: false, bins: 6, least: 0 });
        assert_eq!(fork(6, 2, [3, 4, 0]).question(), Settled(5));
        assert_eq!(fork(6, 2, [3, 5, 0]).question(), Open { asks_heir: false, bins: 6, least: 0 });
        // With reach 2 the child of five tips must be the heir, with reach 1 all are tips.
        assert_eq!(fork(2, 0, [0; 3]).question(), Settled(1));
        assert_eq!(fork(2, 1, [1, 0, 0]).question(), Open { asks_heir: false, bins: 2, least: 0 });
        assert_eq!(fork(1, 1, [0; 3]).question(), Settled(0));
        let single = Branching { subset: 0b010, dropped: 1 };
        assert_eq!(
            Inheritance { branching: single, ..fork(9, 1, [0; 3]) }.question(),
            Question::Settled(8)
        );
    }

    /// Every way to answer the questions on a triple fork: how far the children reach.
    fn answers(reach: u16) -> Vec<[u16; MAX_CHILDREN]> {
        let mut ways = vec![[0; MAX_CHILDREN]];
        for slot in 0..MAX_CHILDREN {
            let one = |earlier: [u16; MAX_CHILDREN]| {
                let choices: Vec<u16> = match fork(reach, slot, earlier).question() {
                    Question::Settled(own) => vec![own],
                    Question::Open { asks_heir, bins, least } => {
                        (least..bins).chain(asks_heir.then_some(reach - 1)).collect()
                    }
                };
                choices.into_iter().map(move |own| {
                    let mut way = earlier;
                    way[slot] = own;
                    way
                })
            };
            ways = ways.into_iter().flat_map(one).collect();
        }
        ways
    }

    #[test]
    fn answers_are_all_ways_to_reach_as_far_each_once() {
        for reach in 2..7 {
            let mut ways = answers(reach);
            ways.sort_unstable();
            let all = (0..reach)
                .flat_map(|a| (0..reach).flat_map(move |b| (0..reach).map(move |c| [a, b, c])));
            // The first child has five tips, for which a reach of 1 is needed.
            let right = all.filter(|way| way.iter().max() == Some(&(reach - 1)) && way[0] >= 1);
            assert_eq!(ways, right.collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_node_that_can_bear_its_tips_can_branch_and_others_cannot() {
        for reach in 0..4 {
            for tips in 1..100 {
                let fits = (0..CLASSES).any(|class| Branching::from_class(class).fits(tips, reach));
                assert_eq!(fits, tips <= most_tips(reach), "{tips} tips, reach {reach}");
            }
        }
    }

    #[test]
    fn far_from_the_tips_the_reach_excludes_only_the_end() {
        for class in (0..CLASSES).map(Branching::from_class) {
            for tips in 1..200 {
                let expected = class.is_possible(tips) && class.children() > 0;
                assert_eq!(class.fits(tips, 30), expected);
            }
        }
    }

    #[test]
    fn shares_leave_every_child_what_it_needs_and_can_bear() {
        for (reach, children) in (1..4).flat_map(|reach| [(reach, 2), (reach, 3)]) {
            let most = most_tips(reach - 1);
            for tips in children..=children * most {
                // By counting: the rest can be shared out when it is neither too few nor too many.
                let rest =
                    |own: &u32| (children - 1..=(children - 1) * most).contains(&(tips - own));
                let right: Vec<u32> = (1..=most.min(tips)).filter(rest).collect();
                let (low, high) = share_bounds(tips, children, reach);
                assert_eq!((low..=high).collect::<Vec<_>>(), right, "{tips} {children} {reach}");
            }
        }
    }

    #[test]
    fn the_encoding_fills_every_feature() {
        for slot in 0..MAX_CHILDREN {
            let mut out = [f32::NAN; REACH_LEN];
            encode(&fork(6, slot, [3, 5, 0]), &mut out);
            assert!(out.iter().all(|x| x.is_finite()));
        }
    }
}
