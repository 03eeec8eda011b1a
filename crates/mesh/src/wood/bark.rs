//! Fissured bark: how deep the surface lies at a point of thick wood.

use super::section::Growing;

/// Thinner wood has smooth bark.
pub(crate) const BARKED: Growing = Growing(0.05, 0.12);

/// Distance between rings and between sides on fissured bark, in metres.
pub(crate) const GRAIN: f32 = 0.025;

/// Width of a plate of bark around the limb and its length along it, in metres.
const PLATE: (f32, f32) = (0.07, 0.35);

/// Depth of the surface at a point around and along a limb, in metres: 0 on the plates of the
/// bark, 1 at the bottom of the fissures between them.
///
/// Fissures run where a smooth random field changes its sign; a finer field roughens the plates.
pub(crate) fn fissure(x: f32, z: f32, along: f32) -> f32 {
    let (around, length) = PLATE;
    let field = |fine: f32, shift: f32| {
        noise([fine * x / around + shift, fine * along / length, fine * z / around - shift])
    };
    // The way bends, so that fissures do.
    let bend = 0.6 * field(0.5, 9.5);
    let run = noise([x / around + bend, along / length + 0.4 * bend, z / around - bend]);
    let lines = (1.0 - 3.5 * run.abs()).max(0.0);
    // Between the long fissures, short ones across and along.
    let cracks = 0.6 * (1.0 - 6.0 * field(1.9, 4.25).abs()).max(0.0);
    let rough = 0.12 * field(4.1, 0.5).abs();
    let edge = lines.max(cracks);
    (edge * (2.0 - edge) + rough).clamp(0.0, 1.0)
}

/// A smooth random field with values in −1 to 1: random at whole numbers, eased between them.
///
/// # Source
///
/// Value noise; the easing is 6t⁵ − 15t⁴ + 10t³ of Perlin 2002, "Improving noise".
fn noise(p: [f32; 3]) -> f32 {
    let low = p.map(libm::floorf);
    let ease = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let [u, v, w] = [0, 1, 2].map(|i| ease(p[i] - low[i]));
    let [i, j, k] = low.map(|x| x as i32);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let line = |j, k| mix(lattice([i, j, k]), lattice([i.wrapping_add(1), j, k]), u);
    let (j1, k1) = (j.wrapping_add(1), k.wrapping_add(1));
    mix(mix(line(j, k), line(j1, k), v), mix(line(j, k1), line(j1, k1), v), w)
}

/// A hash of three whole numbers as a number in −1 to 1.
fn lattice(p: [i32; 3]) -> f32 {
    let [i, j, k] = p.map(|x| x as u32);
    let mut h =
        i.wrapping_mul(0x8da6_b343) ^ j.wrapping_mul(0xd816_3841) ^ k.wrapping_mul(0xcb1a_b31f);
    // The finaliser of MurmurHash3.
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    (h >> 9) as f32 / (1 << 22) as f32 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_continuous_and_within_its_bounds() {
        let mut before = noise([-3.0, 0.3, 7.7]);
        for step in 1..6000 {
            let now = noise([-3.0 + step as f32 * 1e-3, 0.3, 7.7]);
            // The easing rises by at most 15/8, over a difference of at most 2.
            assert!((now - before).abs() < 4e-3 && now.abs() <= 1.0);
            before = now;
        }
    }

    #[test]
    fn bark_has_plates_and_fissures() {
        let depths: Vec<f32> =
            (0..4000).map(|k| fissure(0.3, 0.011 * k as f32, 0.017 * k as f32)).collect();
        assert!(depths.iter().all(|depth| (0.0..=1.0).contains(depth)));
        let share = |of: fn(f32) -> bool| depths.iter().filter(|&&d| of(d)).count() as f64 / 4000.0;
        assert!(share(|d| d < 0.2) > 0.3 && share(|d| d > 0.6) > 0.1);
    }
}
