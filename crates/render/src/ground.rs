//! The level ground that a tree stands on, at y = 0, without end.

use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::ray::Ray;
use crate::sampler::hash;

/// What a tree stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ground {
    /// Nothing.
    None,
    /// Ideally diffuse ground of one albedo, linear.
    Plain(Vec3),
    /// A mown meadow, seen from some metres away; far off, the air hides it.
    Meadow,
}

/// Albedo of grass in the sun and of dry grass between it, linear. Broadband albedo of grassland is
/// 0.15 to 0.25, most of it beyond the visible (Oke 1987, "Boundary Layer Climates").
const GRASS: [Vec3; 2] = [Vec3::new(0.085, 0.125, 0.030), Vec3::new(0.150, 0.150, 0.060)];
/// Sizes of the patches of a meadow, in metres, and how much each matters.
const PATCHES: [(f32, f32); 4] = [(9.0, 0.32), (2.3, 0.28), (0.55, 0.24), (0.12, 0.16)];

impl Ground {
    /// How far along the ray the ground is.
    pub(crate) fn meet(self, ray: &Ray) -> Option<f32> {
        if self == Self::None || ray.direction.y >= 0.0 || ray.origin.y <= 0.0 {
            return None;
        }
        let distance = -ray.origin.y / ray.direction.y;
        (distance < ray.most).then_some(distance)
    }

    /// How the ground scatters light.
    pub(crate) fn bsdf(self, point: Vec3) -> Bsdf {
        let albedo = match self {
            Self::None => Vec3::ZERO,
            Self::Plain(albedo) => albedo,
            Self::Meadow => meadow(point.x, point.z),
        };
        Bsdf { albedo, translucency: 0.0, coat: None }
    }
}

/// Patches of green and dry grass.
fn meadow(x: f32, z: f32) -> Vec3 {
    let patches = PATCHES
        .iter()
        .zip(0..)
        .map(|(&(size, weight), layer)| weight * patch(x / size, z / size, layer));
    let dry = patches.sum::<f32>();
    let fine = patch(x / 0.05, z / 0.05, 9);
    GRASS[0].lerp(GRASS[1], ((dry - 0.25) * 2.0).clamp(0.0, 1.0)) * (0.75 + 0.5 * fine)
}

/// Smooth noise in \[0, 1\] with one draw a unit square.
fn patch(x: f32, z: f32, layer: u32) -> f32 {
    let corner = |i: f32, k: f32| {
        hash(hash(layer, i as i32 as u32), k as i32 as u32) as f32 / u32::MAX as f32
    };
    let (i, k) = (x.floor(), z.floor());
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(x - i), ease(z - k));
    let row = |k: f32| corner(i, k) + (corner(i + 1.0, k) - corner(i, k)) * s;
    row(k) + (row(k + 1.0) - row(k)) * t
}
