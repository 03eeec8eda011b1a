//! From radiance to what a screen shows.
//!
//! # Source
//!
//! Narkowicz 2016, "ACES Filmic Tone Mapping Curve"; IEC 61966-2-1 (sRGB).

use glam::Vec3;

/// Luminance of linear sRGB.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// How radiance becomes a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Tone {
    /// A film's curve: dark tones a little darker, bright ones rolled off to white.
    #[default]
    Filmic,
    /// Proportional up to 1, cut off there.
    Linear,
}

impl Tone {
    /// Display value, linear in \[0, 1\], of a radiance.
    ///
    /// Filmic: `x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14)` with x = 1.6 · radiance: it is
    /// exposed a stop longer than a grey card asks for, as for foliage and bark, which are darker.
    #[must_use]
    pub fn map(self, radiance: Vec3) -> Vec3 {
        let x = radiance.max(Vec3::ZERO).min(Vec3::splat(1e4));
        match self {
            Self::Linear => x.min(Vec3::ONE),
            Self::Filmic => {
                let x = x * 1.6;
                let curve = (x * (x * 2.51 + 0.03)) / (x * (x * 2.43 + 0.59) + 0.14);
                curve.clamp(Vec3::ZERO, Vec3::ONE)
            }
        }
    }
}

/// The encoded value of a linear one, both in \[0, 1\].
pub(crate) fn srgb_from_linear(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::powf(x, 1.0 / 2.4) - 0.055 }
}

/// The same as a byte.
pub(crate) fn srgb_byte(linear: f32) -> u8 {
    (srgb_from_linear(linear) * 255.0 + 0.5) as u8
}

/// The linear value of an encoded one.
pub(crate) fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        for byte in 0..=255u8 {
            assert_eq!(srgb_byte(linear_from_srgb(f32::from(byte) / 255.0)), byte);
        }
        // IEC 61966-2-1: 18 % grey is 118.
        assert_eq!(srgb_byte(0.18), 118);
    }

    #[test]
    fn tones_rise_and_end_at_white() {
        for tone in [Tone::Filmic, Tone::Linear] {
            let steps: Vec<f32> =
                (0..200).map(|i| tone.map(Vec3::splat(i as f32 * 0.05)).x).collect();
            assert!(steps.is_sorted());
            assert_eq!(steps[0], 0.0);
            assert_eq!(tone.map(Vec3::splat(1e30)).x, 1.0);
        }
        let grey = Tone::Filmic.map(Vec3::splat(0.18)).x;
        assert!((0.18..0.45).contains(&grey), "{grey}");
    }
}
