//! Rays and triangles.

use glam::Vec3;

/// A half-line with an end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Unit length, where distances are to be metres.
    pub(crate) direction: Vec3,
    /// How far it goes.
    pub(crate) most: f32,
}

impl Ray {
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, most: f32::MAX / 4.0 }
    }

    /// As the hierarchy of boxes reads it.
    pub(crate) fn traversal(&self) -> obvhs::ray::Ray {
        // The sum makes −0 to 0: the hierarchy takes the sign of its inverse, but not its own, for
        // negative.
        let direction = self.direction + Vec3::ZERO;
        obvhs::ray::Ray::new(self.origin.into(), direction.into(), 0.0, self.most)
    }
}

/// Where a ray meets a triangle: the distance, and the weights of the second and third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    pub(crate) distance: f32,
    pub(crate) weights: [f32; 2],
}

/// A triangle as its first corner and its edges from there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    corner: Vec3,
    edges: [Vec3; 2],
}

impl Triangle {
    pub(crate) fn new([a, b, c]: [Vec3; 3]) -> Self {
        Self { corner: a, edges: [b - a, c - a] }
    }

    /// Where the ray meets it, from either side.
    ///
    /// # Source
    ///
    /// Möller and Trumbore 1997, "Fast, Minimum Storage Ray-Triangle Intersection".
    pub(crate) fn meet(&self, ray: &Ray) -> Option<Meeting> {
        let [b, c] = self.edges;
        let p = ray.direction.cross(c);
        let determinant = b.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let from = ray.origin - self.corner;
        let u = from.dot(p) * inverse;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = from.cross(b);
        let v = ray.direction.dot(q) * inverse;
        if !(v >= 0.0 && u + v <= 1.0) {
            return None;
        }
        let distance = c.dot(q) * inverse;
        // Not a number where the triangle has no area.
        (distance > 0.0 && distance < ray.most).then_some(Meeting { distance, weights: [u, v] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_triangle_where_it_is() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let triangle = Triangle::new(corners);
        for (x, y, inside) in [(0.2, 0.3, true), (0.6, 0.6, false), (-0.1, 0.5, false)] {
            for side in [1.0f32, -1.0] {
                let ray = Ray::new(Vec3::new(x, y, 3.0 * side), Vec3::NEG_Z * side);
                let met = triangle.meet(&ray);
                assert_eq!(met.is_some(), inside);
                if let Some(Meeting { distance, weights: [u, v] }) = met {
                    assert!((distance - 3.0).abs() < 1e-6);
                    assert!((u - x).abs() < 1e-6 && (v - y).abs() < 1e-6);
                }
                assert!(triangle.meet(&Ray { most: 2.9, ..ray }).is_none());
            }
        }
    }

    #[test]
    fn triangles_without_area_are_never_met() {
        for corners in [[Vec3::ZERO; 3], [Vec3::ZERO, Vec3::X, Vec3::X * 2.0]] {
            let ray = Ray::new(Vec3::new(0.5, 0.0, 1.0), Vec3::NEG_Z);
            assert_eq!(Triangle::new(corners).meet(&ray), None);
        }
    }
}
