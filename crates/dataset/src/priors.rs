//! Ages and values of gravitropism that differ from tree to tree.

use deeptree_graph::{Draws, Lineage, Purpose, Seed, TreeInfo};
use serde::{Deserialize, Serialize};

/// The range from a lowest to a highest value, both within; in a plan's file `[lowest, highest]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Span<T>(pub T, pub T);

/// What a tree is to be grown at; where there is none, the preset's own value is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Priors {
    /// Age in growth cycles.
    pub age: Option<u32>,
    /// Gravitropism: the part of the angle to the vertical that a new shoot turns by.
    pub gravitropism: Option<f32>,
}

/// Why trees cannot be drawn from a list of ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SpansError {
    /// There is none.
    #[error("there is no range")]
    Empty,
    /// An end is infinite or not a number.
    #[error("the ends of a range must be finite numbers")]
    NotFinite,
    /// A range ends below its start.
    #[error("a range must not end below its start")]
    Reversed,
    /// A range does not lie above the one before.
    #[error("ranges must ascend and not overlap")]
    Order,
}

impl Priors {
    /// Was this tree grown as asked?
    #[must_use]
    pub fn hold(&self, info: &TreeInfo) -> bool {
        let same = |value: f32| value.to_bits() == info.gravitropism.to_bits();
        self.age.is_none_or(|age| age == info.age) && self.gravitropism.is_none_or(same)
    }

    /// What the tree of this seed is grown at: uniform over the union of the ranges, one draw for
    /// the age and one for the gravitropism.
    pub(crate) fn draw(
        seed: Seed,
        ages: Option<&[Span<u32>]>,
        gravitropisms: Option<&[Span<f64>]>,
    ) -> Self {
        let draws = |coordinate| seed.draws(Lineage::ROOT, Purpose::Priors).at(coordinate);
        Self {
            age: ages.map(|spans| whole(spans, draws(0))),
            gravitropism: gravitropisms.map(|spans| real(spans, draws(1)) as f32),
        }
    }
}

/// Finds out whether values can be drawn from these ranges.
pub(crate) fn check<T: Copy + PartialOrd>(
    spans: &[Span<T>],
    is_finite: impl Fn(T) -> bool,
) -> Result<(), SpansError> {
    if spans.is_empty() {
        return Err(SpansError::Empty);
    }
    if !spans.iter().all(|span| is_finite(span.0) && is_finite(span.1)) {
        return Err(SpansError::NotFinite);
    }
    if spans.iter().any(|span| span.1 < span.0) {
        return Err(SpansError::Reversed);
    }
    if spans.windows(2).any(|pair| pair[1].0 <= pair[0].1) {
        return Err(SpansError::Order);
    }
    Ok(())
}

/// A whole number, each of the ranges' as likely.
fn whole(spans: &[Span<u32>], mut draws: Draws) -> u32 {
    let size = |span: &Span<u32>| (span.1 - span.0) as usize + 1;
    let mut left = draws.index(spans.iter().map(size).sum());
    for span in spans {
        if left < size(span) {
            return span.0 + left as u32;
        }
        left -= size(span);
    }
    0 // Without ranges, which no checked plan has.
}

/// A number of the ranges; one of single values when they have no length.
fn real(spans: &[Span<f64>], mut draws: Draws) -> f64 {
    let length = |span: &Span<f64>| span.1 - span.0;
    let total: f64 = spans.iter().map(length).sum();
    if total <= 0.0 {
        return spans.get(draws.index(spans.len())).map_or(0.0, |span| span.0);
    }
    let mut left = draws.uniform() * total;
    let mut last = 0.0;
    for span in spans.iter().filter(|span| length(span) > 0.0) {
        if left < length(span) {
            return (span.0 + left).min(span.1);
        }
        left -= length(span);
        last = span.1;
    }
    last // The sum of the lengths was rounded up.
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: u64 = 20_000;

    fn drawn(ages: &[Span<u32>], gravitropisms: &[Span<f64>]) -> Vec<(u32, f32)> {
        let draw = |k| {
            let priors = Priors::draw(Seed(k), Some(ages), Some(gravitropisms));
            (priors.age.unwrap(), priors.gravitropism.unwrap())
        };
        (0..N).map(draw).collect()
    }

    #[test]
    fn draws_are_uniform_over_the_ranges_and_miss_the_gaps() {
        let ages = [Span(10, 12), Span(20, 20), Span(30, 31)];
        let gravitropisms = [Span(-0.4, -0.25), Span(-0.15, 0.15), Span(0.25, 0.4)];
        let drawn = drawn(&ages, &gravitropisms);
        // Six ages, a sixth each: within five standard deviations of the binomial law.
        let n = N as f64;
        for age in [10, 11, 12, 20, 30, 31] {
            let count = drawn.iter().filter(|draw| draw.0 == age).count() as f64;
            assert!((count - n / 6.0).abs() < 5.0 * (n * 5.0 / 36.0).sqrt(), "{age}: {count}");
        }
        assert!(drawn.iter().all(|draw| [10, 11, 12, 20, 30, 31].contains(&draw.0)));
        let within = |v: f32, span: &Span<f64>| (span.0 as f32..=span.1 as f32).contains(&v);
        for (span, part) in gravitropisms.iter().zip([0.25, 0.5, 0.25]) {
            let values: Vec<f64> =
                drawn.iter().filter(|d| within(d.1, span)).map(|d| f64::from(d.1)).collect();
            let count = values.len() as f64;
            assert!((count - n * part).abs() < 5.0 * (n * part * (1.0 - part)).sqrt());
            // The mean of a uniform law lies in the middle; its variance is a twelfth of the
            // squared length.
            let mean = values.iter().sum::<f64>() / count;
            let middle = f64::midpoint(span.0, span.1);
            let error = (span.1 - span.0) / (12.0 * count).sqrt();
            assert!((mean - middle).abs() < 5.0 * error, "{span:?}: {mean}");
        }
        assert!(drawn.iter().all(|draw| gravitropisms.iter().any(|span| within(draw.1, span))));
    }

    #[test]
    fn age_and_gravitropism_are_drawn_apart() {
        let drawn = drawn(&[Span(0, 1000)], &[Span(-1.0, 1.0)]);
        // The correlation of independent draws is below five times 1/√n.
        let (a, g): (Vec<f64>, Vec<f64>) =
            drawn.iter().map(|d| (f64::from(d.0), f64::from(d.1))).unzip();
        let mean = |x: &[f64]| x.iter().sum::<f64>() / N as f64;
        let (ma, mg) = (mean(&a), mean(&g));
        let product: f64 = a.iter().zip(&g).map(|(a, g)| (a - ma) * (g - mg)).sum();
        let square = |x: &[f64], m: f64| x.iter().map(|x| (x - m) * (x - m)).sum::<f64>();
        let r = product / (square(&a, ma) * square(&g, mg)).sqrt();
        assert!(r.abs() < 5.0 / (N as f64).sqrt(), "{r}");
    }

    #[test]
    fn single_values_are_ranges() {
        let drawn = drawn(&[Span(7, 7)], &[Span(0.5, 0.5), Span(0.75, 0.75)]);
        assert!(drawn.iter().all(|draw| draw.0 == 7 && (draw.1 == 0.5 || draw.1 == 0.75)));
        assert!(drawn.iter().any(|draw| draw.1 == 0.5) && drawn.iter().any(|draw| draw.1 == 0.75));
        let all = Priors::draw(Seed(1), Some(&[Span(0, 100)]), None);
        assert!(all.age.is_some() && all.gravitropism.is_none());
    }
}
