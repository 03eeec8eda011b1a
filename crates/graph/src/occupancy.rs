//! The occupancy grid Y of the growth space: which places around a tree are taken.

use glam::Vec3;

/// Voxels along each side of the grid.
const SIDE: usize = 32;
/// Side of a voxel in metres.
const VOXEL: f32 = 2.0;
/// Bits of a word.
const BITS: usize = 64;

/// A voxel of [`Occupancy`]: its column, its layer above the ground and its row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Voxel {
    /// 0 at x = −32 m.
    pub x: u8,
    /// 0 at the ground.
    pub y: u8,
    /// 0 at z = −32 m.
    pub z: u8,
}

impl Voxel {
    /// The voxel that holds `position`; none outside of the growth space. A voxel holds its lower
    /// faces and not its upper ones.
    ///
    /// # Units  metres, the foot of the tree at the origin
    #[must_use]
    pub fn holding(position: Vec3) -> Option<Self> {
        // The cast would turn NaN into 0.
        if position.is_nan() {
            return None;
        }
        let [x, y, z] =
            ((position - Occupancy::LOW) / VOXEL).to_array().map(|c| libm::floorf(c) as i64);
        Self::at(x, y, z)
    }

    /// The voxel with these coordinates; none outside of the growth space.
    #[must_use]
    pub fn at(x: i64, y: i64, z: i64) -> Option<Self> {
        let within = |c: i64| u8::try_from(c).ok().filter(|&c| usize::from(c) < SIDE);
        Some(Self { x: within(x)?, y: within(y)?, z: within(z)? })
    }

    /// The voxel's lowest corner in metres.
    #[must_use]
    pub fn low(self) -> Vec3 {
        Occupancy::LOW + VOXEL * Vec3::new(f32::from(self.x), f32::from(self.y), f32::from(self.z))
    }

    /// The voxel's centre in metres.
    #[must_use]
    pub fn centre(self) -> Vec3 {
        self.low() + Vec3::splat(VOXEL / 2.0)
    }

    /// The voxel's number: x changes fastest, then y, then z.
    #[must_use]
    pub const fn index(self) -> usize {
        (self.z as usize * SIDE + self.y as usize) * SIDE + self.x as usize
    }

    const fn of_index(index: usize) -> Self {
        Self {
            x: (index % SIDE) as u8,
            y: (index / SIDE % SIDE) as u8,
            z: (index / (SIDE * SIDE)) as u8,
        }
    }
}

/// Y: 32³ bits over the growth space x, z ∈ \[−32, 32), y ∈ \[0, 64) m, in voxels of 2 m. What lies
/// outside counts as free.
///
/// # Source
///
/// DeepTree, "Environmental Response". The paper sets the root in the middle of the grid; here it
/// stands in the middle of its floor, since nothing grows below the ground.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Occupancy {
    words: [u64; Self::WORDS],
}

impl Occupancy {
    /// Nothing is taken: the open field.
    pub const EMPTY: Self = Self { words: [0; Self::WORDS] };
    /// Voxels along each side.
    pub const SIDE: usize = SIDE;
    /// Side of a voxel in metres.
    pub const VOXEL: f32 = VOXEL;
    /// The lowest corner of the growth space in metres.
    pub const LOW: Vec3 = Vec3::new(-32.0, 0.0, -32.0);
    /// The highest corner of the growth space in metres.
    pub const HIGH: Vec3 = Vec3::new(32.0, 64.0, 32.0);
    /// How many words hold the bits.
    pub const WORDS: usize = SIDE * SIDE * SIDE / BITS;
    /// How many bytes [`Self::to_bytes`] gives.
    pub const BYTES: usize = Self::WORDS * 8;

    /// Is nothing taken?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// How many voxels are taken.
    #[must_use]
    pub fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Takes a voxel.
    pub const fn set(&mut self, voxel: Voxel) {
        let index = voxel.index();
        self.words[index / BITS] |= 1 << (index % BITS);
    }

    /// Is this voxel taken?
    #[must_use]
    pub const fn holds(&self, voxel: Voxel) -> bool {
        let index = voxel.index();
        self.words[index / BITS] >> (index % BITS) & 1 == 1
    }

    /// Is the voxel around `position` taken? Outside of the growth space nothing is.
    ///
    /// # Units  metres, the foot of the tree at the origin
    #[must_use]
    pub fn at(&self, position: Vec3) -> bool {
        Voxel::holding(position).is_some_and(|voxel| self.holds(voxel))
    }

    /// The taken voxels: by z, then y, then x.
    pub fn iter(&self) -> impl Iterator<Item = Voxel> + '_ {
        self.words.iter().enumerate().flat_map(|(at, &word)| {
            let mut left = word;
            core::iter::from_fn(move || {
                let bit = left.trailing_zeros() as usize;
                left &= left.checked_sub(1)?;
                Some(Voxel::of_index(at * BITS + bit))
            })
        })
    }

    /// Takes all voxels that `other` takes.
    pub fn unite(&mut self, other: &Self) {
        for (word, other) in self.words.iter_mut().zip(&other.words) {
            *word |= other;
        }
    }

    /// The words: the bit of voxel (x, y, z) has the number (32 z + y) 32 + x, and bit `b` of word
    /// `w` the number 64 w + b.
    #[must_use]
    pub const fn words(&self) -> &[u64; Self::WORDS] {
        &self.words
    }

    /// The grid of these [`Self::words`].
    #[must_use]
    pub const fn from_words(words: [u64; Self::WORDS]) -> Self {
        Self { words }
    }

    /// The words as bytes, each word's lowest byte first.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip(&self.words) {
            chunk.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// The grid of [`Self::to_bytes`].
    #[must_use]
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let mut words = [0; Self::WORDS];
        for (word, chunk) in words.iter_mut().zip(bytes.chunks_exact(8)) {
            let mut eight = [0; 8];
            eight.copy_from_slice(chunk);
            *word = u64::from_le_bytes(eight);
        }
        Self { words }
    }
}

impl Default for Occupancy {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl core::fmt::Debug for Occupancy {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Occupancy({} of {} voxels)", self.count(), SIDE * SIDE * SIDE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_root_stands_in_the_middle_of_the_floor() {
        assert_eq!(Voxel::holding(Vec3::ZERO), Some(Voxel { x: 16, y: 0, z: 16 }));
        assert_eq!(Voxel::holding(Vec3::new(-0.1, 1.9, -0.1)), Some(Voxel { x: 15, y: 0, z: 15 }));
        assert_eq!(Voxel::holding(Vec3::new(31.9, 63.9, 1.0)), Some(Voxel { x: 31, y: 31, z: 16 }));
    }

    #[test]
    fn what_lies_outside_is_free() {
        let all = Occupancy::from_words([u64::MAX; Occupancy::WORDS]);
        assert!(all.at(Vec3::new(0.0, 0.0, 0.0)) && all.at(Vec3::new(-32.0, 63.9, 31.9)));
        for outside in [
            Vec3::new(32.0, 1.0, 0.0),
            Vec3::new(-32.1, 1.0, 0.0),
            Vec3::new(0.0, -0.1, 0.0),
            Vec3::new(0.0, 64.0, 0.0),
            Vec3::new(0.0, 1.0, 32.0),
            Vec3::new(f32::NAN, 1.0, 0.0),
            Vec3::new(f32::INFINITY, 1.0, 0.0),
            Vec3::splat(1e30),
        ] {
            assert!(!all.at(outside), "{outside}");
        }
        assert_eq!(all.count(), 32 * 32 * 32);
    }

    #[test]
    fn bits_are_counted_along_x_then_y_then_z() {
        let mut grid = Occupancy::EMPTY;
        grid.set(Voxel { x: 3, y: 2, z: 1 });
        // (32 · 1 + 2) · 32 + 3 = 1091 = 17 · 64 + 3.
        assert_eq!(grid.words()[17], 1 << 3);
        assert_eq!(grid.to_bytes()[17 * 8], 8);
    }

    proptest! {
        #[test]
        fn a_grid_takes_what_it_is_given_and_nothing_else(
            places in prop::collection::btree_set((0u8..32, 0u8..32, 0u8..32), 0..40),
        ) {
            let voxels: Vec<Voxel> =
                places.iter().map(|&(z, y, x)| Voxel { x, y, z }).collect();
            let mut grid = Occupancy::EMPTY;
            for &voxel in &voxels {
                grid.set(voxel);
            }
            prop_assert_eq!(grid.iter().collect::<Vec<_>>(), voxels.clone());
            prop_assert_eq!(grid.count(), voxels.len());
            prop_assert_eq!(grid.is_empty(), voxels.is_empty());
            for &voxel in &voxels {
                prop_assert!(grid.holds(voxel) && grid.at(voxel.centre()) && grid.at(voxel.low()));
            }
            prop_assert_eq!(&Occupancy::from_bytes(&grid.to_bytes()), &grid);
            prop_assert_eq!(&Occupancy::from_words(*grid.words()), &grid);
            let mut twice = Occupancy::EMPTY;
            twice.unite(&grid);
            prop_assert_eq!(twice, grid);
        }
    }
}
