//! The encoding of kind `situated`: the place of a node told so that a small network can use it.
//!
//! The networks of this kind factor p(children | node) by the chain rule:
//!
//! 1. *existence*: which [`Branching`] the node has, from [`encode`];
//! 2. *split*: how its tips are shared among its children, one [`encode_split`] a decision;
//! 3. *rotation* of each child, slot by slot, from [`encode_rotation`].

use glam::{Quat, Vec3};

use super::{TreeConditions, Writer, tip_count};
use crate::graph::{MAX_CHILDREN, Node};
use crate::traits::TreeTraits;

/// Tip counts up to this have a one-hot of their own.
const SMALL_TIPS: usize = 16;
/// One-hot steps of d_s, of the distance to the last fork, and of d_r, in metres.
const BRANCH_STEPS: usize = 14;
const FORK_STEPS: usize = 10;
const ROOT_STEPS: usize = 40;
/// Orders with a one-hot of their own; deeper ones share the last.
const ORDERS: usize = 7;

/// Number of features for a model of `species` species.
#[must_use]
pub const fn len(species: usize) -> usize {
    species
        + 2
        + 1
        + TreeTraits::COUNT
        + (2 + SMALL_TIPS + 1)
        + (1 + BRANCH_STEPS)
        + (1 + FORK_STEPS)
        + (1 + ROOT_STEPS)
        + ORDERS
        + 3
        + 3
        + 4
        + 1
        + 2
        + 9
        + 3
}

/// Encodes one node.
///
/// In order: s, a, v; the tips and traits of the whole tree; ln N, 1/√N and a one-hot of small N; d_s, the distance to the last fork
/// and d_r, each as a number and a one-hot of whole metres; o, m_p and the slot as one-hots;
/// q_p and l_p; height and distance from the axis; gravity (as the height of front, up and right), the
/// position and the outward direction, each in the node's own frame.
///
/// # Panics
///
/// When `out` is shorter than [`len`].
///
/// # Source
///
/// Eq. 1, with what q_p hides: the global frame, and the distance to the last fork.
pub fn encode(node: &Node, tree: &TreeConditions, species: usize, out: &mut [f32]) {
    let mut w = Writer { out, at: 0 };
    w.one_hot(tree.species, species);
    w.put(tree.age / 50.0);
    w.put(2.0 * tree.gravitropism);
    put_traits(&mut w, tree);

    let tips = tip_count(node.thickness, tree.tip_radius);
    w.put(libm::logf(tips as f32) / 8.0);
    w.put(1.0 / libm::sqrtf(tips as f32));
    w.one_hot(tips as usize - 1, SMALL_TIPS + 1);

    for (distance, scale, steps) in [
        (node.branch_distance, 16.0, BRANCH_STEPS),
        (node.fork_distance, 8.0, FORK_STEPS),
        (node.root_distance, 32.0, ROOT_STEPS),
    ] {
        w.put(distance / scale);
        w.one_hot(libm::roundf(distance.max(1.0)) as usize - 1, steps);
    }
    w.one_hot(usize::from(node.order), ORDERS);
    w.one_hot(usize::from(node.sibling_count.max(1)) - 1, 3);
    w.one_hot(usize::from(node.slot), 3);
    node.rotation.to_array().into_iter().for_each(|x| w.put(x));
    w.put(node.length);

    let axis_distance = Vec3::new(node.position.x, 0.0, node.position.z);
    let radius = axis_distance.length();
    w.put(node.position.y / 32.0);
    w.put(radius / 16.0);
    let own = node.orientation.inverse();
    w.put3(own * Vec3::Y);
    w.put3(own * (node.position / 32.0));
    // Outward from the trunk; fades out at the axis, where it has no direction.
    w.put3(own * (axis_distance / (radius + 0.5)));
    w.put3(own * outward_from_crown(node.position));
    debug_assert_eq!(w.at, len(species));
}

/// Where the tips and traits of the whole tree stand in [`encode`].
///
/// They are for existence and split. Rotations are not told them, and read zeros there: eight
/// numbers name a training tree, and a network would learn its twigs by heart.
#[must_use]
pub const fn traits(species: usize) -> std::ops::Range<usize> {
    species + 2..species + 3 + TreeTraits::COUNT
}

/// What the whole tree is like, each number near 0 and spread by about 1 over trees.
fn put_traits(w: &mut Writer<'_>, tree: &TreeConditions) {
    let tips = tree.root_tips as f32;
    let TreeTraits { nodes, branches, longest_path, mean_path, crown_radius, height, trunk_length } =
        tree.traits;
    w.put(2.0 * (libm::logf(tips) - 7.5));
    w.put(6.0 * libm::logf(nodes / tips));
    w.put(6.0 * (libm::logf(branches / tips) + 1.0));
    w.put((longest_path - 32.0) / 4.0);
    w.put((mean_path - 18.0) / 3.0);
    w.put((crown_radius - 15.0) / 4.0);
    w.put((height - 25.0) / 4.0);
    w.put((trunk_length - 22.0) / 4.0);
}

/// Direction from the axis at 0.7 of the node's height to the node: roughly away from the
/// crown's centre, where the light of an open field comes from.
fn outward_from_crown(position: Vec3) -> Vec3 {
    let from = position - Vec3::new(0.0, 0.7 * position.y, 0.0);
    from / (from.length() + 0.5)
}

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
}

/// Tip counts up to this have a one-hot of their own in the contexts below.
const CONTEXT_TIPS: usize = 8;

const BRANCHING_LEN: usize = 8 + 4;

fn put_branching(w: &mut Writer<'_>, branching: Branching) {
    w.one_hot(usize::from(branching.subset), 8);
    w.one_hot(usize::from(branching.dropped), 4);
}

fn put_tips(w: &mut Writer<'_>, tips: u32) {
    w.put(libm::logf(tips as f32) / 8.0);
    w.put(1.0 / libm::sqrtf(tips as f32));
    w.one_hot(tips as usize - 1, CONTEXT_TIPS + 1);
}

/// Number of features of [`encode_split`].
pub const SPLIT_LEN: usize = BRANCHING_LEN + 3 + 2 + CONTEXT_TIPS + 1;

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

/// An earlier sibling as the later ones see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sibling {
    /// Tips it bears.
    pub tips: u32,
    /// Its rotation, in standard deviations from the mean of its slot.
    pub turn: Vec3,
}

/// Number of features of [`encode_rotation`] for the child in `slot`.
#[must_use]
pub const fn rotation_len(slot: usize) -> usize {
    BRANCHING_LEN + 1 + 2 + CONTEXT_TIPS + 1 + 4 * slot
}

/// Encodes what the rotation of the child in `slot` depends on besides its parent: the branching,
/// its tips, and the siblings in the slots before it. To follow the node's own features.
///
/// # Panics
///
/// When `out` is shorter than [`rotation_len`].
pub fn encode_rotation(
    branching: Branching,
    parent_tips: u32,
    tips: u32,
    earlier: &[Option<Sibling>],
    out: &mut [f32],
) {
    let mut w = Writer { out, at: 0 };
    put_branching(&mut w, branching);
    w.put(tips as f32 / parent_tips as f32);
    put_tips(&mut w, tips);
    for sibling in earlier {
        let (tips, turn) = sibling.map_or((1, Vec3::ZERO), |s| (s.tips, s.turn));
        w.put(libm::logf(tips as f32) / 8.0);
        w.put3(turn);
    }
    debug_assert_eq!(w.at, rotation_len(earlier.len()));
}

/// Mixture components of the split head. Its outputs: weights' logits, means and log scales of
/// logistic laws over the logit of the share, each [`SPLIT_COMPONENTS`] long.
pub const SPLIT_COMPONENTS: usize = 3;

/// Outputs of the split head.
pub const SPLIT_OUTPUTS: usize = 3 * SPLIT_COMPONENTS;

/// Mixture components of a rotation head. Its outputs: [`ROTATION_COMPONENTS`] logits of the
/// weights, then for each component three means, then for each component three log deviations, of
/// Gaussian laws over the turn (see [`turn_of`]).
pub const ROTATION_COMPONENTS: usize = 4;

/// Outputs of a rotation head.
pub const ROTATION_OUTPUTS: usize = 7 * ROTATION_COMPONENTS;

/// Bounds of the log scales and log deviations that the heads can say, so that no likelihood runs
/// away where the teacher is nearly deterministic.
pub const LOG_SCALE: std::ops::RangeInclusive<f32> = -4.0..=2.0;

/// A rotation as its turn: the rotation vector from the slot's mean rotation, over its deviations.
///
/// `turn = log(mean⁻¹ · q) / scale`, each component by itself.
///
/// # Units  radians over radians
#[must_use]
pub fn turn_of(rotation: Quat, mean: Quat, scale: Vec3) -> Vec3 {
    let d = mean.inverse() * rotation;
    // The shorter of the two ways round.
    let (w, v) = if d.w < 0.0 { (-d.w, -d.xyz()) } else { (d.w, d.xyz()) };
    let sine = v.length();
    let angle = 2.0 * libm::atan2f(sine, w);
    let per_sine = if sine > 1e-7 { angle / sine } else { 2.0 };
    v * per_sine / scale
}

/// The rotation of a turn: the inverse of [`turn_of`].
#[must_use]
pub fn rotation_of(turn: Vec3, mean: Quat, scale: Vec3) -> Quat {
    (mean * Quat::from_scaled_axis(turn * scale)).normalize()
}
