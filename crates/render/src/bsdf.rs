//! How a surface scatters light: a rough dielectric boundary over a diffuse body, which may let
//! light through.
//!
//! With the share E of the light that the boundary reflects ([`Ggx::albedo`]) and E̅ its mean over
//! diffuse light, ρ the body's albedo and t its translucency:
//!
//! ```text
//! reflected:    f = f_ggx + (1 − t) ρ (1 − E(θo)) (1 − E(θi)) / (π (1 − E̅))
//! transmitted:  f =              t  ρ (1 − E(θo)) (1 − E(θi)) / (π (1 − E̅))
//! ```
//!
//! It is reciprocal, and with ρ = 1 all light comes out again, whatever t and the roughness.
//!
//! # Source
//!
//! Kelemen and Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model";
//! translucency as in the glTF extension `KHR_materials_diffuse_transmission`.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;

use crate::ggx::Ggx;

/// The scattering of one point. Directions are local: z along the shading normal on the side that
/// is looked at, unit length, away from the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bsdf {
    /// ρ, linear.
    pub(crate) albedo: Vec3,
    /// t.
    pub(crate) translucency: f32,
    /// The boundary; none for an ideally diffuse surface.
    pub(crate) coat: Option<Ggx>,
}

/// A direction that was drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scattered {
    pub(crate) wi: Vec3,
    /// `f |cos θi| / pdf`.
    pub(crate) weight: Vec3,
    /// Per steradian.
    pub(crate) pdf: f32,
}

impl Bsdf {
    /// `f(wo, wi)`, per steradian, without the cosine.
    pub(crate) fn eval(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        if wo.z <= 0.0 || wi.z == 0.0 {
            return Vec3::ZERO;
        }
        let share = if wi.z > 0.0 { 1.0 - self.translucency } else { self.translucency };
        let body = self.albedo * (share * FRAC_1_PI);
        match self.coat {
            None => body,
            Some(coat) => {
                let passed = (1.0 - coat.albedo(wo.z)) * (1.0 - coat.albedo(wi.z.abs()));
                body * (passed / (1.0 - coat.mean_albedo())) + coat.eval(wo, wi)
            }
        }
    }

    /// The density with which [`Bsdf::sample`] draws `wi`, per steradian.
    pub(crate) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z == 0.0 {
            return 0.0;
        }
        let mirror = self.mirror_share(wo);
        let side = if wi.z > 0.0 { 1.0 - self.translucency } else { self.translucency };
        let body = (1.0 - mirror) * side * wi.z.abs() * FRAC_1_PI;
        body + mirror * self.coat.map_or(0.0, |coat| coat.pdf(wo, wi))
    }

    /// Draws a direction that light comes from; `lobe` chooses how it is scattered.
    pub(crate) fn sample(&self, wo: Vec3, lobe: f32, u: [f32; 2]) -> Option<Scattered> {
        let mirror = self.mirror_share(wo);
        let wi = match self.coat {
            Some(coat) if lobe < mirror => coat.sample(wo, u),
            _ => {
                let through = (lobe - mirror) / (1.0 - mirror) < self.translucency;
                let up = cosine_hemisphere(u);
                if through { Vec3::new(up.x, up.y, -up.z) } else { up }
            }
        };
        let pdf = self.pdf(wo, wi);
        // A mirrored direction may lie below the surface: that light is absorbed.
        let below = lobe < mirror && wi.z <= 0.0;
        if below || pdf <= 0.0 {
            return None;
        }
        Some(Scattered { wi, weight: self.eval(wo, wi) * (wi.z.abs() / pdf), pdf })
    }

    /// How often the boundary's reflection is drawn: its share of all light that comes out.
    fn mirror_share(&self, wo: Vec3) -> f32 {
        let Some(coat) = self.coat else { return 0.0 };
        let mirrored = coat.albedo(wo.z.max(0.0));
        let body = (1.0 - mirrored) * self.albedo.max_element();
        (mirrored / (mirrored + body).max(1e-6)).clamp(0.05, 0.95)
    }
}

/// A direction above, by the cosine.
fn cosine_hemisphere([u, v]: [f32; 2]) -> Vec3 {
    let (sin, cos) = libm::sincosf(TAU * u);
    let radius = v.sqrt();
    Vec3::new(radius * cos, radius * sin, (1.0 - v).max(1e-8).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;
    use deeptree_graph::Seed;

    fn all() -> Vec<Bsdf> {
        let mut all = Vec::new();
        for roughness in [None, Some(0.3), Some(0.6), Some(1.0)] {
            for translucency in [0.0, 0.4, 1.0] {
                let coat = roughness.map(Ggx::new);
                all.push(Bsdf { albedo: Vec3::ONE, translucency, coat });
            }
        }
        all
    }

    fn direction(cos: f32) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    /// The white furnace: under the same light from everywhere, what absorbs nothing is as bright
    /// as the light.
    #[test]
    fn what_absorbs_nothing_gives_all_light_out() {
        for bsdf in all() {
            for cos in [0.1, 0.4, 0.7, 1.0] {
                let draws = 8192;
                let sum: Vec3 = (0..draws)
                    .filter_map(|index| {
                        let mut sampler = Sampler::new(Seed(1), 0, 0, index);
                        bsdf.sample(direction(cos), sampler.one(), sampler.pair())
                    })
                    .map(|scattered| scattered.weight)
                    .sum();
                let out = sum.x / draws as f32;
                assert!((out - 1.0).abs() < 0.01, "{bsdf:?} {cos}: {out}");
            }
        }
    }

    #[test]
    fn scattering_is_reciprocal() {
        for bsdf in all() {
            for (a, b) in [(0.2, 0.9), (0.5, 0.6)] {
                let (a, b) = (direction(a), Vec3::new(0.0, f32::sqrt(1.0 - b * b), b));
                let there = bsdf.eval(a, b);
                assert!((there - bsdf.eval(b, a)).length() <= 1e-5 * there.length());
                // Through the surface: each direction is seen from its own side.
                let flip = |w: Vec3| Vec3::new(w.x, w.y, -w.z);
                let there = bsdf.eval(a, flip(b));
                assert!((there - bsdf.eval(b, flip(a))).length() <= 1e-5 * there.length());
            }
        }
    }

    #[test]
    fn densities_are_of_all_directions() {
        for bsdf in all() {
            let wo = direction(0.6);
            let (rows, columns) = (600, 300);
            let mut sum = 0.0;
            for row in 0..rows {
                for column in 0..columns {
                    let z = 2.0 * (row as f32 + 0.5) / rows as f32 - 1.0;
                    let (sin, cos) = libm::sincosf(TAU * (column as f32 + 0.5) / columns as f32);
                    let flat = (1.0 - z * z).sqrt();
                    sum += f64::from(bsdf.pdf(wo, Vec3::new(flat * cos, flat * sin, z)));
                }
            }
            let whole = sum * 2.0 * std::f64::consts::TAU / f64::from(rows * columns);
            // What the boundary mirrors below the surface is missing.
            assert!(whole < 1.005 && whole > 0.93, "{bsdf:?}: {whole}");
            if bsdf.coat.is_none() {
                assert!((whole - 1.0).abs() < 1e-3, "{bsdf:?}: {whole}");
            }
        }
    }

    #[test]
    fn a_drawn_direction_has_the_density_and_weight_that_are_asked_for() {
        for bsdf in all() {
            let wo = direction(0.5);
            for index in 0..500 {
                let mut sampler = Sampler::new(Seed(2), 1, 1, index);
                let Some(drawn) = bsdf.sample(wo, sampler.one(), sampler.pair()) else { continue };
                assert!((drawn.wi.length() - 1.0).abs() < 1e-4);
                assert_eq!(drawn.pdf, bsdf.pdf(wo, drawn.wi));
                let weight = bsdf.eval(wo, drawn.wi) * drawn.wi.z.abs() / drawn.pdf;
                assert!((drawn.weight - weight).length() <= 1e-5 * weight.length());
            }
        }
    }
}
