//! What the network of competition reads of a tree and of the trees around it.
//!
//! The others are told as indices: sums over them of their size, times how near they are. A sum is
//! told as `½ ln(1 + Σ / 100)`, so that all indices are 0 where no other is within [`REACH`].
//!
//! | index | sum over the others of |
//! |---|---|
//! | six by distance | n φ_k(d), φ_k the hat functions of the [`KNOTS`] |
//! | own species | n g(d) of those of the tree's species |
//! | taller | n g(d) σ((h − own h) / 4 m) |
//! | all | n g(d) |
//! | one-sided | length of the sum of vectors n g(d) towards them |
//!
//! with n the nodes and h the height that another has in the open field, d the distance of the feet,
//! `g(d) = max(0, 1 − d / 20 m)`, σ the logistic function.
//!
//! # Source
//!
//! After Hegyi 1974, "A simulation model for managing jack-pine stands": sizes over distances,
//! summed over the trees within a radius. The growth model's own limit is the density of nodes
//! within 16 m of a bud.

use glam::Vec2;

use super::Writer;
use crate::traits::TreeTraits;

/// Distance at which trees no longer compete, in metres: beyond what two crowns and the radius of
/// the growth model's crown density bridge.
pub const REACH: f32 = 40.0;

/// Where the hat functions of the distance have their tops, in metres; each falls to 0 at its
/// neighbours' tops, the last at [`REACH`].
pub const KNOTS: [f32; 6] = [0.0, 4.0, 8.0, 13.0, 19.0, 27.0];

/// Distance at which the near weight g ends, in metres.
const NEAR: f64 = 20.0;

/// Numbers that the others are told by.
pub const INDICES: usize = KNOTS.len() + 4;

/// What the network says: by how much the others move a tree's [`TreeTraits::state`].
pub const OUTPUTS: usize = TreeTraits::STATES;

/// A tree as its neighbours see it: what it would be in the open field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contender {
    /// Number of its species.
    pub species: usize,
    /// In growth cycles.
    pub age: f32,
    /// Nodes.
    pub nodes: f32,
    /// Height in metres.
    pub height: f32,
}

/// Values that the network reads, of a model of so many species.
#[must_use]
pub const fn len(species: usize) -> usize {
    species + 3 + INDICES
}

/// Writes what is read of a tree: the species as a one-hot, a / 50, ln nodes − 7 and (height −
/// 22 m) / 5 m as they would be in the open field; then the indices of the others, which are told
/// with their places as seen from the tree. Their order does not matter.
///
/// # Panics
///
/// When `out` is shorter than [`len`].
pub fn encode(species: usize, own: &Contender, others: &[(Vec2, Contender)], out: &mut [f32]) {
    let mut w = Writer { out, at: 0 };
    w.one_hot(own.species, species);
    w.put(own.age / 50.0);
    w.put(libm::logf(own.nodes) - 7.0);
    w.put((own.height - 22.0) / 5.0);
    for sum in indices(own, others) {
        w.put((0.5 * libm::log1p(sum / 100.0)) as f32);
    }
}

/// The sums, before they are told as logarithms.
fn indices(own: &Contender, others: &[(Vec2, Contender)]) -> [f64; INDICES] {
    let mut near: Vec<&(Vec2, Contender)> =
        others.iter().filter(|(at, _)| at.length() < REACH).collect();
    // Sums of floats depend on their order: it must not be that in which the trees were named.
    near.sort_by(|a, b| key(a).into_iter().zip(key(b)).fold(std::cmp::Ordering::Equal, then));
    let mut sums = [0.0; INDICES];
    let mut aside = [0.0; 2];
    for &&(at, ref other) in &near {
        let nodes = f64::from(other.nodes);
        let distance = f64::from(at.length());
        let [hats @ .., same, taller, all, _] = &mut sums;
        for (sum, share) in hats.iter_mut().zip(shares(distance)) {
            *sum += nodes * share;
        }
        let weight = nodes * (1.0 - distance / NEAR).max(0.0);
        *all += weight;
        *same += if other.species == own.species { weight } else { 0.0 };
        *taller += weight / (1.0 + libm::exp(f64::from(own.height - other.height) / 4.0));
        if distance > 0.0 {
            aside[0] += weight * f64::from(at.x) / distance;
            aside[1] += weight * f64::from(at.y) / distance;
        }
    }
    sums[INDICES - 1] = libm::sqrt(aside[0] * aside[0] + aside[1] * aside[1]);
    sums
}

fn then(so_far: std::cmp::Ordering, (a, b): (f32, f32)) -> std::cmp::Ordering {
    so_far.then(a.total_cmp(&b))
}

/// What trees are put in order by: all that is read of them.
fn key((at, other): &(Vec2, Contender)) -> [f32; 5] {
    [at.x, at.y, other.nodes, other.height, other.species as f32]
}

/// The values of the hat functions at a distance.
fn shares(distance: f64) -> [f64; KNOTS.len()] {
    let knot = |k: usize| f64::from(KNOTS.get(k).copied().unwrap_or(REACH));
    std::array::from_fn(|k| {
        let falling = (knot(k + 1) - distance) / (knot(k + 1) - knot(k));
        let rising = if k > 0 { (distance - knot(k - 1)) / (knot(k) - knot(k - 1)) } else { 1.0 };
        falling.min(rising).clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: Contender = Contender { species: 1, age: 25.0, nodes: 1000.0, height: 20.0 };

    fn told(others: &[(Vec2, Contender)]) -> Vec<f32> {
        let mut out = vec![9.0; len(3)];
        encode(3, &OWN, others, &mut out);
        out
    }

    #[test]
    fn a_tree_by_itself_is_told_without_any_index() {
        let out = told(&[]);
        assert_eq!(out[..3], [0.0, 1.0, 0.0]);
        assert!((out[3] - 0.5).abs() < 1e-6 && (out[4] + 0.0922).abs() < 1e-4);
        assert!((out[5] + 0.4).abs() < 1e-6);
        assert_eq!(out[6..], [0.0; INDICES]);
        // Where others end to count, and beyond.
        assert_eq!(told(&[(Vec2::new(REACH, 0.0), OWN), (Vec2::new(0.0, -90.0), OWN)]), out);
    }

    #[test]
    fn indices_are_those_worked_out_by_hand() {
        // 5 m off: three quarters of the hat at 4 m, a quarter of that at 8 m; g = 3/4.
        let one = (Vec2::new(3.0, -4.0), Contender { species: 0, nodes: 400.0, ..OWN });
        let sums = indices(&OWN, &[one]);
        let expected = [0.0, 300.0, 100.0, 0.0, 0.0, 0.0, 0.0, 150.0, 300.0, 300.0];
        assert!(sums.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{sums:?}");
        // One of its species on the other side, as far off: nothing is one-sided.
        let two = (Vec2::new(-3.0, 4.0), Contender { nodes: 400.0, ..OWN });
        let sums = indices(&OWN, &[one, two]);
        assert!((sums[6] - 300.0).abs() < 1e-9 && sums[9] < 1e-9, "{sums:?}");
        let out = told(&[one]);
        assert!((out[7] - 0.5 * 4f32.ln()).abs() < 1e-6, "{out:?}");
    }

    #[test]
    fn the_hats_share_out_every_tree_within_the_last_knot() {
        for i in 0..=270 {
            let sum: f64 = shares(0.1 * f64::from(i)).iter().sum();
            assert!((sum - 1.0).abs() < 1e-9, "{i}");
        }
        assert_eq!(shares(f64::from(REACH)), [0.0; KNOTS.len()]);
    }

    #[test]
    fn the_order_in_which_others_are_named_changes_no_bit() {
        let others: Vec<(Vec2, Contender)> = (0..9)
            .map(|i| {
                let x = i as f32;
                (Vec2::new(1.7 * x - 6.0, 0.3 * x), Contender { nodes: 100.1 * x, ..OWN })
            })
            .collect();
        let back: Vec<_> = others.iter().rev().copied().collect();
        assert_eq!(told(&others), told(&back));
    }
}
