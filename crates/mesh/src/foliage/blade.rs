//! The geometry of one shoot of a length of 1: its twig, and its leaves as cards.

use deeptree_graph::Vec3;

use super::habit::{Cards, Habit};
use crate::circle::square;
use crate::dressed::Blade;
use crate::texture::atlas::{Card, Rect, TWIG};
use crate::texture::noise::Noise;

/// Half of the angle by which leaves fold upwards along their midrib, in radians.
const FOLD: f32 = 0.22;

/// How far the tip of a leaf hangs, as a share of its length.
const HANG: f32 = 0.16;

/// Radius of the twig over its length at its foot and its tip.
pub(super) const RADII: [f32; 2] = [0.010, 0.004];

/// The blade of a species with the cards of its texture.
pub(crate) fn blade(habit: &Habit, cards: &[&Card], noise: Noise, coarse: bool) -> Blade {
    let mut blade = Blade::default();
    match habit.cards {
        Cards::Along { leaves, length, angle } => {
            let whole = habit.whole_length();
            let (length, twig_length) = (length / whole, habit.length / whole);
            twig(&mut blade, twig_length);
            for leaf in 0..leaves {
                let draw = |k| noise.at(leaf as i32, k);
                // Leaves crowd towards the tip.
                let many = habit.phyllotaxis.at_a_node();
                let nodes = leaves.div_ceil(many) as f32;
                let share = ((leaf / many) as f32 + 1.0) / nodes;
                let at = (0.98 - 0.78 * (1.0 - share)) * twig_length;
                let last = leaf + 1 == leaves && many == 1;
                let around = habit.phyllotaxis.angle(leaf);
                let (sin, cos) = libm::sincosf(around);
                let out = Vec3::new(cos, sin * habit.round, 0.0);
                let turn = if last { 0.25 } else { angle * (0.85 + 0.3 * draw(0)) };
                let (sin, cos) = libm::sincosf(turn);
                let along = (Vec3::NEG_Z * cos + out * sin + Vec3::Y * 0.06).normalize();
                let up = Vec3::Y
                    + Vec3::NEG_Z * (0.35 * habit.round)
                    + Vec3::new(draw(1) - 0.5, 0.0, draw(2) - 0.5) * 0.7;
                let size = length * (0.8 + 0.3 * draw(3)) * if last { 0.9 } else { 1.0 };
                let card = cards[leaf as usize % cards.len()];
                let seat = Seat {
                    foot: stem(at),
                    along,
                    up: square(up, along),
                    length: size,
                    half_width: card.half_width * size,
                };
                seat.add(&mut blade, card.rect(), if coarse { Bend::Flat } else { Bend::Leaf });
            }
        }
        Cards::Around(many) => {
            for k in 0..many {
                let (sin, cos) =
                    libm::sincosf(k as f32 * core::f32::consts::PI / many as f32 + 0.2);
                let card = cards[k as usize % cards.len()];
                let seat = Seat {
                    foot: Vec3::ZERO,
                    along: Vec3::NEG_Z,
                    up: Vec3::new(-sin, cos, 0.0),
                    length: 1.0,
                    half_width: card.half_width,
                };
                seat.add(&mut blade, card.rect(), if coarse { Bend::Flat } else { Bend::Twig });
            }
        }
    }
    blade
}

/// The point at a share of a twig, which rises a little in its middle.
fn stem(share: f32) -> Vec3 {
    Vec3::new(0.0, 0.10 * share * (1.0 - share), -share)
}

/// How a card bends.
#[derive(Clone, Copy, PartialEq)]
enum Bend {
    Flat,
    /// Folded along its midrib, its tip hanging.
    Leaf,
    /// As a twig does.
    Twig,
}

/// Where a card is.
struct Seat {
    foot: Vec3,
    along: Vec3,
    up: Vec3,
    length: f32,
    half_width: f32,
}

impl Seat {
    fn add(&self, blade: &mut Blade, [left, low, right, high]: Rect, bend: Bend) {
        let side = self.along.cross(self.up);
        let (columns, rows): (u32, u32) = match bend {
            Bend::Flat => (2, 2),
            Bend::Leaf => (3, 2),
            Bend::Twig => (2, 4),
        };
        let first = blade.positions.len() as u32;
        for row in 0..rows {
            let v = row as f32 / (rows - 1) as f32;
            for column in 0..columns {
                let u = column as f32 / (columns - 1) as f32;
                let out = (2.0 * u - 1.0) * self.half_width;
                let lift = match bend {
                    Bend::Flat => 0.0,
                    Bend::Leaf => FOLD * out.abs() - HANG * v * v * self.length,
                    Bend::Twig => (0.12 * v - 0.22 * v * v) * self.length,
                };
                let place = self.along * (v * self.length) + side * out + self.up * lift;
                blade.positions.push(self.foot + place);
                blade.uvs.push([left + (right - left) * u, low + (high - low) * v]);
            }
        }
        let start = blade.indices.len();
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let a = first + row * columns + column;
                let (b, c, d) = (a + 1, a + columns + 1, a + columns);
                blade.indices.extend([a, b, c, a, c, d]);
            }
        }
        normals(blade, first, start);
    }
}

/// The twig of a length: a prism of three sides with a bend.
fn twig(blade: &mut Blade, length: f32) {
    const ROWS: u32 = 3;
    let first = blade.positions.len() as u32;
    for row in 0..ROWS {
        let share = row as f32 / (ROWS - 1) as f32;
        let radius = RADII[0] + (RADII[1] - RADII[0]) * share;
        // The first side again at the end, for the texture.
        for k in 0..4 {
            let angle = k as f32 * core::f32::consts::TAU / 3.0;
            let (sin, cos) = libm::sincosf(angle);
            let out = Vec3::new(cos, sin, 0.0);
            blade.positions.push(stem(share * length) + out * radius);
            blade.normals.push(out);
            let u = TWIG[0] + (TWIG[2] - TWIG[0]) * k as f32 / 3.0;
            blade.uvs.push([u, share * TWIG[3]]);
        }
    }
    for row in 0..ROWS - 1 {
        for k in 0..3 {
            let a = first + row * 4 + k;
            let (b, c, d) = (a + 1, a + 5, a + 4);
            blade.indices.extend([a, c, b, a, d, c]);
        }
    }
}

/// The normals of vertices from `first` on by their triangles, which start at `start`.
fn normals(blade: &mut Blade, first: u32, start: usize) {
    blade.normals.resize(blade.positions.len(), Vec3::ZERO);
    for t in blade.indices[start..].as_chunks::<3>().0 {
        let [a, b, c] = t.map(|i| blade.positions[i as usize]);
        let face = (b - a).cross(c - a);
        for &i in t {
            blade.normals[i as usize] += face;
        }
    }
    for normal in &mut blade.normals[first as usize..] {
        *normal = normal.try_normalize().unwrap_or(Vec3::Y);
    }
}
