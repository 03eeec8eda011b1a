//! The environments that trees have grown in.

use deeptree_graph::Occupancy;
use deeptree_scene::Environment;

/// What stood around a tree while it grew, with its voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    environment: Environment,
    /// Where nothing could grow: obstacles, and what lies outside of the volume it was kept in.
    pub(crate) taken: Occupancy,
    /// What took light away: obstacles.
    pub(crate) shading: Occupancy,
}

impl Surroundings {
    /// The surroundings of a tree that has grown in an environment; none in the open field.
    #[must_use]
    pub fn of(environment: Environment) -> Option<Self> {
        let (taken, shading) = (environment.occupancy(), environment.scene.occupancy());
        (!environment.is_open()).then_some(Self { environment, taken, shading })
    }

    /// The environment.
    #[must_use]
    pub const fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Where nothing could grow.
    #[must_use]
    pub const fn taken(&self) -> &Occupancy {
        &self.taken
    }

    /// What took light away.
    #[must_use]
    pub const fn shading(&self) -> &Occupancy {
        &self.shading
    }
}

/// One of the eight ways to turn a scene about the vertical by quarters, and to mirror it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn(usize);

impl Turn {
    /// How many there are.
    pub(crate) const COUNT: usize = 8;
    /// None.
    pub(crate) const NONE: Self = Self(0);

    /// The turn of this number below [`Self::COUNT`].
    pub(crate) fn new(number: usize) -> Self {
        assert!(number < Self::COUNT, "turn {number}");
        Self(number)
    }

    /// Where a horizontal vector (x, z) points after it: mirrored along x, then turned.
    pub(crate) fn vector(self, [x, z]: [f32; 2]) -> [f32; 2] {
        let x = if self.0 & 4 == 0 { x } else { -x };
        match self.0 & 3 {
            0 => [x, z],
            1 => [-z, x],
            2 => [-x, -z],
            _ => [z, -x],
        }
    }

    /// Where the voxel of this column and row comes to lie.
    fn voxel(self, x: usize, z: usize) -> (usize, usize) {
        const LAST: usize = Occupancy::SIDE - 1;
        let x = if self.0 & 4 == 0 { x } else { LAST - x };
        match self.0 & 3 {
            0 => (x, z),
            1 => (LAST - z, x),
            2 => (LAST - x, LAST - z),
            _ => (z, LAST - x),
        }
    }
}

/// Values of a grid.
pub(crate) const GRID: usize = Occupancy::SIDE * Occupancy::SIDE * Occupancy::SIDE;

/// Writes a grid, turned, as zeros and ones: x fastest, then y, then z. `out` holds zeros.
pub(crate) fn write(grid: &Occupancy, turn: Turn, out: &mut [f32]) {
    for voxel in grid.iter() {
        let (x, z) = turn.voxel(usize::from(voxel.x), usize::from(voxel.z));
        out[(z * Occupancy::SIDE + usize::from(voxel.y)) * Occupancy::SIDE + x] = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Vec3, Voxel};

    #[test]
    fn a_grid_turns_as_the_vectors_to_its_voxels_do() {
        let at = Vec3::new(7.0, 5.0, -11.0);
        let mut grid = Occupancy::EMPTY;
        grid.set(Voxel::holding(at).unwrap());
        let mut seen = Vec::new();
        for number in 0..Turn::COUNT {
            let turn = Turn::new(number);
            let mut values = vec![0.0; GRID];
            write(&grid, turn, &mut values);
            let [x, z] = turn.vector([at.x, at.z]);
            let voxel = Voxel::holding(Vec3::new(x, at.y, z)).unwrap();
            let index =
                (usize::from(voxel.z) * 32 + usize::from(voxel.y)) * 32 + usize::from(voxel.x);
            assert_eq!(values.iter().sum::<f32>(), 1.0);
            assert_eq!(values[index], 1.0, "turn {number}");
            seen.push(index);
        }
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 8, "some turns are the same");
        assert_eq!(Turn::NONE.vector([1.0, 2.0]), [1.0, 2.0]);
    }
}
