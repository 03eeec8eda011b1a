//! Venation: midrib, and veins that leave it towards the margin.

use super::noise::Noise;
use super::outline::{Form, within};

/// A line with the half-widths that it starts and ends with.
#[derive(Clone, Debug)]
pub(crate) struct Stroke {
    pub(crate) points: Vec<[f32; 2]>,
    pub(crate) widths: [f32; 2],
    /// 0 for midribs, 1 for veins that leave them, 2 for those that leave these.
    pub(crate) rank: u8,
}

/// How the veins of a form leave their midrib.
struct Habit {
    /// Pairs of veins.
    pairs: u32,
    /// Where the first and the last pair leave, as shares of the midrib.
    from: (f32, f32),
    /// Angle to the midrib in radians.
    angle: f32,
    /// How much they turn towards the apex over a unit of length, in radians.
    curve: f32,
}

const fn habit(form: Form) -> Habit {
    let (pairs, from, angle, curve) = match form {
        Form::Oak => (6, (0.08, 0.88), 0.86, 0.3),
        Form::Maple => (4, (0.25, 0.8), 0.72, 0.5),
        Form::Tulip => (5, (0.06, 0.86), 0.85, 0.2),
        Form::Beech => (8, (0.06, 0.90), 0.82, 0.6),
        Form::Leaflet => (9, (0.05, 0.92), 1.0, 2.2),
        Form::Lance => (13, (0.04, 0.93), 0.8, 5.0),
    };
    Habit { pairs, from, angle, curve }
}

/// The veins of a blade within its outline.
pub(crate) fn veins(form: Form, outline: &[[f32; 2]], noise: Noise) -> Vec<Stroke> {
    let base = form.base();
    let apex = [0.0, if matches!(form, Form::Tulip) { 0.87 } else { 0.985 }];
    let habit = habit(form);
    let mut all = Vec::new();
    let ends = form.palm().unwrap_or(&[]);
    let ends = if ends.is_empty() { vec![apex] } else { ends.to_vec() };
    for (number, end) in ends.iter().enumerate() {
        let number = number as u32;
        let share = if number < 3 { 1.0 } else { 0.55 };
        let main = run(base, *end, 0.97);
        let reach = share * 0.55;
        for pair in 0..habit.pairs {
            for side in [-1.0f32, 1.0] {
                let draw = noise.other(number).at(pair as i32, side as i32);
                let (low, high) = habit.from;
                let t = (pair as f32 + 0.35 * (draw - 0.5) + 0.12 * side)
                    / (habit.pairs - 1).max(1) as f32;
                let t = (low + (high - low) * t).clamp(0.02, 0.97);
                let start = at(&main, t);
                let direction = {
                    let (a, b) = (at(&main, (t - 0.05).max(0.0)), at(&main, (t + 0.05).min(1.0)));
                    libm::atan2f(b[0] - a[0], b[1] - a[1])
                };
                let angle = direction + side * (habit.angle + 0.12 * (draw - 0.5));
                let points = march(outline, start, angle, -side * habit.curve, reach);
                all.push(Stroke { points, widths: [0.0045 * share, 0.0015], rank: 1 });
            }
        }
        all.push(Stroke { points: main, widths: [0.011 * share, 0.003], rank: 0 });
    }
    all
}

/// A line from one point to another, as far as a share of the way.
fn run(a: [f32; 2], b: [f32; 2], share: f32) -> Vec<[f32; 2]> {
    (0..=12)
        .map(|k| k as f32 / 12.0 * share)
        .map(|t| [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t])
        .collect()
}

/// The point at a share of a line of evenly spaced points.
fn at(points: &[[f32; 2]], share: f32) -> [f32; 2] {
    let place = share * (points.len() - 1) as f32;
    let k = (place as usize).min(points.len() - 2);
    let (a, b, t) = (points[k], points[k + 1], place - k as f32);
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
}

/// A line that goes on in a direction, clockwise from y, turning, until it nears the outline.
fn march(outline: &[[f32; 2]], start: [f32; 2], angle: f32, turn: f32, most: f32) -> Vec<[f32; 2]> {
    const STEP: f32 = 0.012;
    let (mut p, mut angle, mut points) = (start, angle, vec![start]);
    for step in 0..(most / STEP) as u32 {
        let (sin, cos) = libm::sincosf(angle);
        p = [p[0] + STEP * sin, p[1] + STEP * cos];
        if !within(outline, [p[0] + STEP * sin, p[1] + STEP * cos]) {
            break;
        }
        // Veins are nearly straight: a point every few steps draws them.
        if step % 4 == 3 {
            points.push(p);
        }
        angle += STEP * turn;
    }
    points.push(p);
    points
}
