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

use glam::{Quat, Vec2, Vec3};

use super::{TreeConditions, Writer, tip_count};
use crate::crowding::{Crowd, Sense};
use crate::graph::{MAX_CHILDREN, Node};
use crate::plan::Plan;
use crate::reach::most_tips;
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
/// them; `traits` with the tips of the whole tree, `n` the node's tips, `reach` the
/// longest path below, `size` all nodes below, `df` the distance to the
/// last fork, `place` height and distance from the axis, `frame` what is told in the node's own
/// frame, `sense` what has grown so far, `env` what stands around.
pub const ATTRIBUTES: [&str; 19] = [
    "s", "a", "v", "traits", "n", "reach", "size", "ds", "df", "dr", "o", "mp", "slot", "qp", "lp",
    "place", "frame", "sense", "env",
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
/// In order: s, a, v; the tips and traits of the whole tree; ln N, 1/√N and a one-hot of small N;
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

/// Normal scores that tabulated laws reach from and to: beyond, a law has 6 draws in 100 000.
pub const MOST_SCORE: f64 = 4.0;

/// Orders whose edges have a law of length of their own; deeper ones share the last.
pub const LENGTH_ORDERS: usize = 5;

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

pub(super) const BRANCHING_LEN: usize = 8 + 4;
pub(super) const TIPS_LEN: usize = 2 + CONTEXT_TIPS + 1;

pub(super) fn put_branching(w: &mut Writer<'_>, branching: Branching) {
    w.one_hot(usize::from(branching.subset), 8);
    w.one_hot(usize::from(branching.dropped), 4);
}

pub(super) fn put_tips(w: &mut Writer<'_>, tips: u32) {
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

/// An earlier sibling as the later ones see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sibling {
    /// Tips it bears.
    pub tips: u32,
    /// Its turn, in deviations of its slot.
    pub turn: Turn,
}

/// Number of features of [`encode_rotation`] for the child in `slot`.
#[must_use]
pub const fn rotation_len(slot: usize) -> usize {
    BRANCHING_LEN + 1 + TIPS_LEN + 4 + 1 + 4 + 3 * 3 + 1 + 3 * 2 + 4 * slot
}

/// What the rotation of a child depends on besides its parent's own features.
#[derive(Clone, Copy, Debug)]
pub struct RotationContext<'a> {
    /// The branching of the parent.
    pub branching: Branching,
    /// Tips the parent bears.
    pub parent_tips: u32,
    /// Tips the child bears.
    pub tips: u32,
    /// Reach of the parent.
    pub parent_reach: u16,
    /// What is to grow below the child.
    pub plan: Plan,
    /// How rotations in the child's slot lie.
    pub slot: Slot,
    /// The child's roll, in deviations of its slot.
    pub roll: f32,
    /// The parent's own turn, in deviations of its own slot: none at the root.
    pub own: Turn,
    /// The siblings in the slots before it.
    pub earlier: &'a [Option<Sibling>],
}

/// How far a parent's own turn is told, in deviations.
const MOST_OWN: f32 = 3.0;

/// Encodes what the swing of a child depends on besides its parent: the branching, its tips, its
/// reach and whether it is as long as a child's can be, the nodes below it, its roll, how the
/// parent itself is turned (what bends a shoot, its biomass above all, bends the next one alike, so
/// its swing is also told as far as the child would sag for it), the siblings before it, and how gravity and light lie for a child that is not swung at
/// all. To follow the node's own features.
///
/// Gravity is told four times: whether the child's front is so near to the vertical that gravity
/// does not turn it, the axis about which it turns to the vertical, that axis times the angle to
/// the vertical, and this times v, which is how far a tropism turns it.
///
/// # Panics
///
/// When `out` is shorter than [`rotation_len`].
pub fn encode_rotation(
    node: &Node,
    tree: &TreeConditions,
    context: &RotationContext<'_>,
    out: &mut [f32],
) {
    let RotationContext {
        branching,
        parent_tips,
        tips,
        parent_reach,
        plan,
        slot,
        roll,
        own,
        earlier,
    } = *context;
    let mut w = Writer { out, at: 0 };
    put_branching(&mut w, branching);
    w.put(tips as f32 / parent_tips as f32);
    put_tips(&mut w, tips);
    w.put(f32::from(plan.reach) / 16.0);
    w.put(f32::from(u8::from(plan.reach + 1 >= parent_reach)));
    w.put(log_size(plan.nodes));
    w.put(libm::logf((1 + plan.nodes) as f32 / tips as f32));
    w.put(roll);
    // What is rare in a tree must not run away when one shoot bends after another.
    let own_swing = own.swing.clamp(-Vec2::splat(MOST_OWN), Vec2::splat(MOST_OWN));
    w.put3(own_swing.extend(own.roll.clamp(-MOST_OWN, MOST_OWN)));
    let frame = node.orientation * slot.unswung(roll);
    let sags = [node.orientation, frame].map(sag);
    let ratio = if sags[0] > 0.02 { (sags[1] / sags[0]).min(3.0) } else { 0.0 };
    w.put((own_swing.x * ratio).clamp(-MOST_OWN, MOST_OWN));
    let into = frame.inverse();
    w.put3(into * Vec3::Y);
    w.put3(into * outward_from_axis(node.position));
    w.put3(into * outward_from_crown(node.position));
    let (axis, angle) = to_the_vertical(frame);
    w.put(f32::from(u8::from(axis == Vec2::ZERO)));
    for factor in [1.0, angle, 4.0 * tree.gravitropism * angle] {
        w.put(factor * axis.x);
        w.put(factor * axis.y);
    }
    for sibling in earlier {
        let (tips, turn) = sibling.map_or((1, Turn::default()), |s| (s.tips, s.turn));
        w.put(libm::logf(tips as f32) / 8.0);
        w.put3(turn.swing.extend(turn.roll));
    }
    debug_assert_eq!(w.at, rotation_len(earlier.len()));
}

/// The axis, in the frame's own x and y, about which its front turns down to or up from the
/// vertical, and the angle between front and vertical, in radians; none when it is vertical.
fn to_the_vertical(frame: Quat) -> (Vec2, f32) {
    let front = frame * Vec3::NEG_Z;
    let across = front.cross(Vec3::NEG_Y);
    let sine = across.length();
    // Within eight degrees of the vertical, growth does not bend.
    if front.y.abs() >= 0.99 {
        return (Vec2::ZERO, 0.0);
    }
    let axis = frame.inverse() * (across / sine);
    (axis.truncate(), libm::atan2f(sine, front.y.abs()))
}

/// How far a shoot in this frame would sag, but for its biomass and its strength:
/// `(1 − |f_y|) acos |f_y|`.
fn sag(frame: Quat) -> f32 {
    let height = (frame * Vec3::NEG_Z).y.abs().min(1.0);
    (1.0 - height) * libm::acosf(height)
}

/// Outward from the trunk; fades out at the axis, where it has no direction.
fn outward_from_axis(position: Vec3) -> Vec3 {
    let distance = Vec3::new(position.x, 0.0, position.z);
    distance / (distance.length() + 0.5)
}

/// Mixture components of the split head. Its outputs: weights' logits, means and log scales of
/// logistic laws over the logit of the share, each [`SPLIT_COMPONENTS`] long.
pub const SPLIT_COMPONENTS: usize = 3;

/// Outputs of the split head.
pub const SPLIT_OUTPUTS: usize = 3 * SPLIT_COMPONENTS;

/// Mixture components of a rotation head.
pub const ROTATION_COMPONENTS: usize = 4;

/// Outputs of a rotation head, a mixture over the swing (x, y) in deviations of its slot:
///
/// | outputs | what |
/// |---|---|
/// | `K + 1` | logits of the weights: K components, then the aligned law |
/// | `2` | mean and log deviation of x in the aligned law, where y is 0 |
/// | `K` each | means of x, means of y, log deviations of x, of y, and slopes of y on x |
///
/// In a component `x = μ_x + σ_x ε₁` and `y = μ_y + σ_y (ε₂ + a ε₁)`, with ε normal. The aligned law
/// is for what is exactly so in a tree: a shoot that goes straight on, for slot 0, where x is 0
/// too; and a lateral that nothing has bent yet, which lies in the plane of its bud.
pub const ROTATION_OUTPUTS: usize = ROTATION_COMPONENTS + 1 + 2 + 5 * ROTATION_COMPONENTS;

/// Swings below this are none, in radians: above what rounding makes of none.
pub const ALIGNED: f32 = 1e-5;

/// Bounds of the log scales and log deviations that the heads can say, so that no likelihood runs
/// away where the teacher is nearly deterministic.
pub const LOG_SCALE: std::ops::RangeInclusive<f32> = -6.0..=2.0;

/// A rotation as a roll about the parent's front and a swing of the front, both against what is
/// usual in its slot, in its deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// Rotation vector of the swing; it has no component along the front.
    pub swing: Vec2,
    /// Roll; 0 for laterals, whose bud has its place on the shoot.
    pub roll: f32,
}

/// How the rotations in a slot lie: `q = R_z(roll) · exp(mean swing) · exp(swing)`, the swing told off
/// what gravity makes expect of an apical shoot.
///
/// A shoot is rolled about its parent's front, then bent. Told so, the roll depends on nothing, and
/// the swing of one axis on nothing but the shoot's own angle.
///
/// # Units  radians
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// Mean swing.
    pub mean: Vec2,
    /// Centre of the roll, in [−3π/2, π/2): rolls go round as in the growth model, so that the
    /// quaternions have its signs.
    pub roll: f32,
    /// Deviations of the swing.
    pub scale: Vec2,
    /// Deviation of the roll; 0 for laterals.
    pub roll_scale: f32,
}

impl Slot {
    /// A slot where nothing is usual: swings and rolls are what they are.
    pub const PLAIN: Self = Self { mean: Vec2::ZERO, roll: 0.0, scale: Vec2::ONE, roll_scale: 1.0 };

    /// The rotation of a turn, below this parent.
    #[must_use]
    pub fn rotation(&self, turn: Turn, parent: &Node, gravitropism: f32) -> Quat {
        let unswung = self.unswung(turn.roll);
        let bend = self.bend(parent.orientation * unswung, gravitropism);
        (unswung * swing(bend.out(turn.swing * self.scale))).normalize()
    }

    /// The turn of a rotation: the inverse of [`Slot::rotation`], up to the roll of a lateral, which
    /// is lost. The child's front is always kept.
    #[must_use]
    pub fn turn(&self, rotation: Quat, parent: &Node, gravitropism: f32) -> Turn {
        let (roll, swing) = self.split(rotation);
        let bend = self.bend(parent.orientation * self.unswung(roll), gravitropism);
        Turn { swing: bend.own(swing) / self.scale, roll }
    }

    /// The rotation of a child that is not swung off its slot's mean.
    fn unswung(&self, roll: f32) -> Quat {
        Quat::from_rotation_z(self.roll + self.roll_scale * roll) * swing(self.mean)
    }

    /// The roll in deviations, and the swing off the mean in radians.
    #[must_use]
    pub fn split(&self, rotation: Quat) -> (f32, Vec2) {
        if self.is_lateral() {
            let front = self.unswung(0.0).inverse() * rotation * Vec3::NEG_Z;
            return (0.0, swing_of(Quat::from_rotation_arc(Vec3::NEG_Z, front)));
        }
        // The roll for which what is left has no component along the front.
        let mean = swing(self.mean);
        let about_front = Quat::from_xyzw(0.0, 0.0, 1.0, 0.0);
        let (across, along) = (mean.inverse() * rotation, mean.inverse() * about_front * rotation);
        let roll = 2.0 * libm::atan2f(across.z, along.z);
        let rest = mean.inverse() * Quat::from_rotation_z(-roll) * rotation;
        (wrapped(roll - self.roll) / self.roll_scale, swing_of(rest))
    }

    /// Is this turn of the child in `slot` exactly aligned: an apical shoot that goes straight on, or
    /// a lateral in the plane of its bud?
    #[must_use]
    pub fn is_aligned(&self, slot: usize, turn: Turn) -> bool {
        let swing = turn.swing * self.scale;
        if slot == 0 { swing.length() < ALIGNED } else { swing.y.abs() < ALIGNED }
    }

    fn is_lateral(&self) -> bool {
        self.roll_scale == 0.0
    }

    /// What a child of this unswung frame is expected to do.
    fn bend(&self, frame: Quat, gravitropism: f32) -> Bend {
        let (axis, angle) = to_the_vertical(frame);
        if self.is_lateral() || axis == Vec2::ZERO {
            return Bend { expected: Vec2::ZERO, x: Vec2::X };
        }
        let is_straight = self.mean == Vec2::ZERO;
        Bend { expected: gravitropism * angle * axis, x: if is_straight { axis } else { Vec2::X } }
    }
}

/// The swing that gravity makes expect, and the axis that swings are told along.
///
/// An apical shoot turns by v times its angle to the vertical, so its swing is told off that. Where
/// shoots have no angle of their own (no mean swing) nothing but gravity bends them, so the swing is
/// told along the axis of that bend and across.
#[derive(Clone, Copy)]
struct Bend {
    expected: Vec2,
    x: Vec2,
}

impl Bend {
    fn own(self, swing: Vec2) -> Vec2 {
        let off = swing - self.expected;
        Vec2::new(off.dot(self.x), off.dot(self.x.perp()))
    }

    fn out(self, own: Vec2) -> Vec2 {
        self.expected + own.x * self.x + own.y * self.x.perp()
    }
}

/// The angle in [−π, π).
#[must_use]
pub fn wrapped(angle: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    angle - TAU * libm::floorf((angle + PI) / TAU)
}

fn swing(vector: Vec2) -> Quat {
    Quat::from_scaled_axis(vector.extend(0.0))
}

fn swing_of(q: Quat) -> Vec2 {
    // The shorter of the two ways round.
    let (w, v) = if q.w < 0.0 { (-q.w, -q.xyz().truncate()) } else { (q.w, q.xyz().truncate()) };
    let sine = v.length();
    let angle = 2.0 * libm::atan2f(sine, w);
    let per_sine = if sine > 1e-7 { angle / sine } else { 2.0 };
    v * per_sine
}
