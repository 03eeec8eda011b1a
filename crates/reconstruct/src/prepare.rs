//! What is kept of a cloud: finite points, none twice, no more than can be worked on.

use deeptree_graph::Vec3;

use crate::ReconstructError;

/// Points that are worked on at most; a cloud of more is thinned.
pub const MOST_POINTS: usize = 60_000;

/// Side of the finest voxels points are merged in, as a share of the cloud's longest side: far
/// below what a skeleton can show.
const FINEST: f32 = 5e-4;

/// A cloud as it is worked on.
#[derive(Clone, Debug)]
pub(crate) struct Cloud {
    /// One point a voxel, the mean of those in it.
    pub(crate) points: Vec<Vec3>,
    /// Points that were no finite numbers.
    pub(crate) not_finite: usize,
    /// Side of the voxels in metres.
    pub(crate) voxel: f32,
}

/// Merges the points of a cloud that share a voxel; the voxels grow until few enough are left.
///
/// # Errors
///
/// When no point is finite, or all are at one place.
pub(crate) fn prepare(cloud: &[Vec3], most: usize) -> Result<Cloud, ReconstructError> {
    // Squares of distances must stay finite.
    let is_sound = |p: &&Vec3| p.is_finite() && p.abs().max_element() < 1e15;
    let finite = || cloud.iter().filter(is_sound);
    let bounds = finite()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let count = finite().count();
    if count == 0 {
        return Err(ReconstructError::NoPoints { given: cloud.len() });
    }
    let side = (bounds.1 - bounds.0).max_element();
    if side.is_nan() || side <= f32::EPSILON * bounds.0.abs().max(bounds.1.abs()).max_element() {
        return Err(ReconstructError::OnePlace);
    }
    let mut voxel = side * FINEST;
    let mut points: Vec<Vec3> = finite().copied().collect();
    loop {
        points = merged(&points, bounds.0, voxel);
        if points.len() <= most.max(2) {
            return Ok(Cloud { points, not_finite: cloud.len() - count, voxel });
        }
        voxel *= 1.3;
    }
}

/// The mean point of each voxel that has any, in the order of the voxels.
fn merged(points: &[Vec3], low: Vec3, voxel: f32) -> Vec<Vec3> {
    let key = |p: &Vec3| {
        let [x, y, z] = ((*p - low) / voxel).to_array().map(|c| c as u64);
        y << 42 | x << 21 | z
    };
    let mut keyed: Vec<(u64, u32)> = (0..).zip(points).map(|(i, p)| (key(p), i)).collect();
    keyed.sort_unstable_by_key(|&(key, i)| (key, i));
    keyed
        .chunk_by(|a, b| a.0 == b.0)
        .map(|same| {
            let first = points[same[0].1 as usize];
            // About the first, so that a mean of equal points is that point.
            let sum: Vec3 = same.iter().map(|&(_, i)| points[i as usize] - first).sum();
            first + sum / same.len() as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clouds_that_say_nothing_are_refused() {
        let nan = Vec3::new(0.0, f32::NAN, 0.0);
        assert!(matches!(prepare(&[], 9), Err(ReconstructError::NoPoints { given: 0 })));
        assert!(matches!(prepare(&[nan, nan], 9), Err(ReconstructError::NoPoints { given: 2 })));
        let one = Vec3::new(3.0, 2.0, 1e6);
        assert!(matches!(prepare(&[one], 9), Err(ReconstructError::OnePlace)));
        assert!(matches!(prepare(&[one; 5], 9), Err(ReconstructError::OnePlace)));
    }

    #[test]
    fn equal_points_become_one_and_many_points_few() {
        let column: Vec<Vec3> =
            (0..3000).map(|i| Vec3::new(0.0, (i % 1000) as f32 * 0.01, 0.0)).collect();
        let all = prepare(&[&column[..], &[Vec3::NAN]].concat(), 5000).unwrap();
        assert_eq!((all.points.len(), all.not_finite), (1000, 1));
        let few = prepare(&column, 100).unwrap();
        assert!((50..=100).contains(&few.points.len()), "{}", few.points.len());
        let farthest = column
            .iter()
            .map(|p| few.points.iter().map(|q| p.distance(*q)).fold(f32::INFINITY, f32::min));
        assert!(farthest.fold(0.0, f32::max) <= few.voxel);
    }
}
