//! Drawing from the laws that the heads describe; with portable maths only.

use deeptree_graph::signature::situated::LOG_SCALE;
use deeptree_graph::{Draws, Vec3};

/// Draws an index with probability softmax(logits), among those for which `possible` holds.
///
/// None when a logit has overflowed, or nothing is possible.
pub(super) fn categorical(
    logits: &[f32],
    possible: impl Fn(usize) -> bool,
    draws: &mut Draws,
) -> Option<usize> {
    let mut most = f32::NEG_INFINITY;
    for (i, &logit) in logits.iter().enumerate() {
        if possible(i) && logit > most {
            most = logit;
        }
    }
    let weight = |i: usize| if possible(i) { libm::expf(logits[i] - most) } else { 0.0 };
    let total: f32 = (0..logits.len()).map(weight).sum();
    if !total.is_finite() || total <= 0.0 {
        return None;
    }
    let mut left = draws.uniform() as f32 * total;
    let mut last = 0;
    for i in 0..logits.len() {
        let w = weight(i);
        if w > 0.0 {
            if left < w {
                return Some(i);
            }
            left -= w;
            last = i;
        }
    }
    // Rounding left a crumb: the last possible index owns it.
    Some(last)
}

/// Draws how many of `tips` the first of `children` children bears: 1 to `tips − children + 1`.
///
/// `outputs` is a mixture of logistic laws over the logit of the share; bin `k − 1` of the `B`
/// possible counts is the share in `(k − 1, k) / B`.
pub(super) fn split(outputs: &[f32], tips: u32, children: u32, draws: &mut Draws) -> Option<u32> {
    let bins = tips + 1 - children;
    if bins <= 1 {
        return Some(1);
    }
    let components = outputs.len() / 3;
    let i = categorical(&outputs[..components], |_| true, draws)?;
    let scale = scale(outputs[2 * components + i]);
    let u = draws.open_uniform();
    let z = f64::from(outputs[components + i]) + f64::from(scale) * libm::log(u / (1.0 - u));
    let share = 1.0 / (1.0 + libm::exp(-z));
    z.is_finite().then(|| 1 + ((share * f64::from(bins)) as u32).min(bins - 1))
}

/// Draws a turn from a mixture of Gaussian laws with independent components.
pub(super) fn turn(outputs: &[f32], draws: &mut Draws) -> Option<Vec3> {
    let components = outputs.len() / 7;
    let (weights, rest) = outputs.split_at(components);
    let (means, deviations) = rest.split_at(3 * components);
    let i = categorical(weights, |_| true, draws)?;
    let mut axis =
        |k: usize| means[3 * i + k] + scale(deviations[3 * i + k]) * draws.normal() as f32;
    let turn = Vec3::new(axis(0), axis(1), axis(2));
    turn.is_finite().then_some(turn)
}

/// Draws from a law given by its quantiles at even steps, linear between them.
pub(super) fn quantile(quantiles: &[f32], draws: &mut Draws) -> f32 {
    let at = draws.uniform() * (quantiles.len() - 1) as f64;
    let low = (at as usize).min(quantiles.len() - 2);
    let (a, b) = (quantiles[low], quantiles[low + 1]);
    a + (b - a) * (at - low as f64) as f32
}

fn scale(log: f32) -> f32 {
    libm::expf(log.clamp(*LOG_SCALE.start(), *LOG_SCALE.end()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    fn draws(i: u64) -> Draws {
        Seed(i).draws(Lineage::ROOT, Purpose::Existence)
    }

    #[test]
    fn categorical_frequencies_are_the_softmax_over_the_possible() {
        let logits = [0.0, 2.0f32.ln(), 50.0, 5.0f32.ln()];
        let mut counts = [0; 4];
        for i in 0..80_000 {
            counts[categorical(&logits, |c| c != 2, &mut draws(i)).unwrap()] += 1;
        }
        assert_eq!(counts[2], 0);
        for (count, p) in counts.into_iter().zip([0.125, 0.25, 0.0, 0.625]) {
            let se = (p * (1.0 - p) / 80_000.0f64).sqrt();
            assert!((f64::from(count) / 80_000.0 - p).abs() <= 5.0 * se, "{counts:?}");
        }
    }

    #[test]
    fn overflowed_heads_draw_nothing() {
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(categorical(&[0.0, bad], |_| true, &mut draws(1)), None);
            assert_eq!(split(&[0.0, bad, 0.0], 9, 2, &mut draws(1)), None);
            assert_eq!(turn(&[0.0, 1.0, bad, 1.0, 0.0, 0.0, 0.0], &mut draws(1)), None);
        }
        assert_eq!(categorical(&[0.0, 1.0], |_| false, &mut draws(1)), None);
    }

    #[test]
    fn a_split_keeps_a_tip_for_every_child() {
        for tips in 2..40 {
            for i in 0..200 {
                let outputs = [0.0, 0.0, 0.0, -9.0, 0.0, 9.0, 1.0, 2.0, -4.0];
                let k = split(&outputs, tips, 2, &mut draws(i)).unwrap();
                assert!((1..tips).contains(&k));
            }
        }
    }

    #[test]
    fn a_split_by_the_standard_logistic_law_is_uniform() {
        // The logit of a uniform share has the standard logistic law.
        let mut counts = [0.0f64; 5];
        for i in 0..50_000 {
            counts[split(&[0.0, 0.0, 0.0], 6, 2, &mut draws(i)).unwrap() as usize - 1] += 1.0;
        }
        let se = (0.2f64 * 0.8 / 50_000.0).sqrt();
        assert!(counts.iter().all(|c| (c / 50_000.0 - 0.2).abs() < 5.0 * se), "{counts:?}");
    }

    #[test]
    fn turns_have_the_moments_of_their_component() {
        let outputs = [0.0, 1.0, -2.0, 0.5, 0.0, -1.0, -0.5];
        let n = 40_000;
        let turns: Vec<Vec3> = (0..n).map(|i| turn(&outputs, &mut draws(i)).unwrap()).collect();
        let mean = turns.iter().sum::<Vec3>() / n as f32;
        assert!((mean - Vec3::new(1.0, -2.0, 0.5)).abs().max_element() < 0.03);
        let sd = (turns.iter().map(|t| (*t - mean) * (*t - mean)).sum::<Vec3>() / n as f32)
            .to_array()
            .map(f32::sqrt);
        for (sd, log) in sd.into_iter().zip([0.0f32, -1.0, -0.5]) {
            assert!((sd / log.exp() - 1.0).abs() < 0.02);
        }
    }
}
