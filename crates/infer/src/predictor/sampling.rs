//! Drawing from the laws that the heads describe; with portable maths only.

use deeptree_graph::Draws;
use deeptree_graph::Vec2;
use deeptree_graph::signature::inheritance::share_bounds;
use deeptree_graph::signature::situated::{
    Alignment, CLASSES, LOG_SCALE, MOST_SCORE, ROTATION_COMPONENTS,
};

/// Draws an index with probability softmax(logits), among those for which `possible` holds; of
/// [`CLASSES`] at most.
///
/// None when a logit has overflowed, or nothing is possible.
pub(super) fn categorical(
    logits: &[f32],
    possible: impl Fn(usize) -> bool,
    draws: &mut Draws,
) -> Option<usize> {
    let mut weights = [f32::NEG_INFINITY; CLASSES];
    let weights = &mut weights[..logits.len()];
    let mut most = f32::NEG_INFINITY;
    for (i, weight) in weights.iter_mut().enumerate() {
        if possible(i) {
            *weight = logits[i];
            most = if logits[i] > most { logits[i] } else { most };
        }
    }
    for weight in &mut *weights {
        *weight = if *weight == f32::NEG_INFINITY { 0.0 } else { libm::expf(*weight - most) };
    }
    let total: f32 = weights.iter().sum();
    if !total.is_finite() || total <= 0.0 {
        return None;
    }
    let mut left = draws.uniform() as f32 * total;
    let mut last = 0;
    for (i, &weight) in weights.iter().enumerate() {
        if weight > 0.0 {
            if left < weight {
                return Some(i);
            }
            left -= weight;
            last = i;
        }
    }
    // Rounding left a crumb: the last possible index owns it.
    Some(last)
}

/// Draws how many of `tips` tips the first of `children` children of a node of this reach bears.
///
/// `outputs` is a mixture of logistic laws over the logit of the share; bin `k − 1` of the `B =
/// tips − children + 1` counts is the share in `(k − 1, k) / B`. What lies beyond what the reach
/// allows counts for the outermost that it does.
pub(super) fn split(
    outputs: &[f32],
    tips: u32,
    children: u32,
    reach: u16,
    draws: &mut Draws,
) -> Option<u32> {
    let (least, most) = share_bounds(tips, children, reach);
    if least >= most {
        return Some(least);
    }
    let share = share(outputs, draws)?;
    Some((1 + (share * f64::from(tips + 1 - children)) as u32).clamp(least, most))
}

/// Draws the reach of a child, given the outputs of its head and what is asked.
pub(super) fn reach(
    outputs: &[f32],
    heir: u16,
    (asks_heir, bins, least): (bool, u16, u16),
    draws: &mut Draws,
) -> Option<u16> {
    let (logit, mixture) = outputs.split_first()?;
    if asks_heir {
        let p = 1.0 / (1.0 + libm::expf(-logit));
        if p.is_nan() {
            return None;
        }
        if (draws.uniform() as f32) < p {
            return Some(heir);
        }
    }
    let last = bins.checked_sub(1)?;
    if least >= last {
        return Some(last);
    }
    let share = share(mixture, draws)?;
    Some(((share * f64::from(bins)) as u16).clamp(least, last))
}

/// Draws a number between two bounds, both included: its place among them is a share, of which each
/// number has an equal bin.
pub(super) fn count(outputs: &[f32], (least, most): (u32, u32), draws: &mut Draws) -> Option<u32> {
    let bins = f64::from(most - least) + 1.0;
    let share = share(outputs, draws)?;
    Some((least + (share * bins) as u32).min(most))
}

/// Draws a share from a mixture of logistic laws over its logit: weights' logits, means and log
/// scales.
fn share(outputs: &[f32], draws: &mut Draws) -> Option<f64> {
    let components = outputs.len() / 3;
    let i = categorical(&outputs[..components], |_| true, draws)?;
    let scale = scale(outputs[2 * components + i]);
    let u = draws.open_uniform();
    let z = f64::from(outputs[components + i]) + f64::from(scale) * libm::log(u / (1.0 - u));
    z.is_finite().then(|| 1.0 / (1.0 + libm::exp(-z)))
}

/// Draws the swing of a child that can be aligned so from the outputs of its head, in deviations of
/// its slot.
pub(super) fn swing(outputs: &[f32], alignment: Alignment, draws: &mut Draws) -> Option<Vec2> {
    const K: usize = ROTATION_COMPONENTS;
    let (weights, rest) = outputs.split_at(K + 1);
    let (aligned, components) = rest.split_at(2);
    let i = categorical(weights, |_| true, draws)?;
    let of = |row: usize, i: usize| components[row * K + i];
    let x = |i: usize, first: f32| of(0, i) + scale(of(2, i)) * first;
    let swing = if i < K {
        let (first, second) = (draws.normal() as f32, draws.normal() as f32);
        Vec2::new(x(i, first), of(1, i) + scale(of(3, i)) * (second + of(4, i) * first))
    } else {
        let x = match alignment {
            Alignment::Straight => 0.0,
            Alignment::Gravity => {
                let i = categorical(&weights[..K], |_| true, draws)?;
                x(i, draws.normal() as f32)
            }
            Alignment::Bud => aligned[0] + scale(aligned[1]) * draws.normal() as f32,
        };
        Vec2::new(x, 0.0)
    };
    swing.is_finite().then_some(swing)
}

/// Draws from a law given by its values at evenly spaced normal scores, −[`MOST_SCORE`] to [`MOST_SCORE`],
/// linear between them: exact for a normal law, and fine at both ends of any other.
pub(super) fn normal_score(values: &[f32], draws: &mut Draws) -> f32 {
    let steps = (values.len() - 1) as f64;
    let score = draws.normal().clamp(-MOST_SCORE, MOST_SCORE);
    let at = (score + MOST_SCORE) / (2.0 * MOST_SCORE) * steps;
    let low = (at as usize).min(values.len() - 2);
    let (a, b) = (values[low], values[low + 1]);
    a + (b - a) * (at - low as f64) as f32
}

fn scale(log: f32) -> f32 {
    libm::expf(log.clamp(*LOG_SCALE.start(), *LOG_SCALE.end()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::signature::situated::ROTATION_OUTPUTS;
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
            assert_eq!(split(&[0.0, bad, 0.0], 9, 2, 5, &mut draws(1)), None);
            let mut outputs = [0.0; ROTATION_OUTPUTS];
            outputs[..ROTATION_OUTPUTS].fill(bad);
            assert_eq!(swing(&outputs, Alignment::Bud, &mut draws(1)), None);
        }
        assert_eq!(categorical(&[0.0, 1.0], |_| false, &mut draws(1)), None);
    }

    #[test]
    fn a_split_keeps_a_tip_for_every_child() {
        for tips in 2..40 {
            for i in 0..200 {
                let outputs = [0.0, 0.0, 0.0, -9.0, 0.0, 9.0, 1.0, 2.0, -4.0];
                let k = split(&outputs, tips, 2, 9, &mut draws(i)).unwrap();
                assert!((1..tips).contains(&k));
            }
        }
    }

    #[test]
    fn a_split_by_the_standard_logistic_law_is_uniform() {
        // The logit of a uniform share has the standard logistic law.
        let mut counts = [0.0f64; 5];
        for i in 0..50_000 {
            counts[split(&[0.0, 0.0, 0.0], 6, 2, 9, &mut draws(i)).unwrap() as usize - 1] += 1.0;
        }
        let se = (0.2f64 * 0.8 / 50_000.0).sqrt();
        assert!(counts.iter().all(|c| (c / 50_000.0 - 0.2).abs() < 5.0 * se), "{counts:?}");
    }

    #[test]
    fn a_count_by_the_standard_logistic_law_is_uniform() {
        let mut counts = [0.0f64; 5];
        for i in 0..50_000 {
            counts[count(&[0.0, 0.0, 0.0], (7, 11), &mut draws(i)).unwrap() as usize - 7] += 1.0;
        }
        let se = (0.2f64 * 0.8 / 50_000.0).sqrt();
        assert!(counts.iter().all(|c| (c / 50_000.0 - 0.2).abs() < 5.0 * se), "{counts:?}");
    }

    #[test]
    fn a_split_gives_no_child_more_tips_than_its_reach_allows() {
        // Children of reach 0 bear three tips at most: of five tips, the first two or three. By a
        // uniform law over the four counts, half of the mass lies on either side.
        let mut threes = 0.0;
        for i in 0..20_000 {
            let first = split(&[0.0, 0.0, 0.0], 5, 2, 1, &mut draws(i)).unwrap();
            assert!((2..=3).contains(&first));
            threes += f64::from(first - 2);
        }
        assert!((threes / 20_000.0 - 0.5).abs() < 5.0 * (0.25f64 / 20_000.0).sqrt(), "{threes}");
        assert_eq!(split(&[0.0, 0.0, 0.0], 9, 3, 1, &mut draws(1)), Some(3));
    }

    #[test]
    fn reaches_have_the_odds_of_their_head() {
        // Odds of 1 to 3 for the heir; the others uniform over five bins, of which the lowest two
        // count for the second.
        let outputs = [-(3.0f32.ln()), 0.0, 0.0, 0.0];
        let mut counts = [0.0f64; 7];
        for i in 0..40_000 {
            let own = reach(&outputs, 6, (true, 5, 1), &mut draws(i)).unwrap();
            counts[usize::from(own)] += 1.0;
        }
        for (count, p) in counts.into_iter().zip([0.0, 0.3, 0.15, 0.15, 0.15, 0.0, 0.25]) {
            let se = (p * (1.0 - p) / 40_000.0f64).sqrt();
            assert!((count / 40_000.0 - p).abs() <= 5.0 * se, "{counts:?}");
        }
        // After the heir: no odds, and as far as it too.
        let far = [60.0, 0.0, 90.0, 0.0];
        assert_eq!(reach(&far, 6, (false, 7, 0), &mut draws(1)), Some(6));
        assert_eq!(reach(&[f32::NAN, 0.0, 0.0, 0.0], 6, (true, 5, 0), &mut draws(1)), None);
        assert_eq!(reach(&[0.0, 0.0, f32::NAN, 0.0], 6, (false, 7, 0), &mut draws(1)), None);
    }

    /// All weight on one law; K is the aligned one.
    fn outputs(law: usize) -> [f32; ROTATION_OUTPUTS] {
        let mut outputs = [0.0; ROTATION_OUTPUTS];
        outputs[law] = 60.0;
        outputs
    }

    #[test]
    fn swings_have_the_moments_of_their_component() {
        const K: usize = ROTATION_COMPONENTS;
        let mut outputs = outputs(2);
        let set = [1.0, -2.0, -1.0, -0.5, 1.5];
        for (row, value) in set.into_iter().enumerate() {
            outputs[K + 3 + row * K + 2] = value;
        }
        let n = 40_000;
        let swings: Vec<Vec2> =
            (0..n).map(|i| swing(&outputs, Alignment::Bud, &mut draws(i)).unwrap()).collect();
        let mean = swings.iter().sum::<Vec2>() / n as f32;
        assert!((mean - Vec2::new(1.0, -2.0)).abs().max_element() < 0.03, "{mean}");
        let moment =
            |of: fn(Vec2) -> f32| swings.iter().map(|s| of(*s - mean)).sum::<f32>() / n as f32;
        let (sx, sy) = ((-1.0f32).exp(), (-0.5f32).exp());
        let near = |a: f32, b: f32| assert!((a / b - 1.0).abs() < 0.04, "{a} {b}");
        near(moment(|s| s.x * s.x), sx * sx);
        near(moment(|s| s.y * s.y), sy * sy * (1.0 + 1.5 * 1.5));
        near(moment(|s| s.x * s.y), sx * sy * 1.5);
    }

    #[test]
    fn aligned_children_are_exactly_so() {
        const K: usize = ROTATION_COMPONENTS;
        let outputs = outputs(K);
        for i in 0..100 {
            let drawn = |alignment| swing(&outputs, alignment, &mut draws(i)).unwrap();
            assert_eq!(drawn(Alignment::Straight), Vec2::ZERO);
            for alignment in [Alignment::Gravity, Alignment::Bud] {
                let swing = drawn(alignment);
                assert!(swing.y == 0.0 && swing.x != 0.0, "{alignment:?}");
            }
        }
    }

    #[test]
    fn shoots_about_the_level_axis_have_the_mean_of_the_components() {
        // Odds of 3 to 1 for means of 1 and −2, all else impossible.
        const K: usize = ROTATION_COMPONENTS;
        let mut outputs = [0.0; ROTATION_OUTPUTS];
        outputs[..=K].copy_from_slice(&[3f32.ln(), 0.0, -60.0, -60.0, 60.0]);
        (outputs[K + 3], outputs[K + 4]) = (1.0, -2.0);
        let n = 40_000;
        let x = |i| swing(&outputs, Alignment::Gravity, &mut draws(i)).unwrap().x;
        let mean = (0..n).map(x).sum::<f32>() / n as f32;
        // The variance is 1 + 9 · ¾ · ¼.
        assert!((mean - 0.25).abs() < 5.0 * (2.69f32 / n as f32).sqrt(), "{mean}");
    }

    #[test]
    fn scores_of_a_normal_law_give_that_law() {
        // A normal law with mean 3 and deviation 2 is a straight line over the scores.
        let values: Vec<f32> = (0..65).map(|i| 3.0 + 2.0 * (i as f32 / 8.0 - 4.0)).collect();
        let n = 40_000u32;
        let drawn = (0..n).map(|i| f64::from(normal_score(&values, &mut draws(u64::from(i)))));
        let (mut sum, mut squares) = (0.0, 0.0);
        drawn.for_each(|x| (sum, squares) = (sum + x, squares + x * x));
        let mean = sum / f64::from(n);
        let sd = (squares / f64::from(n) - mean * mean).sqrt();
        assert!((mean - 3.0).abs() < 0.04 && (sd / 2.0 - 1.0).abs() < 0.02, "{mean} {sd}");
        assert!((values[0]..=values[64]).contains(&normal_score(&values, &mut draws(1))));
    }
}
