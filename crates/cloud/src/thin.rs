//! Fewer points: the first of each place or voxel.

use deeptree_graph::Vec3;

/// The first point of each voxel, as ascending numbers.
///
/// The grid starts at the origin, so that the voxels of one size lie within those of twice the
/// size: thinning by the one and then by the other is thinning by the other.
pub(crate) fn first_by_voxel(points: &[Vec3], voxel: f32) -> Vec<u32> {
    // A cast saturates: what is farther than 2³¹ voxels shares the last one.
    first_of_each(points, |p| (p / voxel).floor().to_array().map(|c| c as i32))
}

/// The first point of each place, as ascending numbers.
pub(crate) fn first_by_place(points: &[Vec3]) -> Vec<u32> {
    // Adding zero makes −0 and 0 the same place.
    first_of_each(points, |p| p.to_array().map(|c| (c + 0.0).to_bits() as i32))
}

fn first_of_each(points: &[Vec3], key: impl Fn(Vec3) -> [i32; 3]) -> Vec<u32> {
    let mut keyed: Vec<([i32; 3], u32)> =
        points.iter().enumerate().map(|(i, &p)| (key(p), i as u32)).collect();
    keyed.sort_unstable();
    keyed.dedup_by_key(|(key, _)| *key);
    let mut kept: Vec<u32> = keyed.into_iter().map(|(_, i)| i).collect();
    kept.sort_unstable();
    kept
}
