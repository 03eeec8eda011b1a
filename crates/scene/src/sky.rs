//! How much of the sky a point sees.

use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

use deeptree_graph::Vec3;

/// How many rays look for the sky.
pub const SKY_RAYS: usize = 48;

/// The sky at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Share of the sky's hemisphere that no obstacle hides: 1 in the open, 0 in a closed room.
    pub free: f32,
    /// The horizontal direction to the free part, a unit vector; none where no side is freer.
    pub toward: Option<Vec3>,
}

impl Sky {
    /// The sky of the open field.
    pub const OPEN: Self = Self { free: 1.0, toward: None };
}

/// Fixed directions, each standing for the same part of the hemisphere.
///
/// Twelve heights cut the hemisphere into belts of the same area; each has four rays a quarter of a
/// turn apart, and each belt is turned on by the golden ratio of a quarter. So the rays of the
/// whole sky add up to exactly nothing sideways, and scenes turned by a quarter see the same sky.
static RAYS: LazyLock<[Vec3; SKY_RAYS]> = LazyLock::new(|| {
    const BELTS: usize = SKY_RAYS / 4;
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    std::array::from_fn(|i| {
        let belt = (i / 4) as f64;
        let y = (belt + 0.5) / BELTS as f64;
        let across = libm::sqrt(1.0 - y * y);
        let part = GOLDEN * (belt + 0.5);
        let azimuth = FRAC_PI_2 * (part - libm::floor(part));
        let (x, z) = ((across * libm::cos(azimuth)) as f32, (across * libm::sin(azimuth)) as f32);
        let y = y as f32;
        [Vec3::new(x, y, z), Vec3::new(-z, y, x), Vec3::new(-x, y, -z), Vec3::new(z, y, -x)][i % 4]
    })
});

/// The sky that is left where `hidden` rays hit something.
pub(crate) fn look(hidden: impl Fn(Vec3) -> bool) -> Sky {
    let (mut free, mut sum) = (0u32, Vec3::ZERO);
    for &ray in RAYS.iter() {
        if !hidden(ray) {
            free += 1;
            sum += ray;
        }
    }
    let sideways = Vec3::new(sum.x, 0.0, sum.z);
    // Less than this is rounding: a single ray has 0.2 or more across.
    let toward = if sideways.length() > 1e-3 { sideways.try_normalize() } else { None };
    Sky { free: free as f32 / SKY_RAYS as f32, toward }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rays_are_unit_vectors_over_the_hemisphere() {
        for ray in RAYS.iter() {
            assert!((ray.length() - 1.0).abs() < 1e-6 && ray.y > 0.0, "{ray}");
            assert!(ray.x.hypot(ray.z) > 0.2);
        }
        // The mean height over a hemisphere is a half, and the mean squares of all three
        // coordinates are a third.
        let mean = |f: fn(&Vec3) -> f32| RAYS.iter().map(f).sum::<f32>() / SKY_RAYS as f32;
        assert!((mean(|r| r.y) - 0.5).abs() < 1e-6);
        for square in [mean(|r| r.x * r.x), mean(|r| r.y * r.y), mean(|r| r.z * r.z)] {
            assert!((square - 1.0 / 3.0).abs() < 2e-3, "{square}");
        }
    }

    #[test]
    fn the_open_sky_has_no_side() {
        assert_eq!(look(|_| false), Sky::OPEN);
        assert_eq!(look(|_| true), Sky { free: 0.0, toward: None });
    }

    #[test]
    fn half_of_the_sky_is_seen_beside_an_endless_wall() {
        let sky = look(|ray| ray.x > 0.0);
        assert_eq!(sky.free, 0.5);
        let toward = sky.toward.unwrap();
        // The mean of half a hemisphere lies along −x, as well as 24 rays tell.
        assert!(toward.x < -0.99, "{toward}");
    }
}
