//! 3D convolutions of kernel 3³, stride 2 and padding 1, with a rectifier after each.
//!
//! `y[o] = max(0, bias + Σ_k Σ_i x[2 p + k − 1][i] · w[k][i][o])` for place p and the 27 offsets k,
//! x fastest, then y, then z. Every output adds up its terms in this order, with separate multiply
//! and add, so that the bits are the same everywhere. What lies outside counts as 0.

use deeptree_graph::Occupancy;
use deeptree_graph::signature::outlook::KERNEL;

use crate::weights::{ReadWeightsError, Weights};

/// Offsets along one axis.
const TAPS: usize = 3;

/// One convolution from `IN` to `OUT` channels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Convolution<const IN: usize, const OUT: usize> {
    /// `[KERNEL]`
    weights: Vec<[[f32; OUT]; IN]>,
    bias: [f32; OUT],
}

impl<const IN: usize, const OUT: usize> Convolution<IN, OUT> {
    /// The convolution of the tensors `<name>.weight`, `[3, 3, 3, IN, OUT]` by z, y and x, and
    /// `<name>.bias`, `[OUT]`.
    pub(super) fn read(weights: &Weights, name: &str) -> Result<Self, ReadWeightsError> {
        let shape = [TAPS, TAPS, TAPS, IN, OUT].map(Some);
        let values = weights.table(&format!("{name}.weight"), &shape)?.values();
        let bias = weights.table(&format!("{name}.bias"), &[Some(OUT)])?.values();
        let tap = |tap: &[f32]| std::array::from_fn(|i| std::array::from_fn(|o| tap[i * OUT + o]));
        Ok(Self {
            weights: values.chunks_exact(IN * OUT).map(tap).collect(),
            bias: std::array::from_fn(|o| bias[o]),
        })
    }

    pub(super) const fn weight_count(&self) -> usize {
        KERNEL * IN * OUT + OUT
    }

    /// The maps of a cube of `side`³ places, x fastest, then y, then z.
    pub(super) fn maps(&self, side: usize, input: &[[f32; IN]]) -> Vec<[f32; OUT]> {
        let half = side / 2;
        let mut maps = Vec::with_capacity(half * half * half);
        for z in 0..half {
            for y in 0..half {
                for x in 0..half {
                    let mut sum = self.bias;
                    for (kz, iz) in taps(z) {
                        for (ky, iy) in taps(y) {
                            for (kx, ix) in taps(x) {
                                let place = &input[(iz * side + iy) * side + ix];
                                let tap = &self.weights[(kz * TAPS + ky) * TAPS + kx];
                                for (value, weights) in place.iter().zip(tap) {
                                    for (sum, weight) in sum.iter_mut().zip(weights) {
                                        *sum += value * weight;
                                    }
                                }
                            }
                        }
                    }
                    maps.push(sum.map(rectified));
                }
            }
        }
        maps
    }
}

impl<const OUT: usize> Convolution<2, OUT> {
    /// The maps of two grids: as [`Self::maps`] of their bits. A place that is free adds 0 to a
    /// sum, so rows of free places are left out, and the rest is a mask instead of a product.
    pub(super) fn maps_of_bits(&self, grids: [&Occupancy; 2]) -> Vec<[f32; OUT]> {
        const HALF: usize = Occupancy::SIDE / 2;
        /// The places of a row that a tap meets, one in two.
        const MET: u64 = 0x5555_5555;
        let mut maps = Vec::with_capacity(HALF * HALF * HALF);
        for z in 0..HALF {
            for y in 0..HALF {
                let mut sums = [self.bias; HALF];
                for (kz, iz) in taps(z) {
                    for (ky, iy) in taps(y) {
                        // One place to the left, so that the first tap of place 0 finds a 0.
                        let rows = grids.map(|grid| u64::from(row(grid, iy, iz)) << 1);
                        if rows == [0, 0] {
                            continue;
                        }
                        for (kx, tap) in
                            self.weights[(kz * TAPS + ky) * TAPS..][..TAPS].iter().enumerate()
                        {
                            for (row, weights) in rows.iter().zip(tap) {
                                let met = row >> kx & MET;
                                if met > 0 {
                                    add(&mut sums, met, weights);
                                }
                            }
                        }
                    }
                }
                maps.extend(sums.map(|sum| sum.map(rectified)));
            }
        }
        maps
    }
}

/// Adds the weights to each sum whose bit, one in two, is set.
fn add<const OUT: usize>(sums: &mut [[f32; OUT]], met: u64, weights: &[f32; OUT]) {
    for (place, sum) in sums.iter_mut().enumerate() {
        let mask = ((met >> (2 * place)) as u32 & 1).wrapping_neg();
        for (sum, weight) in sum.iter_mut().zip(weights) {
            *sum += f32::from_bits(weight.to_bits() & mask);
        }
    }
}

/// The offsets that meet the cube from the place `at` along one axis, and where: the first of the
/// first place lies outside.
fn taps(at: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..TAPS).filter_map(move |tap| Some((tap, (2 * at + tap).checked_sub(1)?)))
}

/// The 32 voxels along x at this y and z; the lowest bit has the lowest x.
fn row(grid: &Occupancy, y: usize, z: usize) -> u32 {
    let number = z * Occupancy::SIDE + y;
    (grid.words()[number / 2] >> (32 * (number % 2))) as u32
}

/// `v > 0 ? v : 0`; −0 and NaN give +0.
fn rectified(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Draws, Lineage, Purpose, Seed, Voxel};

    const SIDE: i64 = Occupancy::SIDE as i64;

    fn draws(seed: u64) -> Draws {
        Seed(seed).draws(Lineage::ROOT, Purpose::InitialWeights)
    }

    fn convolution<const IN: usize, const OUT: usize>(seed: u64) -> Convolution<IN, OUT> {
        let mut draws = draws(seed);
        let mut number = || (0.4 * draws.normal()) as f32;
        let weights =
            (0..KERNEL).map(|_| [(); IN].map(|()| [(); OUT].map(|()| number()))).collect();
        Convolution { weights, bias: [(); OUT].map(|()| number()) }
    }

    /// A grid of boxes with voxels sprinkled over it.
    fn grid(seed: u64, share: f64) -> Occupancy {
        let mut draws = draws(seed);
        let mut grid = Occupancy::EMPTY;
        let low = [(); 3].map(|()| draws.index(30) as i64);
        let size = [(); 3].map(|()| 1 + draws.index(12) as i64);
        for_each(|x, y, z| {
            let inside = [x, y, z]
                .iter()
                .zip(low.iter().zip(size))
                .all(|(&c, (&l, s))| (l..l + s).contains(&c));
            if inside || draws.uniform() < share {
                grid.set(Voxel::at(x, y, z).unwrap());
            }
        });
        grid
    }

    fn for_each(mut visit: impl FnMut(i64, i64, i64)) {
        for z in 0..SIDE {
            for y in 0..SIDE {
                for x in 0..SIDE {
                    visit(x, y, z);
                }
            }
        }
    }

    /// The definition, channel by channel, of anything that can be asked for the value at a place.
    fn defined<const IN: usize, const OUT: usize>(
        convolution: &Convolution<IN, OUT>,
        half: i64,
        at: impl Fn(i64, i64, i64, usize) -> f32,
        place: [i64; 3],
    ) -> [f32; OUT] {
        assert!(place.iter().all(|c| (0..half).contains(c)));
        std::array::from_fn(|o| {
            let mut sum = convolution.bias[o];
            for dz in -1..=1 {
                for dy in -1..=1 {
                    for dx in -1..=1 {
                        let k = ((dz + 1) * 3 + dy + 1) * 3 + dx + 1;
                        for i in 0..IN {
                            let [x, y, z] = place;
                            let value = at(2 * x + dx, 2 * y + dy, 2 * z + dz, i);
                            sum += value * convolution.weights[k as usize][i][o];
                        }
                    }
                }
            }
            sum.max(0.0)
        })
    }

    #[test]
    fn maps_of_bits_are_those_of_the_definition_to_the_last_bit() {
        for (seed, share) in [(1, 0.0), (2, 0.01), (3, 0.5), (4, 1.0)] {
            let layer = convolution::<2, 4>(seed);
            let grids = [grid(10 + seed, share), grid(20 + seed, share / 2.0)];
            let maps = layer.maps_of_bits([&grids[0], &grids[1]]);
            assert_eq!(maps.len(), 16 * 16 * 16);
            let at = |x, y, z, i: usize| {
                f32::from(u8::from(Voxel::at(x, y, z).is_some_and(|voxel| grids[i].holds(voxel))))
            };
            for (n, map) in maps.iter().enumerate() {
                let n = n as i64;
                let place = [n % 16, n / 16 % 16, n / 256];
                let expected = defined(&layer, 16, at, place);
                assert_eq!(map.map(f32::to_bits), expected.map(f32::to_bits), "{seed} {place:?}");
            }
        }
    }

    #[test]
    fn maps_of_values_are_those_of_the_definition_to_the_last_bit() {
        let side = 8;
        let layer = convolution::<4, 8>(5);
        let mut draws = draws(6);
        let input: Vec<[f32; 4]> =
            (0..side * side * side).map(|_| [(); 4].map(|()| draws.normal() as f32)).collect();
        let side = side as i64;
        let at = |x: i64, y: i64, z: i64, i: usize| {
            let inside = [x, y, z].iter().all(|c| (0..side).contains(c));
            if inside { input[((z * side + y) * side + x) as usize][i] } else { 0.0 }
        };
        for (n, map) in layer.maps(8, &input).iter().enumerate() {
            let n = n as i64;
            let place = [n % 4, n / 4 % 4, n / 16];
            let expected = defined(&layer, 4, at, place);
            assert_eq!(map.map(f32::to_bits), expected.map(f32::to_bits), "{place:?}");
        }
    }

    #[test]
    fn what_is_moved_by_eight_voxels_moves_the_last_maps_by_one_place() {
        let (a, b, c) = (convolution::<2, 4>(7), convolution::<4, 8>(8), convolution::<8, 8>(9));
        let maps = |voxel: Voxel| {
            let mut grid = Occupancy::EMPTY;
            grid.set(voxel);
            let first = a.maps_of_bits([&grid, &Occupancy::EMPTY]);
            c.maps(8, &b.maps(16, &first))
        };
        // The border sees zeros beyond it: only differences to the empty maps move along.
        let empty = c.maps(8, &b.maps(16, &a.maps_of_bits([&Occupancy::EMPTY; 2])));
        let (before, after) =
            (maps(Voxel { x: 9, y: 10, z: 12 }), maps(Voxel { x: 17, y: 10, z: 12 }));
        let mut moved = 0;
        for z in 0..4 {
            for y in 0..4 {
                for x in 1..3 {
                    let at = |x: usize| (z * 4 + y) * 4 + x;
                    for o in 0..8 {
                        let (one, other) = (before[at(x)][o], after[at(x + 1)][o]);
                        let was = (empty[at(x)][o], empty[at(x + 1)][o]);
                        assert!(((one - was.0) - (other - was.1)).abs() < 1e-5);
                        moved += usize::from(one != was.0);
                    }
                }
            }
        }
        assert!(moved > 0, "nothing was there to move");
    }
}
