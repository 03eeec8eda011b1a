//! What one card shows: a leaf, a compound leaf, or a twig with leaves or needles, drawn from its
//! foot at (0, 0) to its tip at a height of 1.

use super::noise::Noise;
use super::outline::Form;
use super::veins::{Stroke, veins};

/// What one card shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Frond {
    /// A simple leaf, with the length of its petiole as a share of the whole.
    Leaf { form: Form, petiole: f32 },
    /// A leaf of opposite leaflets and one at the end.
    Pinnate { form: Form, pairs: u32 },
    /// A twig with alternate leaves.
    Twig(Spray),
    /// A twig full of needles of a length.
    Needles { fascicles: u32, length: f32 },
}

/// The leaves of a twig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spray {
    pub(crate) form: Form,
    pub(crate) leaves: u32,
    /// Length of leaves as a share of the card's.
    pub(crate) length: f32,
    /// Their angle to the twig in radians.
    pub(crate) angle: f32,
    /// How much twig and leaves twist: 0 to 1.
    pub(crate) twist: f32,
    /// How much leaves crowd towards the tip: 0 to 1.
    pub(crate) crowd: f32,
}

/// One blade in its place.
#[derive(Debug)]
pub(crate) struct Lamina {
    pub(crate) outline: Vec<[f32; 2]>,
    pub(crate) veins: Vec<Stroke>,
    pub(crate) seat: Seat,
    /// A number of its own.
    pub(crate) noise: Noise,
}

/// Where a blade sits: its base, the direction of its midrib clockwise from upwards, its length,
/// and how much it bends over its length, in radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seat {
    pub(crate) base: [f32; 2],
    pub(crate) angle: f32,
    pub(crate) length: f32,
    pub(crate) bend: f32,
}

impl Seat {
    /// From the blade's own coordinates.
    pub(crate) fn put(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let (middle, here) = (libm::sincosf(0.5 * self.bend * y), libm::sincosf(self.bend * y));
        let p = [y * middle.0 + x * here.1, y * middle.1 - x * here.0];
        let (sin, cos) = libm::sincosf(self.angle);
        let [x, y] = p.map(|x| x * self.length);
        [self.base[0] + x * cos + y * sin, self.base[1] - x * sin + y * cos]
    }

    /// To the blade's own coordinates, its bend left out.
    pub(crate) fn own(&self, p: [f32; 2]) -> [f32; 2] {
        let (sin, cos) = libm::sincosf(self.angle);
        let (x, y) = (p[0] - self.base[0], p[1] - self.base[1]);
        [(x * cos - y * sin) / self.length, (x * sin + y * cos) / self.length]
    }
}

/// Everything that a card shows, in the order in which it is painted.
#[derive(Debug, Default)]
pub(crate) struct Drawing {
    pub(crate) laminae: Vec<Lamina>,
    /// Petioles, rachises and twigs.
    pub(crate) stems: Vec<Stroke>,
    /// Needles.
    pub(crate) needles: Vec<Stroke>,
}

impl Drawing {
    fn blade(&mut self, form: Form, seat: Seat, noise: Noise) {
        let own = form.outline(noise);
        let put = |points: &[[f32; 2]]| points.iter().map(|&p| seat.put(p)).collect();
        let veins = veins(form, &own, noise.other(9))
            .into_iter()
            .map(|vein| Stroke {
                points: put(&vein.points),
                widths: vein.widths.map(|w| w * seat.length),
                ..vein
            })
            .collect();
        self.laminae.push(Lamina { outline: put(&own), veins, seat, noise });
    }

    fn stem(&mut self, points: Vec<[f32; 2]>, widths: [f32; 2]) {
        self.stems.push(Stroke { points, widths, rank: 0 });
    }

    /// How far it goes to either side.
    pub(crate) fn half_width(&self) -> f32 {
        let blades = self.laminae.iter().flat_map(|lamina| &lamina.outline);
        let needles = self.needles.iter().flat_map(|needle| &needle.points);
        blades.chain(needles).map(|p| p[0].abs()).fold(0.02, f32::max)
    }
}

/// A line from one point to another in pieces, bulging to the right.
fn line(a: [f32; 2], b: [f32; 2], bulge: f32) -> Vec<[f32; 2]> {
    (0..=8)
        .map(|k| k as f32 / 8.0)
        .map(|t| {
            let out = 4.0 * t * (1.0 - t) * bulge;
            [a[0] + (b[0] - a[0]) * t + out, a[1] + (b[1] - a[1]) * t]
        })
        .collect()
}

impl Frond {
    /// One of many of its kind.
    pub(crate) fn draw(self, noise: Noise) -> Drawing {
        let mut drawing = Drawing::default();
        match self {
            Self::Leaf { form, petiole } => leaf(&mut drawing, form, petiole, noise),
            Self::Pinnate { form, pairs } => pinnate(&mut drawing, form, pairs, noise),
            Self::Twig(spray) => twig(&mut drawing, &spray, noise),
            Self::Needles { fascicles, length } => needles(&mut drawing, fascicles, length, noise),
        }
        drawing
    }
}

fn leaf(drawing: &mut Drawing, form: Form, petiole: f32, noise: Noise) {
    let base = form.base()[1];
    let length = (1.0 - petiole) / (1.0 - 0.0 * base);
    let bend = 0.16 * (noise.at(1, 9) - 0.5);
    // The blade ends at a height of 1.
    let seat = Seat { base: [0.0, 1.0 - length], angle: -0.5 * bend, length, bend };
    let foot = seat.put([0.0, base]);
    drawing.stem(line([0.0, 0.0], foot, 0.0), [0.010, 0.007]);
    drawing.blade(form, seat, noise);
}

fn pinnate(drawing: &mut Drawing, form: Form, pairs: u32, noise: Noise) {
    let top = 0.66;
    drawing.stem(line([0.0, 0.0], [0.0, top + 0.03], 0.012), [0.009, 0.004]);
    for pair in 0..pairs {
        let share = pair as f32 / (pairs - 1).max(1) as f32;
        let y = 0.20 + (top - 0.05 - 0.20) * share;
        for side in [-1.0f32, 1.0] {
            let draw = noise.other(pair).at(side as i32, 3);
            let length = (0.27 + 0.10 * share) * (0.92 + 0.16 * draw);
            let angle = side * (1.05 - 0.25 * share + 0.15 * (draw - 0.5));
            let bend = -side * 0.25;
            let seat = Seat { base: [side * 0.004, y + 0.012 * draw], angle, length, bend };
            drawing.blade(form, seat, noise.other(10 * pair + (side > 0.0) as u32));
        }
    }
    let seat = Seat { base: [0.0, top], angle: 0.0, length: 1.0 - top, bend: 0.0 };
    drawing.blade(form, seat, noise.other(99));
}

fn twig(drawing: &mut Drawing, spray: &Spray, noise: Noise) {
    let &Spray { form, leaves, length, angle, twist, crowd } = spray;
    let top = 1.0 - 0.8 * length;
    let sway = |y: f32| 0.03 * (1.0 + 4.0 * twist) * libm::sinf((5.0 + 6.0 * twist) * y);
    let stem: Vec<[f32; 2]> =
        (0..=24).map(|k| k as f32 / 24.0 * top).map(|y| [sway(y), y]).collect();
    drawing.stem(stem, [0.007, 0.003]);
    for k in 0..leaves {
        let draw = noise.other(k).at(5, 5);
        let share = (k as f32 + 0.6 * draw) / leaves as f32;
        let y = 0.06 + (top - 0.06) * libm::powf(share, 1.0 - 0.6 * crowd);
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let angle = side * (angle + 0.35 * (draw - 0.5));
        let bend = -side * 0.5 * angle + twist * 3.0 * (draw - 0.5);
        let length = length * (0.75 + 0.35 * draw) * (1.0 - 0.25 * share * share);
        drawing.blade(form, Seat { base: [sway(y), y], angle, length, bend }, noise.other(k));
    }
    let seat = Seat { base: [sway(top), top], angle: 0.0, length: 1.0 - top, bend: 0.2 };
    drawing.blade(form, seat, noise.other(99));
}

fn needles(drawing: &mut Drawing, fascicles: u32, length: f32, noise: Noise) {
    let top = 1.0 - 0.85 * length;
    drawing.stem(line([0.0, 0.0], [0.0, top], 0.01), [0.016, 0.009]);
    for k in 0..fascicles {
        let share = (k as f32 + noise.at(k as i32, 0)) / fascicles as f32;
        let y = 0.04 + (top - 0.04) * share;
        // Around the twig: those to the viewer are short.
        let around = noise.at(k as i32, 1) * core::f32::consts::TAU;
        let (side, _) = libm::sincosf(around);
        for needle in 0..2 {
            let draw = noise.at(k as i32, 2 + needle);
            let lean = 0.75 - 0.35 * share + 0.3 * (draw - 0.5);
            let (sin, cos) = libm::sincosf(lean);
            let long = length * (0.8 + 0.3 * draw);
            let out = side * sin + 0.06 * (needle as f32 - 0.5);
            let tip = [out * long, y + cos * long];
            let points = line([0.0, y], tip, -0.06 * long * side);
            drawing.needles.push(Stroke { points, widths: [0.0042, 0.0022], rank: 0 });
        }
    }
}
