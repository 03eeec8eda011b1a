//! How the nodes below a node are shared out among its children, and what the network that decides
//! it reads.
//!
//! Slot by slot it is asked how many nodes grow below the child, of those that its tips and its
//! reach allow and that leave the later children what theirs need; the last child takes the rest.
//! Where that cannot be kept (the drawn reaches ask for more nodes than there are, say) it is kept
//! as nearly as it can be.

use super::Writer;
use super::situated::{BRANCHING_LEN, Branching, TIPS_LEN, put_branching, put_tips};
use crate::graph::MAX_CHILDREN;
use crate::plan::Plan;

/// What is known when the size of the child in a slot is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bequest {
    /// The branching of the parent.
    pub branching: Branching,
    /// Tips each child bears, by slot.
    pub child_tips: [u32; MAX_CHILDREN],
    /// Reach of each child, by slot.
    pub child_reaches: [u16; MAX_CHILDREN],
    /// Nodes below the parent.
    pub nodes: u32,
    /// Slot of the child.
    pub slot: usize,
    /// Nodes below the children by slot; those in the slots before the child's are known.
    pub earlier: [u32; MAX_CHILDREN],
}

/// What is left to decide on the nodes below a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Nothing: these are its nodes.
    Settled(u32),
    /// How many, both ends included.
    Open {
        /// The fewest.
        least: u32,
        /// The most.
        most: u32,
    },
}

impl Bequest {
    /// What is left to decide.
    #[must_use]
    pub fn question(&self) -> Size {
        let (least, most) = self.bounds(self.slot);
        let later = (self.slot + 1..MAX_CHILDREN).filter(|&slot| self.branching.has(slot));
        let (mut others_least, mut others_most) = (0u32, 0u32);
        for slot in later {
            let (a, b) = self.bounds(slot);
            (others_least, others_most) =
                (others_least.saturating_add(a), others_most.saturating_add(b));
        }
        let left = self.left();
        let low = left.saturating_sub(others_most).clamp(least, most);
        let high = left.saturating_sub(others_least).clamp(low, most);
        if low == high { Size::Settled(low) } else { Size::Open { least: low, most: high } }
    }

    /// The nodes that are left for the child and those after it.
    fn left(&self) -> u32 {
        let before = (0..self.slot).filter(|&slot| self.branching.has(slot));
        let taken: u32 = before.map(|slot| self.earlier[slot]).sum();
        self.nodes.saturating_sub(self.branching.children()).saturating_sub(taken)
    }

    fn bounds(&self, slot: usize) -> (u32, u32) {
        Plan::nodes_between(self.child_tips[slot], self.child_reaches[slot])
    }
}

/// Number of features of [`encode`].
pub const SIZE_LEN: usize = BRANCHING_LEN + MAX_CHILDREN + TIPS_LEN + 4 + 2 * MAX_CHILDREN;

/// Encodes the question how many nodes grow below the child in a slot, to follow the parent's own
/// features: the branching and slot; its tips; the nodes that are left and the fewest and most that
/// it can have; its tips as a share of those left; tips and reaches of all children.
///
/// # Panics
///
/// When `out` is shorter than [`SIZE_LEN`].
pub fn encode(known: &Bequest, out: &mut [f32]) {
    let Bequest { branching, child_tips, child_reaches, slot, .. } = *known;
    let mut w = Writer { out, at: 0 };
    put_branching(&mut w, branching);
    w.one_hot(slot, MAX_CHILDREN);
    put_tips(&mut w, child_tips[slot]);
    let log = |count: u32| libm::logf(1.0 + count as f32) / 8.0;
    let (least, most) = match known.question() {
        Size::Settled(nodes) => (nodes, nodes),
        Size::Open { least, most } => (least, most),
    };
    for count in [known.left(), least, most] {
        w.put(log(count));
    }
    let tips = |i: usize| if branching.has(i) { child_tips[i] } else { 0 };
    let left: u32 = (slot..MAX_CHILDREN).map(tips).sum();
    w.put(child_tips[slot] as f32 / left as f32);
    for (i, &reach) in child_reaches.iter().enumerate() {
        w.put(log(tips(i)));
        w.put(if branching.has(i) { f32::from(reach) / 16.0 } else { 0.0 });
    }
    debug_assert_eq!(w.at, SIZE_LEN);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fork(nodes: u32, slot: usize, earlier: [u32; MAX_CHILDREN]) -> Bequest {
        let branching = Branching { subset: 0b111, dropped: 0 };
        let (child_tips, child_reaches) = ([5, 2, 1], [4, 2, 1]);
        Bequest { branching, child_tips, child_reaches, nodes, slot, earlier }
    }

    #[test]
    fn questions_of_a_triple_fork_are_those_worked_out_by_hand() {
        // Five tips over four levels: 4 to 20 nodes; two over two: 2 to 4; one over one: one.
        // Of 15 nodes below, three are the children: 12 are left, of which the others need three to
        // five.
        assert_eq!(fork(15, 0, [0; 3]).question(), Size::Open { least: 7, most: 9 });
        assert_eq!(fork(15, 1, [8, 0, 0]).question(), Size::Settled(3));
        assert_eq!(fork(15, 2, [8, 3, 0]).question(), Size::Settled(1));
        // Too few for the reaches, and too many for the tips.
        assert_eq!(fork(4, 0, [0; 3]).question(), Size::Settled(4));
        assert_eq!(fork(90, 0, [0; 3]).question(), Size::Settled(20));
    }

    #[test]
    fn all_that_is_left_is_shared_out() {
        for nodes in 10..=28 {
            let mut whole = vec![fork(nodes, 0, [0; 3])];
            for slot in 0..MAX_CHILDREN {
                let mut next = Vec::new();
                for known in whole {
                    let choices = match known.question() {
                        Size::Settled(own) => own..=own,
                        Size::Open { least, most } => least..=most,
                    };
                    for own in choices {
                        let mut after = Bequest { slot: slot + 1, ..known };
                        after.earlier[slot] = own;
                        next.push(after);
                    }
                }
                whole = next;
            }
            assert!(!whole.is_empty());
            for way in whole {
                assert_eq!(way.earlier.iter().sum::<u32>() + 3, nodes);
                for slot in 0..MAX_CHILDREN {
                    let (least, most) = way.bounds(slot);
                    assert!((least..=most).contains(&way.earlier[slot]));
                }
            }
        }
    }

    #[test]
    fn the_encoding_fills_every_feature() {
        for slot in 0..MAX_CHILDREN {
            let mut out = [f32::NAN; SIZE_LEN];
            encode(&fork(16, slot, [8, 3, 0]), &mut out);
            assert!(out.iter().all(|x| x.is_finite()));
        }
    }
}
