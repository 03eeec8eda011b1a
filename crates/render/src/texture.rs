//! Pictures on surfaces.

use deeptree_mesh::Image;
use glam::{Vec3, Vec4};
use std::sync::LazyLock;

use crate::error::RenderError;

/// Linear values of the 256 steps of sRGB.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| crate::tone::linear_from_srgb(i as f32 / 255.0)));

/// A picture that repeats over the plane; v upwards, v = 1 the upper edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Texture<'a> {
    image: &'a Image,
    is_srgb: bool,
}

impl<'a> Texture<'a> {
    /// A picture of colours in sRGB, or of numbers.
    pub(crate) fn new(
        image: &'a Image,
        is_srgb: bool,
        material: &str,
        what: &'static str,
    ) -> Result<Self, RenderError> {
        let &Image { width, height, channels, .. } = image;
        let bytes = image.pixels.len();
        let expected = u128::from(width) * u128::from(height) * u128::from(channels);
        if bytes == 0 || bytes as u128 != expected || !matches!(channels, 1 | 3 | 4) {
            let material = material.to_owned();
            return Err(RenderError::Image { material, what, width, height, channels, bytes });
        }
        Ok(Self { image, is_srgb })
    }

    /// Colour and alpha, between the four pixels around the place.
    pub(crate) fn sample(&self, [u, v]: [f32; 2]) -> Vec4 {
        self.blend([u, v], |x, y| self.texel(x, y))
    }

    /// Alpha alone: 1 where the picture has none.
    pub(crate) fn alpha(&self, uv: [f32; 2]) -> f32 {
        if self.image.channels < 4 {
            return 1.0;
        }
        self.blend(uv, |x, y| {
            Vec4::splat(f32::from(self.image.pixels[self.offset(x, y) + 3]) / 255.0)
        })
        .x
    }

    fn blend(&self, [u, v]: [f32; 2], texel: impl Fn(u32, u32) -> Vec4) -> Vec4 {
        let (x, along) = place(u, self.image.width);
        let (y, down) = place(1.0 - v, self.image.height);
        let next = |i: u32, n: u32| if i + 1 == n { 0 } else { i + 1 };
        let (right, below) = (next(x, self.image.width), next(y, self.image.height));
        let upper = texel(x, y).lerp(texel(right, y), along);
        upper.lerp(texel(x, below).lerp(texel(right, below), along), down)
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        (y as usize * self.image.width as usize + x as usize) * usize::from(self.image.channels)
    }

    fn texel(&self, x: u32, y: u32) -> Vec4 {
        let at = self.offset(x, y);
        let value = |byte: u8| {
            if self.is_srgb { LINEAR[usize::from(byte)] } else { f32::from(byte) / 255.0 }
        };
        let pixels = &self.image.pixels;
        if self.image.channels == 1 {
            return Vec3::splat(value(pixels[at])).extend(1.0);
        }
        let alpha = if self.image.channels == 4 { f32::from(pixels[at + 3]) / 255.0 } else { 1.0 };
        Vec3::new(value(pixels[at]), value(pixels[at + 1]), value(pixels[at + 2])).extend(alpha)
    }
}

/// The pixel whose middle is before a coordinate, and how far it is to the next.
fn place(x: f32, n: u32) -> (u32, f32) {
    // Coordinates that are not finite have no place; they get the first.
    let x = if x.is_finite() { (x - x.floor()) * n as f32 - 0.5 } else { 0.0 };
    let x = if x < 0.0 { x + n as f32 } else { x };
    let before = (x as u32).min(n - 1);
    (before, (x - before as f32).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Image {
        // Red above, green below; opaque left, transparent right.
        let pixels = vec![255, 0, 0, 255, 255, 0, 0, 0, 0, 255, 0, 255, 0, 255, 0, 0];
        Image { width: 2, height: 2, channels: 4, pixels }
    }

    #[test]
    fn the_upper_edge_is_where_v_is_one() {
        let image = picture();
        let texture = Texture::new(&image, true, "m", "colour").unwrap();
        assert_eq!(texture.sample([0.25, 0.75]), Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!(texture.sample([0.25, 0.25]), Vec4::new(0.0, 1.0, 0.0, 1.0));
        assert_eq!(texture.alpha([0.75, 0.25]), 0.0);
        assert_eq!(texture.alpha([-0.75, 7.25]), 1.0, "it repeats");
        assert!((texture.alpha([0.5, 0.5]) - 0.5).abs() < 1e-6);
        assert!(texture.sample([f32::NAN, f32::INFINITY]).is_finite());
    }

    #[test]
    fn pictures_of_the_wrong_size_are_refused() {
        for (width, height, channels, bytes) in
            [(2, 2, 4, 15), (0, 0, 4, 0), (2, 2, 2, 8), (u32::MAX, u32::MAX, 4, 4)]
        {
            let image = Image { width, height, channels, pixels: vec![0; bytes] };
            assert!(Texture::new(&image, true, "m", "colour").is_err());
        }
    }
}
