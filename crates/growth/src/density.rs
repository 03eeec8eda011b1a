//! Crown density: the only limit to a crown in the open field, and what a growth cycle costs.
//!
//! `D_i = Σ_{j ≠ i, |b_i − b_j| < R} 1 / max(1, |b_i − b_j|)²` over the bases of all internodes.
//!
//! The sum is exact. It is cheap because a bud flushes only while D stays below a limit that is
//! known beforehand: the cells are visited from near to far, and a sum above its limit is dropped.

use deeptree_graph::Vec3;

/// Side of a grid cell in metres.
const CELL: f32 = 4.0;

/// Positions are kept in blocks of this many lanes, each with its own partial sum, so that the
/// compiler vectorises the sum and the order of additions is the same on every processor.
const LANES: usize = 8;

/// A position that no sum reaches: fills the last block of a cell.
const FAR: f32 = 1e18;

#[derive(Clone, Copy)]
struct Block {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
}

const EMPTY: Block = Block { x: [FAR; LANES], y: [FAR; LANES], z: [FAR; LANES] };

/// The bases of all internodes, by cell.
pub(crate) struct DensityGrid {
    radius_squared: f32,
    /// Cell offsets within the radius, nearest first.
    offsets: Vec<[i32; 3]>,
    origin: Vec3,
    dims: [i32; 3],
    /// Blocks of cell c: `blocks[start[c]..start[c + 1]]`.
    start: Vec<u32>,
    blocks: Vec<Block>,
    fill: Vec<u32>,
}

impl DensityGrid {
    pub(crate) fn new(radius: f32) -> Self {
        Self {
            radius_squared: radius * radius,
            offsets: offsets_within(radius),
            origin: Vec3::ZERO,
            dims: [0; 3],
            start: Vec::new(),
            blocks: Vec::new(),
            fill: Vec::new(),
        }
    }

    /// Sorts the bases into cells (a counting sort, in the order given).
    pub(crate) fn fill(&mut self, bases: impl Iterator<Item = Vec3> + Clone) {
        let mut low = Vec3::splat(f32::INFINITY);
        let mut high = Vec3::splat(f32::NEG_INFINITY);
        for base in bases.clone() {
            low = low.min(base);
            high = high.max(base);
        }
        self.origin = low;
        self.dims = cell_of(high - low).map(|n| n + 1);
        let cells = self.dims.iter().product::<i32>() as usize;

        self.fill.clear();
        self.fill.resize(cells, 0);
        for base in bases.clone() {
            let cell = self.index(cell_of(base - low));
            self.fill[cell] += 1;
        }
        self.start.clear();
        let mut blocks = 0;
        for &count in &self.fill {
            self.start.push(blocks);
            blocks += count.div_ceil(LANES as u32);
        }
        self.start.push(blocks);
        self.blocks.clear();
        self.blocks.resize(blocks as usize, EMPTY);
        self.fill.fill(0);
        for base in bases {
            let cell = self.index(cell_of(base - low));
            let at = self.fill[cell] as usize;
            self.fill[cell] += 1;
            let block = &mut self.blocks[self.start[cell] as usize + at / LANES];
            (block.x[at % LANES], block.y[at % LANES], block.z[at % LANES]) = base.into();
        }
    }

    /// D at the base of an internode that is in the grid, or some value above `limit` when D is.
    pub(crate) fn at(&self, base: Vec3, limit: f32) -> f32 {
        // The internode meets itself once, at distance 0.
        let mut sum = -1.0;
        let [x, y, z] = cell_of(base - self.origin);
        let [nx, ny, nz] = self.dims;
        for &[dx, dy, dz] in &self.offsets {
            let (cx, cy, cz) = (x + dx, y + dy, z + dz);
            // A negative coordinate is a huge one when read without its sign.
            if cx as u32 >= nx as u32 || cy as u32 >= ny as u32 || cz as u32 >= nz as u32 {
                continue;
            }
            let cell = self.index([cx, cy, cz]);
            let blocks = self.start[cell] as usize..self.start[cell + 1] as usize;
            if blocks.is_empty() {
                continue;
            }
            sum += weight(&self.blocks[blocks], base, self.radius_squared);
            if sum > limit {
                break;
            }
        }
        sum
    }

    const fn index(&self, [x, y, z]: [i32; 3]) -> usize {
        ((z * self.dims[1] + y) * self.dims[0] + x) as usize
    }
}

/// Σ 1 / max(1, d²) over the positions of some blocks within the radius.
fn weight(blocks: &[Block], base: Vec3, radius_squared: f32) -> f32 {
    let mut sums = [0.0f32; LANES];
    for block in blocks {
        #[expect(clippy::needless_range_loop, reason = "four arrays side by side")]
        for lane in 0..LANES {
            let (dx, dy, dz) =
                (block.x[lane] - base.x, block.y[lane] - base.y, block.z[lane] - base.z);
            let d2 = dx * dx + dy * dy + dz * dz;
            let w = 1.0 / if d2 > 1.0 { d2 } else { 1.0 };
            sums[lane] += if d2 < radius_squared { w } else { 0.0 };
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

fn cell_of(offset: Vec3) -> [i32; 3] {
    (offset / CELL).to_array().map(|x| x as i32)
}

/// Offsets of the cells that can hold a position within `radius`, by the distance of their centres.
fn offsets_within(radius: f32) -> Vec<[i32; 3]> {
    let reach = libm::ceilf(radius / CELL) as i32;
    let mut offsets = Vec::new();
    for z in -reach..=reach {
        for y in -reach..=reach {
            for x in -reach..=reach {
                let gap = [x, y, z].map(|d| (d.abs() - 1).max(0) as f32 * CELL);
                if gap.iter().map(|g| g * g).sum::<f32>() < radius * radius {
                    offsets.push([x, y, z]);
                }
            }
        }
    }
    offsets.sort_by_key(|&[x, y, z]| (x * x + y * y + z * z, z, y, x));
    offsets
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    fn cloud(n: usize, size: f64) -> Vec<Vec3> {
        (0..n)
            .map(|i| {
                let mut draws = Seed(i as u64).draws(Lineage::ROOT, Purpose::Priors);
                let mut coordinate = || ((draws.uniform() - 0.5) * size) as f32;
                Vec3::new(coordinate(), coordinate(), coordinate())
            })
            .collect()
    }

    #[test]
    fn the_sum_is_the_one_over_all_pairs() {
        let points = cloud(700, 40.0);
        let mut grid = DensityGrid::new(16.0);
        grid.fill(points.iter().copied());
        for (i, &a) in points.iter().enumerate() {
            let pairs: f64 = points
                .iter()
                .enumerate()
                .filter(|&(j, b)| j != i && a.distance(*b) < 16.0)
                .map(|(_, b)| 1.0 / f64::from(a.distance_squared(*b)).max(1.0))
                .sum();
            assert!((f64::from(grid.at(a, f32::INFINITY)) - pairs).abs() < 1e-4 * pairs.max(1.0));
        }
    }

    #[test]
    fn a_sum_that_stops_early_lies_on_the_same_side_of_its_limit() {
        let points = cloud(700, 20.0);
        let mut grid = DensityGrid::new(16.0);
        grid.fill(points.iter().copied());
        for &a in &points {
            let whole = grid.at(a, f32::INFINITY);
            for limit in [1.0, 5.0, 10.0, 20.0] {
                assert_eq!(grid.at(a, limit) > limit, whole > limit);
            }
        }
    }
}
