//! Turning a frame towards a direction, or away from it.

use deeptree_graph::{Quat, Vec3};

/// Frames this close to the line of the direction are left alone: within about 8°.
const DEAD_ZONE: f32 = 0.99;

/// Turns `frame` by part `k` of the angle between its front and the line of `direction`.
///
/// `φ = acos |front · n|`; the front turns about `front × n` by `min(φ, k φ)`. So k > 0 turns
/// towards n, k < 0 away from it.
///
/// # Units  `direction` is a unit vector in the frame's parent space
#[must_use]
pub(crate) fn turn(frame: Quat, direction: Vec3, k: f32) -> Quat {
    let front = frame * Vec3::NEG_Z;
    let cosine = front.dot(direction).abs();
    if cosine >= DEAD_ZONE || k == 0.0 {
        return frame;
    }
    let line_angle = libm::acosf(cosine);
    let angle = line_angle.min(k * line_angle);
    match front.cross(direction).try_normalize() {
        Some(axis) => (Quat::from_axis_angle(axis, angle) * frame).normalize(),
        None => frame,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame whose front leans `degrees` from the vertical, and that angle after the turn.
    fn lean_after(degrees: f32, k: f32) -> f32 {
        let upright = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let frame = Quat::from_rotation_z(degrees.to_radians()) * upright;
        (turn(frame, Vec3::NEG_Y, k) * Vec3::NEG_Z).angle_between(Vec3::Y).to_degrees()
    }

    #[test]
    fn negative_gravitropism_halves_a_lean_of_40_degrees_at_minus_one_half() {
        assert!((lean_after(40.0, -0.5) - 20.0).abs() < 1e-3);
    }

    #[test]
    fn positive_gravitropism_droops_by_the_same_part() {
        assert!((lean_after(40.0, 0.25) - 50.0).abs() < 1e-3);
    }

    #[test]
    fn within_8_degrees_of_the_line_nothing_turns() {
        assert!((lean_after(8.0, -0.5) - 8.0).abs() < 1e-3);
        assert!((lean_after(172.0, -0.5) - 172.0).abs() < 1e-3);
    }
}
