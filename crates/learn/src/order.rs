//! The order of the samples: a keyed permutation that is computed, not stored.

use deeptree_graph::{Draws, Lineage, Purpose, Seed};

/// Rounds of the network; four are enough for orders that look random (Luby and Rackoff 1988).
const ROUNDS: usize = 4;

/// The orders in which one network sees its samples: one permutation after another.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    seed: Seed,
    network: u64,
    samples: u64,
    pass: u64,
    permutation: Permutation,
}

impl Order {
    /// # Panics
    ///
    /// When there are no samples.
    pub(crate) fn new(seed: Seed, network: u64, samples: usize) -> Self {
        assert!(samples > 0, "an order of no samples");
        let samples = samples as u64;
        let permutation = Permutation::new(seed, network, 0, samples);
        Self { seed, network, samples, pass: 0, permutation }
    }

    /// The sample at `position`, which counts on from epoch to epoch.
    pub(crate) fn sample(&mut self, position: u64) -> usize {
        let pass = position / self.samples;
        if pass != self.pass {
            self.pass = pass;
            self.permutation = Permutation::new(self.seed, self.network, pass, self.samples);
        }
        self.permutation.at(position % self.samples) as usize
    }

    /// Draws for a task that picks the sample at `position` itself.
    pub(crate) fn draws(&self, position: u64) -> Draws {
        self.seed.draws(Lineage::ROOT, Purpose::EpochOrder).at(self.network).at(position)
    }
}

/// A keyed bijection of `0..len`: a Feistel network on the next power of four, walked on where it
/// leaves the range.
///
/// # Source
///
/// Black and Rogaway 2002, "Ciphers with arbitrary finite domains" (generalised Feistel, cycle
/// walking).
#[derive(Clone, Debug)]
struct Permutation {
    len: u64,
    half: u32,
    keys: [u64; ROUNDS],
}

impl Permutation {
    fn new(seed: Seed, network: u64, pass: u64, len: u64) -> Self {
        let mut draws = seed.draws(Lineage::ROOT, Purpose::EpochOrder).at(network).at(pass);
        let bits = u64::BITS - (len - 1).leading_zeros();
        Self { len, half: bits.div_ceil(2), keys: std::array::from_fn(|_| draws.bits()) }
    }

    fn at(&self, index: u64) -> u64 {
        let mut x = index;
        loop {
            x = self.shuffled(x);
            if x < self.len {
                return x;
            }
        }
    }

    fn shuffled(&self, x: u64) -> u64 {
        let mask = (1u64 << self.half) - 1;
        let (mut left, mut right) = (x >> self.half, x & mask);
        for key in self.keys {
            // Any mixing function makes a bijection; this one is a multiply and two folds.
            let mixed = (right ^ key).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
            (left, right) = (right, left ^ ((mixed >> 32) & mask));
        }
        left << self.half | right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pass_visits_every_sample_once_in_another_order() {
        for samples in [1, 2, 3, 16, 17, 1000, 4097] {
            let mut order = Order::new(Seed(3), 1, samples);
            let passes: Vec<Vec<usize>> = (0..3)
                .map(|pass| {
                    (0..samples).map(|i| order.sample((pass * samples + i) as u64)).collect()
                })
                .collect();
            for pass in &passes {
                let mut sorted = pass.clone();
                sorted.sort_unstable();
                assert!(sorted.iter().copied().eq(0..samples), "{samples} samples");
            }
            assert!(samples < 16 || passes[0] != passes[1]);
        }
    }

    #[test]
    fn places_are_uncorrelated_with_samples() {
        let n = 100_000;
        let mut order = Order::new(Seed(9), 0, n);
        let half = n as f64 / 2.0;
        let products = (0..n).map(|i| (i as f64 - half) * (order.sample(i as u64) as f64 - half));
        let correlation = products.sum::<f64>() / (n as f64).powi(3) * 12.0;
        assert!(correlation.abs() < 5.0 / (n as f64).sqrt(), "{correlation}");
    }
}
