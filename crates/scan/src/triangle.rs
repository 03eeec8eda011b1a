//! Where a ray meets a triangle.

use deeptree_graph::Vec3;
use glam::DVec3;

/// A corner and the edges from it, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    corner: Vec3,
    edges: [Vec3; 2],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// Distance in lengths of the ray's direction.
    pub(crate) distance: f64,
    /// Shares of the second and third corner.
    pub(crate) shares: [f64; 2],
}

impl Triangle {
    pub(crate) fn new([a, b, c]: [Vec3; 3]) -> Self {
        Self { corner: a, edges: [b - a, c - a] }
    }

    /// The triangle as all rays from one place meet it, from either side.
    pub(crate) fn seen_from(&self, from: DVec3) -> Seen {
        let [ab, ac] = self.edges.map(|edge| edge.as_dvec3());
        let to = from - self.corner.as_dvec3();
        let second = to.cross(ab);
        Seen { normal: ac.cross(ab), first: ac.cross(to), second, volume: ac.dot(second) }
    }

    /// The cosine between a unit direction and the triangle's normal, on either side.
    pub(crate) fn cosine(&self, along: DVec3) -> f64 {
        let [ab, ac] = self.edges.map(|edge| edge.as_dvec3());
        ab.cross(ac).try_normalize().map_or(0.0, |normal| normal.dot(along).abs())
    }

    /// The lowest and highest coordinates.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let corners = [self.corner, self.corner + self.edges[0], self.corner + self.edges[1]];
        let [a, b, c] = corners;
        (a.min(b).min(c), a.max(b).max(c))
    }
}

/// A triangle seen from one place.
///
/// # Source
///
/// Möller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection", with the products
/// that do not depend on the direction taken first; in double precision, with the edges included, so
/// that nothing slips between two triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    normal: DVec3,
    first: DVec3,
    second: DVec3,
    /// Six times the volume of the tetrahedron of the triangle and the place.
    volume: f64,
}

impl Seen {
    /// Where the ray along a direction meets the triangle.
    pub(crate) fn meeting(&self, along: DVec3) -> Option<Meeting> {
        let determinant = along.dot(self.normal);
        // All is compared before it is divided: most triangles are missed.
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        let size = determinant * sign;
        let u = along.dot(self.first) * sign;
        let v = along.dot(self.second) * sign;
        let distance = self.volume * sign;
        let is_hit = size > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= size && distance > 0.0;
        is_hit.then(|| Meeting { distance: distance / size, shares: [u / size, v / size] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_triangle_where_it_pierces_it() {
        let flat = Triangle::new([Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0]);
        let down = |x, z| flat.seen_from(DVec3::new(x, 3.0, z)).meeting(-DVec3::Y);
        assert_eq!(down(1.0, 2.0), Some(Meeting { distance: 3.0, shares: [0.5, 0.25] }));
        assert_eq!(down(3.0, 3.0), None);
        assert!(down(0.0, 0.0).is_some(), "a corner belongs to it");
        let up = |y| flat.seen_from(DVec3::new(1.0, y, 1.0)).meeting(DVec3::Y);
        assert!(up(-1.0).is_some(), "from below");
        assert!(up(1.0).is_none(), "behind");
        assert_eq!(flat.cosine(-DVec3::Y), 1.0);
    }
}
