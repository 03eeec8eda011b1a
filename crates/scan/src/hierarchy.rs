//! Finding the few triangles near a beam: a hierarchy of bounding boxes.

use deeptree_graph::Vec3;
use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Bounds grow by this share of their farthest coordinate and by [`MARGIN`]: more than the rounding
/// in the test of a ray from 1 km away against them, so that only the triangles themselves decide.
const MARGIN_SHARE: f32 = 1e-5;
/// In metres.
const MARGIN: f32 = 2e-4;

/// Things by where they are. What it hands out is only near.
#[derive(Clone)]
pub(crate) struct Hierarchy {
    bvh: Bvh2,
}

impl Hierarchy {
    /// The hierarchy of things with these lowest and highest corners.
    pub(crate) fn new(bounds: impl Iterator<Item = (Vec3, Vec3)>) -> Self {
        let boxes: Vec<Aabb> = bounds
            .map(|(low, high)| {
                let farthest = low.abs().max(high.abs()).max_element();
                let margin = Vec3::splat(MARGIN_SHARE * farthest + MARGIN);
                Aabb::new((low - margin).into(), (high + margin).into())
            })
            .collect();
        let numbers = (0..boxes.len() as u32).collect();
        let low = PlocSearchDistance::Low;
        Self { bvh: PlocBuilder::new().build(low, &boxes, numbers, SortPrecision::U64, 0) }
    }

    /// Hands things near a cone to `look`, the nearer ones rather first: around the line from `from`
    /// along the unit vector `along`, with a radius of `slope` a metre. `look` says how far, in metres,
    /// is still to be looked.
    pub(crate) fn walk(
        &self,
        from: DVec3,
        along: DVec3,
        slope: f64,
        mut look: impl FnMut(usize) -> f64,
    ) {
        let ray = Ray { from: from.as_vec3(), inverse: inverse(along), slope: slope as f32 };
        let mut most = f32::INFINITY;
        let nodes = &self.bvh.nodes;
        let mut stack = Vec::with_capacity(64);
        if let Some(root) = nodes.first() {
            stack.extend(ray.entry(root.aabb()).map(|near| (near, 0u32)));
        }
        while let Some((near, at)) = stack.pop() {
            if near > most {
                continue;
            }
            let node = &nodes[at as usize];
            let first = node.first_index;
            if node.is_leaf() {
                for k in first..first + node.prim_count {
                    let look = look(self.bvh.primitive_indices[k as usize] as usize);
                    // A little more, so that rounding does not hide what is as near.
                    most = most.min(look as f32 * 1.000_01 + MARGIN);
                }
                continue;
            }
            let entry = |at: u32| Some((ray.entry(nodes[at as usize].aabb())?, at));
            let (left, right) = (entry(first), entry(first + 1));
            let farther_first = match (left, right) {
                (Some(a), Some(b)) if a.0 < b.0 => [right, left],
                _ => [left, right],
            };
            stack.extend(farther_first.into_iter().flatten().filter(|(near, _)| *near <= most));
        }
    }
}

/// A cone.
struct Ray {
    from: Vec3,
    /// The inverse of each component of the direction.
    inverse: Vec3,
    slope: f32,
}

/// The inverse of each component, none of them infinite: zero times infinity is no number.
fn inverse(along: DVec3) -> Vec3 {
    let inverse = |c: f64| {
        let c = if c.abs() < 1e-12 { libm::copysign(1e-12, c) } else { c };
        (1.0 / c) as f32
    };
    Vec3::new(inverse(along.x), inverse(along.y), inverse(along.z))
}

impl Ray {
    /// How far the cone goes until it can meet a box; none where it does not.
    fn entry(&self, bounds: &Aabb) -> Option<f32> {
        let (mut low, mut high) =
            (Vec3::from(bounds.min) - self.from, Vec3::from(bounds.max) - self.from);
        if self.slope > 0.0 {
            // No part of the box is farther away than the sum of its farthest coordinates.
            let reach = low.abs().max(high.abs()).element_sum();
            low -= Vec3::splat(self.slope * reach);
            high += Vec3::splat(self.slope * reach);
        }
        let (a, b) = (low * self.inverse, high * self.inverse);
        let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
        (near <= far && far >= 0.0).then_some(near)
    }
}
