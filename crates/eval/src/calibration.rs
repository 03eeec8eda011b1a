//! Do probabilities that were told come true? Reliability of chances, uniformity of ranks, and means
//! whose errors know that the nodes of one tree are alike.
//!
//! All three are filled tree by tree: `add` for each sample of a tree, `close` at its end, `merge`
//! with those of other trees.

use serde::{Deserialize, Serialize};

/// A mean of samples that come in trees.
///
/// With n_t samples of sum s_t in tree t of T, the mean is `r = Σ s_t / Σ n_t`, and its standard
/// error `√(T / (T − 1) · Σ (s_t − r n_t)²) / Σ n_t`.
///
/// # Source
///
/// Cochran 1977, "Sampling Techniques", §6.3 and §9A: ratio of cluster totals
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TreeMean {
    trees: f64,
    /// Σ n, Σ s
    count: f64,
    sum: f64,
    /// Σ n², Σ n s, Σ s²
    squares: [f64; 3],
    /// n and s of the tree at hand.
    #[serde(skip)]
    open: [f64; 2],
}

impl TreeMean {
    /// Adds a sample of the tree at hand.
    pub fn add(&mut self, x: f64) {
        self.open[0] += 1.0;
        self.open[1] += x;
    }

    /// Ends the tree at hand. One without samples does not count.
    pub fn close(&mut self) {
        let [n, s] = std::mem::take(&mut self.open);
        if n > 0.0 {
            let squares = [n * n, n * s, s * s];
            self.merge(&Self { trees: 1.0, count: n, sum: s, squares, open: [0.0; 2] });
        }
    }

    /// Adds other trees, which must be closed.
    pub fn merge(&mut self, other: &Self) {
        self.trees += other.trees;
        self.count += other.count;
        self.sum += other.sum;
        for (own, other) in self.squares.iter_mut().zip(other.squares) {
            *own += other;
        }
    }

    /// How many samples.
    #[must_use]
    pub const fn count(&self) -> f64 {
        self.count
    }

    /// Their mean; 0 of none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        if self.count > 0.0 { self.sum / self.count } else { 0.0 }
    }

    /// Its standard error; 0 where fewer than two trees have samples, which tell none.
    #[must_use]
    pub fn error(&self) -> f64 {
        if self.trees < 2.0 {
            return 0.0;
        }
        let (r, [nn, ns, ss]) = (self.mean(), self.squares);
        let scatter = (ss - 2.0 * r * ns + r * r * nn).max(0.0);
        (self.trees / (self.trees - 1.0) * scatter).sqrt() / self.count
    }
}

/// Bins of a reliability diagram.
pub const BINS: usize = 10;

/// Told probabilities in tenths, each with what came.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reliability {
    bins: [Bin; BINS],
    /// Happened less told, over all bins.
    pub excess: TreeMean,
    told: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Bin {
    told: f64,
    excess: TreeMean,
}

/// A point of a reliability diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BinPoint {
    /// Mean of the told probabilities.
    pub told: f64,
    /// Share of those that came true.
    pub happened: f64,
    /// Standard error of the difference, from tree to tree.
    pub error: f64,
    /// How many.
    pub count: f64,
}

impl Reliability {
    /// Adds a told probability and whether it came true.
    pub fn add(&mut self, told: f64, happened: bool) {
        let excess = f64::from(u8::from(happened)) - told;
        let bin = &mut self.bins[((told * BINS as f64) as usize).min(BINS - 1)];
        bin.told += told;
        bin.excess.add(excess);
        self.told += told;
        self.excess.add(excess);
    }

    /// Ends the tree at hand.
    pub fn close(&mut self) {
        self.bins.iter_mut().for_each(|bin| bin.excess.close());
        self.excess.close();
    }

    /// Adds other trees, which must be closed.
    pub fn merge(&mut self, other: &Self) {
        for (own, other) in self.bins.iter_mut().zip(&other.bins) {
            own.told += other.told;
            own.excess.merge(&other.excess);
        }
        self.excess.merge(&other.excess);
        self.told += other.told;
    }

    /// How many probabilities were told.
    #[must_use]
    pub const fn count(&self) -> f64 {
        self.excess.count()
    }

    /// Mean of the told probabilities.
    #[must_use]
    pub fn told(&self) -> f64 {
        self.told / self.count().max(1.0)
    }

    /// The bins that have any.
    pub fn points(&self) -> impl Iterator<Item = BinPoint> + '_ {
        self.bins.iter().filter(|bin| bin.excess.count() > 0.0).map(|bin| {
            let (count, told) = (bin.excess.count(), bin.told / bin.excess.count());
            let happened = told + bin.excess.mean();
            BinPoint { told, happened, error: bin.excess.error(), count }
        })
    }

    /// The expected calibration error: mean distance between told and happened, bin by bin.
    ///
    /// # Source
    ///
    /// Naeini, Cooper and Hauskrecht 2015
    #[must_use]
    pub fn calibration_error(&self) -> f64 {
        self.mean_over_bins(|point| (point.happened - point.told).abs())
    }

    /// What [`Self::calibration_error`] would be on average if every bin were right: the mean size
    /// of a normal error is √(2/π) of its standard deviation.
    #[must_use]
    pub fn calibration_chance(&self) -> f64 {
        core::f64::consts::FRAC_2_PI.sqrt() * self.mean_over_bins(|point| point.error)
    }

    fn mean_over_bins(&self, of: impl Fn(&BinPoint) -> f64) -> f64 {
        let sum: f64 = self.points().map(|point| point.count * of(&point)).sum();
        sum / self.count().max(1.0)
    }
}

/// Bins that ranks are counted in.
pub const RANK_BINS: usize = 20;

/// Where true values stand in the laws that were told of them: uniformly over 0 to 1 if these are
/// right. A rank that is an interval, as of whole numbers, is spread evenly over it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Uniformity {
    mass: [f64; RANK_BINS],
    /// Rank less ½: above 0 where the true values are larger than told.
    pub bias: TreeMean,
    /// `12 (rank − ½)² − 1`: above 0 where the true values scatter more than told.
    pub spread: TreeMean,
}

impl Uniformity {
    /// Adds a rank between `low` and `high`.
    pub fn add(&mut self, low: f64, high: f64) {
        let (middle, width) = (0.5 * (low + high) - 0.5, high - low);
        self.bias.add(middle);
        self.spread.add(12.0 * middle * middle + width * width - 1.0);
        let bins = RANK_BINS as f64;
        let first = ((low * bins) as usize).min(RANK_BINS - 1);
        let last = ((high * bins) as usize).min(RANK_BINS - 1);
        if first == last || width <= 0.0 {
            self.mass[last] += 1.0;
            return;
        }
        for (bin, mass) in self.mass.iter_mut().enumerate().take(last + 1).skip(first) {
            let (start, end) = (bin as f64 / bins, (bin + 1) as f64 / bins);
            *mass += (high.min(end) - low.max(start)).max(0.0) / width;
        }
    }

    /// Ends the tree at hand.
    pub fn close(&mut self) {
        self.bias.close();
        self.spread.close();
    }

    /// Adds other trees, which must be closed.
    pub fn merge(&mut self, other: &Self) {
        for (own, other) in self.mass.iter_mut().zip(other.mass) {
            *own += other;
        }
        self.bias.merge(&other.bias);
        self.spread.merge(&other.spread);
    }

    /// How many ranks.
    #[must_use]
    pub const fn count(&self) -> f64 {
        self.bias.count()
    }

    /// Share of the ranks in each bin.
    #[must_use]
    pub fn shares(&self) -> [f64; RANK_BINS] {
        let total = self.mass.iter().sum::<f64>().max(1.0);
        self.mass.map(|mass| mass / total)
    }

    /// The largest distance between the distribution function of the ranks and the uniform one, at
    /// the ends of the bins: the part of the probability that is in the wrong place.
    #[must_use]
    pub fn gap(&self) -> f64 {
        if self.count() < 1.0 {
            return 0.0;
        }
        let mut below = 0.0;
        let gaps = self.shares().into_iter().enumerate().map(|(bin, share)| {
            below += share;
            (below - (bin + 1) as f64 / RANK_BINS as f64).abs()
        });
        gaps.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_over_trees_and_its_error_are_those_worked_out_by_hand() {
        // Trees of 1, 2 and 3 samples: sums 1, 5, 6, mean 2; off by −1, 1, 0.
        let mut all = TreeMean::default();
        for tree in [&[1.0][..], &[2.0, 3.0], &[], &[1.0, 2.0, 3.0]] {
            let mut one = TreeMean::default();
            tree.iter().for_each(|&x| one.add(x));
            one.close();
            all.merge(&one);
        }
        assert_eq!((all.count(), all.mean()), (6.0, 2.0));
        assert!((all.error() - (3.0f64 / 2.0 * 2.0).sqrt() / 6.0).abs() < 1e-12);
        assert_eq!(TreeMean::default().error(), 0.0);
    }

    #[test]
    fn trees_of_one_sample_have_the_binomial_error() {
        let mut all = TreeMean::default();
        for i in 0..400 {
            all.add(f64::from(u8::from(i % 4 == 0)));
            all.close();
        }
        let binomial = (0.25f64 * 0.75 / 399.0).sqrt();
        assert!((all.error() - binomial).abs() < 1e-12, "{}", all.error());
    }

    #[test]
    fn reliability_is_that_worked_out_by_hand() {
        let mut found = Reliability::default();
        // Of four told 0.2 one comes, of six told 0.9 all.
        (0..4).for_each(|i| found.add(0.2, i == 0));
        (0..6).for_each(|_| found.add(0.9, true));
        found.close();
        let points: Vec<BinPoint> = found.points().collect();
        assert_eq!(points.len(), 2);
        assert!((points[0].told - 0.2).abs() < 1e-12 && (points[0].happened - 0.25).abs() < 1e-12);
        assert!((points[1].told - 0.9).abs() < 1e-12 && (points[1].happened - 1.0).abs() < 1e-12);
        assert!((found.calibration_error() - (4.0 * 0.05 + 6.0 * 0.1) / 10.0).abs() < 1e-12);
        assert!((found.excess.mean() - (7.0 - 6.2) / 10.0).abs() < 1e-12);
        assert!((found.told() - 0.62).abs() < 1e-12);
    }

    #[test]
    fn a_bin_says_by_how_much_chance_moves_it() {
        // Four trees, of 10 told 0.5 each: 3, 5, 5 and 7 come.
        let mut found = Reliability::default();
        for come in [3, 5, 5, 7] {
            (0..10).for_each(|i| found.add(0.5, i < come));
            found.close();
        }
        let error = (4.0f64 / 3.0 * 8.0).sqrt() / 40.0;
        let point = found.points().next().unwrap();
        assert!((point.error - error).abs() < 1e-12 && (point.happened - 0.5).abs() < 1e-12);
        assert!((found.calibration_chance() / error - 0.797_884_56).abs() < 1e-8);
    }

    #[test]
    fn ranks_spread_evenly_are_uniform_whether_points_or_intervals() {
        let (mut points, mut intervals) = (Uniformity::default(), Uniformity::default());
        for i in 0..1000 {
            let u = (f64::from(i) + 0.5) / 1000.0;
            points.add(u, u);
            points.close();
            // A coin: two intervals of a half.
            let low = if i % 2 == 0 { 0.0 } else { 0.5 };
            intervals.add(low, low + 0.5);
            intervals.close();
        }
        for found in [points, intervals] {
            assert!(found.gap() < 1e-9, "{}", found.gap());
            assert!(found.bias.mean().abs() < 1e-9);
            assert!(found.spread.mean().abs() < 1e-5, "{}", found.spread.mean());
            assert!(found.shares().iter().all(|share| (share - 0.05).abs() < 1e-9));
        }
    }

    #[test]
    fn values_larger_than_told_lean_up_and_those_that_scatter_too_little_crowd_the_middle() {
        let (mut up, mut narrow) = (Uniformity::default(), Uniformity::default());
        for i in 0..1000 {
            let u = (f64::from(i) + 0.5) / 1000.0;
            // The square root of a uniform number has distribution function x².
            up.add(u.sqrt(), u.sqrt());
            narrow.add(0.25 + 0.5 * u, 0.25 + 0.5 * u);
        }
        up.close();
        narrow.close();
        assert!((up.bias.mean() - (2.0 / 3.0 - 0.5)).abs() < 1e-4);
        assert!((up.gap() - 0.25).abs() < 2e-3, "{}", up.gap());
        assert!((narrow.spread.mean() + 0.75).abs() < 1e-4);
        assert!((narrow.gap() - 0.25).abs() < 2e-3);
    }
}
