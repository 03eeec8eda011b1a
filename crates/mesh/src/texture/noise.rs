//! Random fields in the plane that repeat, as textures do.
//!
//! # Source
//!
//! Value noise; the easing is 6t⁵ − 15t⁴ + 10t³ of Perlin 2002, "Improving noise". Cells: Worley
//! 1996, "A cellular texture basis function".

/// Random fields of one seed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    pub(crate) seed: u32,
}

/// The nearest points of a cell field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Distance to the nearest point.
    pub(crate) near: f32,
    /// Distance to the border between the nearest point and the next one.
    pub(crate) border: f32,
    /// 24 random bits of the nearest point as a number in [0, 1).
    pub(crate) id: f32,
}

/// The largest whole number not above `x`, and what `x` has beyond it.
fn split(x: f32) -> (i32, f32) {
    let whole = x as i32;
    let whole = if (whole as f32) > x { whole - 1 } else { whole };
    (whole, x - whole as f32)
}

/// A lattice coordinate within the period; most are, and a division takes long.
fn wrap(i: i32, period: i32) -> i32 {
    if (0..period).contains(&i) { i } else { i.rem_euclid(period) }
}

fn ease(t: f32) -> f32 {
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

impl Noise {
    /// The fields of a seed, one of many by `number`.
    pub(crate) const fn new(seed: u64, number: u32) -> Self {
        let low = seed as u32 ^ ((seed >> 32) as u32).rotate_left(13);
        Self { seed: mix(low ^ number.wrapping_mul(0x9e37_79b9)) }
    }

    /// Other fields, one of many by `number`.
    pub(crate) const fn other(self, number: u32) -> Self {
        Self { seed: mix(self.seed ^ number.wrapping_mul(0x85eb_ca6b).wrapping_add(1)) }
    }

    /// A number in [0, 1) for a lattice point.
    pub(crate) const fn at(self, i: i32, j: i32) -> f32 {
        (self.bits(i, j) >> 8) as f32 * (1.0 / (1 << 24) as f32)
    }

    const fn bits(self, i: i32, j: i32) -> u32 {
        let h = (i as u32).wrapping_mul(0x8da6_b343) ^ (j as u32).wrapping_mul(0xd816_3841);
        mix(h ^ self.seed)
    }

    /// A smooth field with values in −1 to 1 that repeats after `period` whole steps.
    pub(crate) fn value(self, p: [f32; 2], period: [i32; 2]) -> f32 {
        let ((i, u), (j, v)) = (split(p[0]), split(p[1]));
        let (i, j) = (wrap(i, period[0]), wrap(j, period[1]));
        let next = |k: i32, period: i32| if k + 1 == period { 0 } else { k + 1 };
        let (i1, j1) = (next(i, period[0]), next(j, period[1]));
        let (u, v) = (ease(u), ease(v));
        let low = self.at(i, j) + (self.at(i1, j) - self.at(i, j)) * u;
        let high = self.at(i, j1) + (self.at(i1, j1) - self.at(i, j1)) * u;
        2.0 * (low + (high - low) * v) - 1.0
    }

    /// A sum of ever finer fields, each half as strong: about −1 to 1.
    pub(crate) fn cloud(self, p: [f32; 2], period: [i32; 2], octaves: u32) -> f32 {
        let (mut sum, mut strength, mut most) = (0.0, 1.0, 0.0);
        let (mut p, mut period) = (p, period);
        for octave in 0..octaves {
            sum += strength * self.other(octave).value(p, period);
            most += strength;
            strength *= 0.5;
            p = p.map(|x| 2.0 * x);
            period = period.map(|n| 2 * n);
        }
        sum / most
    }

    /// The cells around random points, one in each unit square, `jitter` (0 to 1) out of its
    /// middle; repeats after `period` whole steps. `size` is what a step measures in either
    /// direction: it stretches distances to borders, not the cells.
    pub(crate) fn cells(self, p: [f32; 2], period: [i32; 2], jitter: f32, size: [f32; 2]) -> Cell {
        let ((i, u), (j, v)) = (split(p[0]), split(p[1]));
        let shift = self.other(77);
        let mut points = [([0.0f32; 2], 0.0f32); 9];
        let (mut best, mut near) = (0, f32::INFINITY);
        for (k, point) in points.iter_mut().enumerate() {
            let (di, dj) = (k as i32 % 3 - 1, k as i32 / 3 - 1);
            let at = (wrap(i + di, period[0]), wrap(j + dj, period[1]));
            let id = self.at(at.0, at.1);
            let x = di as f32 + 0.5 + jitter * (id - 0.5) - u;
            let y = dj as f32 + 0.5 + jitter * (shift.at(at.0, at.1) - 0.5) - v;
            *point = ([x, y], id);
            let squared = x * x + y * y;
            if squared < near {
                (best, near) = (k, squared);
            }
        }
        let (a, id) = points[best];
        let mut border = f32::INFINITY;
        for (k, &(b, _)) in points.iter().enumerate() {
            if k == best {
                continue;
            }
            // Borders are the perpendicular bisectors: n·p = c in steps.
            let (x, y) = (b[0] - a[0], b[1] - a[1]);
            let c = 0.5 * ((a[0] + b[0]) * x + (a[1] + b[1]) * y);
            let (nx, ny) = (x / size[0], y / size[1]);
            let squared = (nx * nx + ny * ny).max(1e-9);
            // The smallest c² / n² of all, for one root in place of eight.
            border = border.min(c * c.abs() / squared);
        }
        // Another number for the cell than the one that placed its point.
        let id = (id * 7919.0) % 1.0;
        Cell { near: libm::sqrtf(near), border: libm::sqrtf(border.max(0.0)), id }
    }
}

/// The finaliser of MurmurHash3.
const fn mix(h: u32) -> u32 {
    let h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    let h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// 0 below `low`, 1 above `high`, smooth between; downwards where `low` is above `high`.
pub(crate) fn step(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_repeat_after_their_period() {
        let noise = Noise::new(5, 1);
        let cells = |p| noise.cells(p, [8, 6], 0.9, [1.0, 2.0]);
        for k in 0..200 {
            let p = [0.137 * k as f32, 0.291 * k as f32];
            let q = [p[0] + 8.0, p[1] - 6.0];
            let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-3, "{p:?}: {a} {b}");
            near(noise.value(p, [8, 6]), noise.value(q, [8, 6]));
            near(noise.cloud(p, [8, 6], 4), noise.cloud(q, [8, 6], 4));
            near(cells(p).border, cells(q).border);
        }
    }

    #[test]
    fn values_are_spread_around_zero() {
        let noise = Noise::new(1, 2);
        let n = 4000;
        let mean: f32 =
            (0..n).map(|k| noise.value([k as f32 * 0.7, 0.3], [5000, 9])).sum::<f32>() / n as f32;
        assert!(mean.abs() < 0.05, "{mean}");
    }
}
