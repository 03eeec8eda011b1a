//! Triangles between two rows of vertices that need not have equally many.
//!
//! Each edge of a row gets a triangle with the vertex of the other row that lies nearest to its
//! middle: edges of both rows are taken in the order of their middles.

/// Angle-like number of a direction, growing counter-clockwise from −y: 0 to 4.
///
/// As good as an angle to sort by, and exact: the way around the square |x| + |y| = 1.
fn diamond(x: f32, y: f32) -> f32 {
    let length = x.abs() + y.abs();
    if length == 0.0 {
        return 0.0;
    }
    let (x, y) = (x / length, y / length);
    if x >= 0.0 { 1.0 + y } else { 3.0 - y }
}

/// The triangles between the rows `low` and `high`, whose vertices have growing angles; both rows
/// span the same turn. Gives each triangle as (row, index) thrice: row 0 is `low`.
pub(crate) fn strip(low: &[f32], high: &[f32], mut emit: impl FnMut([(bool, usize); 3])) {
    let (mut i, mut j) = (0, 0);
    while i + 1 < low.len() || j + 1 < high.len() {
        let middle = |row: &[f32], k: usize| {
            if k + 1 < row.len() { row[k] + row[k + 1] } else { f32::INFINITY }
        };
        if middle(low, i) <= middle(high, j) {
            emit([(false, i), (false, i + 1), (true, j)]);
            i += 1;
        } else {
            emit([(false, i), (true, j + 1), (true, j)]);
            j += 1;
        }
    }
}

/// The triangles between a rectangle of `outer` vertices around the origin and a regular polygon
/// within it, on the unit `circle`, its first vertex towards −y, both counter-clockwise.
///
/// No triangle is turned over: an edge of the polygon only gets a vertex that lies before it.
/// Gives each triangle as (outer?, index) thrice, counter-clockwise.
pub(crate) fn ring(
    outer: &[[f32; 2]],
    circle: &[[f32; 2]],
    mut emit: impl FnMut([(bool, usize); 3]),
) {
    let (n, sides) = (outer.len(), circle.len() - 1);
    // Outer vertices as if the rectangle were the square around the circle: an edge of the polygon
    // then gets a vertex of the quarter that it faces, however long the rectangle is.
    let extent = |axis: usize, sign: f32| {
        outer.iter().map(|p| sign * p[axis]).fold(f32::MIN_POSITIVE, f32::max)
    };
    let (right, left) = (extent(0, 1.0), extent(0, -1.0));
    let (high, low) = (extent(1, 1.0), extent(1, -1.0));
    let scaled = |i: usize| {
        let [x, y] = outer[i % n];
        [x / if x > 0.0 { right } else { left }, y / if y > 0.0 { high } else { low }]
    };
    let start = diamond(scaled(0)[0], scaled(0)[1]);
    let after_start = |x: f32, y: f32| (diamond(x, y) - start).rem_euclid(4.0);
    let middle_out = |i: usize| {
        let (a, b) = (scaled(i), scaled(i + 1));
        after_start(0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))
    };
    // The middle of an edge of the polygon, whose vertices are (sin, −cos).
    let edge = |k: usize| {
        let ([c, s], [d, t]) = (circle[k], circle[k + 1]);
        [0.5 * (s + t), -0.5 * (c + d)]
    };
    let middle_in = |k: usize| after_start(edge(k)[0], edge(k)[1]);
    let sees = |i: usize, k: usize| {
        let ([x, y], [a, b]) = (outer[i % n], edge(k));
        x * a + y * b > 1.001 * (a * a + b * b)
    };
    // The inner edge whose middle comes first after the start; those before it come last.
    let first = (0..sides)
        .reduce(|best, k| if middle_in(k) < middle_in(best) { k } else { best })
        .unwrap_or(0);
    let inner = |j: usize| (first + j) % sides;
    let (mut i, mut j) = (0, 0);
    while i < n || j < sides {
        let out_first = i < n && (j == sides || middle_out(i) <= middle_in(inner(j)));
        let out = if i < n && j < sides {
            let (here, there) = (sees(i, inner(j)), sees(i + 1, inner(j)));
            if here == there { out_first } else { there }
        } else {
            out_first
        };
        if out {
            emit([(true, i), (true, (i + 1) % n), (false, inner(j))]);
            i += 1;
        } else {
            emit([(false, inner(j + 1)), (false, inner(j)), (true, i % n)]);
            j += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diamonds_grow_with_the_angle() {
        let angles = (0..1000).map(|k| -1.57 + k as f32 * core::f32::consts::TAU / 1000.0);
        let turns: Vec<f32> = angles.map(|a| diamond(libm::cosf(a), libm::sinf(a))).collect();
        assert!(turns[1..999].is_sorted(), "{turns:?}");
    }

    /// A rectangle around the unit circle, its lower and upper side divided.
    fn rectangle(left: f32, right: f32, low: f32, high: f32, width: usize) -> Vec<[f32; 2]> {
        let x = |c: usize| -left + (left + right) * c as f32 / width as f32;
        let bottom = (0..=width).map(|c| [x(c), -low]);
        bottom.chain((0..=width).rev().map(|c| [x(c), high])).collect()
    }

    #[test]
    fn no_triangle_of_a_ring_is_turned_over_and_the_area_is_that_between() {
        for width in [1, 2, 3, 5, 9] {
            for sides in [3, 4, 5, 8, 16, 33] {
                for (left, right, low, high) in [
                    (1.2, 1.2, 1.2, 1.2),
                    (1.3, 1.3, 20.0, 20.0),
                    (8.0, 8.0, 1.2, 1.2),
                    (1.2, 5.0, 1.2, 9.0),
                    (30.0, 1.1, 40.0, 1.25),
                    (1.2, 1.2, 60.0, 1.2),
                ] {
                    let outer = rectangle(left, right, low, high, width);
                    let inner = |k: usize| {
                        let angle = core::f32::consts::TAU * k as f32 / sides as f32;
                        [libm::sinf(angle), -libm::cosf(angle)]
                    };
                    let (mut total, mut count) = (0.0, 0);
                    ring(&outer, &crate::circle::circle(sides as u32), |t| {
                        let [a, b, c] = t.map(|(out, i)| if out { outer[i] } else { inner(i) });
                        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                        assert!(area > 0.0, "{width} {sides} {left} {right} {low} {high} {t:?}");
                        total += area;
                        count += 1;
                    });
                    assert_eq!(count, outer.len() + sides);
                    // Twice the rectangle, less twice the regular polygon.
                    let polygon = sides as f32 * libm::sinf(core::f32::consts::TAU / sides as f32);
                    let exact = 2.0 * (left + right) * (low + high) - polygon;
                    assert!((total / exact - 1.0).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn a_strip_has_a_triangle_for_each_edge() {
        let row = |n: usize| (0..=n).map(|k| k as f32 / n as f32).collect::<Vec<_>>();
        for (a, b) in [(3, 8), (5, 5), (12, 4)] {
            let mut edges = 0;
            strip(&row(a), &row(b), |t| {
                edges += 1;
                let area = |p: [f32; 2], q: [f32; 2], r: [f32; 2]| {
                    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
                };
                let [p, q, r] =
                    t.map(|(high, k)| if high { [row(b)[k], 1.0] } else { [row(a)[k], 0.0] });
                assert!(area(p, q, r) > 0.0, "{t:?}");
            });
            assert_eq!(edges, a + b);
        }
    }
}
