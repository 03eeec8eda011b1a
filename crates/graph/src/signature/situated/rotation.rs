//! What the swing of a child depends on besides its parent's own features.

use glam::{Quat, Vec2, Vec3};

use super::branching::{BRANCHING_LEN, Branching, TIPS_LEN, put_branching, put_tips};
use super::turn::{Slot, Turn, to_the_vertical};
use super::{log_size, outward_from_axis, outward_from_crown};
use crate::graph::Node;
use crate::plan::Plan;
use crate::signature::{TreeConditions, Writer};

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

/// Up to where a parent's own turn is told as it is, in deviations.
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
    let own_swing = Vec2::new(compressed(own.swing.x), compressed(own.swing.y));
    w.put3(own_swing.extend(own.roll.clamp(-MOST_OWN, MOST_OWN)));
    let frame = node.orientation * slot.unswung(roll);
    let sags = [node.orientation, frame].map(pull);
    let ratio = if sags[0] > 0.02 { (sags[1] / sags[0]).min(3.0) } else { 0.0 };
    w.put(compressed(own.swing.x * ratio));
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

/// A parent's swing in deviations, as it is told: beyond [`MOST_OWN`] by its logarithm, so that what is
/// rare in a tree does not run away when one shoot bends after another.
fn compressed(x: f32) -> f32 {
    let beyond = (x.abs() / MOST_OWN).max(1.0);
    x / beyond * (1.0 + libm::logf(beyond))
}

/// How far a shoot in this frame would sag, but for its biomass and its strength:
/// `(1 − |f_y|) acos |f_y|`.
fn pull(frame: Quat) -> f32 {
    let height = (frame * Vec3::NEG_Z).y.abs().min(1.0);
    (1.0 - height) * libm::acosf(height)
}

/// Mixture components of a rotation head.
pub const ROTATION_COMPONENTS: usize = 4;

/// Outputs of a rotation head, a mixture over the swing (x, y) in deviations of its slot:
///
/// | outputs | what |
/// |---|---|
/// | `K + 1` | logits of the weights: K components, then the aligned law |
/// | `2` | mean and log deviation of x in the aligned law of laterals, where y is 0 |
/// | `K` each | means of x, means of y, log deviations of x, of y, and slopes of y on x |
///
/// In a component `x = μ_x + σ_x ε₁` and `y = μ_y + σ_y (ε₂ + a ε₁)`, with ε normal. The aligned law
/// is for what is exactly so in a tree, an [`Alignment`](super::Alignment): y is 0. Of a shoot that
/// goes straight on x is 0 too; of one that swings about the level axis x has the law that the
/// components give it.
pub const ROTATION_OUTPUTS: usize = ROTATION_COMPONENTS + 1 + 2 + 5 * ROTATION_COMPONENTS;
