//! How well a cloud and a surface agree.

mod skeletons;
mod surface;

use deeptree_graph::Vec3;
use deeptree_mesh::Mesh;

use crate::kdtree::KdTree;
pub use skeletons::{ORDERS, SAME_WAY, SkeletonFit};
pub use surface::Surface;

/// Points the surface is sampled at unless told otherwise: shares are right to a third of a percent.
pub const SAMPLES: usize = 100_000;

/// Distances in one direction, in metres, sorted.
#[derive(Clone, Debug, PartialEq)]
pub struct Distances {
    sorted: Vec<f32>,
}

impl Distances {
    fn new(mut distances: Vec<f32>) -> Self {
        distances.sort_unstable_by(f32::total_cmp);
        Self { sorted: distances }
    }

    /// Their mean; 0 of none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.sorted.iter().map(|&d| f64::from(d)).sum();
        sum / self.sorted.len().max(1) as f64
    }

    /// The distance that a share of them does not exceed; 0 of none.
    #[must_use]
    pub fn quantile(&self, share: f64) -> f64 {
        let last = self.sorted.len().saturating_sub(1);
        let at = libm::ceil(share * self.sorted.len() as f64) as usize;
        self.sorted.get(at.saturating_sub(1).min(last)).map_or(0.0, |&d| f64::from(d))
    }

    /// The share of them that is within a tolerance, 0 to 1; 0 of none.
    #[must_use]
    pub fn share_within(&self, tolerance: f32) -> f64 {
        let within = self.sorted.partition_point(|&d| d <= tolerance);
        within as f64 / self.sorted.len().max(1) as f64
    }
}

/// The distances between a cloud and a surface, both ways.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Of each point of the cloud from the surface.
    pub cloud_to_tree: Distances,
    /// Of points spread evenly over the surface from the nearest point of the cloud.
    pub tree_to_cloud: Distances,
}

impl Fit {
    /// Measures a cloud against the surface of a mesh in the same frame.
    ///
    /// Distances are exact: point to triangle, and point to point. The surface is sampled at
    /// `samples` points, each standing for the same area ([`Surface::samples`]).
    #[must_use]
    pub fn new(cloud: &[Vec3], mesh: &Mesh, samples: usize) -> Self {
        let surface = Surface::new(mesh);
        let index = KdTree::new(cloud);
        let to_tree = cloud.iter().map(|&point| surface.distance(point)).collect();
        let to_cloud = surface
            .samples(samples)
            .into_iter()
            .map(|at| index.nearest(at).map_or(f32::INFINITY, |(_, squared)| libm::sqrtf(squared)))
            .collect();
        Self { cloud_to_tree: Distances::new(to_tree), tree_to_cloud: Distances::new(to_cloud) }
    }

    /// F: the harmonic mean of the share of the cloud that is within a tolerance of the surface and
    /// the share of the surface that is within it of the cloud; 0 to 1.
    ///
    /// `F = 2 p r / (p + r)`
    #[must_use]
    pub fn f_score(&self, tolerance: f32) -> f64 {
        let recall = self.cloud_to_tree.share_within(tolerance);
        let precision = self.tree_to_cloud.share_within(tolerance);
        if recall + precision > 0.0 { 2.0 * precision * recall / (precision + recall) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo};
    use deeptree_mesh::{WoodOptions, tubes};

    /// A cylinder of radius 0.1 m from the origin to 10 m up, and what closes it.
    fn column() -> Mesh {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let rotation = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let root = ChildSignature { rotation, thickness: 0.1, length: 10.0 };
        let options = WoodOptions {
            foot_flare: 1.0,
            fluting: 0.0,
            max_sides: 256,
            tolerance: 1e-5,
            ..WoodOptions::default()
        };
        tubes(&BranchGraph::new(info, Vec3::ZERO, root), &options)
    }

    /// Points around the axis of the column, away from its ends.
    fn ring(radius: f32) -> Vec<Vec3> {
        let at = |i: u16| {
            let (sin, cos) = (f32::from(i) * 0.37).sin_cos();
            Vec3::new(radius * cos, 1.0 + f32::from(i) * 0.008, radius * sin)
        };
        (0..1000).map(at).collect()
    }

    #[test]
    fn points_around_a_cylinder_are_as_far_as_their_radius_says() {
        for distance in [0.0, 0.02, 0.3] {
            let fit = Fit::new(&ring(0.1 + distance), &column(), 1000);
            let of = &fit.cloud_to_tree;
            for value in [of.mean(), of.quantile(0.5), of.quantile(1.0)] {
                assert!((value - f64::from(distance)).abs() < 2e-4, "{value} for {distance}");
            }
            assert_eq!(of.share_within(distance - 0.001), 0.0);
            assert_eq!(of.share_within(distance + 0.001), 1.0);
        }
    }

    #[test]
    fn samples_stand_for_equal_areas() {
        let surface = Surface::new(&column());
        let samples = surface.samples(20_000);
        assert_eq!(samples.len(), 20_000);
        // Half of the side lies below the middle.
        let below = samples.iter().filter(|p| p.y < 5.0).count() as f64 / 20_000.0;
        assert!((below - 0.5).abs() < 0.01, "{below}");
        assert!(samples.iter().all(|&p| surface.distance(p) < 1e-5));
        let side = 2.0 * core::f64::consts::PI * 0.1 * 10.0;
        assert!((surface.area() / side - 1.0).abs() < 0.03, "{}", surface.area());
    }

    #[test]
    fn half_a_surface_that_is_seen_scores_two_thirds() {
        let mesh = column();
        let seen: Vec<Vec3> =
            Surface::new(&mesh).samples(40_000).into_iter().filter(|p| p.y < 5.0).collect();
        let fit = Fit::new(&seen, &mesh, 10_000);
        // Precision a half, recall one: F = 2/3.
        assert!((fit.f_score(0.02) - 2.0 / 3.0).abs() < 0.01, "{}", fit.f_score(0.02));
        assert_eq!(Fit::new(&[], &mesh, 100).f_score(1.0), 0.0);
    }
}
