//! Painting bark: a square of a metre that repeats in both directions.

use super::canvas::{Canvas, Pixel, Rgb, blend, scaled};
use super::noise::{Noise, step};

/// Side of the piece of bark that the texture shows, in metres.
pub(crate) const BARK_SIZE: f32 = 1.0;

/// How the bark of a species breaks up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relief {
    /// Smooth, with lenticels across and folds.
    Smooth,
    /// Ridges along the trunk between deep fissures.
    Ridges,
    /// Ridges that part and meet again around lozenges.
    Interlaced,
    /// Flat plates of several layers.
    Plates,
    /// Long narrow scales.
    Scales,
}

/// What bark is painted with: colours are linear, relief and sizes in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bark {
    pub(crate) relief: Relief,
    /// Width and length of ridges or plates.
    pub(crate) plate: [f32; 2],
    /// Depth of the fissures.
    pub(crate) depth: f32,
    /// Of the outer surface.
    pub(crate) face: Rgb,
    /// Elsewhere on the outer surface.
    pub(crate) stain: Rgb,
    /// At the bottom of fissures.
    pub(crate) fissure: Rgb,
    pub(crate) roughness: f32,
}

/// Paints bark.
pub(crate) fn paint(side: u32, bark: &Bark, noise: Noise) -> Canvas {
    let _ = step(0.0, 1.0, 0.5);
    Canvas::fill(side, |p| {
        let cloud = noise.cloud(p.map(|x| 8.0 * x), [8, 8], 5);
        let color = scaled(blend(bark.face, bark.stain, 0.5 + 0.5 * cloud), 1.0);
        Pixel { color, alpha: 1.0, height: 0.0, roughness: bark.roughness }
    })
}
