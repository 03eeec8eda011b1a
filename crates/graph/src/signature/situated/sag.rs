//! How a lateral lies: as its bud stands, and bent by its weight.
//!
//! A bud stands in a plane of the shoot that bears it, at an angle of its own. What grows from it turns
//! down, in the upright plane of its front f, by `σ (1 − |f_y|)`; σ is its *sag*, which the wood that
//! it bears makes and its thickness holds. So of the two numbers of a lateral's front one depends on
//! nothing, and the other neither on that nor on how gravity lies.

use glam::{Quat, Vec3};

/// Least of `1 − |f_y|`, so that there is a sag to every bend.
const LEAST: f32 = 0.01;

/// Fronts whose level part is shorter have no heading.
const VERTICAL: f32 = 1e-6;

/// Sags this many times smaller than usual are told as they are, larger ones by their logarithm.
const FINE: f64 = 100.0;

/// Largest number that a sag is told by.
const MOST: f64 = 20.0;

/// The number that a sag is told by where sags are about `usual` large, `arsinh(100 σ / usual)`: sags
/// scatter over orders of magnitude.
pub fn told(sag: f32, usual: f32) -> f32 {
    libm::asinh(FINE * f64::from(sag) / f64::from(usual)) as f32
}

/// The inverse of [`told`].
pub fn heard(told: f32, usual: f32) -> f32 {
    (libm::sinh(f64::from(told).clamp(-MOST, MOST)) * f64::from(usual) / FINE) as f32
}

/// The frame of what grows from a bud whose frame is this, at an angle about its x and with a sag.
pub(super) fn bent(bud: Quat, angle: f32, sag: f32) -> Quat {
    let straight = bud * Quat::from_rotation_x(angle);
    let front = straight * Vec3::NEG_Z;
    let level = front.cross(Vec3::NEG_Y);
    let sine = level.length();
    // What has overflowed is not bent either.
    let has_heading = sine >= VERTICAL;
    if !has_heading {
        return straight;
    }
    // Neither beyond straight down nor beyond straight up.
    let down = libm::atan2f(sine, -front.y);
    let turn = (sag * steepness(front)).clamp(down - core::f32::consts::PI, down);
    Quat::from_axis_angle(level / sine, turn) * straight
}

/// Angle and sag of what grows from a bud whose frame is this and has this front: the inverse of
/// [`bent`]. In an upright plane of the bud they cannot be told apart; a vertical front can have any
/// heading, and is told with the bud's.
pub(super) fn unbent(bud: Quat, front: Vec3) -> (f32, f32) {
    let (ahead, aside) = (bud * Vec3::NEG_Z, bud * Vec3::Y);
    // What is bent keeps its heading.
    let own = front.with_y(0.0);
    let heading = if own.length() < VERTICAL { ahead.with_y(0.0) } else { own };
    let across = Vec3::new(-heading.z, 0.0, heading.x);
    let (mut sine, mut cosine) = (-ahead.dot(across), aside.dot(across));
    let straight = |sine: f32, cosine: f32| cosine * ahead + sine * aside;
    if straight(sine, cosine).dot(heading) < 0.0 {
        (sine, cosine) = (-sine, -cosine);
    }
    let length = libm::sqrtf(sine * sine + cosine * cosine);
    if length < 1e-9 {
        return (0.0, 0.0);
    }
    let straight = straight(sine / length, cosine / length);
    let sag = (elevation(straight) - elevation(front)) / steepness(straight);
    (libm::atan2f(sine, cosine), sag)
}

fn steepness(front: Vec3) -> f32 {
    (1.0 - front.y.abs()).max(LEAST)
}

/// Angle above the level.
fn elevation(front: Vec3) -> f32 {
    libm::atan2f(front.y, front.with_y(0.0).length())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_shoot_bends_by_its_sag_and_an_upright_one_does_not() {
        // Its front is x, its bud's plane level.
        let level = Quat::from_rotation_y(-core::f32::consts::FRAC_PI_2)
            * Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
        let front = bent(level, 0.0, 0.3) * Vec3::NEG_Z;
        assert!(front.distance(Vec3::new(0.3f32.cos(), -(0.3f32.sin()), 0.0)) < 1e-6, "{front}");
        let upright = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        assert!((bent(upright, 0.0, 0.3) * Vec3::NEG_Z).distance(Vec3::Y) < 1e-6);
        // No sag bends beyond straight down.
        assert!((bent(level, 0.0, 9.0) * Vec3::NEG_Z).distance(Vec3::NEG_Y) < 1e-6);
    }

    #[test]
    fn angle_and_sag_are_found_again() {
        let mut found = 0;
        for i in 0..400 {
            let f = i as f32;
            let bud = Quat::from_rotation_y(f)
                * Quat::from_rotation_x(0.7 * f)
                * Quat::from_rotation_z(0.3 * f);
            let (angle, sag) = (0.3 * (1.3 * f).sin(), 0.2 + 0.2 * (2.1 * f).sin());
            let child = bent(bud, angle, sag);
            let front = child * Vec3::NEG_Z;
            let is_clear = (bud * Vec3::X).y.abs() > 0.05 && front.y.abs() < 0.95;
            let straight = bud * (Quat::from_rotation_x(angle) * Vec3::NEG_Z);
            if !is_clear || straight.y.abs() > 0.95 {
                continue;
            }
            let (a, s) = unbent(bud, front);
            assert!(
                (a - angle).abs() < 1e-4 && (s - sag).abs() < 1e-4,
                "{i}: {a} {angle} {s} {sag}"
            );
            found += 1;
        }
        assert!(found > 200, "{found}");
    }

    #[test]
    fn sags_are_told_and_heard() {
        for sag in [-0.3, 0.0, 1e-6, 2e-3, 0.7] {
            assert!((heard(told(sag, 0.05), 0.05) - sag).abs() <= 1e-6 * sag.abs());
        }
        // arsinh x nears ln 2x.
        assert!((told(0.1, 0.05) - 400f32.ln()).abs() < 1e-4);
        assert!(heard(1e9, 0.05).is_finite());
    }
}
