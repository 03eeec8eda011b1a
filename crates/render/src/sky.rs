//! The colours of a clear sky and of the sun behind the same air.
//!
//! # Source
//!
//! Preetham, Shirley and Smits 1999, "A Practical Analytic Model for Daylight": luminance of the sky
//! (their appendix A.2), transmittance of the air (A.1). Henyey and Greenstein 1941: the phase
//! function of haze. Kasten and Young 1989: airmass. IES Lighting Handbook, clear sky: what the sky
//! sheds on level ground.
//! Deviation: Preetham's luminances are scaled to the IES's illuminance, since they are up to twice
//! that; his chromaticities, which make the horizon pink, are not used: the colour is that of sunlight
//! scattered once by as much air as there is in a direction, which is blue above and pale at the
//! horizon. Below the lowest degree the horizon's colour goes on.

use std::f32::consts::PI;

use glam::Vec3;

use crate::tone::luminance;

/// Luminous irradiance of the sun above the air, in the unit of the sky: kcd/m² · sr.
const SOLAR: f32 = 128.0;
/// What wavelengths stand for red, green and blue, in µm.
const WAVELENGTHS: [f32; 3] = [0.61, 0.55, 0.455];
/// Absorption of ozone there, per cm.
const OZONE: [f32; 3] = [0.12, 0.085, 0.004];
/// Thickness of the ozone layer, in cm.
const OZONE_LAYER: f32 = 0.35;

/// No part of a clear sky is darker, in kcd/m².
const LEAST: f32 = 0.3;

/// A clear sky.
#[derive(Clone, Debug)]
pub(crate) struct ClearSky {
    /// Unit vector towards the sun.
    pub(crate) sun: Vec3,
    turbidity: f32,
    /// Perez's five parameters.
    perez: [f32; 5],
    /// Luminance in kcd/m² over Perez's function.
    zenith: f32,
}

impl ClearSky {
    /// The sky with the sun at `sun`; turbidity 2 is very clear, 6 is hazy.
    pub(crate) fn new(sun: Vec3, turbidity: f32) -> Self {
        let t = turbidity;
        let perez = [
            0.1787 * t - 1.4630,
            -0.3554 * t + 0.4275,
            -0.0227 * t + 5.3251,
            0.1206 * t - 2.5771,
            -0.0670 * t + 0.3703,
        ];
        // The zenith is as bright as level ground then gets what it should.
        let mut sky = Self { sun, turbidity, perez, zenith: 1.0 };
        sky.zenith = (0.8 + 15.5 * sun.y.max(0.0).sqrt()) / sky.shed();
        sky
    }

    /// Illuminance of level ground, in klx: ∫ L cos θ dω over the sky.
    fn shed(&self) -> f32 {
        let (rows, columns) = (32u32, 64u32);
        let mut sum = 0.0;
        for i in 0..rows * columns {
            // Rows of equal cos² have equal ∫ cos dω = π / rows.
            let up = (((i / columns) as f32 + 0.5) / rows as f32).sqrt();
            let turn = std::f32::consts::TAU * ((i % columns) as f32 + 0.5) / columns as f32;
            let (sin, cos) = libm::sincosf(turn);
            let flat = (1.0 - up * up).sqrt();
            sum += self.luminance(Vec3::new(flat * sin, up, flat * cos));
        }
        sum * std::f32::consts::PI / (rows * columns) as f32
    }

    /// Luminance of a direction in kcd/m².
    fn luminance(&self, direction: Vec3) -> f32 {
        let up = direction.y.max(0.01);
        let cos = direction.dot(self.sun).clamp(-1.0, 1.0);
        self.zenith * perez_at(&self.perez, up, libm::acosf(cos), cos)
    }

    /// Radiance from a direction, as linear sRGB with its luminance in kcd/m².
    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        self.color(direction) * self.luminance(direction).max(LEAST)
    }

    /// Colour of a direction, of luminance 1: of sunlight that was scattered once on its way,
    /// `E_sun (τ_air p_air + τ_haze p_haze) / τ · (1 − e^(−τ m))` at airmass m.
    fn color(&self, direction: Vec3) -> Vec3 {
        let cos = direction.dot(self.sun).clamp(-1.0, 1.0);
        let airmass = airmass(direction.y.max(0.01));
        let [air, haze] = self.depths();
        let depth = air + haze;
        let scattered = (air * phase_of_air(cos) + haze * phase_of_haze(cos)) / depth;
        let seen = (depth * -airmass).to_array().map(|x| 1.0 - libm::expf(x));
        let color = self.sun_irradiance() * scattered * Vec3::from_array(seen);
        color / luminance(color).max(f32::MIN_POSITIVE)
    }

    /// Optical depths of air and of haze towards the zenith.
    fn depths(&self) -> [Vec3; 2] {
        let haze = 0.04608 * self.turbidity - 0.04586;
        let power = |factor: f32, exponent: f32| {
            Vec3::from_array(
                WAVELENGTHS.map(|wavelength| factor * libm::powf(wavelength, exponent)),
            )
        };
        [power(0.008735, -4.08), power(haze, -1.3)]
    }

    /// Irradiance of the sun on a surface that faces it, in the same unit.
    pub(crate) fn sun_irradiance(&self) -> Vec3 {
        let airmass = airmass(self.sun.y);
        let [air, haze] = self.depths();
        let depth = air + haze + Vec3::from_array(OZONE) * OZONE_LAYER;
        let through = (depth * -airmass).to_array().map(libm::expf);
        Vec3::from_array(through) * SOLAR
    }
}

/// Perez's distribution: `(1 + A e^(B / cos θ)) (1 + C e^(D γ) + E cos² γ)`.
fn perez_at([a, b, c, d, e]: &[f32; 5], cos_zenith: f32, angle: f32, cos: f32) -> f32 {
    (1.0 + a * libm::expf(b / cos_zenith)) * (1.0 + c * libm::expf(d * angle) + e * cos * cos)
}

/// Airmass in a direction of this height, in zenith's: Kasten and Young's.
fn airmass(up: f32) -> f32 {
    let up = up.clamp(0.0, 1.0);
    let height = libm::asinf(up).to_degrees();
    1.0 / (up + 0.50572 * libm::powf(height + 6.07995, -1.6364))
}

/// Phase function of air (Rayleigh's), per steradian.
fn phase_of_air(cos: f32) -> f32 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// Phase function of haze, per steradian: Henyey and Greenstein's.
fn phase_of_haze(cos: f32) -> f32 {
    const FORWARD: f32 = 0.76;
    let square = FORWARD * FORWARD;
    (1.0 - square) / (4.0 * PI * libm::powf(1.0 + square - 2.0 * FORWARD * cos, 1.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(height: f32) -> Vec3 {
        let height = height.to_radians();
        Vec3::new(0.0, libm::sinf(height), libm::cosf(height))
    }

    /// ∫ p dω = 1.
    #[test]
    fn phase_functions_scatter_all_light() {
        for phase in [phase_of_air, phase_of_haze] {
            let n = 20_000;
            let cos = |i: i32| (i as f32 + 0.5) / n as f32 * 2.0 - 1.0;
            let all = (0..n).map(|i| f64::from(phase(cos(i)))).sum::<f64>() / f64::from(n);
            assert!((4.0 * std::f64::consts::PI * all - 1.0).abs() < 1e-3, "{all}");
        }
    }

    /// At the horizon the air is thick enough that all colours are scattered.
    #[test]
    fn the_sky_is_pale_at_the_horizon() {
        let sky = ClearSky::new(sun(45.0), 2.5);
        let blue = |c: Vec3| c.z / c.x;
        let [high, low] = [40.0f32, 1.0].map(|height| {
            let (sin, cos) = libm::sincosf(height.to_radians());
            sky.color(Vec3::new(0.0, sin, -cos))
        });
        assert!(blue(low) < 1.3 && blue(high) > 1.4 * blue(low), "{low} {high}");
        assert!((luminance(low) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_clear_sky_sheds_what_it_does_and_is_blue_away_from_the_sun() {
        let sky = ClearSky::new(sun(45.0), 2.5);
        // The IES's clear day, sun at 45°: 13.8 klx.
        assert!((sky.shed() - 13.83).abs() < 0.05, "{}", sky.shed());
        let away = sky.radiance(Vec3::new(0.0, 0.8, -0.6));
        assert!(away.z > 1.4 * away.x, "{away}");
        let near = sky.radiance(sky.sun);
        assert!(luminance(near) > 3.0 * luminance(away));
    }

    /// Illuminance outdoors on a clear day: full sun 80–110 klx square to it, the sky 8–25 klx
    /// (IES Lighting Handbook, daylight availability).
    #[test]
    fn the_sun_is_as_bright_as_it_is() {
        let full = luminance(ClearSky::new(sun(60.0), 2.5).sun_irradiance());
        assert!((80.0..110.0).contains(&full), "{full}");
        let low = ClearSky::new(sun(5.0), 2.5).sun_irradiance();
        assert!(low.x > 1.5 * low.z && luminance(low) < 0.6 * full, "{low}");
    }
}
