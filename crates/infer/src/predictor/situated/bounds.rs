//! Shoots that would leave the volume that growth is kept in.

use core::f32::consts::{FRAC_PI_2, TAU};

use deeptree_graph::{Draws, Quat, Vec3};

/// Circles around the drawn direction that are tried, up to a right angle.
const CIRCLES: u32 = 9;
/// Directions that are tried on each.
const SPOKES: u32 = 8;

/// A child's rotation, turned as little as leads to where the child may be: first by 10° to one of
/// eight sides, in an order that starts at a random one, then by 20°, and so on. None where not even
/// a right angle does.
pub(super) fn turned(
    rotation: Quat,
    draws: &mut Draws,
    is_free: impl Fn(Quat) -> bool,
) -> Option<Quat> {
    let start = draws.uniform() as f32;
    (1..=CIRCLES).find_map(|circle| {
        let angle = FRAC_PI_2 * circle as f32 / CIRCLES as f32;
        (0..SPOKES).find_map(|spoke| {
            let side = TAU * (start + spoke as f32 / SPOKES as f32);
            let axis = Vec3::new(libm::cosf(side), libm::sinf(side), 0.0);
            let turned = (rotation * Quat::from_axis_angle(axis, angle)).normalize();
            is_free(turned).then_some(turned)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    fn front(rotation: Quat) -> Vec3 {
        rotation * Vec3::NEG_Z
    }

    #[test]
    fn before_a_wall_a_shoot_turns_about_as_little_as_it_can() {
        // A shoot of 1 m that heads for a wall at a right angle must turn by acos(distance).
        let heading = Quat::from_rotation_x(0.4) * Quat::from_rotation_y(1.3);
        let wall = front(heading);
        for seed in 0..200 {
            let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::ChildRotation);
            let distance = 0.05 + 0.9 * draws.uniform() as f32;
            let turned = turned(heading, &mut draws, |q| front(q).dot(wall) <= distance).unwrap();
            let angle = front(turned).angle_between(wall).to_degrees();
            let least = distance.acos().to_degrees();
            assert!((least - 1e-3..least + 10.1).contains(&angle), "{seed}: {angle} of {least}");
            assert!(turned.is_normalized());
        }
    }

    #[test]
    fn all_sides_are_as_likely_where_all_are_free() {
        let mut sum = Vec3::ZERO;
        for seed in 0..4000 {
            let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::ChildRotation);
            sum += front(turned(Quat::IDENTITY, &mut draws, |_| true).unwrap());
        }
        // Of unit steps of sin 10° in random directions: five standard errors.
        assert!(sum.truncate().length() < 5.0 * 0.174 * 4000f32.sqrt(), "{sum}");
    }

    #[test]
    fn without_a_way_out_there_is_none() {
        let mut draws = Seed(1).draws(Lineage::ROOT, Purpose::ChildRotation);
        assert_eq!(turned(Quat::IDENTITY, &mut draws, |_| false), None);
        let back = |q: Quat| front(q).z > 0.1;
        assert_eq!(turned(Quat::IDENTITY, &mut draws, back), None);
    }
}
