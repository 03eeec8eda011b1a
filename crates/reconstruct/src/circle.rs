//! Circles through points that may show one side of a stem only.

use deeptree_graph::Vec2;
use glam::DVec2;

/// Steps of the fit; it converges quadratically.
const STEPS: usize = 12;

/// Sectors that the arc is counted in.
const SECTORS: usize = 24;

/// A circle fitted to points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Circle {
    pub(crate) centre: Vec2,
    /// In metres.
    pub(crate) radius: f32,
    /// Mean distance of the points from the circle, in metres.
    pub(crate) error: f32,
    /// Share of the circle that has points on it, 0 to 1.
    pub(crate) arc: f32,
}

/// The circle that fits best.
///
/// Starts from the algebraic fit and goes on by Gauss–Newton steps on `|p − c| − r`, weighted by
/// Cauchy's law with a tenth of the points' spread, so that the middle of a noisy rim is found and
/// points off it count little. None of fewer than five points, and where no circle fits.
///
/// # Source
///
/// Kåsa 1976, "A circle fitting procedure and its error analysis"; iteratively reweighted least
/// squares.
pub(crate) fn fit(points: &[Vec2]) -> Option<Circle> {
    if points.len() < 5 {
        return None;
    }
    let n = points.len() as f64;
    let mean: DVec2 = points.iter().map(|p| p.as_dvec2()).sum::<DVec2>() / n;
    let local: Vec<DVec2> = points.iter().map(|p| p.as_dvec2() - mean).collect();
    let scale = libm::sqrt(local.iter().map(|p| p.length_squared()).sum::<f64>() / n);
    let (mut centre, mut radius) = algebraic(&local)?;
    for _ in 0..STEPS {
        let mut normal = [[0.0; 3]; 3];
        let mut right = [0.0; 3];
        for p in &local {
            let from = *p - centre;
            let length = from.length();
            if length <= 0.0 {
                continue;
            }
            let residual = length - radius;
            let off = residual / (0.1 * scale);
            let weight = 1.0 / (1.0 + off * off);
            let row = [-from.x / length, -from.y / length, -1.0];
            for i in 0..3 {
                right[i] -= weight * row[i] * residual;
                for k in 0..3 {
                    normal[i][k] += weight * row[i] * row[k];
                }
            }
        }
        let [x, y, r] = solve(normal, right)?;
        centre += DVec2::new(x, y);
        radius += r;
    }
    let is_sound = radius > 0.0 && radius < 20.0 * scale && centre.is_finite();
    is_sound.then(|| {
        let errors: f64 = local.iter().map(|p| (p.distance(centre) - radius).abs()).sum();
        let mut seen = [false; SECTORS];
        for p in &local {
            let from = *p - centre;
            let turn = libm::atan2(from.y, from.x) / core::f64::consts::TAU + 0.5;
            seen[((turn * SECTORS as f64) as usize).min(SECTORS - 1)] = true;
        }
        Circle {
            centre: (centre + mean).as_vec2(),
            radius: radius as f32,
            error: (errors / n) as f32,
            arc: seen.iter().filter(|seen| **seen).count() as f32 / SECTORS as f32,
        }
    })
}

/// `x² + y² = 2 a x + 2 b y + c` by least squares: centre (a, b), radius √(c + a² + b²).
fn algebraic(points: &[DVec2]) -> Option<(DVec2, f64)> {
    let mut normal = [[0.0; 3]; 3];
    let mut right = [0.0; 3];
    for p in points {
        let row = [2.0 * p.x, 2.0 * p.y, 1.0];
        for i in 0..3 {
            right[i] += row[i] * p.length_squared();
            for k in 0..3 {
                normal[i][k] += row[i] * row[k];
            }
        }
    }
    let [a, b, c] = solve(normal, right)?;
    let squared = c + a * a + b * b;
    (squared > 0.0).then(|| (DVec2::new(a, b), libm::sqrt(squared)))
}

/// Cramer's rule; none where the equations say too little.
fn solve(m: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let all = determinant(m);
    let size = m[0][0] * m[1][1] * m[2][2];
    // Written so that what is no number says too little, too.
    let says_enough = all.abs() > 1e-9 * size.abs();
    if !says_enough {
        return None;
    }
    let with = |column: usize| {
        let mut m = m;
        (0..3).for_each(|i| m[i][column] = right[i]);
        determinant(m) / all
    };
    Some([with(0), with(1), with(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(from: f32, to: f32, n: u16) -> Vec<Vec2> {
        let at = |i: u16| {
            let (sin, cos) = (from + (to - from) * f32::from(i) / f32::from(n)).sin_cos();
            Vec2::new(50.0, -20.0) + 0.3 * Vec2::new(cos, sin)
        };
        (0..n).map(at).collect()
    }

    #[test]
    fn points_of_an_arc_give_its_circle_whatever_part_is_seen() {
        for (to, arc_seen) in [(6.2, 1.0), (3.1, 0.5), (1.6, 0.25)] {
            let circle = fit(&arc(0.0, to, 60)).unwrap();
            assert!(circle.centre.distance(Vec2::new(50.0, -20.0)) < 2e-3, "{circle:?}");
            assert!((circle.radius - 0.3).abs() < 2e-3, "{circle:?}");
            assert!((circle.arc - arc_seen).abs() < 0.1, "{circle:?}");
        }
    }

    #[test]
    fn a_few_points_off_the_circle_move_it_little() {
        let mut points = arc(0.0, 3.5, 60);
        points.extend((0..8).map(|i| Vec2::new(50.5 + 0.05 * i as f32, -19.8)));
        let circle = fit(&points).unwrap();
        assert!((circle.radius - 0.3).abs() < 0.01, "{circle:?}");
    }

    #[test]
    fn points_on_a_line_or_at_one_place_have_no_circle() {
        let line: Vec<Vec2> = (0..20).map(|i| Vec2::splat(i as f32)).collect();
        assert_eq!(fit(&line).filter(|circle| circle.radius < 50.0), None);
        assert_eq!(fit(&[Vec2::ONE; 9]), None);
        assert_eq!(fit(&line[..3]), None);
    }
}
