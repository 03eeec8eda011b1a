//! The holes in pictures of leaves.

use deeptree_mesh::Material;

/// Which pixels of a picture are there; all of one without pixels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cutout {
    width: usize,
    height: usize,
    is_there: Vec<bool>,
}

impl Cutout {
    /// What a material covers.
    pub(crate) fn of(material: &Material) -> Self {
        let (Some(cutoff), Some(image)) = (material.alpha_cutoff, &material.color_image) else {
            return Self::default();
        };
        if image.channels != 4 {
            return Self::default();
        }
        let (width, height) = (image.width as usize, image.height as usize);
        let is_there = |pixel: &[u8; 4]| f32::from(pixel[3]) * material.color[3] >= 255.0 * cutoff;
        let is_there = image.pixels.as_chunks::<4>().0.iter().map(is_there).collect();
        Self { width, height, is_there }
    }

    /// Is the surface there, at these shares of the second and third corner? Pictures repeat, and v
    /// goes upwards.
    pub(crate) fn is_there(&self, corners: [[f32; 2]; 3], [second, third]: [f64; 2]) -> bool {
        let [a, b, c] = corners.map(|uv| uv.map(f64::from));
        let at = |k: usize| a[k] + (b[k] - a[k]) * second + (c[k] - a[k]) * third;
        let pixel = |share: f64, size: usize| {
            let share = share - share.floor();
            ((share * size as f64) as usize).min(size.saturating_sub(1))
        };
        let (column, row) = (pixel(at(0), self.width), pixel(1.0 - at(1), self.height));
        self.is_there.get(row * self.width + column).copied().unwrap_or(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_looked_up_from_its_lower_left_corner() {
        // Only the upper right pixel of two by two.
        let cutout = Cutout { width: 2, height: 2, is_there: vec![false, true, false, false] };
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(cutout.is_there(corners, [0.75, 0.75]));
        for shares in [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75]] {
            assert!(!cutout.is_there(corners, shares), "{shares:?}");
        }
        assert!(Cutout::default().is_there(corners, [0.3, 0.3]));
    }
}
