//! The colours of a clear sky and of the sun behind the same air.
//!
//! # Source
//!
//! Preetham, Shirley and Smits 1999, "A Practical Analytic Model for Daylight": luminance of the sky
//! (their appendix A.2), transmittance of the air (A.1). Takagi et al. 1990, "Accurate Rendering
//! Technique Based on Colorimetric Conception": the colour temperature of the sky, by its luminance;
//! CIE 15: the chromaticity of daylight of a colour temperature. Kasten and Young 1989: airmass.
//! IES Lighting Handbook, clear sky: what the sky sheds on level ground.
//! Deviation: Preetham's luminances are scaled to the IES's illuminance, since they are up to twice
//! that; his chromaticities, which make the horizon pink, are not used; below the lowest degree the
//! horizon's colour goes on.

use glam::{Mat3, Vec3};

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
        let luminance = self.luminance(direction).max(LEAST);
        rgb_of_daylight(color_temperature(luminance)) * luminance
    }

    /// Irradiance of the sun on a surface that faces it, in the same unit.
    pub(crate) fn sun_irradiance(&self) -> Vec3 {
        let height = libm::asinf(self.sun.y.clamp(-1.0, 1.0)).to_degrees().max(0.0);
        let airmass = 1.0 / (self.sun.y.max(0.0) + 0.50572 * libm::powf(height + 6.07995, -1.6364));
        let haze = 0.04608 * self.turbidity - 0.04586;
        let through = std::array::from_fn(|i| {
            let wavelength = WAVELENGTHS[i];
            let air = 0.008735 * libm::powf(wavelength, -4.08);
            let dust = haze * libm::powf(wavelength, -1.3);
            libm::expf(-airmass * (air + dust) - OZONE[i] * OZONE_LAYER * airmass)
        });
        Vec3::from_array(through) * SOLAR
    }
}

/// Perez's distribution: `(1 + A e^(B / cos θ)) (1 + C e^(D γ) + E cos² γ)`.
fn perez_at([a, b, c, d, e]: &[f32; 5], cos_zenith: f32, angle: f32, cos: f32) -> f32 {
    (1.0 + a * libm::expf(b / cos_zenith)) * (1.0 + c * libm::expf(d * angle) + e * cos * cos)
}

/// Correlated colour temperature in kelvins of sky of a luminance in kcd/m²:
/// `6500 + 1.1985e8 / L^1.2` with L in cd/m².
fn color_temperature(luminance: f32) -> f32 {
    6500.0 + 1.1985e8 / libm::powf(1000.0 * luminance, 1.2)
}

/// Linear sRGB, of luminance 1, of daylight of a colour temperature of at least 4000 K.
fn rgb_of_daylight(kelvins: f32) -> Vec3 {
    let i = 1000.0 / kelvins;
    let x = if kelvins < 7000.0 {
        ((-4.6070 * i + 2.9678) * i + 0.09911) * i + 0.244_063
    } else {
        ((-2.0064 * i + 1.9018) * i + 0.24748) * i + 0.237_040
    };
    let y = (-3.0 * x + 2.870) * x - 0.275;
    rgb_from_xyy(1.0, x, y).max(Vec3::ZERO)
}

/// Linear sRGB (IEC 61966-2-1) of a CIE xyY colour.
fn rgb_from_xyy(luminance: f32, x: f32, y: f32) -> Vec3 {
    let xyz = Vec3::new(x, y, 1.0 - x - y) * (luminance / y.max(1e-6));
    let rgb_from_xyz = Mat3::from_cols(
        Vec3::new(3.240_97, -0.969_244, 0.055_63),
        Vec3::new(-1.537_383, 1.875_968, -0.203_977),
        Vec3::new(-0.498_611, 0.041_555, 1.056_972),
    );
    rgb_from_xyz * xyz
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tone::luminance;

    fn sun(height: f32) -> Vec3 {
        let height = height.to_radians();
        Vec3::new(0.0, libm::sinf(height), libm::cosf(height))
    }

    #[test]
    fn white_is_white() {
        // D65 has the chromaticity (0.3127, 0.3290).
        for white in [rgb_from_xyy(1.0, 0.3127, 0.3290), rgb_of_daylight(6504.0)] {
            assert!((white - Vec3::ONE).abs().max_element() < 5e-3, "{white}");
        }
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
