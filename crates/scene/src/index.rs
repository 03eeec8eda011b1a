//! Finding the few obstacles near a ray or a box: a hierarchy of bounding boxes.

use deeptree_graph::Vec3;
use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::Ray;

/// Obstacles by where they are. What it hands out is only near: the caller looks closely, so that
/// no answer depends on how the hierarchy was built.
#[derive(Clone)]
pub(crate) struct Index {
    bvh: Bvh2,
}

impl std::fmt::Debug for Index {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Index({} boxes)", self.bvh.nodes.len())
    }
}

/// Bounds grow by this share of their farthest coordinate, and by at least as many metres: more
/// than the rounding in the test of a ray against them.
const MARGIN: f32 = 1e-5;

impl Index {
    /// The index of things with these lowest and highest corners.
    pub(crate) fn new(bounds: impl Iterator<Item = [Vec3; 2]>) -> Self {
        let boxes: Vec<Aabb> = bounds
            .map(|[low, high]| {
                let farthest = low.abs().max(high.abs()).max_element();
                let margin = Vec3::splat(MARGIN * farthest.max(1.0));
                Aabb::new((low - margin).into(), (high + margin).into())
            })
            .collect();
        let numbers = (0..boxes.len() as u32).collect();
        let bvh = PlocBuilder::new().build(
            PlocSearchDistance::Low,
            &boxes,
            numbers,
            SortPrecision::U64,
            0,
        );
        Self { bvh }
    }

    /// Does `found` hold for one of the things near the ray `from + s · along`, s in \[0, `most`\]?
    pub(crate) fn any_along(
        &self,
        from: Vec3,
        along: Vec3,
        most: f32,
        mut found: impl FnMut(usize) -> bool,
    ) -> bool {
        // Finite, since nothing is farther, and a little more than asked for.
        let ray = Ray::new(from.into(), along.into(), 0.0, most.min(f32::MAX / 2.0) * 1.001);
        !self.bvh.ray_traverse_miss(ray, |_, at| {
            if found(self.bvh.primitive_indices[at] as usize) { 0.0 } else { f32::INFINITY }
        })
    }

    /// Does `found` hold for one of the things near the box between two corners?
    pub(crate) fn any_within(
        &self,
        low: Vec3,
        high: Vec3,
        mut found: impl FnMut(usize) -> bool,
    ) -> bool {
        let mut any = false;
        let within = Aabb::new(Vec3A::from(low), Vec3A::from(high));
        self.bvh.aabb_traverse(within, |bvh, node| {
            let node = &bvh.nodes[node as usize];
            let leaves = node.first_index..node.first_index + node.prim_count;
            any =
                any || leaves.clone().any(|at| found(bvh.primitive_indices[at as usize] as usize));
            !any
        });
        any
    }
}
