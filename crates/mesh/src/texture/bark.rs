//! Painting bark: a square of a metre that repeats in both directions.
//!
//! Bark is a field of heights in metres first; colours follow what lies deep and what stands out.

use super::canvas::{Canvas, Pixel, Rgb, blend, scaled};
use super::noise::{Noise, step};

/// How the bark of a species breaks up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Relief {
    /// Smooth, with lenticels across and folds.
    Smooth,
    /// Ridges along the trunk between fissures.
    Ridges,
    /// Ridges that part and meet again around lozenges.
    Interlaced {
        /// How much of the way between two fissures they take, 0 to 1.
        gap: f32,
        /// How deep cracks across the ridges are, as a share of the depth.
        cracks: f32,
    },
    /// Flat plates of several layers.
    Plates,
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

/// What a point of bark is like.
struct Point {
    /// Metres below the highest plates.
    deep: f32,
    /// 0 at the bottom of fissures, 1 on what stands out.
    out: f32,
    /// Which of the two colours of the surface, 0 to 1.
    stain: f32,
    /// Lighter or darker than its colour, −1 to 1.
    grain: f32,
}

/// Paints bark; one texture is one metre.
pub(crate) fn paint(side: u32, bark: &Bark, noise: Noise) -> Canvas {
    // Even, so that what crosses aslant repeats too.
    let counts = bark.plate.map(|size| (libm::roundf(0.5 / size) as i32).max(1) * 2);
    Canvas::fill(side, |p| {
        let point = match bark.relief {
            Relief::Smooth => smooth(p, counts, bark.depth, noise),
            Relief::Ridges => ridges(p, counts, bark.depth, noise),
            Relief::Interlaced { gap, cracks } => {
                interlaced(p, counts, (bark.depth, gap, cracks), noise)
            }
            Relief::Plates => plates(p, counts, bark.depth, noise),
        };
        let face = blend(bark.face, bark.stain, point.stain.clamp(0.0, 1.0));
        let color = blend(bark.fissure, face, point.out.clamp(0.0, 1.0));
        Pixel {
            color: scaled(color, 1.0 + 0.3 * point.grain),
            alpha: 1.0,
            height: -point.deep,
            roughness: bark.roughness + 0.08 * (1.0 - point.out) + 0.05 * point.grain,
        }
    })
}

/// A field that repeats so many times in the picture.
fn cloud(noise: Noise, [x, y]: [f32; 2], [across, up]: [i32; 2], octaves: u32) -> f32 {
    noise.cloud([x * across as f32, y * up as f32], [across, up], octaves)
}

/// Elongated cells whose borders are fissures; each ridge is split by shallow cracks across and
/// lined along.
fn ridges([x, y]: [f32; 2], [across, up]: [i32; 2], depth: f32, noise: Noise) -> Point {
    let size = [1.0 / across as f32, 1.0 / up as f32];
    let bend = cloud(noise.other(1), [x, y], [3, 4], 3);
    let fray = cloud(noise.other(2), [x, y], [2 * across, 3 * up], 3);
    let at = [(x + 0.9 * size[0] * bend) * across as f32 + 0.20 * fray, y * up as f32 + 0.9 * bend];
    let cell = noise.cells(at, [across, up], 0.95, size);
    let width = size[0];
    let far = cell.border + 0.03 * width * fray;
    let ridge = step(0.03 * width, 0.34 * width, far);
    // Shorter plates on the ridges.
    let small = [2 * across, 5 * up];
    let at = [at[0] * 2.0 + 0.3 * fray, y * small[1] as f32 + 1.5 * bend + 0.5 * cell.id];
    let part = noise.other(3).cells(at, small, 0.9, [0.5 * size[0], 0.2 * size[1]]);
    let crack = step(0.09 * width, 0.0, part.border) * ridge;
    let lines = cloud(noise.other(4), [x + 0.2 * size[0] * bend, y], [6 * across, 2 * up], 4);
    let rough = cloud(noise.other(5), [x, y], [96, 64], 3);
    let level = 0.18 * (part.id - 0.5) + 0.16 * lines + 0.07 * rough;
    let deep = 1.0 - ridge * (1.0 + level - 0.30 * crack);
    let tone = cloud(noise.other(6), [x, y], [4, 3], 4);
    Point {
        deep: depth * deep,
        out: (0.1 + 0.9 * ridge) * (1.0 - 0.45 * crack),
        stain: 0.45 + 0.7 * tone + 0.35 * (cell.id - 0.5) + 0.2 * lines,
        grain: 0.45 * lines + 0.45 * rough + 0.3 * (part.id - 0.5),
    }
}

/// Two families of fissures that cross aslant and fade out here and there, so that the ridges
/// between them part and meet again; cracks across break ridges into blocks.
fn interlaced(
    [x, y]: [f32; 2],
    [across, up]: [i32; 2],
    (depth, gap, cracks): (f32, f32, f32),
    noise: Noise,
) -> Point {
    let bend = cloud(noise.other(1), [x, y], [3, 3], 3);
    let other = cloud(noise.other(2), [x, y], [4, 3], 3);
    let fray = cloud(noise.other(3), [x, y], [2 * across, 2 * up], 3);
    let (u, v) = (x * across as f32, y * up as f32);
    // Distance from the nearest line of a family, 0 on it to 1 between two.
    let line = |place: f32| 1.0 - (2.0 * (place - libm::floorf(place)) - 1.0).abs();
    let first = line(0.5 * (u + v) + 0.65 * bend + 0.12 * fray);
    let second = line(0.5 * (u - v) + 0.65 * other - 0.12 * fray);
    let fades = cloud(noise.other(8), [x, y], [across / 2, up], 2);
    let wide = gap + 0.16 * fray;
    let cut = |far: f32, fade: f32| step(wide, 0.25 * gap, far) * step(-0.35, 0.05, fade);
    let stands = 1.0 - cut(first, fades).max(cut(second, 0.1 - fades));
    let lines = cloud(noise.other(4), [x + 0.012 * bend, y], [5 * across, 2 * up], 4);
    let rough = cloud(noise.other(5), [x, y], [96, 72], 3);
    // Flakes along the ridges, and blocks of them.
    let flakes = [3 * across, up];
    let at = [3.0 * u + 1.2 * bend + 0.4 * fray, v + 1.5 * other + 0.2 * fray];
    let flake = noise.other(6).cells(at, flakes, 0.95, [1.0, 3.0]);
    let (split, block) = if cracks > 0.0 {
        let at = [u + 0.8 * bend + 0.2 * fray, 4.0 * v + 2.5 * other + 0.6 * fray];
        let size = [1.0 / across as f32, 0.25 / up as f32];
        let block = noise.other(9).cells(at, [across, 4 * up], 0.9, size);
        (step(0.004, 0.0, block.border + 0.001 * fray) * stands, block.id)
    } else {
        (0.0, 0.5)
    };
    let crack = step(0.16, 0.0, flake.border) * stands;
    let round = 0.3 * (first.min(second) - 0.4);
    let level = round + 0.14 * lines + 0.07 * rough + 0.12 * (flake.id - 0.5)
        - 0.16 * crack
        - cracks * (split - 0.3 * (block - 0.5));
    let deep = 1.0 - stands * (1.0 + level) - 0.08 * (1.0 - stands) * lines;
    let tone = cloud(noise.other(7), [x, y], [4, 3], 4);
    let out = (0.04 + 0.96 * step(0.05, 0.85, stands)) * (1.0 - 0.30 * crack);
    Point {
        deep: depth * deep,
        out: out * (1.0 - 1.4 * cracks.min(0.5) * split),
        stain: 0.45 + 0.6 * tone + 0.25 * lines + 0.4 * (0.6 - stands),
        grain: 0.4 * lines + 0.4 * rough + 0.25 * (flake.id - 0.5),
    }
}

/// Plates between wide fissures; they come off in layers, and the inner ones are redder.
fn plates([x, y]: [f32; 2], [across, up]: [i32; 2], depth: f32, noise: Noise) -> Point {
    let size = [1.0 / across as f32, 1.0 / up as f32];
    let bend = cloud(noise.other(1), [x, y], [4, 4], 3);
    let fray = cloud(noise.other(2), [x, y], [4 * across, 4 * up], 3);
    let fork = cloud(noise.other(7), [x, y], [2 * across, 2 * up], 3);
    let at = [
        x * across as f32 + 0.6 * bend + 0.22 * fork + 0.08 * fray,
        y * up as f32 + 0.6 * bend - 0.22 * fork + 0.08 * fray,
    ];
    let cell = noise.cells(at, [across, up], 0.9, size);
    let width = size[0];
    let wide = 0.20 + 0.10 * fork;
    let plate = step(0.03 * width, wide * width, cell.border + 0.05 * width * fray);
    // Layers: a field of heights cut into steps, with thin edges.
    let field = 2.2
        + 1.6 * cloud(noise.other(3), [x, y], [2 * across, 2 * up], 4)
        + 3.0 * (cell.border / width).min(0.5)
        + 0.8 * (cell.id - 0.5);
    let layer = libm::floorf(field);
    let within = field - layer;
    let edge = step(0.12, 0.0, within);
    let rough = cloud(noise.other(5), [x, y], [100, 80], 3);
    let level = ((layer + step(0.0, 0.15, within)) / 4.5).clamp(0.0, 1.0);
    let deep = 1.0 - plate * (0.45 + 0.5 * level + 0.05 * rough);
    let tone = cloud(noise.other(6), [x, y], [5, 4], 4);
    Point {
        deep: depth * deep,
        out: (0.05 + 0.95 * plate) * (1.0 - 0.35 * edge),
        stain: 0.9 * (level - 0.35) + 0.55 * tone,
        grain: 0.5 * rough + 0.5 * (noise.at(layer as i32, (cell.id * 999.0) as i32) - 0.5),
    }
}

/// Smooth bark with lenticels, folds across and patches of lichen.
fn smooth([x, y]: [f32; 2], [across, up]: [i32; 2], depth: f32, noise: Noise) -> Point {
    let bend = cloud(noise.other(1), [x, y], [3, 4], 4);
    // Folds run around the trunk.
    let fold = cloud(noise.other(2), [x, y + 0.02 * bend], [across, 6 * up], 3);
    let rough = cloud(noise.other(3), [x, y], [110, 160], 3);
    // Lenticels: a short dash in some of the cells.
    let dash = |noise: Noise, across: i32, up: i32, share: f32| {
        let size = [1.0 / across as f32, 1.0 / up as f32];
        let cell = noise.cells([x * across as f32, y * up as f32], [across, up], 0.8, size);
        if cell.id < share { step(0.30, 0.12, cell.near) } else { 0.0 }
    };
    let lenticel = dash(noise.other(4), 40, 130, 0.22).max(dash(noise.other(5), 16, 70, 0.10));
    let patch = cloud(noise.other(6), [x, y], [4, 5], 5);
    let lichen = step(0.12, 0.5, patch + 0.25 * cloud(noise.other(8), [x, y], [40, 44], 4));
    let tone = cloud(noise.other(7), [x, y], [2, 3], 4);
    Point {
        deep: depth * (0.5 - 0.35 * fold - 0.5 * lenticel - 0.12 * rough - 0.1 * lichen),
        out: 1.0 - 0.45 * lenticel,
        stain: 0.4 + 0.9 * tone - 0.25 * fold - 0.6 * lichen,
        grain: 0.28 * rough + 0.22 * fold + 0.35 * lichen + 0.3 * tone,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERLACED: Relief = Relief::Interlaced { gap: 0.46, cracks: 0.2 };

    const BARK: Bark = Bark {
        relief: Relief::Ridges,
        plate: [0.06, 0.3],
        depth: 0.02,
        face: [0.3; 3],
        stain: [0.2; 3],
        fissure: [0.05; 3],
        roughness: 0.8,
    };

    /// Across the edges of the texture, neighbours differ as they do anywhere in it.
    #[test]
    fn bark_goes_on_at_the_opposite_edge() {
        for relief in [Relief::Smooth, Relief::Ridges, INTERLACED, Relief::Plates] {
            let side = 256usize;
            let canvas = paint(side as u32, &Bark { relief, ..BARK }, Noise::new(4, 1));
            let at = |column: usize, row: usize| canvas.pixels[row % side * side + column % side];
            let unlike = |a: Pixel, b: Pixel| {
                (a.color[0] - b.color[0]).abs() + 10.0 * (a.height - b.height).abs()
            };
            let column =
                |c: usize| -> f32 { (0..side).map(|r| unlike(at(c, r), at(c + 1, r))).sum() };
            let row = |r: usize| -> f32 { (0..side).map(|c| unlike(at(c, r), at(c, r + 1))).sum() };
            for step in [&column as &dyn Fn(usize) -> f32, &row] {
                let inside: Vec<f32> = (0..side - 1).map(step).collect();
                let most = inside.iter().copied().fold(0.0, f32::max);
                let across = step(side - 1);
                assert!(across <= most, "{relief:?}: {across} across the edge, {most} within");
            }
        }
    }

    #[test]
    fn fissures_are_as_deep_as_they_are_said_to_be() {
        for relief in [Relief::Ridges, INTERLACED, Relief::Plates] {
            let canvas = paint(256, &Bark { relief, ..BARK }, Noise::new(4, 1));
            let heights = canvas.pixels.iter().map(|pixel| pixel.height);
            let (low, high) = heights.fold((f32::MAX, f32::MIN), |(a, b), h| (a.min(h), b.max(h)));
            let depth = (high - low) / BARK.depth;
            assert!((0.8..1.5).contains(&depth), "{relief:?} {depth}");
        }
    }
}
