//! A surface that can be asked how far a point is from it.

use deeptree_graph::Vec3;
use deeptree_mesh::Mesh;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// The triangles of a mesh by where they are.
#[derive(Clone)]
pub struct Surface {
    triangles: Vec<[Vec3; 3]>,
    bvh: Bvh2,
}

impl std::fmt::Debug for Surface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Surface({} triangles)", self.triangles.len())
    }
}

impl Surface {
    /// The surface of a mesh.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let triangles: Vec<[Vec3; 3]> = mesh.triangles().collect();
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|[a, b, c]| Aabb::new(a.min(*b).min(*c).into(), a.max(*b).max(*c).into()))
            .collect();
        let numbers = (0..boxes.len() as u32).collect();
        let bvh = PlocBuilder::new().build(
            PlocSearchDistance::Minimum,
            &boxes,
            numbers,
            SortPrecision::U64,
            0,
        );
        Self { triangles, bvh }
    }

    /// The distance of a point from the nearest point of the surface in metres; infinite without
    /// triangles.
    #[must_use]
    pub fn distance(&self, from: Vec3) -> f32 {
        self.nearest(from).map_or(f32::INFINITY, |(_, squared)| libm::sqrtf(squared))
    }

    /// The triangle nearest to a point and the square of its distance.
    #[must_use]
    pub fn nearest(&self, from: Vec3) -> Option<(u32, f32)> {
        let nodes = &self.bvh.nodes;
        if self.triangles.is_empty() || nodes.is_empty() {
            return None;
        }
        let mut best = (0, f32::INFINITY);
        let mut stack = vec![(0, apart(nodes[0].aabb(), from))];
        while let Some((at, bound)) = stack.pop() {
            if bound > best.1 {
                continue;
            }
            let node = &nodes[at as usize];
            let first = node.first_index;
            if node.is_leaf() {
                for leaf in first..first + node.prim_count {
                    let triangle = self.bvh.primitive_indices[leaf as usize];
                    let squared = squared_distance(&self.triangles[triangle as usize], from);
                    if squared < best.1 {
                        best = (triangle, squared);
                    }
                }
                continue;
            }
            let both = [first, first + 1].map(|i| (i, apart(nodes[i as usize].aabb(), from)));
            let [near, far] = if both[0].1 <= both[1].1 { both } else { [both[1], both[0]] };
            stack.push(far);
            stack.push(near);
        }
        Some(best)
    }

    /// Area in square metres.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(area).sum()
    }

    /// Points spread evenly over the surface, the same at each call.
    ///
    /// Sample i stands at the share `(i + ½) / n` of the area in the order of the triangles, and
    /// within its triangle where the plastic sequence puts it, folded at the diagonal.
    ///
    /// # Source
    ///
    /// Roberts 2018, "The unreasonable effectiveness of quasirandom sequences".
    #[must_use]
    pub fn samples(&self, n: usize) -> Vec<Vec3> {
        const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
        let total = self.area();
        let mut out = Vec::with_capacity(n);
        let mut below = 0.0;
        for triangle in &self.triangles {
            below += area(triangle);
            while out.len() < n && (out.len() as f64 + 0.5) / n as f64 * total < below {
                let i = out.len() as f64 + 0.5;
                let [mut u, mut v] = PLASTIC.map(|step| (i * step).fract() as f32);
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let [a, b, c] = *triangle;
                out.push(a + (b - a) * u + (c - a) * v);
            }
        }
        out
    }
}

fn area([a, b, c]: &[Vec3; 3]) -> f64 {
    f64::from((b - a).cross(c - a).length()) / 2.0
}

/// The square of the distance between a point and a box.
fn apart(of: &Aabb, from: Vec3) -> f32 {
    let (low, high): (Vec3, Vec3) = (of.min.into(), of.max.into());
    from.distance_squared(from.clamp(low, high.max(low)))
}

/// The square of the distance between a point and a triangle.
///
/// # Source
///
/// Ericson 2005, "Real-Time Collision Detection", §5.1.5: the regions of corners and edges, by the
/// signs of barycentric coordinates.
fn squared_distance(&[a, b, c]: &[Vec3; 3], p: Vec3) -> f32 {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let inside = |edge: Vec3, from: Vec3| normal.cross(edge).dot(p - from) >= 0.0;
    let flat = normal.length_squared();
    if flat > 0.0 && inside(ab, a) && inside(c - b, b) && inside(a - c, c) {
        let height = normal.dot(p - a);
        return height * height / flat;
    }
    let edge = |from: Vec3, along: Vec3| {
        let length = along.length_squared();
        let share =
            if length > 0.0 { ((p - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        p.distance_squared(from + along * share)
    };
    edge(a, ab).min(edge(b, c - b)).min(edge(c, a - c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_as_far_from_a_triangle_as_from_its_nearest_face_edge_or_corner() {
        let flat = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 4.0)];
        let distance = |x, y, z| squared_distance(&flat, Vec3::new(x, y, z)).sqrt();
        for (at, expected) in [
            ((1.0, 2.0, 1.0), 2.0),
            ((1.0, -3.0, 1.0), 3.0),
            ((1.0, 0.0, -2.0), 2.0),
            ((-3.0, 4.0, 0.0), 5.0),
            ((3.0, 0.0, 3.0), 2.0f32.sqrt()),
            ((7.0, 4.0, 0.0), 5.0),
        ] {
            assert!((distance(at.0, at.1, at.2) - expected).abs() < 1e-6, "{at:?}");
        }
        // A triangle without area is its edges.
        let line = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
        assert!((squared_distance(&line, Vec3::new(1.5, 2.0, 0.0)) - 4.0).abs() < 1e-6);
        assert!((squared_distance(&[Vec3::X; 3], Vec3::ZERO) - 1.0).abs() < 1e-6);
    }
}
