//! A square picture under work: colour, cover, height and roughness of each pixel.
//!
//! Places are in units of the side, x to the right and y upwards from the lower left corner; heights
//! in the same unit, so that slopes do not depend on the number of pixels.

use crate::material::Image;

/// A colour, linear in light.
pub(crate) type Rgb = [f32; 3];

/// Between two colours.
pub(crate) fn blend(a: Rgb, b: Rgb, share: f32) -> Rgb {
    core::array::from_fn(|k| a[k] + (b[k] - a[k]) * share)
}

/// A colour made lighter or darker.
pub(crate) fn scaled(a: Rgb, by: f32) -> Rgb {
    a.map(|x| x * by)
}

/// What one pixel shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) color: Rgb,
    /// Share of it that is covered.
    pub(crate) alpha: f32,
    pub(crate) height: f32,
    pub(crate) roughness: f32,
}

/// A square picture under work.
pub(crate) struct Canvas {
    pub(crate) side: u32,
    pub(crate) pixels: Vec<Pixel>,
}

impl Canvas {
    /// A picture of one colour that covers nothing.
    pub(crate) fn new(side: u32, color: Rgb, roughness: f32) -> Self {
        let pixel = Pixel { color, alpha: 0.0, height: 0.0, roughness };
        Self { side, pixels: vec![pixel; (side * side) as usize] }
    }

    /// Sets each pixel by its place.
    pub(crate) fn fill(side: u32, mut pixel: impl FnMut([f32; 2]) -> Pixel) -> Self {
        let mut pixels = Vec::with_capacity((side * side) as usize);
        let size = side as f32;
        for row in 0..side {
            let y = 1.0 - (row as f32 + 0.5) / size;
            pixels.extend((0..side).map(|column| pixel([(column as f32 + 0.5) / size, y])));
        }
        Self { side, pixels }
    }

    /// The colours in sRGB, with alpha if asked for.
    pub(crate) fn color_image(&self, alpha: bool) -> Image {
        let encode = Encoder::new();
        let mut pixels = Vec::with_capacity(self.pixels.len() * 4);
        for pixel in &self.pixels {
            pixels.extend(pixel.color.map(|x| encode.byte(x)));
            if alpha {
                pixels.push(byte(pixel.alpha));
            }
        }
        let channels = if alpha { 4 } else { 3 };
        Image { width: self.side, height: self.side, channels, pixels }
    }

    /// Roughness, one channel.
    pub(crate) fn roughness_image(&self) -> Image {
        let pixels = self.pixels.iter().map(|pixel| byte(pixel.roughness)).collect();
        Image { width: self.side, height: self.side, channels: 1, pixels }
    }

    /// The normals of the heights, in the tangent frame; `wraps` says whether the right edge goes on
    /// at the left and the upper at the lower.
    pub(crate) fn normal_image(&self, wraps: bool) -> Image {
        let side = self.side as usize;
        let near = |k: usize, by: isize| {
            let at = k as isize + by;
            if wraps {
                at.rem_euclid(side as isize) as usize
            } else {
                at.clamp(0, side as isize - 1) as usize
            }
        };
        let height = |column: usize, row: usize| self.pixels[row * side + column].height;
        let run = side as f32 / 2.0;
        let mut pixels = Vec::with_capacity(side * side * 3);
        for row in 0..side {
            let (above, below) = (near(row, -1), near(row, 1));
            for column in 0..side {
                let dx = height(near(column, 1), row) - height(near(column, -1), row);
                let dy = height(column, above) - height(column, below);
                let slope = [-dx * run, -dy * run].map(|s| s.clamp(-2.0, 2.0));
                let length = libm::sqrtf(slope[0] * slope[0] + slope[1] * slope[1] + 1.0);
                let normal = [slope[0] / length, slope[1] / length, 1.0 / length];
                pixels.extend(normal.map(|x| byte(0.5 + 0.5 * x)));
            }
        }
        Image { width: self.side, height: self.side, channels: 3, pixels }
    }

    /// Carries the colours of what is covered on to what is not, so that filters which mix
    /// neighbours find no other colour at the outlines.
    ///
    /// Means of ever larger squares are taken of what they cover; a pixel without cover gets that
    /// of the smallest square around it that has any.
    pub(crate) fn spread_color(&mut self) {
        let side = self.side as usize;
        let start = self.pixels.iter().map(|p| (scaled(p.color, p.alpha), p.alpha)).collect();
        let mut levels: Vec<(usize, Vec<(Rgb, f32)>)> = vec![(side, start)];
        while levels[levels.len() - 1].0 > 1 {
            let (fine_side, fine) = &levels[levels.len() - 1];
            let coarse_side = fine_side.div_ceil(2);
            let mut coarse = vec![([0.0; 3], 0.0); coarse_side * coarse_side];
            for (k, &(color, cover)) in fine.iter().enumerate() {
                let at = (k / fine_side / 2) * coarse_side + k % fine_side / 2;
                let (sum, total): &mut (Rgb, f32) = &mut coarse[at];
                *sum = core::array::from_fn(|c| sum[c] + color[c]);
                *total += cover;
            }
            levels.push((coarse_side, coarse));
        }
        for (k, pixel) in self.pixels.iter_mut().enumerate() {
            if pixel.alpha > 0.02 {
                continue;
            }
            let (mut column, mut row) = (k % side, k / side);
            for (level_side, level) in &levels {
                let (sum, cover) = level[row * level_side + column];
                if cover > 0.02 {
                    pixel.color = scaled(sum, 1.0 / cover);
                    break;
                }
                (column, row) = (column / 2, row / 2);
            }
        }
    }
}

/// A share as a byte.
fn byte(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Linear light to bytes of sRGB, by a table.
///
/// # Source
///
/// IEC 61966-2-1:1999.
struct Encoder(Vec<u8>);

const STEPS: f32 = 4095.0;

impl Encoder {
    fn new() -> Self {
        let encode = |linear: f32| {
            if linear <= 0.003_130_8 {
                12.92 * linear
            } else {
                1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055
            }
        };
        Self((0..=STEPS as u32).map(|k| byte(encode(k as f32 / STEPS))).collect())
    }

    fn byte(&self, linear: f32) -> u8 {
        self.0[(linear.clamp(0.0, 1.0) * STEPS + 0.5) as usize]
    }
}

/// A rectangle of pixels with how much of each an outline covers.
pub(crate) struct Mask {
    /// Column and row of the first pixel.
    pub(crate) corner: [u32; 2],
    pub(crate) width: usize,
    pub(crate) cover: Vec<f32>,
}

/// Rows of samples a pixel.
const SAMPLES: u32 = 4;

impl Mask {
    /// What a closed polygon covers of a picture; where it overlaps itself counts once.
    pub(crate) fn of(side: u32, outline: &[[f32; 2]]) -> Self {
        let size = side as f32;
        let points: Vec<[f32; 2]> =
            outline.iter().map(|&[x, y]| [x * size, (1.0 - y) * size]).collect();
        let bound = |axis: usize| {
            let all = points.iter().map(|p| p[axis]);
            let (low, high) =
                all.fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            let low = (low.max(0.0) as u32).min(side);
            (low, (libm::ceilf(high.clamp(0.0, size)) as u32).max(low))
        };
        let ((left, right), (top, bottom)) = (bound(0), bound(1));
        let width = (right - left) as usize;
        let mut cover = vec![0.0; width * (bottom - top) as usize];
        let mut crossings: Vec<(f32, i32)> = Vec::new();
        for line in 0..(bottom - top) * SAMPLES {
            let y = top as f32 + (line as f32 + 0.5) / SAMPLES as f32;
            crossings.clear();
            for (k, &a) in points.iter().enumerate() {
                let b = points[(k + 1) % points.len()];
                if (a[1] <= y) != (b[1] <= y) {
                    let x = a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]);
                    crossings.push((x, if b[1] > a[1] { 1 } else { -1 }));
                }
            }
            crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
            let row = (line / SAMPLES) as usize * width;
            let mut winding = 0;
            for pair in crossings.windows(2) {
                winding += pair[0].1;
                if winding != 0 {
                    let ends = [pair[0].0, pair[1].0].map(|x| (x - left as f32).max(0.0));
                    add_span(&mut cover[row..row + width], ends);
                }
            }
        }
        Self { corner: [left, top], width, cover }
    }
}

/// Adds what a run from `low` to `high` covers of a row of pixels.
fn add_span(row: &mut [f32], [low, high]: [f32; 2]) {
    let part = 1.0 / SAMPLES as f32;
    let last = (libm::ceilf(high) as usize).min(row.len());
    for (k, cover) in row.iter_mut().enumerate().take(last).skip(low as usize) {
        let here = (high.min(k as f32 + 1.0) - low.max(k as f32)).max(0.0);
        *cover += part * here;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_covers_the_area_of_its_polygon() {
        let polygon: Vec<[f32; 2]> = (0..200)
            .map(|k| libm::sincosf(k as f32 * core::f32::consts::TAU / 200.0))
            .map(|(sin, cos)| [0.5 + 0.31 * cos, 0.45 + 0.31 * sin])
            .collect();
        let mask = Mask::of(128, &polygon);
        let area: f32 = mask.cover.iter().sum::<f32>() / (128.0 * 128.0);
        let truth = core::f32::consts::PI * 0.31 * 0.31;
        assert!((area - truth).abs() < 1e-3 * truth, "{area} {truth}");
        assert!(mask.cover.iter().all(|&c| (0.0..=1.0001).contains(&c)));
    }

    #[test]
    fn outlines_beyond_the_picture_are_cut_off() {
        let mask = Mask::of(16, &[[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]]);
        assert_eq!((mask.corner, mask.width, mask.cover.len()), ([0, 0], 16, 256));
        assert!(mask.cover.iter().all(|&c| (c - 1.0).abs() < 1e-5));
        assert!(Mask::of(16, &[[3.0, 3.0], [4.0, 3.0], [4.0, 4.0]]).cover.is_empty());
    }

    #[test]
    fn spread_colors_reach_every_pixel() {
        let mut canvas = Canvas::new(32, [1.0, 0.0, 0.0], 0.5);
        let covered = &mut canvas.pixels[5 * 32 + 7];
        (covered.alpha, covered.color) = (1.0, [0.0, 0.25, 0.0]);
        canvas.spread_color();
        assert!(canvas.pixels.iter().all(|p| p.color == [0.0, 0.25, 0.0]));
    }

    #[test]
    fn normals_are_of_unit_length_and_lean_down_the_slope() {
        let size = 64;
        // A ridge along y of a slope of a half: heights and places have one unit.
        let canvas = Canvas::fill(size, |[x, _]| Pixel {
            color: [0.0; 3],
            alpha: 1.0,
            height: -0.5 * (x - 0.5).abs(),
            roughness: 0.5,
        });
        let image = canvas.normal_image(false);
        let at = |column: usize, row: usize| -> [f32; 3] {
            let first = 3 * (row * size as usize + column);
            core::array::from_fn(|k| f32::from(image.pixels[first + k]) / 127.5 - 1.0)
        };
        for (column, side) in [(12, -1.0), (50, 1.0)] {
            let [x, y, z] = at(column, 30);
            // (∓1, 0, 2) / √5
            assert!(
                (x - side * 0.4472).abs() < 0.01 && y.abs() < 0.01 && (z - 0.8944).abs() < 0.01
            );
        }
    }

    #[test]
    fn srgb_of_known_values() {
        let encode = Encoder::new();
        // 18 % grey is 118 (0.4614), half of the light 188 (0.7354).
        assert_eq!([0.0, 0.18, 0.5, 1.0].map(|x| encode.byte(x)), [0, 118, 188, 255]);
    }
}
