//! How far apart two samples of one quantity are.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

/// Two distances between the laws that two samples were drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distances {
    /// Kolmogorov–Smirnov: the largest gap between the two distribution functions, in [0, 1].
    ///
    /// `D = sup_x |F_a(x) − F_b(x)|`
    pub ks: f64,
    /// The chance of a gap at least as large between two samples of the same law.
    ///
    /// The limit of large samples ([`kolmogorov_tail`]); with ties, or below some 20 samples, it
    /// is too large.
    pub ks_p: f64,
    /// 1-Wasserstein: the area between the two distribution functions, in the samples' unit.
    ///
    /// `W1 = ∫ |F_a(x) − F_b(x)| dx`
    pub wasserstein: f64,
}

impl Distances {
    /// Compares two samples, of any sizes and in any order.
    ///
    /// `None` when one of them is empty or holds a number that is not finite.
    #[must_use]
    pub fn between(a: &[f64], b: &[f64]) -> Option<Self> {
        let usable = |samples: &[f64]| !samples.is_empty() && samples.iter().all(|x| x.is_finite());
        if !usable(a) || !usable(b) {
            return None;
        }
        let (ks, wasserstein) = sweep(&sorted(a), &sorted(b));
        let (n, m) = (a.len() as f64, b.len() as f64);
        let ks_p = kolmogorov_tail((n * m / (n + m)).sqrt() * ks);
        Some(Self { ks, ks_p, wasserstein })
    }
}

fn sorted(samples: &[f64]) -> Vec<f64> {
    let mut samples = samples.to_vec();
    samples.sort_by(f64::total_cmp);
    samples
}

/// Follows both distribution functions, from jump to jump; the gap is constant between two.
fn sweep(a: &[f64], b: &[f64]) -> (f64, f64) {
    let (mut i, mut j) = (0, 0);
    let (mut ks, mut area) = (0.0f64, 0.0);
    let mut from = a[0].min(b[0]);
    while i < a.len() || j < b.len() {
        let gap = (i as f64 / a.len() as f64 - j as f64 / b.len() as f64).abs();
        let x = a.get(i).into_iter().chain(b.get(j)).copied().fold(f64::INFINITY, f64::min);
        ks = ks.max(gap);
        area += gap * (x - from);
        from = x;
        // All samples at x jump at once: ties are no gap.
        i += a[i..].iter().take_while(|&&sample| sample <= x).count();
        j += b[j..].iter().take_while(|&&sample| sample <= x).count();
    }
    (ks, area)
}

/// The upper tail of Kolmogorov's law: the limit of P(√(nm/(n+m)) D ≥ λ) for equal laws.
///
/// `Q(λ) = 2 Σ_k (−1)^(k−1) exp(−2 k² λ²) = 1 − √(2π)/λ Σ_k exp(−(2k−1)² π² / (8 λ²))`
///
/// Of the two series, which Jacobi's theta identity makes equal, the faster one is summed.
///
/// # Source
///
/// Kolmogorov 1933; Smirnov 1948, "Table for estimating the goodness of fit".
#[must_use]
pub fn kolmogorov_tail(lambda: f64) -> f64 {
    /// Where both series need four terms for all digits of an `f64`.
    const SWITCH: f64 = 1.18;
    let series = |term: &dyn Fn(f64) -> f64| (1..=5).map(|k| term(f64::from(k))).sum::<f64>();
    if lambda <= 0.0 {
        1.0
    } else if lambda < SWITCH {
        let step = -PI * PI / (8.0 * lambda * lambda);
        let sum = series(&|k| ((2.0 * k - 1.0).powi(2) * step).exp());
        1.0 - (2.0 * PI).sqrt() / lambda * sum
    } else {
        let sign = |k: f64| if k % 2.0 == 0.0 { -1.0 } else { 1.0 };
        2.0 * series(&|k| sign(k) * (-2.0 * k * k * lambda * lambda).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    #[test]
    fn two_point_masses_are_as_far_apart_as_the_points() {
        let far = Distances::between(&[2.0; 3], &[-1.5; 7]).unwrap();
        assert!(close(far.ks, 1.0) && close(far.wasserstein, 3.5));
    }

    #[test]
    fn equal_samples_have_no_distance_whatever_their_order_and_repetition() {
        let same = Distances::between(&[1.0, 3.0, 2.0], &[3.0, 1.0, 2.0, 2.0, 1.0, 3.0]).unwrap();
        assert!(close(same.ks, 0.0) && close(same.wasserstein, 0.0) && close(same.ks_p, 1.0));
    }

    #[test]
    fn a_uniform_law_shifted_by_d_is_d_away_in_both_distances() {
        let (n, shift) = (1000u32, 0.25);
        let grid: Vec<f64> = (0..n).map(|i| f64::from(i) / f64::from(n)).collect();
        let shifted: Vec<f64> = grid.iter().map(|x| x + shift).collect();
        let distances = Distances::between(&grid, &shifted).unwrap();
        // The grid's step bounds what rounding can do to coinciding jumps.
        assert!((distances.ks - shift).abs() < 1.001 / f64::from(n));
        assert!((distances.wasserstein - shift).abs() < 1e-9);
    }

    #[test]
    fn samples_of_unequal_size_have_the_distances_that_scipy_gives() {
        // scipy 1.x: a = [((37 i) % 101) / 101 for i in range(40)],
        // b = [(((53 i) % 97) / 97)**2 for i in range(25)]; ks_2samp(a, b).statistic,
        // wasserstein_distance(a, b), special.kolmogorov(sqrt(40 · 25 / 65) · statistic).
        let a: Vec<f64> = (0..40).map(|i| f64::from((37 * i) % 101) / 101.0).collect();
        let b: Vec<f64> = (0..25).map(|i| (f64::from((53 * i) % 97) / 97.0).powi(2)).collect();
        let distances = Distances::between(&a, &b).unwrap();
        assert!(close(distances.ks, 0.355));
        assert!(close(distances.wasserstein, 0.216_888_833_000_634_55));
        assert!(close(distances.ks_p, 0.041_396_704_820_232_55));
    }

    #[test]
    fn ties_within_and_between_samples_are_counted_as_scipy_does() {
        // scipy: a = [i % 7 for i in range(30)], b = [i % 5 + 1 for i in range(22)].
        let a: Vec<f64> = (0..30).map(|i| f64::from(i % 7)).collect();
        let b: Vec<f64> = (0..22).map(|i| f64::from(i % 5 + 1)).collect();
        let distances = Distances::between(&a, &b).unwrap();
        assert!(
            close(distances.ks, 1.0 / 6.0) && close(distances.wasserstein, 0.539_393_939_393_939_5)
        );
    }

    #[test]
    fn the_tail_is_kolmogorovs_on_both_sides_of_the_switch() {
        // scipy.special.kolmogorov(λ).
        let expected = [
            (0.4, 0.997_192_326_777_298_3),
            (0.8, 0.544_142_411_574_198_1),
            (1.0, 0.269_999_671_677_354_56),
            (1.2, 0.112_249_666_670_724_97),
            (1.5, 0.022_217_962_616_525_127),
            (2.0, 0.000_670_925_255_779_695_3),
        ];
        for (lambda, tail) in expected {
            assert!(close(kolmogorov_tail(lambda), tail), "λ = {lambda}");
        }
    }

    #[test]
    fn empty_and_poisoned_samples_have_no_distance() {
        assert_eq!(Distances::between(&[], &[1.0]), None);
        assert_eq!(Distances::between(&[1.0], &[f64::NAN]), None);
    }
}
