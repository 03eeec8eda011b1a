//! Which children a node has, and how its tips are shared among them.

use crate::graph::MAX_CHILDREN;
use crate::reach::most_tips;
use crate::signature::Writer;

/// Which children a node has, and how many of its own tips the export dropped.
///
/// A grown tree ends in tips that are not nodes of the graph. With N the tip count of the node and
/// N_i those of its children, the pipe model is exact: `N = Σ N_i + dropped`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Branching {
    /// Bit i: the child in slot i exists.
    pub subset: u8,
    /// Dropped tips, one for each slot at most.
    pub dropped: u8,
}

/// Classes of the existence head: 8 subsets × 0 to 3 dropped tips, impossible ones included.
pub const CLASSES: usize = 32;

impl Branching {
    /// The branching of class `class` in 0..[`CLASSES`].
    #[must_use]
    pub const fn from_class(class: usize) -> Self {
        Self { subset: (class / 4) as u8, dropped: (class % 4) as u8 }
    }

    /// The class of this branching.
    #[must_use]
    pub const fn class(self) -> usize {
        self.subset as usize * 4 + self.dropped as usize
    }

    /// How many children exist.
    #[must_use]
    pub const fn children(self) -> u32 {
        self.subset.count_ones()
    }

    /// Does the child in `slot` exist?
    #[must_use]
    pub const fn has(self, slot: usize) -> bool {
        self.subset >> slot & 1 == 1
    }

    /// Can a node of `tips` tips branch so? Each child bears at least one of the tips that are not
    /// dropped, a node without children has only dropped tips, and there are three slots.
    #[must_use]
    pub const fn is_possible(self, tips: u32) -> bool {
        let (children, dropped) = (self.children(), self.dropped as u32);
        if children == 0 {
            dropped == tips && dropped <= MAX_CHILDREN as u32
        } else {
            children + dropped <= MAX_CHILDREN as u32 && tips >= children + dropped
        }
    }

    /// Is there a number of tips with which a node can branch so?
    #[must_use]
    pub const fn is_ever_possible(self) -> bool {
        let (children, dropped) = (self.children(), self.dropped as u32);
        children + dropped > 0 && children + dropped <= MAX_CHILDREN as u32
    }

    /// Can a node of `tips` tips and this reach branch so? A node of reach 0 has no children, any
    /// other one has, and children of one less can bear what is not dropped.
    ///
    /// Some branching fits wherever the node can bear its tips at all,
    /// `tips ≤ most_tips(reach)`.
    #[must_use]
    pub const fn fits(self, tips: u32, reach: u16) -> bool {
        let (children, dropped) = (self.children(), self.dropped as u32);
        let borne = match reach {
            0 => return children == 0 && self.is_possible(tips),
            _ => children.saturating_mul(most_tips(reach - 1)),
        };
        children > 0 && self.is_possible(tips) && tips - dropped <= borne
    }
}

/// Tip counts up to this have a one-hot of their own in the contexts below.
const CONTEXT_TIPS: usize = 8;

pub(in crate::signature) const BRANCHING_LEN: usize = 8 + 4;
pub(in crate::signature) const TIPS_LEN: usize = 2 + CONTEXT_TIPS + 1;

pub(in crate::signature) fn put_branching(w: &mut Writer<'_>, branching: Branching) {
    w.one_hot(usize::from(branching.subset), 8);
    w.one_hot(usize::from(branching.dropped), 4);
}

pub(in crate::signature) fn put_tips(w: &mut Writer<'_>, tips: u32) {
    w.put(libm::logf(tips as f32) / 8.0);
    w.put(1.0 / libm::sqrtf(tips as f32));
    w.one_hot(tips as usize - 1, CONTEXT_TIPS + 1);
}

/// Number of features of [`encode_split`].
pub const SPLIT_LEN: usize = BRANCHING_LEN + MAX_CHILDREN + TIPS_LEN;

/// Encodes the question "of `tips` tips, how many does the child in `slot` bear?", to follow the
/// node's own features.
///
/// # Panics
///
/// When `out` is shorter than [`SPLIT_LEN`].
pub fn encode_split(branching: Branching, slot: usize, tips: u32, out: &mut [f32]) {
    let mut w = Writer { out, at: 0 };
    put_branching(&mut w, branching);
    w.one_hot(slot, MAX_CHILDREN);
    put_tips(&mut w, tips);
    debug_assert_eq!(w.at, SPLIT_LEN);
}

/// Mixture components of the split head. Its outputs: weights' logits, means and log scales of
/// logistic laws over the logit of the share, each [`SPLIT_COMPONENTS`] long.
pub const SPLIT_COMPONENTS: usize = 3;

/// Outputs of the split head.
pub const SPLIT_OUTPUTS: usize = 3 * SPLIT_COMPONENTS;
