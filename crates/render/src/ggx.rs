//! Reflection off a rough dielectric: the microfacet distribution GGX.
//!
//! Directions are in the local frame: z along the shading normal, all of unit length and pointing
//! away from the surface.
//!
//! # Source
//!
//! Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; Heitz 2014,
//! "Understanding the Masking-Shadowing Function"; Heitz 2018, "Sampling the GGX Distribution of
//! Visible Normals".

use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::Vec3;

/// Refractive index of bark and cuticle against air: that of cellulose and wax.
const INDEX: f32 = 1.5;
/// The smoothest surface: below, floats do not resolve the peak.
const MIN_ROUGHNESS: f32 = 0.05;

/// A rough dielectric boundary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ggx {
    roughness: f32,
    alpha: f32,
}

impl Ggx {
    /// The boundary of a perceptual roughness in \[0, 1\]; `α = roughness²` as in glTF.
    pub(crate) fn new(roughness: f32) -> Self {
        let roughness = roughness.clamp(MIN_ROUGHNESS, 1.0);
        Self { roughness, alpha: roughness * roughness }
    }

    /// `f = F D G₂ / (4 cos θo cos θi)`, per steradian; 0 unless both directions are above.
    pub(crate) fn eval(self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let half = (wo + wi).normalize();
        let masking = 1.0 / (1.0 + self.lambda(wo) + self.lambda(wi));
        fresnel(wo.dot(half)) * self.density(half) * masking / (4.0 * wo.z * wi.z)
    }

    /// The density with which [`Ggx::sample`] draws `wi`, per steradian.
    pub(crate) fn pdf(self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let half = (wo + wi).normalize();
        self.density(half) / ((1.0 + self.lambda(wo)) * 4.0 * wo.z)
    }

    /// A direction that light is reflected from towards `wo`; it may be below the surface.
    pub(crate) fn sample(self, wo: Vec3, [u, v]: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.alpha * wo.x, self.alpha * wo.y, wo.z).normalize();
        // A cap of the sphere that is seen from there (Dupuy and Benyoub 2023).
        let z = (1.0 - v) * (1.0 + stretched.z) - stretched.z;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = libm::sincosf(TAU * u);
        let half = Vec3::new(radius * cos, radius * sin, z) + stretched;
        let half = Vec3::new(self.alpha * half.x, self.alpha * half.y, half.z.max(0.0));
        let Some(half) = half.try_normalize() else { return Vec3::new(-wo.x, -wo.y, wo.z) };
        half * (2.0 * wo.dot(half)) - wo
    }

    /// Share of the light from a direction at this cosine that is reflected.
    pub(crate) fn albedo(self, cos: f32) -> f32 {
        TABLES.albedo(cos, self.roughness)
    }

    /// The same of diffuse light.
    pub(crate) fn mean_albedo(self) -> f32 {
        TABLES.mean(self.roughness)
    }

    /// The distribution D of the normals of microfacets.
    fn density(self, half: Vec3) -> f32 {
        let square = self.alpha * self.alpha;
        // Written so that the peak of a smooth surface keeps its digits.
        let t = half.x * half.x + half.y * half.y + square * half.z * half.z;
        square / (PI * t * t)
    }

    /// Smith's Λ: hidden over visible area.
    fn lambda(self, w: Vec3) -> f32 {
        let flat = w.x * w.x + w.y * w.y;
        let slope = self.alpha * self.alpha * flat / (w.z * w.z).max(1e-12);
        0.5 * ((1.0 + slope).sqrt() - 1.0)
    }
}

/// Share of unpolarised light that a smooth boundary reflects, by the cosine outside.
pub(crate) fn fresnel(cos: f32) -> f32 {
    let cos = cos.clamp(0.0, 1.0);
    let inside = (1.0 - (1.0 - cos * cos) / (INDEX * INDEX)).sqrt();
    let parallel = (INDEX * cos - inside) / (INDEX * cos + inside);
    let perpendicular = (cos - INDEX * inside) / (cos + INDEX * inside);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Albedos by cosine and roughness, integrated once.
struct Tables {
    /// `albedo[r][c]`: row r for roughness r/(N−1); column c for the cosine (c/(N−1))².
    albedo: [[f32; Self::N]; Self::N],
    mean: [f32; Self::N],
}

static TABLES: LazyLock<Tables> = LazyLock::new(Tables::new);

impl Tables {
    const N: usize = 32;
    /// Directions of one integral: 16 × 16 strata.
    const STRATA: usize = 16;

    fn new() -> Self {
        let at = |i: usize| i as f32 / (Self::N - 1) as f32;
        let mut tables = Self { albedo: [[0.0; Self::N]; Self::N], mean: [0.0; Self::N] };
        for r in 0..Self::N {
            let ggx = Ggx::new(at(r));
            for c in 0..Self::N {
                tables.albedo[r][c] = integrate(ggx, at(c) * at(c));
            }
            // E̅ = 2 ∫ E(µ) µ dµ of what is looked up, so that what is left is all of the rest.
            const STEPS: usize = 512;
            let mean = (0..STEPS).map(|i| {
                let cos = (i as f32 + 0.5) / STEPS as f32;
                2.0 * tables.albedo(cos, at(r)) * cos / STEPS as f32
            });
            tables.mean[r] = mean.sum();
        }
        tables
    }

    fn albedo(&self, cos: f32, roughness: f32) -> f32 {
        let (c, at) = place(cos.clamp(0.0, 1.0).sqrt());
        let (r, up) = place(roughness);
        let row = |r: usize| self.albedo[r][c] * (1.0 - at) + self.albedo[r][c + 1] * at;
        row(r) * (1.0 - up) + row(r + 1) * up
    }

    fn mean(&self, roughness: f32) -> f32 {
        let (r, up) = place(roughness);
        self.mean[r] * (1.0 - up) + self.mean[r + 1] * up
    }
}

/// The table's entry below a number of \[0, 1\], and how far the number is from it to the next.
fn place(x: f32) -> (usize, f32) {
    let x = x * (Tables::N - 1) as f32;
    let below = (x as usize).min(Tables::N - 2);
    (below, x - below as f32)
}

/// Share of the light from `cos` that is reflected: mean of F G₂/G₁ over visible normals.
fn integrate(ggx: Ggx, cos: f32) -> f32 {
    let cos = cos.max(1e-4);
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let n = Tables::STRATA;
    let one = |i: usize| {
        let u = [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32);
        let wi = ggx.sample(wo, u);
        if wi.z <= 0.0 {
            return 0.0;
        }
        let masking = (1.0 + ggx.lambda(wo)) / (1.0 + ggx.lambda(wo) + ggx.lambda(wi));
        fresnel(wo.dot((wo + wi).normalize())) * masking
    };
    (0..n * n).map(one).sum::<f32>() / (n * n) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(cos: f32, angle: f32) -> Vec3 {
        let sin = (1.0 - cos * cos).sqrt();
        Vec3::new(sin * libm::cosf(angle), sin * libm::sinf(angle), cos)
    }

    /// Midpoint rule over the hemisphere, in steps of equal solid angle.
    fn over_hemisphere(f: impl Fn(Vec3) -> f32) -> f64 {
        let (rows, columns) = (800, 800);
        let mut sum = 0.0;
        for row in 0..rows {
            for column in 0..columns {
                let cos = (row as f32 + 0.5) / rows as f32;
                let angle = TAU * (column as f32 + 0.5) / columns as f32;
                sum += f64::from(f(direction(cos, angle)));
            }
        }
        sum * std::f64::consts::TAU / f64::from(rows * columns)
    }

    #[test]
    fn fresnel_has_the_values_of_glass() {
        // ((n − 1)/(n + 1))² = 0.04; at Brewster's angle one polarisation is left:
        // ½ ((n² − 1)/(n² + 1))² = 0.0740; all light is reflected at 90°.
        assert!((fresnel(1.0) - 0.04).abs() < 1e-6);
        let brewster = 1.0 / (1.0f32 + INDEX * INDEX).sqrt();
        assert!((fresnel(brewster) - 0.5 * (1.25f32 / 3.25).powi(2)).abs() < 1e-5);
        assert!((fresnel(0.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn projected_normals_have_the_area_of_the_surface() {
        // ∫ D(h) cos θ dω = 1 (Walter et al. 2007, Eq. 4).
        for roughness in [0.45, 0.6, 1.0] {
            let ggx = Ggx::new(roughness);
            let area = over_hemisphere(|h| ggx.density(h) * h.z);
            assert!((area - 1.0).abs() < 5e-3, "{roughness}: {area}");
        }
    }

    #[test]
    fn reflection_is_reciprocal_and_gives_out_what_the_tables_say() {
        for roughness in [0.35, 0.6, 1.0] {
            let ggx = Ggx::new(roughness);
            for cos in [0.15, 0.5, 0.95] {
                let wo = direction(cos, 0.3);
                let wi = direction(0.4, 2.0);
                let there = ggx.eval(wo, wi);
                assert!((there - ggx.eval(wi, wo)).abs() <= 1e-5 * there);
                let out = over_hemisphere(|wi| ggx.eval(wo, wi) * wi.z);
                assert!(out <= 1.0);
                let table = f64::from(ggx.albedo(cos));
                assert!((out - table).abs() < 3e-3, "{roughness} {cos}: {out} {table}");
            }
        }
    }

    /// Pearson's chi-square of 40 000 drawn directions against the density in 8 × 16 cells of
    /// equal solid angle.
    #[test]
    fn directions_are_drawn_as_the_density_says() {
        for (roughness, cos) in [(0.4, 0.8), (0.7, 0.3), (1.0, 0.9)] {
            let (ggx, wo) = (Ggx::new(roughness), direction(cos, 1.0));
            let draws = 40_000u32;
            let mut counts = [[0u32; 16]; 8];
            for index in 0..draws {
                // Independent numbers, not a net: chi-square is about those.
                let u = [1, 2].map(|k| {
                    let bits = crate::sampler::hash(crate::sampler::hash(index, k), 77);
                    bits as f32 / 4_294_967_296.0
                });
                let wi = ggx.sample(wo, u.map(|x| x.min(0.999_999_9)));
                if wi.z > 0.0 {
                    let turn = (libm::atan2f(wi.y, wi.x) / TAU).rem_euclid(1.0);
                    counts[((wi.z * 8.0) as usize).min(7)][((turn * 16.0) as usize).min(15)] += 1;
                }
            }
            let (mut chi, mut cells) = (0.0, 0.0);
            for (row, counts) in counts.iter().enumerate() {
                for (column, &seen) in counts.iter().enumerate() {
                    let mut share = 0.0;
                    for i in 0..1024 {
                        let cos = (row as f32 + ((i / 32) as f32 + 0.5) / 32.0) / 8.0;
                        let turn = (column as f32 + ((i % 32) as f32 + 0.5) / 32.0) / 16.0;
                        share += f64::from(ggx.pdf(wo, direction(cos, TAU * turn)));
                    }
                    let expected =
                        share / 1024.0 * std::f64::consts::TAU / 128.0 * f64::from(draws);
                    if expected > 5.0 {
                        chi += (f64::from(seen) - expected).powi(2) / expected;
                        cells += 1.0;
                    }
                }
            }
            // Mean n, variance 2n: five standard deviations.
            assert!(chi < cells + 5.0 * f64::sqrt(2.0 * cells), "{roughness}: {chi} {cells}");
        }
    }
}
