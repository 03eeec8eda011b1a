//! Painting leaves.

use super::atlas::{Card, TWIG};
use super::canvas::{Canvas, Mask, Rgb, blend, scaled};
use super::frond::Lamina;
use super::noise::{Noise, step};
use super::veins::Stroke;

/// What leaves are painted with; colours are the light that a leaf sends back or on, linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ink {
    /// Between the veins.
    pub(crate) blade: Rgb,
    /// In some places instead.
    pub(crate) mottle: Rgb,
    /// Midrib, veins and petiole.
    pub(crate) vein: Rgb,
    /// The colours that leaves turn to, card by card in turns, and how far they have: 0 not at all,
    /// 1 wholly.
    pub(crate) turned: [Rgb; 2],
    pub(crate) turning: f32,
    /// Share of the blade that is dry.
    pub(crate) dry: f32,
    /// Twigs.
    pub(crate) twig: Rgb,
    pub(crate) roughness: f32,
}

/// What dry spots look like.
const DRY: Rgb = [0.16, 0.075, 0.03];

/// Noise without a period that matters.
const WIDE: [i32; 2] = [4096, 4096];

/// Paints cards on a canvas, and the twig's bark at its edge.
pub(crate) fn paint(side: u32, cards: &[Card], ink: &Ink, noise: Noise) -> Canvas {
    let mut canvas = Canvas::new(side, ink.blade, ink.roughness);
    for (number, card) in cards.iter().enumerate() {
        let turned = ink.turned[number % 2];
        // The second kind is a little lighter and yellower.
        let tone = if number % 2 == 0 { [1.0; 3] } else { [1.12, 1.06, 0.95] };
        for stroke in &card.drawing.stems {
            stem(&mut canvas, card, stroke, ink.vein.map(|x| 0.8 * x));
        }
        for lamina in &card.drawing.laminae {
            blade(&mut canvas, card, lamina, ink, (turned, tone));
        }
        for (k, stroke) in card.drawing.needles.iter().enumerate() {
            let draw = noise.at(k as i32, 41);
            let turn = step(1.0 - ink.turning, 1.2 - ink.turning, noise.at(k as i32, 42));
            let color = blend(blend(ink.blade, ink.mottle, draw), turned, turn);
            stem(&mut canvas, card, stroke, color);
        }
    }
    twig(&mut canvas, ink, noise);
    canvas.spread_color();
    canvas
}

/// From the card's own coordinates to the canvas'.
fn place(card: &Card, p: [f32; 2]) -> [f32; 2] {
    [card.foot[0] + p[0] * card.length, card.foot[1] + p[1] * card.length]
}

/// Paints a rounded line over what is there.
fn stem(canvas: &mut Canvas, card: &Card, stroke: &Stroke, color: Rgb) {
    let least = 0.6 / canvas.side as f32;
    let widths = stroke.widths.map(|w| (w * card.length).max(least));
    let points: Vec<[f32; 2]> = stroke.points.iter().map(|&p| place(card, p)).collect();
    along(canvas.side, &points, widths, 1.5, |at, distance, width| {
        let edge = 1.0 / canvas.side as f32;
        let cover = step(width + 0.5 * edge, width - 0.5 * edge, distance);
        if cover <= 0.0 {
            return;
        }
        let pixel = &mut canvas.pixels[at];
        let round = libm::sqrtf((1.0 - (distance / width) * (distance / width)).max(0.0));
        let lit = scaled(color, 0.8 + 0.25 * round);
        let share = if pixel.alpha > 0.0 { cover } else { 1.0 };
        pixel.color = blend(pixel.color, lit, share);
        pixel.alpha = pixel.alpha.max(cover);
        pixel.height += (width * round - pixel.height) * cover;
    });
}

/// Visits the pixels near a line: index, distance to it, and its half-width there; `reach` is how
/// many half-widths far, a pixel more at least.
fn along(
    side: u32,
    points: &[[f32; 2]],
    widths: [f32; 2],
    reach: f32,
    mut visit: impl FnMut(usize, f32, f32),
) {
    let size = side as f32;
    let pieces = (points.len() - 1) as f32;
    for (k, ends) in points.windows(2).enumerate() {
        let [a, b] = [ends[0], ends[1]];
        let far = widths[0].max(widths[1]) * reach + 1.0 / size;
        let bound = |axis: usize| {
            let (low, high) = (a[axis].min(b[axis]) - far, a[axis].max(b[axis]) + far);
            ((low * size).max(0.0) as u32, ((high * size).max(0.0) as u32 + 1).min(side))
        };
        let ((left, right), (low, high)) = (bound(0), bound(1));
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let squared = (dx * dx + dy * dy).max(1e-12);
        for row in side - high..side - low.min(side) {
            let y = 1.0 - (row as f32 + 0.5) / size;
            for column in left..right {
                let x = (column as f32 + 0.5) / size;
                let t = (((x - a[0]) * dx + (y - a[1]) * dy) / squared).clamp(0.0, 1.0);
                let (ex, ey) = (x - a[0] - t * dx, y - a[1] - t * dy);
                let distance = libm::sqrtf(ex * ex + ey * ey);
                if distance <= far {
                    let share = (k as f32 + t) / pieces;
                    let width = widths[0] + (widths[1] - widths[0]) * share;
                    visit((row * side + column) as usize, distance, width);
                }
            }
        }
    }
}

/// How much of each pixel of a mask is vein, and how near one it is.
struct Venation {
    line: Vec<f32>,
    near: Vec<f32>,
}

fn venation(side: u32, card: &Card, lamina: &Lamina, mask: &Mask) -> Venation {
    let mut all = Venation { line: vec![0.0; mask.cover.len()], near: vec![0.0; mask.cover.len()] };
    let size = side as usize;
    let pixel = 1.0 / side as f32;
    for vein in &lamina.veins {
        if vein.points.len() < 2 {
            continue;
        }
        let points: Vec<[f32; 2]> = vein.points.iter().map(|&p| place(card, p)).collect();
        let widths = vein.widths.map(|w| (w * card.length).max(0.35 * pixel));
        let wide = (0.045 * lamina.seat.length * card.length).max(2.0 * pixel);
        let reach = (2.0 * wide / widths[0]).max(2.0);
        // What is thinner than a pixel is as much fainter.
        let thin = (1.4 * vein.widths[0] * card.length / pixel).clamp(0.3, 1.0);
        let strength = if vein.rank == 0 { 1.0 } else { 0.8 * thin };
        along(side, &points, widths, reach, |at, distance, width| {
            let (column, row) = (at % size, at / size);
            let (left, top) = (mask.corner[0] as usize, mask.corner[1] as usize);
            if column < left || column >= left + mask.width || row < top {
                return;
            }
            let k = (row - top) * mask.width + column - left;
            if k >= all.line.len() {
                return;
            }
            let line = strength * step(width + pixel, (width - pixel).max(0.0), distance);
            all.line[k] = all.line[k].max(line);
            let near = strength * step(2.0 * wide, 0.0, distance);
            all.near[k] = all.near[k].max(near);
        });
    }
    all
}

/// Paints a blade over what is there.
fn blade(canvas: &mut Canvas, card: &Card, lamina: &Lamina, ink: &Ink, (turned, tint): (Rgb, Rgb)) {
    let side = canvas.side;
    let outline: Vec<[f32; 2]> = lamina.outline.iter().map(|&p| place(card, p)).collect();
    let mask = Mask::of(side, &outline);
    if mask.width == 0 {
        return;
    }
    let veins = venation(side, card, lamina, &mask);
    let noise = lamina.noise;
    let tone = 0.82 + 0.36 * noise.at(2, 2);
    let turning = ink.turning * (0.55 + 0.9 * noise.at(3, 3));
    let size = side as f32;
    let scale = lamina.seat.length * card.length;
    for (k, &cover) in mask.cover.iter().enumerate() {
        if cover <= 0.0 {
            continue;
        }
        let (column, row) =
            (mask.corner[0] as usize + k % mask.width, mask.corner[1] as usize + k / mask.width);
        let x = ((column as f32 + 0.5) / size - card.foot[0]) / card.length;
        let y = (1.0 - (row as f32 + 0.5) / size - card.foot[1]) / card.length;
        let own = lamina.seat.own([x, y]).map(|x| x + 16.0);
        let cloud = noise.cloud(own.map(|x| 5.0 * x), WIDE, 3);
        let grain = noise.other(1).value(own.map(|x| 70.0 * x), WIDE);
        let net = noise.other(2).cells(own.map(|x| 34.0 * x), WIDE, 0.95, [1.0; 2]);
        let mesh = step(0.09, 0.0, net.border) * (1.0 - veins.near[k]);

        let mut color = blend(ink.blade, ink.mottle, (0.5 + 0.7 * cloud).clamp(0.0, 1.0));
        // What is far from the veins turns first.
        let turn = turning * 2.2 - 1.1 + 0.5 * cloud + 0.35 * (1.0 - 2.0 * veins.near[k]);
        color = core::array::from_fn(|k| color[k] * tint[k]);
        let fall = scaled(turned, 1.0 + 0.30 * cloud - 0.10 * veins.near[k]);
        color = blend(color, fall, step(-0.35, 0.35, turn));
        color = scaled(color, tone * (1.0 + 0.09 * grain));
        color = blend(color, ink.vein, 0.18 * mesh + 0.62 * veins.line[k]);
        let mut dry = 0.0;
        if ink.dry > 0.0 {
            let spot = noise.other(3).cloud(own.map(|x| 7.0 * x), WIDE, 4);
            let spread = 0.5 + spot + 2.4 * ink.dry;
            // Spots have a yellow border.
            color = blend(color, scaled(turned, 0.8), 0.7 * step(1.15, 1.32, spread));
            dry = step(1.30, 1.42, spread);
            color = blend(color, scaled(DRY, 1.0 + 0.5 * cloud + 0.2 * grain), dry);
        }

        let pixel = &mut canvas.pixels[row * side as usize + column];
        let share = if pixel.alpha > 0.0 { cover } else { 1.0 };
        pixel.color = blend(pixel.color, color, share);
        pixel.alpha = pixel.alpha.max(cover.min(1.0));
        let relief = 0.012 * (1.0 - veins.near[k]) - 0.006 * veins.line[k] + 0.0018 * net.border;
        pixel.height = scale * relief;
        pixel.roughness = ink.roughness + 0.12 * veins.line[k] + 0.2 * dry + 0.05 * grain;
    }
}

/// Paints the strip of twig bark.
fn twig(canvas: &mut Canvas, ink: &Ink, noise: Noise) {
    let side = canvas.side;
    let first = ((TWIG[0] * side as f32) as u32).saturating_sub(side / 128);
    for row in 0..side {
        let y = row as f32 / side as f32;
        for column in first..side {
            let x = (column - first) as f32 / side as f32;
            let grain = noise.other(50).cloud([x * 150.0, y * 40.0], WIDE, 3);
            let pixel = &mut canvas.pixels[(row * side + column) as usize];
            pixel.color = scaled(ink.twig, 1.0 + 0.35 * grain);
            pixel.alpha = 1.0;
            pixel.height = 0.001 * grain;
            pixel.roughness = 0.8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::atlas::cards;
    use super::super::frond::Frond;
    use super::super::outline::{Form, area};
    use super::*;

    const INK: Ink = Ink {
        blade: [0.1, 0.25, 0.05],
        mottle: [0.08, 0.2, 0.04],
        vein: [0.3, 0.4, 0.15],
        turned: [[0.5, 0.3, 0.05]; 2],
        turning: 0.0,
        dry: 0.0,
        twig: [0.1; 3],
        roughness: 0.5,
    };

    #[test]
    fn a_leaf_covers_the_area_of_its_outline() {
        let noise = Noise::new(3, 2);
        for form in [Form::Maple, Form::Beech, Form::Tulip] {
            let cards = cards(Frond::Leaf { form, petiole: 0.0 }, noise);
            let canvas = paint(256, &cards, &INK, noise);
            let left = (0.95 * 256.0) as usize;
            let rows = canvas.pixels.chunks(256);
            let cover: f32 = rows.flat_map(|row| &row[..left]).map(|pixel| pixel.alpha).sum();
            let outline =
                |card: &Card| card.length * card.length * area(&card.drawing.laminae[0].outline);
            let truth: f32 = cards.iter().map(outline).sum();
            let share = cover / (256.0 * 256.0) / truth;
            assert!((0.99..1.02).contains(&share), "{form:?}: {share}");
        }
    }

    #[test]
    fn green_leaves_are_green_and_turned_leaves_are_not() {
        let noise = Noise::new(3, 2);
        let cards = cards(Frond::Leaf { form: Form::Maple, petiole: 0.2 }, noise);
        let mean = |turning: f32| -> Rgb {
            let canvas = paint(256, &cards, &Ink { turning, ..INK }, noise);
            let blade = canvas.pixels.iter().filter(|pixel| pixel.alpha > 0.9);
            blade.fold([0.0; 3], |sum, pixel| core::array::from_fn(|k| sum[k] + pixel.color[k]))
        };
        let [red, green, blue] = mean(0.0);
        assert!(green > 1.5 * red && green > 2.0 * blue);
        let [red, green, _] = mean(1.0);
        assert!(red > green);
    }
}
