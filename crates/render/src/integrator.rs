//! The light that comes along a ray: path tracing.
//!
//! # Source
//!
//! Kajiya 1986, "The Rendering Equation"; Veach 1997, "Robust Monte Carlo Methods for Light
//! Transport Simulation" (multiple importance sampling, Russian roulette).

use glam::Vec3;

use crate::ground::Ground;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::{Label, Scene, Surface};
use crate::tone::luminance;

/// Paths this long or longer may end by chance.
const ROULETTE: u32 = 3;
/// Distance beyond the trees at which the air hides all but 1/e of the ground, in metres: as on a
/// hazy morning, so that the horizon is soft.
const VISIBILITY: f32 = 200.0;

/// What a ray of the camera brings.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// Radiance, where there is something to see.
    pub(crate) color: Vec3,
    /// 1 where there is something to see; 0 where the picture's background shows.
    pub(crate) alpha: f32,
    /// Share of the light that the tree keeps from the ground, where that is not seen itself.
    pub(crate) shadow: f32,
}

/// How paths are traced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Integrator<'a> {
    pub(crate) scene: &'a Scene<'a>,
    /// Surfaces a path may meet.
    pub(crate) depth: u32,
    /// Are sky and ground seen, or only what they do to the tree?
    pub(crate) sees_surroundings: bool,
}

impl std::fmt::Debug for Scene<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Scene({:?})", self.ground)
    }
}

impl Integrator<'_> {
    /// What the camera sees along a ray.
    pub(crate) fn see(&self, ray: &Ray, sampler: &mut Sampler) -> Seen {
        let first = self.scene.meet(ray);
        if !self.sees_surroundings {
            return match first {
                Some(surface) if surface.label != Label::Ground => {
                    Seen { color: self.follow(*ray, surface, sampler), alpha: 1.0, shadow: 0.0 }
                }
                Some(ground) => Seen { shadow: self.shadow(&ground, sampler), ..Seen::default() },
                None => Seen::default(),
            };
        }
        let light = &self.scene.light;
        let color = match first {
            None => light.dome(ray.direction) + light.sun(ray.direction).unwrap_or_default(),
            Some(surface) => {
                let color = self.follow(*ray, surface, sampler);
                match (surface.label, self.scene.ground) {
                    (Label::Ground, Ground::Meadow) => self.haze(ray, &surface, color),
                    _ => color,
                }
            }
        };
        Seen { color, alpha: 1.0, shadow: 0.0 }
    }

    /// Radiance along a ray that meets `surface`.
    fn follow(&self, mut ray: Ray, mut surface: Surface, sampler: &mut Sampler) -> Vec3 {
        let light = &self.scene.light;
        let (mut radiance, mut throughput) = (Vec3::ZERO, Vec3::ONE);
        for depth in 1..=self.depth {
            let wo = surface.to_local(-ray.direction);
            radiance += throughput * self.direct(&surface, wo, sampler);

            // Go on in a direction that much light may come from.
            let drawn = surface.bsdf.sample(wo, sampler.one(), sampler.pair());
            let survival = sampler.one();
            let Some(drawn) = drawn else { break };
            let direction = surface.to_world(drawn.wi);
            if !surface.agrees(direction, drawn.wi) {
                break;
            }
            throughput *= drawn.weight;
            ray = surface.leave(direction);
            let Some(next) = self.scene.meet(&ray) else {
                let weight = power(drawn.pdf, light.pdf(direction));
                let beyond = light.dome(direction) + light.sun(direction).unwrap_or_default();
                radiance += throughput * beyond * weight;
                break;
            };
            surface = next;
            if depth >= ROULETTE {
                let chance = throughput.max_element().min(0.95);
                if survival >= chance {
                    break;
                }
                throughput /= chance;
            }
        }
        radiance
    }

    /// Radiance that goes to `wo` of what comes straight from sun and sky, by a drawn direction of
    /// theirs.
    fn direct(&self, surface: &Surface, wo: Vec3, sampler: &mut Sampler) -> Vec3 {
        let drawn = self.scene.light.sample(sampler.one(), sampler.pair());
        let wi = surface.to_local(drawn.direction);
        if drawn.pdf <= 0.0 || !surface.agrees(drawn.direction, wi) {
            return Vec3::ZERO;
        }
        let scattered = surface.bsdf.eval(wo, wi) * wi.z.abs();
        if scattered == Vec3::ZERO || !self.scene.is_free(&surface.leave(drawn.direction)) {
            return Vec3::ZERO;
        }
        let weight = power(drawn.pdf, surface.bsdf.pdf(wo, wi));
        scattered * drawn.radiance * (weight / drawn.pdf)
    }

    /// Share of the light on the open ground that the tree keeps from here.
    ///
    /// Only the blocked light is counted, so that open ground is free of noise.
    fn shadow(&self, ground: &Surface, sampler: &mut Sampler) -> f32 {
        let drawn = self.scene.light.sample(sampler.one(), sampler.pair());
        let cos = drawn.direction.y;
        if cos <= 0.0 || !self.scene.is_shaded(&ground.leave(drawn.direction)) {
            return 0.0;
        }
        // All light on open ground is π.
        luminance(drawn.radiance) * cos / (drawn.pdf * std::f32::consts::PI)
    }

    /// A meadow's radiance behind the air before it, which is clear as far as there are trees.
    fn haze(&self, ray: &Ray, ground: &Surface, color: Vec3) -> Vec3 {
        let beyond = (ground.point - ray.origin).length() - self.scene.farthest(ray.origin);
        let clear = libm::expf(-beyond.max(0.0) / VISIBILITY);
        let level = Vec3::new(ray.direction.x, 0.02, ray.direction.z).normalize_or(Vec3::X);
        color * clear + self.scene.light.dome(level) * (1.0 - clear)
    }
}

/// Veach's power heuristic, β = 2: the weight of a draw of density `own`.
fn power(own: f32, other: f32) -> f32 {
    // Of ratios, since squares of large densities overflow.
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}
