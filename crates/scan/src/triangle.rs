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

    /// Where the ray from `from` along `along` meets the triangle, from either side.
    ///
    /// # Source
    ///
    /// Möller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection"; in double
    /// precision, with the edges included, so that nothing slips between two triangles.
    pub(crate) fn meeting(&self, from: DVec3, along: DVec3) -> Option<Meeting> {
        let [ab, ac] = self.edges.map(|edge| edge.as_dvec3());
        let p = along.cross(ac);
        let determinant = ab.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let to = from - self.corner.as_dvec3();
        let u = to.dot(p) / determinant;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = to.cross(ab);
        let v = along.dot(q) / determinant;
        let distance = ac.dot(q) / determinant;
        let hit = v >= 0.0 && u + v <= 1.0 && distance > 0.0;
        hit.then_some(Meeting { distance, shares: [u, v] })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_triangle_where_it_pierces_it() {
        let flat = Triangle::new([Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0]);
        let down = |x, z| flat.meeting(DVec3::new(x, 3.0, z), -DVec3::Y);
        assert_eq!(down(1.0, 2.0), Some(Meeting { distance: 3.0, shares: [0.5, 0.25] }));
        assert_eq!(down(3.0, 3.0), None);
        assert!(down(0.0, 0.0).is_some(), "a corner belongs to it");
        assert!(flat.meeting(DVec3::new(1.0, -1.0, 1.0), DVec3::Y).is_some(), "from below");
        assert!(flat.meeting(DVec3::new(1.0, 1.0, 1.0), DVec3::Y).is_none(), "behind");
        assert_eq!(flat.cosine(-DVec3::Y), 1.0);
    }
}
