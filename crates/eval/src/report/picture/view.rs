//! Where a tree is seen from.

use deeptree_graph::{BranchGraph, Vec3};

/// A direction of sight, as one walks around a tree and climbs.
///
/// From the front x points to the right, y up and z to the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// How far around the vertical the viewer has walked from the front to the right, in degrees.
    pub azimuth: f32,
    /// How high above the horizon the viewer stands, in degrees.
    pub elevation: f32,
}

/// The extent of a tree in a view, in metres from its foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f32,
    pub(super) right: f32,
    pub(super) bottom: f32,
    pub(super) top: f32,
}

/// The axes of a view in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    right: Vec3,
    up: Vec3,
    toward: Vec3,
}

impl View {
    /// From the front.
    pub const FRONT: Self = Self { azimuth: 0.0, elevation: 0.0 };
    /// From the right.
    pub const SIDE: Self = Self { azimuth: 90.0, elevation: 0.0 };
    /// From behind.
    pub const BACK: Self = Self { azimuth: 180.0, elevation: 0.0 };
    /// From above.
    pub const TOP: Self = Self { azimuth: 0.0, elevation: 90.0 };
    /// From the front and the right, somewhat above.
    pub const QUARTER: Self = Self { azimuth: 45.0, elevation: 20.0 };

    /// The ground is a line only where one does not look down on it.
    pub(super) fn shows_ground(self) -> bool {
        self.elevation < 5.0
    }

    pub(super) fn axes(self) -> Axes {
        let (sin_a, cos_a) = libm::sincosf(self.azimuth.to_radians());
        let (sin_e, cos_e) = libm::sincosf(self.elevation.to_radians());
        let right = Vec3::new(cos_a, 0.0, -sin_a);
        let toward = Vec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        Axes { right, up: toward.cross(right), toward }
    }

    /// The extent of all internodes with their thickness, of the foot, and of the trees and boxes
    /// around.
    pub(super) fn frame(
        self,
        tree: &BranchGraph,
        beside: &[BranchGraph],
        boxes: &[[Vec3; 8]],
    ) -> Frame {
        let axes = self.axes();
        let foot = tree.root().base();
        let nothing = Frame { left: 0.0, right: 0.0, bottom: 0.0, top: 0.0 };
        let trees = std::iter::once(tree).chain(beside);
        let nodes = trees.flat_map(BranchGraph::nodes);
        let tips = nodes.map(|node| (node.position, node.thickness));
        let corners = boxes.iter().flatten().map(|&corner| (corner, 0.0));
        tips.chain(corners).fold(nothing, |frame, (place, radius)| {
            let tip = axes.look(place - foot);
            Frame {
                left: frame.left.min(tip.x - radius),
                right: frame.right.max(tip.x + radius),
                bottom: frame.bottom.min(tip.y - radius),
                top: frame.top.max(tip.y + radius),
            }
        })
    }
}

impl Axes {
    /// A vector of the world as the viewer has it: to the right, up, and toward the viewer.
    pub(super) fn look(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.right), v.dot(self.up), v.dot(self.toward))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_points_where_in_each_view() {
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        // In each view: what points right, up, and to the viewer.
        for (view, right, up, toward) in [
            (View::FRONT, x, y, z),
            (View::SIDE, -z, y, x),
            (View::BACK, -x, y, -z),
            (View::TOP, x, -z, y),
        ] {
            let axes = view.axes();
            assert!(axes.look(right).distance(Vec3::X) < 1e-6, "{view:?}");
            assert!(axes.look(up).distance(Vec3::Y) < 1e-6, "{view:?}");
            assert!(axes.look(toward).distance(Vec3::Z) < 1e-6, "{view:?}");
        }
        // From above the front right, up leans away from the viewer.
        let look = View::QUARTER.axes().look(Vec3::Y);
        assert!(look.y > 0.9 && look.z > 0.3, "{look}");
    }
}
