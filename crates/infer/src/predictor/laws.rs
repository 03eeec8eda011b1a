//! The distribution functions of the laws that the heads describe: what [`super::sampling`] draws
//! from.

use deeptree_graph::Vec2;
use deeptree_graph::signature::inheritance::share_bounds;
use deeptree_graph::signature::situated::{Alignment, LOG_SCALE, MOST_SCORE, ROTATION_COMPONENTS};

use super::foretold::{Chance, Rank};

/// `1 / (1 + e^{−x})`
pub(super) fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}

/// Φ: the standard normal distribution function.
fn normal(z: f64) -> f64 {
    0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2)
}

/// The softmax over those for which `possible` holds; none when a logit has overflowed or nothing
/// is possible.
pub(super) fn softmax(logits: &[f32], possible: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
    let logit = |i: usize| if possible(i) { f64::from(logits[i]) } else { f64::NEG_INFINITY };
    let most = (0..logits.len()).map(logit).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = (0..logits.len()).map(|i| libm::exp(logit(i) - most)).collect();
    let total: f64 = weights.iter().sum();
    total.is_finite().then(|| weights.iter().map(|weight| weight / total).collect())
}

/// Where `taken` tips stand, of `tips` that the first of `children` children of a node of this reach
/// can bear: see [`super::sampling::split`]. Outer none where the numbers overflow, inner none where
/// nothing is left to decide.
pub(super) fn split(
    outputs: &[f32],
    (tips, children, reach): (u32, u32, u16),
    taken: u32,
) -> Option<Option<Rank>> {
    let (least, most) = share_bounds(tips, children, reach);
    if least >= most {
        return Some(None);
    }
    let bins = tips + 1 - children;
    ranked(outputs, bins, (taken <= least, taken - 1), (taken >= most, taken)).map(Some)
}

/// Where a reach stands below that of the heir, of `bins` of which the lowest to `least` count for
/// that; as [`split`].
pub(super) fn reach(outputs: &[f32], (bins, least): (u16, u16), own: u16) -> Option<Option<Rank>> {
    if least + 1 >= bins {
        return Some(None);
    }
    let own = u32::from(own);
    let (is_least, is_most) = (own <= u32::from(least), own + 1 >= u32::from(bins));
    ranked(outputs, u32::from(bins), (is_least, own), (is_most, own + 1)).map(Some)
}

/// Where `own` stands among the numbers between two bounds; as [`split`], and what lies beyond the
/// bounds counts for them.
pub(super) fn count(outputs: &[f32], (least, most): (u32, u32), own: u32) -> Option<Rank> {
    let (bins, bin) = (most - least + 1, own.clamp(least, most) - least);
    ranked(outputs, bins, (bin == 0, bin), (bin + 1 == bins, bin + 1))
}

/// Where the bins from the one to the other stand; what is outermost is open.
fn ranked(outputs: &[f32], bins: u32, low: (bool, u32), high: (bool, u32)) -> Option<Rank> {
    let logit = |bin: u32| {
        let (bin, bins) = (f64::from(bin), f64::from(bins));
        libm::log(bin / (bins - bin))
    };
    let low = if low.0 { 0.0 } else { below_share(outputs, logit(low.1))? };
    let high = if high.0 { 1.0 } else { below_share(outputs, logit(high.1))? };
    Some(Rank { low, high })
}

/// Probability that the logit of a share is below `logit`, in a mixture of logistic laws.
fn below_share(outputs: &[f32], logit: f64) -> Option<f64> {
    let components = outputs.len() / 3;
    are_finite(outputs)?;
    let weights = softmax(&outputs[..components], |_| true)?;
    let below = |i: usize| {
        let mean = f64::from(outputs[components + i]);
        weights[i] * logistic((logit - mean) / scale(outputs[2 * components + i]))
    };
    // Rounding may carry a sum over 1.
    finite((0..components).map(below).sum()).map(|share| share.min(1.0))
}

/// What is said of a swing, in deviations of its slot: whether it is aligned, and where it stands
/// about x, and about y given x. None where the numbers overflow.
pub(super) fn swing(
    outputs: &[f32],
    alignment: Alignment,
    swing: Vec2,
    is_aligned: bool,
) -> Option<(Chance, [Option<Rank>; 2])> {
    const K: usize = ROTATION_COMPONENTS;
    are_finite(outputs)?;
    let weights = softmax(&outputs[..=K], |_| true)?;
    let (aligned, components) = outputs[K + 1..].split_at(2);
    let chance = Chance { probability: weights[K], happened: is_aligned };
    let (x, y) = (f64::from(swing.x), f64::from(swing.y));
    let of = |row: usize, i: usize| components[row * K + i];
    let first = |i: usize| (x - f64::from(of(0, i))) / scale(of(2, i));
    let second =
        |i: usize| (y - f64::from(of(1, i))) / scale(of(3, i)) - f64::from(of(4, i)) * first(i);
    let mixed = |weights: &[f64], of: &dyn Fn(usize) -> f64| {
        let total: f64 = weights.iter().sum();
        finite((0..K).map(|i| weights[i] * normal(of(i))).sum::<f64>() / total)
    };
    let below_x = || mixed(&weights[..K], &first);
    if is_aligned {
        let rank = match alignment {
            Alignment::Straight => None,
            Alignment::Gravity => Some(Rank::at(below_x()?)),
            Alignment::Bud => {
                let off = (x - f64::from(aligned[0])) / scale(aligned[1]);
                Some(Rank::at(finite(normal(off))?))
            }
        };
        return Some((chance, [rank, None]));
    }
    // Of y, each component counts as much as it explains x; far out the nearest explains all.
    let logs: Vec<f64> = (0..K)
        .map(|i| {
            let z = first(i);
            libm::log(weights[i]) - 0.5 * z * z - libm::log(scale(of(2, i)))
        })
        .collect();
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let explains: Vec<f64> = logs.iter().map(|log| libm::exp(log - most)).collect();
    let below_y = mixed(&explains, &second)?;
    Some((chance, [Some(Rank::at(below_x()?)), Some(Rank::at(below_y))]))
}

/// Where a swing that is not aligned stands about y, whatever it is about x.
pub(super) fn about_y(outputs: &[f32], y: f32) -> Option<Rank> {
    const K: usize = ROTATION_COMPONENTS;
    are_finite(outputs)?;
    let weights = softmax(&outputs[..K], |_| true)?;
    let of = |row: usize, i: usize| outputs[K + 3 + row * K + i];
    let below = |i: usize| {
        let with_x = f64::from(of(4, i));
        let deviation = scale(of(3, i)) * libm::sqrt(1.0 + with_x * with_x);
        weights[i] * normal((f64::from(y) - f64::from(of(1, i))) / deviation)
    };
    finite((0..K).map(below).sum()).map(|share| Rank::at(share.min(1.0)))
}

/// Where a value stands in a law given by its values at evenly spaced normal scores: see
/// [`super::sampling::normal_score`].
pub(super) fn of_scores(values: &[f32], x: f32) -> Rank {
    // The share below where the values pass from the first `count` to the others.
    let share = |count: usize| {
        if count == 0 {
            return 0.0;
        }
        if count == values.len() {
            return 1.0;
        }
        let (a, b) = (f64::from(values[count - 1]), f64::from(values[count]));
        let at = (count - 1) as f64 + (f64::from(x) - a) / (b - a);
        normal(MOST_SCORE * (2.0 * at / (values.len() - 1) as f64 - 1.0))
    };
    let low = share(values.partition_point(|&value| value < x));
    Rank { low, high: share(values.partition_point(|&value| value <= x)) }
}

fn are_finite(outputs: &[f32]) -> Option<()> {
    outputs.iter().all(|x| x.is_finite()).then_some(())
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn scale(log: f32) -> f64 {
    f64::from(libm::expf(log.clamp(*LOG_SCALE.start(), *LOG_SCALE.end())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predictor::sampling;
    use deeptree_graph::signature::situated::ROTATION_OUTPUTS;
    use deeptree_graph::{Draws, Lineage, Purpose, Seed};

    const N: u64 = 40_000;

    fn draws(i: u64) -> Draws {
        Seed(i).draws(Lineage::ROOT, Purpose::Existence)
    }

    /// Places drawn evenly within the ranks are uniform: their mean is ½ and their mean square ⅓.
    fn assert_uniform(what: &str, ranks: impl Iterator<Item = Rank>) {
        let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for (i, Rank { low, high }) in (0..).zip(ranks) {
            assert!((0.0..=1.0).contains(&low) && (low..=1.0).contains(&high), "{low} {high}");
            let u = low + (high - low) * draws(i + 1_000_000).uniform();
            (n, sum, squares) = (n + 1.0, sum + u, squares + u * u);
        }
        assert!(n > 1000.0, "{what}: {n}");
        assert!((sum / n - 0.5f64).abs() < 5.0 * (1.0 / 12.0 / n).sqrt(), "{what}: {}", sum / n);
        let error = 5.0 * (4.0 / 45.0 / n).sqrt();
        assert!((squares / n - 1.0 / 3.0f64).abs() < error, "{what}: {}", squares / n);
    }

    #[test]
    fn what_is_drawn_from_a_split_stands_uniformly_in_it() {
        let outputs = [0.4, -0.3, 1.0, -2.0, 0.3, 1.5, -1.0, 0.2, 0.8];
        for question in [(9, 2, 6), (40, 3, 9), (5, 2, 1)] {
            let (tips, children, reach) = question;
            let ranks = (0..N).map(|i| {
                let taken =
                    sampling::split(&outputs, tips, children, reach, &mut draws(i)).unwrap();
                split(&outputs, question, taken).unwrap().unwrap()
            });
            assert_uniform("split", ranks);
        }
        assert_eq!(split(&outputs, (9, 3, 1), 3), Some(None));
    }

    #[test]
    fn what_is_drawn_from_a_reach_stands_uniformly_in_it() {
        let outputs = [-60.0, 0.4, -0.3, 1.0, -2.0, 0.3, 1.5, -1.0, 0.2, 0.8];
        for (bins, least) in [(7, 0), (9, 3)] {
            let ranks = (0..N).map(|i| {
                let own = sampling::reach(&outputs, 20, (true, bins, least), &mut draws(i));
                reach(&outputs[1..], (bins, least), own.unwrap()).unwrap().unwrap()
            });
            assert_uniform("reach", ranks);
        }
        assert_eq!(reach(&outputs[1..], (4, 3), 3), Some(None));
    }

    #[test]
    fn swings_that_are_drawn_stand_uniformly_about_both_axes() {
        let mut outputs = [0.0; ROTATION_OUTPUTS];
        for (i, out) in outputs.iter_mut().enumerate() {
            *out = draws(77 + i as u64).normal() as f32 * 0.7;
        }
        for alignment in [Alignment::Straight, Alignment::Gravity, Alignment::Bud] {
            let (mut of_axis, mut of_y_alone) = ([Vec::new(), Vec::new()], Vec::new());
            let (mut chances, mut aligned) = (0.0, 0.0);
            for i in 0..N {
                let drawn = sampling::swing(&outputs, alignment, &mut draws(i)).unwrap();
                let is_aligned = drawn.y == 0.0;
                let (chance, ranks) = swing(&outputs, alignment, drawn, is_aligned).unwrap();
                if !is_aligned {
                    of_y_alone.push(about_y(&outputs, drawn.y).unwrap());
                }
                chances += chance.probability;
                aligned += f64::from(u8::from(chance.happened));
                for (of_axis, rank) in of_axis.iter_mut().zip(ranks) {
                    of_axis.extend(rank);
                }
            }
            let error = 5.0 * (chances * (1.0 - chances / N as f64)).sqrt();
            assert!((aligned - chances).abs() < error, "{aligned} {chances}");
            let has_x = alignment != Alignment::Straight;
            assert_eq!(of_axis[0].len() > of_axis[1].len(), has_x);
            let [x, y] = of_axis;
            assert_uniform("x", x.into_iter());
            assert_uniform("y", y.into_iter());
            assert_uniform("y alone", of_y_alone.into_iter());
        }
    }

    #[test]
    fn what_is_drawn_from_scores_stands_uniformly_in_them_ties_included() {
        // A third of the values is the same.
        let values: Vec<f32> =
            (0..65).map(|i| if i < 30 { 1.0 } else { 1.0 + (i as f32 - 29.0).powi(2) }).collect();
        let ranks =
            (0..N).map(|i| of_scores(&values, sampling::normal_score(&values, &mut draws(i))));
        assert_uniform("scores", ranks);
        assert_eq!(of_scores(&values, 0.5), Rank { low: 0.0, high: 0.0 });
        assert_eq!(of_scores(&values, 1e6), Rank { low: 1.0, high: 1.0 });
        // Φ(1) of a normal law with mean 3 and deviation 2, from tables.
        let line: Vec<f32> = (0..65).map(|i| 3.0 + 2.0 * (i as f32 / 8.0 - 4.0)).collect();
        let Rank { low, high } = of_scores(&line, 5.0);
        assert!((low - 0.841_345).abs() < 1e-5 && low == high, "{low} {high}");
    }

    #[test]
    fn overflowed_heads_say_nothing() {
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(softmax(&[0.0, bad], |_| true), None);
            assert_eq!(split(&[0.0, bad, 0.0], (9, 2, 5), 4), None);
            assert_eq!(swing(&[bad; ROTATION_OUTPUTS], Alignment::Bud, Vec2::ONE, false), None);
        }
        assert_eq!(softmax(&[0.0, 1.0], |_| false), None);
    }
}
