//! Rotations as a roll and a swing off what is usual in a slot.

use glam::{Quat, Vec2, Vec3};

use super::sag;
use crate::graph::Node;

/// Swings below this are none, in radians: above what rounding makes of none.
pub const ALIGNED: f32 = 1e-5;

/// Up to here is the level part of the normal of a plane that is taken for upright. What leaves such a
/// plane of a bud does so for other reasons than its weight, and is told as a sag as many times larger as
/// this goes into 1.
const UPRIGHT: f32 = 1e-4;

/// A rotation as a roll about the parent's front and a swing of the front, both against what is
/// usual in its slot, in its deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// Rotation vector of the swing; it has no component along the front. Of a lateral, its angle in
    /// the plane of its bud, and what its [`sag`] is told by.
    pub swing: Vec2,
    /// Roll; 0 for laterals, whose bud has its place on the shoot.
    pub roll: f32,
}

/// What is exactly so of some swings in a tree, and has a law of its own beside that of the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alignment {
    /// An apical shoot goes straight on: both components of its swing are 0.
    Straight,
    /// An apical shoot that nothing but gravity bends swings about the level axis: y is 0.
    Gravity,
    /// A lateral that nothing has bent yet lies in the plane of its bud: y is 0.
    Bud,
}

/// How the rotations in a slot lie: `q = R_z(roll) · exp(mean swing) · exp(swing)`, the swing told off
/// what gravity makes expect of an apical shoot.
///
/// A lateral is bent by its [`sag`] instead of the last of these.
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
    /// Deviations of the swing; of a lateral, that of its angle, and how large sags usually are (their
    /// root mean square).
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
        if self.is_lateral() {
            let angle = turn.swing.x * self.scale.x;
            let sag = sag::heard(turn.swing.y, self.scale.y);
            let bud = parent.orientation * unswung;
            if sag == 0.0 || is_upright(bud) {
                return (unswung * swing(Vec2::new(angle, UPRIGHT * sag))).normalize();
            }
            return (parent.orientation.inverse() * sag::bent(bud, angle, sag)).normalize();
        }
        let bend = self.bend(parent.orientation * unswung, gravitropism);
        (unswung * swing(bend.out(turn.swing * self.scale))).normalize()
    }

    /// The turn of a rotation: the inverse of [`Slot::rotation`], up to the roll of a lateral, which
    /// is lost. The child's front is always kept.
    #[must_use]
    pub fn turn(&self, rotation: Quat, parent: &Node, gravitropism: f32) -> Turn {
        let (roll, swing) = self.split(rotation);
        if self.is_lateral() {
            let bud = parent.orientation * self.unswung(0.0);
            let (angle, sag) = if swing.y.abs() < ALIGNED {
                (swing.x, 0.0)
            } else if is_upright(bud) {
                (swing.x, swing.y / UPRIGHT)
            } else {
                sag::unbent(bud, parent.orientation * rotation * Vec3::NEG_Z)
            };
            let told = sag::told(sag, self.scale.y);
            return Turn { swing: Vec2::new(angle / self.scale.x, told), roll: 0.0 };
        }
        let bend = self.bend(parent.orientation * self.unswung(roll), gravitropism);
        Turn { swing: bend.own(swing) / self.scale, roll }
    }

    /// The rotation of a child that is not swung off its slot's mean.
    pub(super) fn unswung(&self, roll: f32) -> Quat {
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

    /// How a child that is rolled so, below this parent, can be exactly aligned: about the level axis
    /// where shoots have no angle of their own and gravity has an axis to bend them about.
    #[must_use]
    pub fn alignment(&self, roll: f32, parent: &Node) -> Alignment {
        if self.is_lateral() {
            return Alignment::Bud;
        }
        let (axis, _) = to_the_vertical(parent.orientation * self.unswung(roll));
        let is_bent_by_gravity_alone = self.mean == Vec2::ZERO && axis != Vec2::ZERO;
        if is_bent_by_gravity_alone { Alignment::Gravity } else { Alignment::Straight }
    }

    /// Is this turn exactly aligned?
    #[must_use]
    pub fn is_aligned(&self, alignment: Alignment, turn: Turn) -> bool {
        let swing = turn.swing * self.scale;
        match alignment {
            Alignment::Straight => swing.length() < ALIGNED,
            Alignment::Gravity => swing.y.abs() < ALIGNED,
            Alignment::Bud => turn.swing.y == 0.0,
        }
    }

    /// Does what grows here, below this parent, stand at its bud's own angle, whatever it sags?
    #[must_use]
    pub fn shows_bud(&self, parent: &Node) -> bool {
        self.is_lateral() && !is_upright(parent.orientation * self.unswung(0.0))
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

/// The axis, in the frame's own x and y, about which its front turns down to or up from the
/// vertical, and the angle between front and vertical, in radians; none when it is vertical.
pub(super) fn to_the_vertical(frame: Quat) -> (Vec2, f32) {
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

/// Does the plane of a bud hide what its shoot sags?
fn is_upright(bud: Quat) -> bool {
    (bud * Vec3::X).y.abs() < UPRIGHT
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
