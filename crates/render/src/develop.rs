//! From a picture of radiance to one of bytes.

use deeptree_mesh::Image;
use glam::{Vec3, Vec4};

use crate::film::Picture;
use crate::tone::{Tone, srgb_from_linear};

/// What is behind a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// Nothing: the picture gets an alpha, straight, and the shadow is black that is transparent.
    Transparent,
    /// Paper of a colour in sRGB, each in \[0, 1\], on which the tree throws its shadow. It is mixed
    /// with the tree as a viewer mixes a transparent picture with the page: by the bytes, in which
    /// twigs thinner than a pixel stay visible.
    Paper(Vec3),
}

/// How a picture becomes bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Developing {
    /// Stops: each doubles the brightness.
    pub exposure: f32,
    /// The curve.
    pub tone: Tone,
    /// What is where the picture shows nothing.
    pub background: Background,
    /// How dark the shadow on paper is: 0 (none) to 1 (as dark as it would be).
    pub shadow: f32,
}

impl Default for Developing {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            tone: Tone::default(),
            background: Background::Paper(Vec3::ONE),
            shadow: 1.0,
        }
    }
}

/// Bytes of 3 channels, or of 4 where the background is transparent.
#[must_use]
pub fn develop(picture: &Picture, how: &Developing) -> Image {
    let brighter = libm::exp2f(how.exposure);
    let channels = if how.background == Background::Transparent { 4 } else { 3 };
    let mut pixels = Vec::with_capacity(picture.pixels.len() * channels);
    for (&pixel, &shadow) in picture.pixels.iter().zip(&picture.shadow) {
        let pixel = Vec4::from(pixel);
        let alpha = pixel.w.clamp(0.0, 1.0);
        let color = how.tone.map(pixel.truncate() * (brighter / alpha.max(1e-6)));
        let shadow = (shadow * how.shadow).clamp(0.0, 1.0 - alpha);
        let encoded = Vec3::from_array(color.to_array().map(srgb_from_linear));
        // The shadow is black, so it adds to alpha only.
        let (encoded, alpha) = match how.background {
            Background::Transparent => {
                (encoded * (alpha / (alpha + shadow).max(1e-6)), alpha + shadow)
            }
            Background::Paper(paper) => (encoded * alpha + paper * (1.0 - alpha - shadow), 1.0),
        };
        let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        pixels.extend(encoded.to_array().map(byte));
        if channels == 4 {
            pixels.push(byte(alpha));
        }
    }
    Image { width: picture.width, height: picture.height, channels: channels as u8, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixel: [f32; 4], shadow: f32) -> Picture {
        Picture { width: 1, height: 1, pixels: vec![pixel], shadow: vec![shadow], samples: 1 }
    }

    #[test]
    fn paper_shows_where_nothing_is_and_darkens_in_the_shadow() {
        let linear = Developing { tone: Tone::Linear, ..Developing::default() };
        assert_eq!(develop(&picture([0.0; 4], 0.0), &linear).pixels, [255; 3]);
        assert_eq!(develop(&picture([0.0; 4], 1.0), &linear).pixels, [0; 3]);
        // Half of 18 % grey, which is 118, and half of white.
        let half = develop(&picture([0.09, 0.09, 0.09, 0.5], 0.0), &linear);
        assert!(half.pixels.iter().all(|byte| byte.abs_diff(186) <= 1), "{:?}", half.pixels);
        let clear = Developing { background: Background::Transparent, ..linear };
        assert_eq!(develop(&picture([0.0; 4], 0.5), &clear).pixels, [0, 0, 0, 128]);
        let stop = Developing { exposure: 1.0, ..linear };
        assert_eq!(develop(&picture([0.09, 0.5, 0.0, 1.0], 0.0), &stop).pixels, [118, 255, 0]);
    }
}
