//! Triangles: where rays meet them, and which boxes they reach into.

use deeptree_graph::Vec3;
use glam::DVec3;

/// Three corners in metres.
pub(crate) type Triangle = [Vec3; 3];

/// Where the line `from + s · along` meets the triangle: s, and whether it comes from the side from
/// which the corners run anticlockwise. None where it misses or runs within the plane.
///
/// # Source
///
/// Möller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection"; in double
/// precision, with the edges included, so that nothing slips between two triangles.
pub(crate) fn meeting(triangle: &Triangle, from: DVec3, along: DVec3) -> Option<(f64, bool)> {
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let p = along.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let t = from - a;
    let u = t.dot(p) / determinant;
    let q = t.cross(ab);
    let v = along.dot(q) / determinant;
    let is_within = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    is_within.then(|| (ac.dot(q) / determinant, determinant > 0.0))
}

/// Does a triangle of a solid's surface reach into the open box of this centre and these half
/// sides? Only a triangle that has points strictly inside does.
pub(crate) fn reaches_into(triangle: &Triangle, centre: DVec3, half: DVec3) -> bool {
    let corners = triangle.map(|corner| corner.as_dvec3() - centre);
    !axes(corners).into_iter().any(|axis| {
        let (low, high, reach) = extents(corners, axis, half);
        reach > 0.0 && (low >= reach || high <= -reach)
    })
}

/// Does a triangle of a sheet meet the box of this centre and these half sides? The box holds its
/// lower faces and not its upper ones, so that a sheet between two voxels lies in one of them.
pub(crate) fn meets(triangle: &Triangle, centre: DVec3, half: DVec3) -> bool {
    let corners = triangle.map(|corner| corner.as_dvec3() - centre);
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let within = (0..3).all(|axis| high[axis] >= -half[axis] && low[axis] < half[axis]);
    within
        && !axes(corners).into_iter().any(|axis| {
            let (low, high, reach) = extents(corners, axis, half);
            low > reach || high < -reach
        })
}

/// A triangle and a box are apart exactly when they are so along one of these: the box's normals,
/// the triangle's, and the products of their edges.
///
/// # Source
///
/// Akenine-Möller 2001, "Fast 3D triangle–box overlap testing".
fn axes([a, b, c]: [DVec3; 3]) -> [DVec3; 13] {
    let edges = [b - a, c - b, a - c];
    let mut axes = [DVec3::ZERO; 13];
    axes[..3].copy_from_slice(&DVec3::AXES);
    axes[3] = edges[0].cross(edges[1]);
    for (i, edge) in edges.into_iter().enumerate() {
        for (k, axis) in DVec3::AXES.into_iter().enumerate() {
            axes[4 + 3 * i + k] = axis.cross(edge);
        }
    }
    axes
}

/// The extent of the corners along an axis, and half of the box's around 0.
fn extents(corners: [DVec3; 3], axis: DVec3, half: DVec3) -> (f64, f64, f64) {
    let [a, b, c] = corners.map(|corner| corner.dot(axis));
    (a.min(b).min(c), a.max(b).max(c), axis.abs().dot(half))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: Triangle =
        [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 4.0), Vec3::new(4.0, 0.0, 0.0)];

    #[test]
    fn a_line_meets_a_triangle_where_it_pierces_it() {
        let down = |x, z| meeting(&FLAT, DVec3::new(x, 3.0, z), DVec3::new(0.0, -2.0, 0.0));
        // From above the corners run anticlockwise: z then x is a turn about +y.
        assert_eq!(down(1.0, 1.0), Some((1.5, true)));
        assert_eq!(down(3.0, 3.0), None);
        assert_eq!(down(0.0, 0.0), Some((1.5, true)), "a corner belongs to it");
        let up = meeting(&FLAT, DVec3::new(1.0, -1.0, 1.0), DVec3::Y);
        assert_eq!(up, Some((1.0, false)));
        assert_eq!(meeting(&FLAT, DVec3::new(1.0, 0.0, 1.0), DVec3::X), None, "along the plane");
    }

    #[test]
    fn boxes_beside_the_slope_of_a_triangle_are_apart_from_it() {
        let half = DVec3::splat(1.0);
        for inside in [reaches_into as fn(&Triangle, DVec3, DVec3) -> bool, meets] {
            assert!(inside(&FLAT, DVec3::new(1.0, 0.5, 1.0), half));
            // Within the bounds of the triangle, but beyond its slope: the corner nearest to it is
            // (2.2, 2.2), and the slope x + z = 4.
            assert!(!inside(&FLAT, DVec3::new(3.2, 0.5, 3.2), half));
            assert!(inside(&FLAT, DVec3::new(2.9, 0.5, 2.9), half));
            assert!(!inside(&FLAT, DVec3::new(1.0, 1.5, 1.0), half));
        }
    }

    #[test]
    fn a_sheet_between_two_boxes_lies_in_the_upper_one_and_a_surface_in_none() {
        let half = DVec3::splat(1.0);
        let (below, above) = (DVec3::new(1.0, -1.0, 1.0), DVec3::new(1.0, 1.0, 1.0));
        assert!(!meets(&FLAT, below, half) && meets(&FLAT, above, half));
        assert!(!reaches_into(&FLAT, below, half) && !reaches_into(&FLAT, above, half));
    }
}
