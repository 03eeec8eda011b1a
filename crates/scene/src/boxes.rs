//! Boxes: axis-aligned, or turned about the vertical.

use deeptree_graph::Vec3;
use glam::DVec3;

/// How a box was described; it is written to a file as it was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoxShape {
    /// Its sides run along the axes.
    Aligned {
        /// The corner with the lowest coordinates, in metres.
        min: Vec3,
        /// The corner with the highest coordinates, in metres.
        max: Vec3,
    },
    /// It is turned about the vertical through its centre.
    Turned {
        /// In metres.
        center: Vec3,
        /// Half of each side, in metres.
        half: Vec3,
        /// Degrees about +y: 90 turns +x to −z.
        yaw: f32,
    },
}

/// What is wrong with a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BoxProblem {
    /// It has neither of the two forms.
    #[error("give either `min` and `max`, or `center` and `half` and perhaps `yaw`")]
    Form,
    /// A NaN, an infinity, or a place that no tree can meet.
    #[error("its numbers must be finite and within 10000 m of the tree")]
    Number,
    /// A corner lies on the wrong side of the other.
    #[error("`min` must lie below `max` along {axis}; swap them, or make it thicker")]
    Inverted {
        /// x, y or z.
        axis: char,
    },
    /// A half side of nothing or less.
    #[error("`half` must be above 0 along {axis}")]
    Flat {
        /// x, y or z.
        axis: char,
    },
}

/// A box that nothing can grow through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    shape: BoxShape,
    centre: DVec3,
    half: DVec3,
    /// Cosine and sine of the yaw.
    turn: [f64; 2],
}

/// The farthest coordinate, in metres: beyond, single precision loses the centimetres.
pub(crate) const FARTHEST: f32 = 10_000.0;

/// Is every coordinate a number within reach?
pub(crate) fn is_within_reach(v: Vec3) -> bool {
    v.is_finite() && v.abs().max_element() <= FARTHEST
}

fn axis_where(wrong: impl Fn(usize) -> bool) -> Option<char> {
    (0..3).find(|&axis| wrong(axis)).map(|axis| ['x', 'y', 'z'][axis])
}

impl Cuboid {
    /// The box of a description.
    ///
    /// # Errors
    ///
    /// When a number is NaN, infinite or too far, or a side is not above 0.
    pub fn new(shape: BoxShape) -> Result<Self, BoxProblem> {
        let (centre, half, turn) = match shape {
            BoxShape::Aligned { min, max } => {
                if !(is_within_reach(min) && is_within_reach(max)) {
                    return Err(BoxProblem::Number);
                }
                if let Some(axis) = axis_where(|axis| min[axis] >= max[axis]) {
                    return Err(BoxProblem::Inverted { axis });
                }
                let (min, max) = (min.as_dvec3(), max.as_dvec3());
                ((min + max) / 2.0, (max - min) / 2.0, [1.0, 0.0])
            }
            BoxShape::Turned { center, half, yaw } => {
                if !(is_within_reach(center) && is_within_reach(half) && yaw.is_finite()) {
                    return Err(BoxProblem::Number);
                }
                if let Some(axis) = axis_where(|axis| half[axis] <= 0.0) {
                    return Err(BoxProblem::Flat { axis });
                }
                (center.as_dvec3(), half.as_dvec3(), cosine_and_sine(f64::from(yaw)))
            }
        };
        Ok(Self { shape, centre, half, turn })
    }

    /// How it was described.
    #[must_use]
    pub fn shape(&self) -> BoxShape {
        self.shape
    }

    /// The same box, moved.
    ///
    /// # Errors
    ///
    /// When it is moved out of reach.
    pub fn moved(&self, by: Vec3) -> Result<Self, BoxProblem> {
        Self::new(match self.shape {
            BoxShape::Aligned { min, max } => BoxShape::Aligned { min: min + by, max: max + by },
            BoxShape::Turned { center, half, yaw } => {
                BoxShape::Turned { center: center + by, half, yaw }
            }
        })
    }

    /// A direction of the world as the box sees it.
    fn to_local(self, v: DVec3) -> DVec3 {
        let [cos, sin] = self.turn;
        DVec3::new(cos * v.x - sin * v.z, v.y, sin * v.x + cos * v.z)
    }

    fn to_world(self, v: DVec3) -> DVec3 {
        let [cos, sin] = self.turn;
        DVec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x)
    }

    /// Its eight corners, in metres.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let side = |axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
            let corner = DVec3::new(side(0), side(1), side(2)) * self.half;
            (self.centre + self.to_world(corner)).as_vec3()
        })
    }

    /// The lowest and the highest corner of the space it takes, in metres.
    #[must_use]
    pub fn bounds(&self) -> [Vec3; 2] {
        self.corners().into_iter().fold(
            [Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY)],
            |[low, high], corner| [low.min(corner), high.max(corner)],
        )
    }

    /// Does a point lie inside, or on the surface?
    #[must_use]
    pub fn contains(&self, point: Vec3) -> bool {
        let local = self.to_local(point.as_dvec3() - self.centre).abs();
        local.x <= self.half.x && local.y <= self.half.y && local.z <= self.half.z
    }

    /// The point of the box that is nearest to a point, which itself is where it lies inside.
    #[must_use]
    pub fn nearest(&self, point: Vec3) -> Vec3 {
        if self.contains(point) {
            return point;
        }
        let local = self.to_local(point.as_dvec3() - self.centre);
        (self.centre + self.to_world(local.clamp(-self.half, self.half))).as_vec3()
    }

    /// Does the ray `from + s · along` meet the box at some s in \[0, `most`\]?
    #[must_use]
    pub(crate) fn meets(&self, from: Vec3, along: Vec3, most: f64) -> bool {
        let from = self.to_local(from.as_dvec3() - self.centre);
        let along = self.to_local(along.as_dvec3());
        let (mut enter, mut leave) = (0.0f64, most);
        for axis in 0..3 {
            let (from, along, half) = (from[axis], along[axis], self.half[axis]);
            if along == 0.0 {
                if from.abs() > half {
                    return false;
                }
                continue;
            }
            let (a, b) = ((-half - from) / along, (half - from) / along);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }

    /// Does it share more than a surface with the box of this centre and these half sides, which
    /// run along the axes?
    ///
    /// Two boxes are apart exactly when they are so along one of their face normals or of the
    /// products of their edges; with both upright that leaves the vertical and the four normals of
    /// the sides.
    pub(crate) fn overlaps(&self, centre: DVec3, half: DVec3) -> bool {
        let [cos, sin] = self.turn.map(f64::abs);
        let gap = (self.centre - centre).abs();
        let own = DVec3::new(
            cos * self.half.x + sin * self.half.z,
            self.half.y,
            sin * self.half.x + cos * self.half.z,
        );
        let along_axes = gap.x < half.x + own.x && gap.y < half.y + own.y && gap.z < half.z + own.z;
        let gap = self.to_local(self.centre - centre).abs();
        let other = [cos * half.x + sin * half.z, sin * half.x + cos * half.z];
        along_axes && gap.x < self.half.x + other[0] && gap.z < self.half.z + other[1]
    }
}

/// Cosine and sine of an angle in degrees, exact at the quarters.
fn cosine_and_sine(degrees: f64) -> [f64; 2] {
    let within = degrees - 360.0 * libm::floor(degrees / 360.0);
    let quarters = libm::floor(within / 90.0);
    let rest = (within - 90.0 * quarters).to_radians();
    let (cos, sin) = (libm::cos(rest), libm::sin(rest));
    match quarters as u8 % 4 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn aligned(min: [f32; 3], max: [f32; 3]) -> Cuboid {
        Cuboid::new(BoxShape::Aligned { min: min.into(), max: max.into() }).unwrap()
    }

    fn turned(center: [f32; 3], half: [f32; 3], yaw: f32) -> Cuboid {
        let (center, half) = (center.into(), half.into());
        Cuboid::new(BoxShape::Turned { center, half, yaw }).unwrap()
    }

    #[test]
    fn quarters_of_a_turn_are_exact() {
        for (degrees, expected) in [
            (0.0, [1.0, 0.0]),
            (90.0, [0.0, 1.0]),
            (180.0, [-1.0, 0.0]),
            (-90.0, [0.0, -1.0]),
            (630.0, [0.0, -1.0]),
        ] {
            assert_eq!(cosine_and_sine(degrees).map(|x| x + 0.0), expected, "{degrees}");
        }
        let [cos, sin] = cosine_and_sine(60.0);
        assert!((cos - 0.5).abs() < 1e-15 && (sin - 0.75f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_quarter_turn_swaps_width_and_depth() {
        let a = turned([4.0, 1.0, -2.0], [3.0, 1.0, 0.5], 90.0);
        let b = aligned([3.5, 0.0, -5.0], [4.5, 2.0, 1.0]);
        assert_eq!(a.bounds(), b.bounds());
        for x in -20..40 {
            for z in -30..20 {
                let p = Vec3::new(x as f32 * 0.25, 1.0, z as f32 * 0.25);
                assert_eq!(a.contains(p), b.contains(p), "{p}");
                let centre = p.as_dvec3();
                let half = DVec3::splat(0.1);
                assert_eq!(a.overlaps(centre, half), b.overlaps(centre, half), "{p}");
            }
        }
    }

    #[test]
    fn a_turn_by_thirty_degrees_takes_x_towards_minus_z() {
        let b = turned([0.0, 0.0, 0.0], [10.0, 1.0, 0.1], 30.0);
        // Its long axis runs along (cos 30°, −sin 30°).
        assert!(b.contains(Vec3::new(0.866 * 9.0, 0.0, -0.5 * 9.0)));
        assert!(!b.contains(Vec3::new(0.866 * 9.0, 0.0, 0.5 * 9.0)));
    }

    #[test]
    fn a_box_that_is_turned_by_45_degrees_misses_what_its_bounds_hold() {
        let b = turned([0.0, 0.0, 0.0], [2.0, 2.0, 2.0], 45.0);
        // Its corner points along x, at 2√2; the voxel at the corner of its bounds is free.
        assert!(b.overlaps(DVec3::new(2.5, 0.0, 0.0), DVec3::splat(0.5)));
        assert!(!b.overlaps(DVec3::new(2.3, 0.0, 2.3), DVec3::splat(0.5)));
        assert!(!b.overlaps(DVec3::new(0.0, 2.5, 0.0), DVec3::splat(0.5)), "they touch");
    }

    #[test]
    fn the_nearest_point_is_on_a_face_an_edge_or_a_corner() {
        let b = aligned([3.0, 0.0, -1.0], [5.0, 2.0, 1.0]);
        let near = |x, y, z| b.nearest(Vec3::new(x, y, z)).to_array();
        assert_eq!(near(0.0, 1.0, 0.5), [3.0, 1.0, 0.5]);
        assert_eq!(near(0.0, 4.0, 0.5), [3.0, 2.0, 0.5]);
        assert_eq!(near(9.0, -4.0, 3.0), [5.0, 0.0, 1.0]);
        assert_eq!(near(4.25, 0.5, 0.125), [4.25, 0.5, 0.125], "inside");
        // Turned by 45 degrees, its corner at √2 along x; the way there is square to no face.
        let b = turned([0.0; 3], [1.0, 1.0, 1.0], 45.0);
        let corner = Vec3::new(2.0f32.sqrt(), 0.0, 0.0);
        assert!(b.nearest(Vec3::new(3.0, 0.0, 0.0)).distance(corner) < 1e-6);
        // The face between x and z lies at 1 along (1, 0, 1) / √2.
        let face = b.nearest(Vec3::new(5.0, 0.0, 5.0));
        assert!(face.distance(Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt())) < 1e-6, "{face}");
    }

    #[test]
    fn a_segment_meets_a_box_when_it_enters_it() {
        let b = aligned([3.0, 0.0, -1.0], [5.0, 2.0, 1.0]);
        let meets = |a: [f32; 3], b2: [f32; 3]| {
            let (a, b2) = (Vec3::from(a), Vec3::from(b2));
            b.meets(a, b2 - a, 1.0)
        };
        assert!(meets([2.0, 1.0, 0.0], [6.0, 1.0, 0.0]), "through");
        assert!(meets([4.0, 1.0, 0.0], [4.1, 1.0, 0.0]), "inside");
        assert!(!meets([2.0, 1.0, 0.0], [2.9, 1.0, 0.0]), "before");
        assert!(!meets([2.0, 1.0, 1.5], [6.0, 1.0, 1.5]), "beside");
        assert!(!meets([2.0, 1.0, 0.0], [1.0, 1.0, 0.0]), "away");
        assert!(meets([4.0, 9.0, 0.0], [4.0, -9.0, 0.0]), "from above");
    }

    #[test]
    fn boxes_that_cannot_be_are_told_why() {
        let aligned = |min: [f32; 3], max: [f32; 3]| {
            Cuboid::new(BoxShape::Aligned { min: min.into(), max: max.into() }).unwrap_err()
        };
        assert_eq!(aligned([0.0; 3], [1.0, f32::NAN, 1.0]), BoxProblem::Number);
        assert_eq!(aligned([0.0; 3], [1.0, 1e9, 1.0]), BoxProblem::Number);
        assert_eq!(aligned([0.0; 3], [1.0, 1.0, -1.0]), BoxProblem::Inverted { axis: 'z' });
        assert_eq!(aligned([0.0; 3], [0.0, 1.0, 1.0]), BoxProblem::Inverted { axis: 'x' });
        let turned = |half: [f32; 3], yaw| {
            let shape = BoxShape::Turned { center: Vec3::ZERO, half: half.into(), yaw };
            Cuboid::new(shape).unwrap_err()
        };
        assert_eq!(turned([1.0, 0.0, 1.0], 0.0), BoxProblem::Flat { axis: 'y' });
        assert_eq!(turned([1.0; 3], f32::INFINITY), BoxProblem::Number);
    }
}
