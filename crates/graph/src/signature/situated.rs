//! The encoding of kind `situated`: the place of a node told so that a small network can use it.
//!
//! The networks of this kind factor p(children | node) by the chain rule:
//!
//! 1. *existence*: which [`Branching`] the node has, from [`encode`];
//! 2. *split*: how its tips are shared among its children, one [`encode_split`] a decision;
//! 3. *reach*: how long the longest path below each child is, one
//!    [`Question`](super::inheritance::Question) a child;
//! 4. *roll* of the apical child, from a table; then the *swing* of each child, slot by slot, from
//!    [`encode_rotation`].

mod branching;
mod rotation;
pub mod sag;
mod turn;

use glam::{Quat, Vec3};

pub(super) use branching::{BRANCHING_LEN, TIPS_LEN, put_branching, put_tips};
pub use branching::{Branching, CLASSES, SPLIT_COMPONENTS, SPLIT_LEN, SPLIT_OUTPUTS, encode_split};
pub use rotation::{
    ROTATION_COMPONENTS, ROTATION_OUTPUTS, RotationContext, Sibling, encode_rotation, rotation_len,
};
pub use turn::{ALIGNED, Alignment, Slot, Turn, wrapped};

use super::{TreeConditions, Writer, tip_count};
use crate::crowding::{Crowd, Sense};
use crate::graph::Node;
use crate::kin::Kin;
use crate::plan::Plan;
use crate::surround::{NEIGHBOURS, Surround};
use crate::traits::TreeTraits;

/// Tip counts up to this have a one-hot of their own.
const SMALL_TIPS: usize = 16;
/// Reaches up to this have a one-hot of their own; farther ones share the last.
const SMALL_REACH: usize = 15;
/// Nodes beyond the longest path up to this have a one-hot of their own; more share the last.
const SMALL_SURPLUS: usize = 8;
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
        + Kin::NUMBERS
        + (2 + SMALL_TIPS + 1)
        + (1 + SMALL_REACH + 2)
        + (3 + SMALL_SURPLUS + 2)
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
        + SENSE_LEN
        + ENV_LEN
}

/// The crown's centre, its outlook twice, and two crowds of a number and a direction.
const SENSE_LEN: usize = 3 + 3 + 3 + 2 * 4;

/// Z, the shade, and the direction to the light.
const ENV_LEN: usize = NEIGHBOURS + 1 + 3;

/// What [`encode`] writes, in its order, by the paper's symbols without subscripts where it has
/// them; `traits` with the tips of the whole tree, `standing` where it stands among its kin, `n` the node's tips, `reach` the
/// longest path below, `size` all nodes below, `df` the distance to the
/// last fork, `place` height and distance from the axis, `frame` what is told in the node's own
/// frame, `sense` what has grown so far, `env` what stands around.
pub const ATTRIBUTES: [&str; 20] = [
    "s", "a", "v", "traits", "standing", "n", "reach", "size", "ds", "df", "dr", "o", "mp", "slot",
    "qp", "lp", "place", "frame", "sense", "env",
];

/// Where the attribute of this name stands in [`encode`]; none for a name not in [`ATTRIBUTES`].
#[must_use]
pub fn attribute(name: &str, species: usize) -> Option<std::ops::Range<usize>> {
    let distances = [1 + BRANCH_STEPS, 1 + FORK_STEPS, 1 + ROOT_STEPS];
    let widths = [
        species,
        1,
        1,
        1 + TreeTraits::COUNT,
        Kin::NUMBERS,
        2 + SMALL_TIPS + 1,
        1 + SMALL_REACH + 2,
        3 + SMALL_SURPLUS + 2,
        distances[0],
        distances[1],
        distances[2],
        ORDERS,
        3,
        3,
        4,
        1,
        2,
        12,
        SENSE_LEN,
        ENV_LEN,
    ];
    let index = ATTRIBUTES.iter().position(|known| *known == name)?;
    let start = widths[..index].iter().sum();
    Some(start..start + widths[index])
}

/// Encodes one node, with what is to grow below it.
///
/// In order: s, a, v; the tips and traits of the whole tree, and where it stands; ln N, 1/√N and a one-hot of small N;
/// the reach and a one-hot of it; the nodes below, those beyond the longest path with a one-hot, and
/// the nodes by tip; d_s, the distance to the last fork and d_r, each as a number and a
/// one-hot of whole metres; o, m_p and the slot as one-hots; q_p and l_p; height and distance from
/// the axis; gravity (as the height of front, up and right), the position and the outward direction,
/// each in the node's own frame; and what has grown so far and what stands around, their
/// directions also in that frame.
///
/// # Panics
///
/// When `out` is shorter than [`len`].
///
/// # Source
///
/// Eq. 1, with what q_p hides: the global frame, and the distance to the last fork; with the
/// plan that growth follows: traits, tips and reach; and with what the growth model's density and
/// crown centre tell its buds.
pub fn encode(
    node: &Node,
    tree: &TreeConditions,
    plan: Plan,
    sense: &Sense,
    species: usize,
    out: &mut [f32],
) {
    let mut w = Writer { out, at: 0 };
    w.one_hot(tree.species, species);
    w.put(tree.age / 50.0);
    w.put(2.0 * tree.gravitropism);
    put_traits(&mut w, tree);
    tree.standing.into_iter().for_each(|x| w.put(x));

    let tips = tip_count(node.thickness, tree.tip_radius);
    w.put(libm::logf(tips as f32) / 8.0);
    w.put(1.0 / libm::sqrtf(tips as f32));
    w.one_hot(tips as usize - 1, SMALL_TIPS + 1);

    let Plan { reach, nodes } = plan;
    w.put(f32::from(reach) / 32.0);
    w.one_hot(usize::from(reach), SMALL_REACH + 2);
    let surplus = nodes.saturating_sub(u32::from(reach));
    w.put(log_size(nodes));
    w.put(log_size(surplus));
    w.put(libm::logf((1 + nodes) as f32 / tips as f32));
    w.one_hot(surplus as usize, SMALL_SURPLUS + 2);

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

    let radius = node.position.with_y(0.0).length();
    w.put(node.position.y / 32.0);
    w.put(radius / 16.0);
    let own = node.orientation.inverse();
    w.put3(own * Vec3::Y);
    w.put3(own * (node.position / 32.0));
    w.put3(own * outward_from_axis(node.position));
    w.put3(own * outward_from_crown(node.position));
    put_sense(&mut w, sense, node.position, own);
    put_surround(&mut w, &sense.surround, own);
    debug_assert_eq!(w.at, len(species));
}

/// What has grown so far, seen from `position` in the frame whose inverse is `own`.
fn put_sense(w: &mut Writer<'_>, sense: &Sense, position: Vec3, own: Quat) {
    let Sense { centre, outlook, near, wide, .. } = *sense;
    w.put3(own * ((centre - position) / 16.0));
    w.put3(own * ((outlook - position) / 16.0));
    w.put3(own * (outlook.with_y(0.0) / 4.0));
    for (Crowd { nodes, towards }, scale) in [(near, 2.0), (wide, 8.0)] {
        w.put(libm::logf(1.0 + nodes as f32) / 8.0);
        w.put3(own * (towards / scale));
    }
}

/// What stands around, in the frame whose inverse is `own`: all zeros in the open field.
fn put_surround(w: &mut Writer<'_>, surround: &Surround, own: Quat) {
    let Surround { taken, shade, bright } = *surround;
    for place in 0..NEIGHBOURS {
        w.put((taken >> place & 1) as f32);
    }
    w.put(shade);
    w.put3(own * (shade * bright));
}

/// `ln(1 + n) / 8` of a number of nodes.
fn log_size(nodes: u32) -> f32 {
    libm::logf(1.0 + nodes as f32) / 8.0
}

/// Where the tips and traits of the whole tree stand in [`encode`].
#[must_use]
pub const fn traits(species: usize) -> std::ops::Range<usize> {
    species + 2..species + 3 + TreeTraits::COUNT
}

/// Where it stands among its kin in [`encode`], which follows its traits.
#[must_use]
pub const fn standing(species: usize) -> std::ops::Range<usize> {
    let start = traits(species).end;
    start..start + Kin::NUMBERS
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

/// Outward from the trunk; fades out at the axis, where it has no direction.
fn outward_from_axis(position: Vec3) -> Vec3 {
    let distance = Vec3::new(position.x, 0.0, position.z);
    distance / (distance.length() + 0.5)
}

/// Normal scores that tabulated laws reach from and to: beyond, a law has 6 draws in 100 000.
pub const MOST_SCORE: f64 = 4.0;

/// Orders whose edges have a law of length of their own; deeper ones share the last.
pub const LENGTH_ORDERS: usize = 5;

/// Bounds of the log scales and log deviations that the heads can say, so that no likelihood runs
/// away where the teacher is nearly deterministic.
pub const LOG_SCALE: std::ops::RangeInclusive<f32> = -6.0..=2.0;
