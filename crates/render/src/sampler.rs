//! Well-spread random numbers: Owen-scrambled Sobol points, keyed by pixel, sample and dimension.
//!
//! # Source
//!
//! Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4): padded pairs of the first two
//! Sobol dimensions, shuffled and scrambled by a hash of the key. Ahmed 2024, "An Implementation
//! Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact": the second dimension in five steps.

use deeptree_graph::Seed;

/// The random numbers of one sample of one pixel. Each number depends on the seed, the pixel, the
/// number of the sample and how many were taken before; on nothing else.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    key: u32,
    index: u32,
    dimension: u32,
}

impl Sampler {
    /// The numbers of sample `index` of a pixel.
    pub(crate) const fn new(seed: Seed, x: u32, y: u32, index: u32) -> Self {
        let key = hash(hash(hash(seed.0 as u32, (seed.0 >> 32) as u32), x), y);
        Self { key, index, dimension: 0 }
    }

    /// Two numbers in [0, 1) that are well spread together, over all samples of the pixel.
    pub(crate) const fn pair(&mut self) -> [f32; 2] {
        self.dimension += 1;
        let key = hash(self.key, self.dimension);
        let index = scramble(self.index, key);
        let first = scramble(index.reverse_bits(), hash(key, 1));
        let second = scramble(sobol_second(index), hash(key, 2));
        [unit(first), unit(second)]
    }

    /// One number in [0, 1), well spread over all samples of the pixel.
    pub(crate) const fn one(&mut self) -> f32 {
        self.dimension += 1;
        let key = hash(self.key, self.dimension);
        let index = scramble(self.index, key);
        unit(scramble(index.reverse_bits(), hash(key, 1)))
    }
}

/// The 24 upper bits as a number in [0, 1): a float holds them exactly.
const fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1u32 << 24) as f32)
}

/// The second Sobol dimension: Pascal's triangle modulo 2, times the bits of the index.
const fn sobol_second(index: u32) -> u32 {
    let mut v = index;
    v ^= (v >> 16) & 0x0000_ffff;
    v ^= (v >> 8) & 0x00ff_00ff;
    v ^= (v >> 4) & 0x0f0f_0f0f;
    v ^= (v >> 2) & 0x3333_3333;
    v ^= (v >> 1) & 0x5555_5555;
    v.reverse_bits()
}

/// Owen's nested uniform scrambling: flips each bit by a hash of the bits above it.
const fn scramble(bits: u32, key: u32) -> u32 {
    laine_karras(bits.reverse_bits(), key).reverse_bits()
}

/// A permutation in which each bit depends on itself and those below only (Laine and Karras 2011,
/// with Burley's constants).
const fn laine_karras(mut x: u32, key: u32) -> u32 {
    x = x.wrapping_add(key);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^ x.wrapping_mul(0x8d22_f6e6)
}

/// Folds a word into a key: the finaliser of MurmurHash3 (Appleby 2011, public domain).
pub(crate) const fn hash(key: u32, word: u32) -> u32 {
    let mut h = key.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
        ^ word.wrapping_mul(0xcc9e_2d51).wrapping_add(0x9e37_79b9);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Direction numbers of the second dimension: Joe and Kuo 2008, primitive polynomial x + 1.
    #[test]
    fn the_second_dimension_is_that_of_the_published_direction_numbers() {
        let mut directions = [1u32 << 31; 32];
        for i in 1..32 {
            directions[i] = directions[i - 1] ^ (directions[i - 1] >> 1);
        }
        for index in [0, 1, 2, 3, 4, 5, 100, 0xffff, 0x1234_5678, u32::MAX] {
            let sum = (0..32)
                .filter(|bit| index >> bit & 1 == 1)
                .fold(0, |sum, bit| sum ^ directions[bit as usize]);
            assert_eq!(sobol_second(index), sum, "{index}");
        }
    }

    /// A (0, m, 2)-net in base 2 has one point in each elementary interval of area 2⁻ᵐ; Owen
    /// scrambling keeps that (Owen 1995).
    #[test]
    fn pairs_of_a_pixel_are_a_net() {
        for pixel in 0..20 {
            for row in 0..=6u32 {
                let (wide, high) = (1 << row, 64 >> row);
                let mut counts = vec![0; 64];
                for index in 0..64 {
                    let mut sampler = Sampler::new(Seed(7), pixel, 3, index);
                    sampler.one();
                    let [x, y] = sampler.pair();
                    counts[(x * wide as f32) as usize * high + (y * high as f32) as usize] += 1;
                }
                assert!(counts.iter().all(|&n| n == 1), "pixel {pixel}, {wide} x {high}");
            }
        }
    }

    #[test]
    fn single_numbers_of_a_pixel_are_stratified() {
        let mut seen = [false; 64];
        for index in 0..64 {
            seen[(Sampler::new(Seed(1), 5, 9, index).one() * 64.0) as usize] = true;
        }
        assert!(seen.iter().all(|&one| one));
    }

    #[test]
    fn pixels_and_dimensions_do_not_follow_each_other() {
        let numbers = |x, skip| -> Vec<f64> {
            let one = |index| {
                let mut sampler = Sampler::new(Seed(3), x, 0, index);
                for _ in 0..skip {
                    sampler.pair();
                }
                f64::from(sampler.pair()[0]) - 0.5
            };
            (0..4096).map(one).collect()
        };
        let correlation = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64 * 12.0
        };
        let first = numbers(0, 0);
        // Of independent uniform numbers: 0 ± 1/√4096; five of those are 0.08.
        for other in [numbers(1, 0), numbers(0, 1), numbers(256, 0)] {
            assert!(correlation(&first, &other).abs() < 0.08);
        }
        assert!((correlation(&first, &first) - 1.0).abs() < 0.01);
    }
}
