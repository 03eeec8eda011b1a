//! Filling the occupancy grid.

use deeptree_graph::{Occupancy, Vec3, Voxel};
use glam::DVec3;

/// Takes the voxels between two corners for which `taken` says so, given their centre and half
/// sides.
pub(crate) fn take(
    grid: &mut Occupancy,
    [low, high]: [Vec3; 2],
    mut taken: impl FnMut(DVec3, DVec3) -> bool,
) {
    let last = Occupancy::SIDE as i64 - 1;
    let range = |axis: usize| {
        let cell = |x: f32| libm::floorf((x - Occupancy::LOW[axis]) / Occupancy::VOXEL) as i64;
        // One more on either side, for rounding.
        (cell(low[axis]) - 1).max(0)..=(cell(high[axis]) + 1).min(last)
    };
    let half = DVec3::splat(f64::from(Occupancy::VOXEL) / 2.0);
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let Some(voxel) = Voxel::at(x, y, z) else { continue };
                if !grid.holds(voxel) && taken(voxel.centre().as_dvec3(), half) {
                    grid.set(voxel);
                }
            }
        }
    }
}
