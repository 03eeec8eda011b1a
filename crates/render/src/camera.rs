//! A thin-lens camera that places itself: so that the whole tree is in the picture, or near the tree.

use std::f32::consts::TAU;

use glam::Vec3;

use crate::error::RenderError;
use crate::ray::Ray;

/// Height of the eyes of who looks at a tree from the ground, in metres.
const EYES: f32 = 1.6;
/// How far from the bark or the twigs who looks from near stands, in metres.
const NEAR: f32 = 2.0;
/// Share of the picture that stays free around the tree: left and right, below, above.
const MARGINS: [f32; 3] = [0.05, 0.08, 0.05];

/// From where a tree is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// From +z, at the height of the eyes.
    Front,
    /// From +x, likewise.
    Right,
    /// From −z, likewise.
    Back,
    /// From −x, likewise.
    Left,
    /// From between front and right, half above.
    Quarter,
    /// From straight above, front below.
    Top,
    /// The trunk below the height of the eyes, from two metres in front of it.
    Trunk,
    /// What of the tree is foremost, from two metres in front of it.
    Twigs,
}

impl View {
    /// All views.
    pub const ALL: [Self; 8] = [
        Self::Front,
        Self::Right,
        Self::Back,
        Self::Left,
        Self::Quarter,
        Self::Top,
        Self::Trunk,
        Self::Twigs,
    ];

    /// Its name: `front`, `right`, `back`, `left`, `quarter`, `top`, `trunk`, `twigs`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Right => "right",
            Self::Back => "back",
            Self::Left => "left",
            Self::Quarter => "quarter",
            Self::Top => "top",
            Self::Trunk => "trunk",
            Self::Twigs => "twigs",
        }
    }

    /// Azimuth from +z towards +x, and elevation above the horizon, of who looks; in radians.
    const fn place(self) -> (f32, f32) {
        match self {
            Self::Front | Self::Trunk | Self::Twigs => (0.0, 0.0),
            Self::Right => (0.25 * TAU, 0.0),
            Self::Back => (0.5 * TAU, 0.0),
            Self::Left => (0.75 * TAU, 0.0),
            Self::Quarter => (0.1 * TAU, 0.075 * TAU),
            Self::Top => (0.0, 0.25 * TAU),
        }
    }
}

impl std::str::FromStr for View {
    type Err = RenderError;

    fn from_str(name: &str) -> Result<Self, RenderError> {
        Self::ALL.into_iter().find(|view| view.name() == name).ok_or_else(|| RenderError::View {
            name: name.to_owned(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The middle of the lens, in metres; of a camera without perspective a point of its plane.
    position: Vec3,
    /// Right, up and forward; unit vectors.
    axes: [Vec3; 3],
    /// Left, right, lower and upper edge of what is seen: at a distance of 1, or in metres
    /// without perspective.
    window: [f32; 4],
    lens: Lens,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Lens {
    /// Radius, and the distance of what is sharp, in metres.
    Thin {
        radius: f32,
        focus: f32,
    },
    Orthographic,
}

impl Camera {
    /// A camera that looks at points from where `view` says, so near that they just fit; but at the
    /// trunk and the twigs from two metres. The root's foot is at the origin.
    ///
    /// `aspect` is width over height; `angle` the angle of view from below to above, in radians.
    /// Views from the ground stand upright: like a camera with a movable back, they keep verticals
    /// vertical.
    ///
    /// # Errors
    ///
    /// When there are no points, or the angle is not from 0.02 to 2.
    pub fn framing(
        points: impl Iterator<Item = Vec3>,
        view: View,
        aspect: f32,
        angle: f32,
    ) -> Result<Self, RenderError> {
        if !(0.02..=2.0).contains(&angle) {
            return Err(RenderError::Range {
                what: "the angle of view in radians",
                value: angle,
                low: 0.02,
                high: 2.0,
            });
        }
        let (azimuth, elevation) = view.place();
        let axes = axes(azimuth, elevation);
        let points: Vec<Vec3> = points.collect();
        let half = [aspect, 1.0].map(|side| side * libm::tanf(angle / 2.0));
        let (low, high) = bounds(&points).ok_or(RenderError::Empty)?;
        let camera = match view {
            View::Trunk => near(trunk(&points), axes, half),
            View::Twigs => near(foremost(&points), axes, half),
            _ if elevation == 0.0 => upright(&points, axes, half, (low, high)),
            _ => above(&points, axes, half),
        };
        let focus = match view {
            View::Trunk | View::Twigs => NEAR,
            _ => ((low + high) / 2.0 - camera.position).dot(axes[2]).max(0.1),
        };
        Ok(Self { lens: Lens::Thin { radius: 0.0, focus }, ..camera })
    }

    /// A camera without perspective that looks from an azimuth (from +z towards +x) and an
    /// elevation, in radians: what is at `center` is in the middle, and the picture is as wide and
    /// as high as `size`, in metres.
    #[must_use]
    pub fn orthographic(center: Vec3, azimuth: f32, elevation: f32, size: [f32; 2]) -> Self {
        // Farther away than any tree reaches.
        const AWAY: f32 = 200.0;
        let axes = axes(azimuth, elevation);
        let [w, h] = size.map(|side| side / 2.0);
        Self {
            position: center - axes[2] * AWAY,
            axes,
            window: [-w, w, -h, h],
            lens: Lens::Orthographic,
        }
    }

    /// The same camera with a lens of this radius in metres, which is sharp where it was.
    #[must_use]
    pub fn with_aperture(self, radius: f32) -> Self {
        match self.lens {
            Lens::Thin { focus, .. } => Self { lens: Lens::Thin { radius, focus }, ..self },
            Lens::Orthographic => self,
        }
    }

    /// The middle of the lens in metres; of a camera without perspective a point of its plane.
    #[must_use]
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// Right, up and forward, as unit vectors.
    #[must_use]
    pub fn axes(&self) -> [Vec3; 3] {
        self.axes
    }

    /// The ray through a place of the picture, from left to right and from above down in [0, 1],
    /// and a place of the lens.
    pub(crate) fn ray(&self, [x, y]: [f32; 2], lens: [f32; 2]) -> Ray {
        let [right, up, forward] = self.axes;
        let [l, r, b, t] = self.window;
        let at = right * (l + (r - l) * x) + up * (t + (b - t) * y);
        match self.lens {
            Lens::Orthographic => Ray::new(self.position + at, forward),
            Lens::Thin { radius, focus } => {
                let sharp = self.position + (at + forward) * focus;
                let (sin, cos) = libm::sincosf(TAU * lens[0]);
                let from = (right * cos + up * sin) * (radius * lens[1].sqrt());
                let origin = self.position + from;
                Ray::new(origin, (sharp - origin).normalize())
            }
        }
    }

    /// Where a point is in the picture, as [`Camera::framing`] counts, and how far along the
    /// camera's axis; none for what is behind the camera.
    #[must_use]
    pub fn project(&self, point: Vec3) -> Option<([f32; 2], f32)> {
        let [x, y, depth] = self.axes.map(|axis| axis.dot(point - self.position));
        if depth <= 0.0 {
            return None;
        }
        let scale = if self.lens == Lens::Orthographic { 1.0 } else { depth };
        let [l, r, b, t] = self.window;
        Some(([(x / scale - l) / (r - l), (t - y / scale) / (t - b)], depth))
    }
}

/// Right, up and forward of who looks from an azimuth and an elevation.
fn axes(azimuth: f32, elevation: f32) -> [Vec3; 3] {
    let (sin, cos) = libm::sincosf(azimuth);
    let (high, flat) = libm::sincosf(elevation);
    let right = Vec3::new(cos, 0.0, -sin);
    let forward = -Vec3::new(flat * sin, high, flat * cos);
    [right, right.cross(forward), forward]
}

/// Lowest and highest coordinates.
fn bounds(points: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let (&first, rest) = points.split_first()?;
    Some(rest.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p))))
}

/// A camera at the height of the eyes that looks level; its window is moved up to the crown.
fn upright(points: &[Vec3], axes: [Vec3; 3], half: [f32; 2], (low, high): (Vec3, Vec3)) -> Camera {
    let [right, _, forward] = axes;
    let height = (high.y - low.y).max(0.01);
    let eyes = low.y + EYES.min(0.3 * height);
    let middle = (low + high) / 2.0;
    // Left, right, lower and upper edge of the points, seen from so far before the nearest.
    let near = points.iter().map(|&p| forward.dot(p - middle)).fold(f32::INFINITY, f32::min);
    let from = |away: f32| {
        let mut position = middle + forward * (near - away);
        position.y = eyes;
        position
    };
    let edges = |away: f32| {
        let position = from(away);
        points.iter().fold([f32::MAX, f32::MIN, f32::MAX, f32::MIN], |[l, r, b, t], &p| {
            let p = p - position;
            let depth = forward.dot(p);
            let (x, y) = (right.dot(p) / depth, p.y / depth);
            [l.min(x), r.max(x), b.min(y), t.max(y)]
        })
    };
    let [side, below, above] = MARGINS;
    let room = [2.0 * half[0] * (1.0 - 2.0 * side), 2.0 * half[1] * (1.0 - below - above)];
    let fits = |[l, r, b, t]: [f32; 4]| r - l <= room[0] && t - b <= room[1];
    let mut far = (high - low).length().max(0.01);
    while !fits(edges(far)) {
        far *= 2.0;
    }
    let mut close = 1e-3 * far;
    for _ in 0..24 {
        let between = 0.5 * (close + far);
        if fits(edges(between)) { far = between } else { close = between }
    }
    let [l, r, b, t] = edges(far);
    let x = 0.5 * (l + r);
    let y = 0.5 * (b + t) + half[1] * (above - below);
    let window = [x - half[0], x + half[0], y - half[1], y + half[1]];
    Camera { position: from(far), axes, window, lens: Lens::Orthographic }
}

/// A camera whose middle looks along the axis: the nearest from which all points are within four
/// planes through it.
fn above(points: &[Vec3], axes: [Vec3; 3], half: [f32; 2]) -> Camera {
    let [right, up, forward] = axes;
    let inner = half.map(|h| h * (1.0 - 2.0 * MARGINS[0]));
    // Of each plane the farthest point: of x − t z and −x − t z, and of y likewise.
    let mut far = [f32::MIN; 4];
    for &p in points {
        let (x, y, z) = (right.dot(p), up.dot(p), forward.dot(p));
        let found = [x - inner[0] * z, -x - inner[0] * z, y - inner[1] * z, -y - inner[1] * z];
        far = std::array::from_fn(|i| far[i].max(found[i]));
    }
    let z = f32::min(-(far[0] + far[1]) / (2.0 * inner[0]), -(far[2] + far[3]) / (2.0 * inner[1]));
    let (x, y) = ((far[0] - far[1]) / 2.0, (far[2] - far[3]) / 2.0);
    // At the same point would be within it.
    let position = right * x + up * y + forward * (z - 1e-3);
    let window = [-half[0], half[0], -half[1], half[1]];
    Camera { position, axes, window, lens: Lens::Orthographic }
}

/// A camera that looks at a point from near, level.
fn near(point: Vec3, axes: [Vec3; 3], half: [f32; 2]) -> Camera {
    let window = [-half[0], half[0], -half[1], half[1]];
    Camera { position: point - axes[2] * NEAR, axes, window, lens: Lens::Orthographic }
}

/// The foremost point, towards +z.
fn foremost(points: &[Vec3]) -> Vec3 {
    points.iter().copied().fold(Vec3::NEG_INFINITY, |best, p| if p.z > best.z { p } else { best })
}

/// The front of the trunk at three quarters of the height of the eyes, or of the tree's own height
/// if it is not so high: the middle and the foremost of the points there and near the axis.
fn trunk(points: &[Vec3]) -> Vec3 {
    let top = points.iter().map(|p| p.y).fold(0.0, f32::max);
    let height = 0.75 * EYES.min(top);
    let is_trunk = |p: &&Vec3| (p.y - height).abs() < 0.3 && p.x.abs().max(p.z.abs()) < 1.2;
    let (mut sum, mut count, mut front) = (0.0, 0.0f32, 0.0f32);
    for p in points.iter().filter(is_trunk) {
        (sum, count, front) = (sum + p.x, count + 1.0, front.max(p.z));
    }
    Vec3::new(sum / count.max(1.0), height, front)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CLOSE: [View; 2] = [View::Trunk, View::Twigs];

    fn corners(low: Vec3, high: Vec3) -> Vec<Vec3> {
        let pick = |i: usize, k: usize| if i >> k & 1 == 0 { low[k] } else { high[k] };
        (0..8).map(|i| Vec3::new(pick(i, 0), pick(i, 1), pick(i, 2))).collect()
    }

    proptest! {
        #[test]
        fn the_picture_contains_the_bounding_box_and_is_filled(
            size in [0.05f32..30.0, 0.05f32..60.0, 0.05f32..30.0],
            at in [-20.0f32..20.0, 0.0f32..5.0, -20.0f32..20.0],
            aspect in 0.3f32..3.0,
            angle in 0.1f32..1.5,
        ) {
            let low = Vec3::from(at);
            let points = corners(low, low + Vec3::from(size));
            for view in View::ALL.into_iter().filter(|view| !CLOSE.contains(view)) {
                let camera = Camera::framing(points.iter().copied(), view, aspect, angle).unwrap();
                let seen: Vec<[f32; 2]> =
                    points.iter().map(|&p| camera.project(p).unwrap().0).collect();
                let mut span = [0.0f32; 2];
                for axis in 0..2 {
                    let least = seen.iter().map(|s| s[axis]).fold(f32::MAX, f32::min);
                    let most = seen.iter().map(|s| s[axis]).fold(f32::MIN, f32::max);
                    prop_assert!(least >= 0.01 && most <= 0.99, "{view:?} {least} {most}");
                    span[axis] = most - least;
                }
                let filled = span[0].max(span[1]);
                prop_assert!(filled > 0.6, "{view:?}: {span:?}");
            }
        }
    }

    #[test]
    fn a_ray_goes_through_what_is_projected_there() {
        let points = corners(Vec3::new(-4.0, 0.0, -5.0), Vec3::new(6.0, 12.0, 3.0));
        for view in View::ALL.into_iter().filter(|view| !CLOSE.contains(view)) {
            let camera = Camera::framing(points.iter().copied(), view, 1.3, 0.6).unwrap();
            let orthographic = Camera::orthographic(Vec3::Y, 0.4, 0.2, [20.0, 15.0]);
            for camera in [camera, orthographic] {
                for &point in &points {
                    let (at, _) = camera.project(point).unwrap();
                    let ray = camera.ray(at, [0.3, 0.9]);
                    let off = (point - ray.origin).cross(ray.direction).length();
                    assert!(off < 1e-3, "{view:?} {off}");
                }
            }
        }
    }

    #[test]
    fn close_views_look_at_the_bark_and_at_what_is_foremost_from_two_metres() {
        let mut points = corners(Vec3::new(-0.3, 0.0, -0.3), Vec3::new(0.3, 10.0, 0.3));
        points.extend(corners(Vec3::new(-0.3, 1.0, -0.3), Vec3::new(0.3, 1.4, 0.3)));
        points.push(Vec3::new(2.0, 7.0, 5.0));
        for (view, at) in CLOSE.into_iter().zip([Vec3::new(0.0, 1.2, 0.3), points[16]]) {
            let camera = Camera::framing(points.iter().copied(), view, 1.0, 0.5).unwrap();
            let (place, depth) = camera.project(at).unwrap();
            assert!((place[0] - 0.5).abs() + (place[1] - 0.5).abs() < 1e-4, "{view:?} {place:?}");
            assert!((depth - 2.0).abs() < 1e-4, "{view:?} {depth}");
            let Lens::Thin { focus, .. } = camera.lens else { unreachable!() };
            assert_eq!(focus, 2.0);
        }
    }

    #[test]
    fn a_lens_is_sharp_at_its_focus_only() {
        let points = corners(Vec3::splat(-1.0), Vec3::ONE);
        let camera = Camera::framing(points.iter().copied(), View::Front, 1.0, 0.5).unwrap();
        let wide = camera.with_aperture(0.2);
        let (a, b) = (wide.ray([0.4, 0.5], [0.0, 0.9]), wide.ray([0.4, 0.5], [0.5, 0.9]));
        let apart = |depth: f32| {
            let at =
                |ray: Ray| ray.origin + ray.direction * (depth / ray.direction.dot(camera.axes[2]));
            (at(a) - at(b)).length()
        };
        let Lens::Thin { focus, .. } = wide.lens else { unreachable!() };
        assert!(apart(focus) < 1e-4 && apart(2.0 * focus) > 0.1);
    }

    #[test]
    fn unknown_views_are_told_what_there_is() {
        let error = "sideways".parse::<View>().unwrap_err().to_string();
        assert!(error.contains("'sideways'") && error.contains("quarter"));
        assert!(Camera::framing([].into_iter(), View::Top, 1.0, 0.5).is_err());
        assert!(Camera::framing([Vec3::ONE].into_iter(), View::Top, 1.0, 3.0).is_err());
        assert!(Camera::framing([Vec3::ONE].into_iter(), View::Front, 1.0, 0.5).is_ok());
    }
}
