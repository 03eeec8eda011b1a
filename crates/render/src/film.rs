//! The picture that forms: samples of pixels, until they are as good as asked for.

use deeptree_graph::Seed;
use glam::Vec3;
use rayon::prelude::*;

use crate::camera::Camera;
use crate::error::RenderError;
use crate::integrator::{Integrator, Seen};
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::tone::luminance;

/// Pixels a picture may have a side.
pub const MAX_SIZE: u32 = 16_384;
/// Samples a pixel may have.
pub const MAX_SAMPLES: u32 = 1 << 16;
/// Side of the squares of pixels that share an estimate of the error.
const TILE: u32 = 16;
/// Samples of a round. The error is judged by how the means of rounds differ, since the samples of
/// one round are spread over what one alone would miss.
const ROUND: u32 = 8;

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Width and height in pixels, 1 to [`MAX_SIZE`].
    pub size: [u32; 2],
    /// Most samples a pixel, 1 to [`MAX_SAMPLES`].
    pub samples: u32,
    /// Standard error at which a tile is good enough, as a share of its brightness: 0 for all
    /// samples everywhere. Default 0.01.
    pub error: f32,
    /// Most surfaces a path may meet. Default 16.
    pub depth: u32,
    /// Are sky and ground in the picture? If not, it is transparent there but for the shadow.
    pub surroundings: bool,
    /// The seed of all samples.
    pub seed: Seed,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            size: [512, 512],
            samples: 64,
            error: 0.01,
            depth: 16,
            surroundings: true,
            seed: Seed(0),
        }
    }
}

impl Options {
    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    ///
    /// When a field is out of its range.
    pub fn validate(&self) -> Result<(), RenderError> {
        let [width, height] = self.size;
        if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
            return Err(RenderError::Size { width, height });
        }
        if !(1..=MAX_SAMPLES).contains(&self.samples) {
            return Err(RenderError::Samples { samples: self.samples });
        }
        if !(self.error >= 0.0 && self.error.is_finite()) {
            let (what, value) = ("the error", self.error);
            return Err(RenderError::Range { what, value, low: 0.0, high: f32::MAX });
        }
        if self.depth == 0 {
            let what = "the length of a path";
            return Err(RenderError::Range { what, value: 0.0, low: 1.0, high: f32::MAX });
        }
        Ok(())
    }
}

/// A picture in linear sRGB, row by row from above.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Radiance times alpha, and alpha: the share of the pixel in which there is something.
    pub pixels: Vec<[f32; 4]>,
    /// Share of its light that the ground of the pixel has lost to the tree, times the share of
    /// the pixel that is ground; 0 where the ground itself is in the picture.
    pub shadow: Vec<f32>,
    /// How many samples were taken.
    pub samples: u64,
}

impl Picture {
    /// Mean of red, green and blue over all pixels.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in &self.pixels {
            (0..3).for_each(|i| sum[i] += f64::from(pixel[i]));
        }
        sum.map(|one| one / self.pixels.len() as f64)
    }
}

/// Takes a picture; `done` is told of each tile of pixels that is ready, out of how many.
///
/// The same scene, camera and options give the same bits, whatever the number of threads.
///
/// # Errors
///
/// When an option is out of its range.
pub fn render(
    scene: &Scene<'_>,
    camera: &Camera,
    options: &Options,
    done: impl Fn(u64) + Sync,
) -> Result<Picture, RenderError> {
    options.validate()?;
    let [width, height] = options.size;
    let integrator =
        Integrator { scene, depth: options.depth, sees_surroundings: options.surroundings };
    let columns = width.div_ceil(TILE);
    let tiles = u64::from(columns) * u64::from(height.div_ceil(TILE));
    let pixels = width as usize * height as usize;
    let mut picture = Picture {
        width,
        height,
        pixels: vec![[0.0; 4]; pixels],
        shadow: vec![0.0; pixels],
        samples: 0,
    };
    // A row of tiles at a time, so that few pixels stand there twice.
    for row in 0..tiles / u64::from(columns) {
        let ready: Vec<Vec<Pixel>> = (0..columns)
            .into_par_iter()
            .map(|column| {
                let tile = Tile::new([column, row as u32], options.size);
                let pixels = tile.expose(&integrator, camera, options);
                done(tiles);
                pixels
            })
            .collect();
        for (column, pixels) in ready.into_iter().enumerate() {
            let tile = Tile::new([column as u32, row as u32], options.size);
            for (pixel, [x, y]) in pixels.iter().zip(tile.places()) {
                let at = y as usize * width as usize + x as usize;
                let mean = pixel.mean();
                picture.pixels[at] = mean.color.extend(mean.alpha).into();
                picture.shadow[at] = mean.shadow;
                picture.samples += u64::from(pixel.count);
            }
        }
    }
    Ok(picture)
}

/// How many tiles a picture of this size has: that often [`render`] says that one is ready.
#[must_use]
pub fn tile_count([width, height]: [u32; 2]) -> u64 {
    u64::from(width.div_ceil(TILE)) * u64::from(height.div_ceil(TILE))
}

/// A square of pixels.
#[derive(Clone, Copy)]
struct Tile {
    from: [u32; 2],
    to: [u32; 2],
}

impl Tile {
    fn new([column, row]: [u32; 2], [width, height]: [u32; 2]) -> Self {
        let from = [column * TILE, row * TILE];
        Self { from, to: [(from[0] + TILE).min(width), (from[1] + TILE).min(height)] }
    }

    fn places(self) -> impl Iterator<Item = [u32; 2]> {
        (self.from[1]..self.to[1])
            .flat_map(move |y| (self.from[0]..self.to[0]).map(move |x| [x, y]))
    }

    /// Takes samples of all pixels until there are enough, or the mean error is small.
    fn expose(self, integrator: &Integrator<'_>, camera: &Camera, options: &Options) -> Vec<Pixel> {
        let mut pixels = vec![Pixel::default(); self.places().count()];
        let mut taken = 0;
        while taken < options.samples {
            let until = options.samples.min(taken + ROUND);
            for (pixel, [x, y]) in pixels.iter_mut().zip(self.places()) {
                for index in taken..until {
                    let mut sampler = Sampler::new(options.seed, x, y, index);
                    let [dx, dy] = sampler.pair().map(tent);
                    let at = [
                        (x as f32 + 0.5 + dx) / options.size[0] as f32,
                        (y as f32 + 0.5 + dy) / options.size[1] as f32,
                    ];
                    let ray = camera.ray(at, sampler.pair());
                    pixel.add(integrator.see(&ray, &mut sampler));
                }
            }
            taken = until;
            pixels.iter_mut().for_each(Pixel::end_round);
            let squares: f32 = pixels.iter().map(|pixel| pixel.error() * pixel.error()).sum();
            if (squares / pixels.len() as f32).sqrt() < options.error {
                break;
            }
        }
        pixels
    }
}

/// A draw of the tent from −1 to 1: the filter of the pixels.
fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Default)]
struct Pixel {
    color: Vec3,
    alpha: f32,
    shadow: f32,
    count: u32,
    /// Of the samples of this round, as bright as a screen can show them.
    brightness: f32,
    in_round: u32,
    /// Sum and sum of squares of the rounds' mean brightness.
    rounds: [f32; 2],
    round_count: u32,
}

impl Pixel {
    fn add(&mut self, seen: Seen) {
        // One path that went wrong must not spoil a picture.
        let color = if seen.color.is_finite() { seen.color } else { Vec3::ZERO };
        self.color += color;
        self.alpha += seen.alpha;
        self.shadow += seen.shadow;
        self.count += 1;
        // The background is white to the eye.
        self.brightness += (luminance(color) + (1.0 - seen.alpha) * (1.0 - seen.shadow)).min(4.0);
        self.in_round += 1;
    }

    fn end_round(&mut self) {
        let mean = self.brightness / self.in_round.max(1) as f32;
        self.rounds = [self.rounds[0] + mean, self.rounds[1] + mean * mean];
        self.round_count += 1;
        (self.brightness, self.in_round) = (0.0, 0);
    }

    fn mean(&self) -> Seen {
        let n = self.count.max(1) as f32;
        Seen { color: self.color / n, alpha: self.alpha / n, shadow: self.shadow / n }
    }

    /// Standard error of the brightness, as a share of it and a little more: the eye sees less in
    /// the dark. Infinite after one round, when nothing is known of it.
    fn error(&self) -> f32 {
        if self.round_count < 2 {
            return f32::INFINITY;
        }
        let n = self.round_count as f32;
        let mean = self.rounds[0] / n;
        let variance = (self.rounds[1] / n - mean * mean).max(0.0);
        (variance / (n - 1.0)).sqrt() / (mean + 0.1)
    }
}
