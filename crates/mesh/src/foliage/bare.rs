//! A shoot of a length of 1 in winter: its twig and side twigs, of wood alone.

use core::f32::consts::{PI, TAU};

use deeptree_graph::Vec3;

use super::blade::RADII;
use super::habit::Habit;
use crate::circle::square;
use crate::dressed::Blade;
use crate::texture::noise::Noise;

/// Corners of a twig's cross-section.
const SIDES: u32 = 3;

/// The bare shoot of a species.
pub(crate) fn blade(habit: &Habit, noise: Noise, coarse: bool) -> Blade {
    let bare = habit.bare;
    // A length of 1 is that of the shoot with its leaves.
    let length = habit.length / habit.whole_length();
    let radii = RADII.map(|radius| radius * bare.thickness * length);
    let turn = TAU * noise.at(0, 1);
    let main = |share: f32| {
        // It rises as leafy shoots do, and winds once from side to side, square to that.
        let (side, other) = libm::sincosf(turn + 1.5 * TAU * share);
        let wind = bare.wind * share * (1.0 - 0.5 * share);
        let lift = 0.10 * share * (1.0 - share) + wind * (other - libm::cosf(turn));
        Vec3::new(wind * side, lift, -share) * length
    };
    let mut blade = Blade::default();
    let winding = bare.wind >= 0.01;
    let (rows, side_rows) = if coarse { (2, 1) } else { (if winding { 4 } else { 2 }, 2) };
    rod(&mut blade, main, rows, radii);
    for side in 0..bare.sides {
        let draw = |k| noise.at(side as i32 + 1, k);
        let share = (side as f32 + 0.5 + 0.6 * (draw(0) - 0.5)) / bare.sides as f32;
        let share = 0.12 + 0.83 * share;
        let angle = habit.phyllotaxis.angle(side) + 0.6 * (draw(1) - 0.5);
        let (sin, cos) = libm::sincosf(angle);
        // As flat as the leafy shoot; round where leaves stand around it.
        let out = Vec3::new(cos, sin * habit.round.max(0.3), 0.0).normalize();
        let (sin, cos) = libm::sincosf(bare.angle * (0.75 + 0.5 * draw(2)));
        let along = Vec3::NEG_Z * cos + out * sin;
        let reach = bare.length * length * (0.45 + 0.55 * draw(3)) * (1.0 - 0.4 * share);
        let (foot, bend) = (main(share), 0.15 * reach * (draw(4) - 0.5));
        let across = square(Vec3::Y, along);
        let way = |t: f32| foot + along * (reach * t) + across * (4.0 * bend * t * (1.0 - t));
        let thick = thickness(radii, share) * 0.7;
        rod(&mut blade, way, side_rows, [thick, thick * 0.45]);
    }
    blade
}

fn thickness(radii: [f32; 2], share: f32) -> f32 {
    radii[0] + (radii[1] - radii[0]) * share
}

/// A twig along a way from 0 to 1, with a point at its end.
fn rod(blade: &mut Blade, way: impl Fn(f32) -> Vec3, rows: u32, radii: [f32; 2]) {
    let first = blade.positions.len() as u32;
    let (foot, tip) = (way(0.0), way(1.0));
    let front = (tip - foot).normalize_or(Vec3::NEG_Z);
    let right = square(Vec3::X, front);
    let up = right.cross(front);
    for row in 0..rows {
        let share = row as f32 / rows as f32;
        for k in 0..SIDES {
            let (sin, cos) = libm::sincosf(k as f32 * TAU / SIDES as f32 + PI / 6.0);
            let out = right * cos + up * sin;
            blade.positions.push(way(share) + out * thickness(radii, share));
            blade.normals.push(out);
            blade.uvs.push([k as f32 / SIDES as f32, share]);
        }
    }
    blade.positions.push(tip);
    blade.normals.push(front);
    blade.uvs.push([0.5, 1.0]);
    let last = first + rows * SIDES;
    for row in 0..rows {
        for k in 0..SIDES {
            let (a, b) = (first + row * SIDES + k, first + row * SIDES + (k + 1) % SIDES);
            if row + 1 < rows {
                blade.indices.extend([a, b + SIDES, b, a, a + SIDES, b + SIDES]);
            } else {
                blade.indices.extend([a, last, b]);
            }
        }
    }
}
