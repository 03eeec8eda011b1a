//! Sheets of paper with pictures and words on them.

use deeptree_mesh::Image;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// A sheet of one colour, sRGB.
pub(super) struct Paper {
    image: Image,
}

/// Sizes of letters.
#[derive(Clone, Copy)]
pub(super) enum Letters {
    Small,
    Large,
}

impl Letters {
    const fn height(self) -> RasterHeight {
        match self {
            Self::Small => RasterHeight::Size16,
            Self::Large => RasterHeight::Size20,
        }
    }

    /// Pixels of a word.
    pub(super) fn width(self, text: &str) -> u32 {
        (text.chars().count() * get_raster_width(FontWeight::Regular, self.height())) as u32
    }
}

impl Paper {
    pub(super) fn new([width, height]: [u32; 2], color: [u8; 3]) -> Self {
        let pixels = color.repeat(width as usize * height as usize);
        Self { image: Image { width, height, channels: 3, pixels } }
    }

    pub(super) fn into_image(self) -> Image {
        self.image
    }

    /// Lays a picture of three channels on the sheet; what is beyond the edge is cut.
    pub(super) fn lay(&mut self, picture: &Image, [x, y]: [u32; 2]) {
        let width = picture.width.min(self.image.width.saturating_sub(x)) as usize * 3;
        for row in 0..picture.height.min(self.image.height.saturating_sub(y)) {
            let from = row as usize * picture.width as usize * 3;
            let to = ((y + row) as usize * self.image.width as usize + x as usize) * 3;
            self.image.pixels[to..to + width].copy_from_slice(&picture.pixels[from..from + width]);
        }
    }

    /// Writes a word with the middle of its upper edge at a place. Letters that the font has not
    /// stay blank.
    pub(super) fn write(&mut self, text: &str, [x, y]: [u32; 2], letters: Letters, ink: [u8; 3]) {
        let mut left = x.saturating_sub(letters.width(text) / 2);
        for letter in text.chars() {
            let Some(raster) = get_raster(letter, FontWeight::Regular, letters.height()) else {
                left += letters.width(" ");
                continue;
            };
            for (row, line) in raster.rows().enumerate() {
                for (column, &strength) in line.iter().enumerate() {
                    self.dab(left + column as u32, y + row as u32, strength, ink);
                }
            }
            left += raster.width() as u32;
        }
    }

    fn dab(&mut self, x: u32, y: u32, strength: u8, ink: [u8; 3]) {
        if x >= self.image.width || y >= self.image.height {
            return;
        }
        let at = (y as usize * self.image.width as usize + x as usize) * 3;
        for (pixel, ink) in self.image.pixels[at..at + 3].iter_mut().zip(ink) {
            let (old, ink, share) = (u32::from(*pixel), u32::from(ink), u32::from(strength));
            *pixel = ((old * (255 - share) + ink * share + 127) / 255) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_pictures_beyond_the_edge_are_cut() {
        let mut paper = Paper::new([20, 20], [255; 3]);
        paper.write("a long word", [10, 5], Letters::Large, [0; 3]);
        let picture = Image { width: 4, height: 4, channels: 3, pixels: vec![7; 48] };
        paper.lay(&picture, [18, 18]);
        let image = paper.into_image();
        assert_eq!(&image.pixels[(18 * 20 + 18) * 3..][..6], [7; 6]);
        assert!(image.pixels.iter().any(|&byte| byte > 7 && byte < 100));
    }
}
