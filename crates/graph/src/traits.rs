//! What one tree as a whole is like.

use crate::graph::BranchGraph;
use crate::plan::Plan;

/// A handful of numbers of a whole tree. Every node carries them like its age, so that trees differ
/// from each other as much as the teacher's do; a purely local signature evens them out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeTraits {
    /// Nodes of the tree.
    pub nodes: f32,
    /// Gravelius branches of the tree.
    pub branches: f32,
    /// Longest way from the foot to a node, in metres.
    pub longest_path: f32,
    /// Mean way from the foot to the nodes, in metres.
    pub mean_path: f32,
    /// Distance of the outermost node from the axis, in metres.
    pub crown_radius: f32,
    /// Height of the highest node, in metres.
    pub height: f32,
    /// Length of the branch of order 0, in metres.
    pub trunk_length: f32,
}

impl TreeTraits {
    /// How many numbers they are.
    pub const COUNT: usize = 7;

    /// The traits of a tree whose foot is the origin.
    #[must_use]
    pub fn of(tree: &BranchGraph) -> Self {
        let nodes = tree.nodes();
        let most = |of: fn(&crate::Node) -> f32| nodes.iter().map(of).fold(0.0, f32::max);
        let paths: f64 = nodes.iter().map(|node| f64::from(node.root_distance)).sum();
        let starts = |node: &&crate::Node| node.parent.is_none() || node.slot > 0;
        Self {
            nodes: nodes.len() as f32,
            branches: nodes.iter().filter(starts).count() as f32,
            longest_path: most(|node| node.root_distance),
            mean_path: (paths / nodes.len() as f64) as f32,
            crown_radius: most(|node| {
                let (x, z) = (node.position.x, node.position.z);
                libm::sqrtf(x * x + z * z)
            }),
            height: most(|node| node.position.y),
            trunk_length: most(|node| if node.order == 0 { node.branch_distance } else { 0.0 }),
        }
    }

    /// The numbers in the order of the fields.
    #[must_use]
    pub const fn to_array(self) -> [f32; Self::COUNT] {
        let Self { nodes, branches, longest_path, mean_path, crown_radius, height, trunk_length } =
            self;
        [nodes, branches, longest_path, mean_path, crown_radius, height, trunk_length]
    }

    /// The inverse of [`Self::to_array`].
    #[must_use]
    pub const fn from_array(numbers: [f32; Self::COUNT]) -> Self {
        let [nodes, branches, longest_path, mean_path, crown_radius, height, trunk_length] =
            numbers;
        Self { nodes, branches, longest_path, mean_path, crown_radius, height, trunk_length }
    }

    /// How many numbers [`Self::state`] has.
    pub const STATES: usize = 1 + Self::COUNT;

    /// Names of the numbers of [`Self::state`].
    pub const STATE_NAMES: [&str; Self::STATES] = [
        "tips",
        "nodes",
        "longest_path",
        "branches",
        "mean_path",
        "crown_radius",
        "height",
        "trunk_length",
    ];

    /// Which numbers of [`Self::state`] are logarithms of counts; the others are metres.
    pub const STATE_IS_COUNT: [bool; Self::STATES] =
        [true, true, false, true, false, false, false, false];

    /// The traits of a tree of so many tips as numbers that linear laws fit, counts as logarithms:
    /// ln tips, ln nodes, longest path, ln branches, mean path, crown radius, height, length of the
    /// trunk; lengths in metres.
    #[must_use]
    pub fn state(&self, tips: u32) -> [f64; Self::STATES] {
        let log = |count: f32| libm::log(f64::from(count));
        [
            libm::log(f64::from(tips)),
            log(self.nodes),
            f64::from(self.longest_path),
            log(self.branches),
            f64::from(self.mean_path),
            f64::from(self.crown_radius),
            f64::from(self.height),
            f64::from(self.trunk_length),
        ]
    }

    /// The reach of the root that its longest path implies, in nodes: `⌊l + ½⌋ − 1`.
    ///
    /// Internodes are about a metre long, 0.997 m in the mean over the species, so that the nodes of
    /// the longest path are as many as its metres.
    #[must_use]
    pub fn reach(&self) -> u16 {
        (libm::roundf(self.longest_path) - 1.0).clamp(0.0, f32::from(u16::MAX)) as u16
    }

    /// What is to grow below the root of such a tree.
    #[must_use]
    pub fn plan(&self) -> Plan {
        // A float beyond the range of an integer becomes its largest.
        Plan { reach: self.reach(), nodes: (libm::roundf(self.nodes) - 1.0).max(0.0) as u32 }
    }

    /// Are all numbers finite, and those that count or measure a tree above 0?
    #[must_use]
    pub fn is_sound(self) -> bool {
        let Self { nodes, branches, mean_path, .. } = self;
        self.to_array().iter().all(|x| (0.0..1e9).contains(x))
            && nodes > 0.0
            && branches > 0.0
            && mean_path > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChildSignature, Quat, TreeInfo, Vec3};

    #[test]
    fn traits_of_a_t_are_those_worked_out_by_hand() {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let edge = |degrees: f32, length| {
            let rotation = Quat::from_rotation_x(degrees.to_radians());
            Some(ChildSignature { rotation, thickness: 0.1, length })
        };
        // Two metres up; on top an apical metre straight on and a lateral of 3 m to the side.
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(90.0, 2.0).unwrap());
        tree.grow(0, [edge(0.0, 1.0), edge(90.0, 3.0), None]);
        let traits = TreeTraits::of(&tree).to_array();
        let expected = [3.0, 2.0, 5.0, 10.0 / 3.0, 3.0, 3.0, 3.0];
        assert!(traits.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{traits:?}");
        assert_eq!(TreeTraits::from_array(traits).to_array(), traits);
    }

    #[test]
    fn a_state_holds_counts_as_logarithms_and_lengths_as_they_are() {
        let e = core::f64::consts::E as f32;
        let traits = TreeTraits::from_array([e * e, e, 5.0, 4.0, 3.0, 2.0, 1.0]);
        let expected = [0.0, 2.0, 5.0, 1.0, 4.0, 3.0, 2.0, 1.0];
        let state = traits.state(1);
        assert!(state.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{state:?}");
    }

    #[test]
    fn a_path_of_so_many_internodes_of_a_metre_has_one_less_below_the_root() {
        let with = |longest_path| TreeTraits {
            longest_path,
            ..TreeTraits::from_array([1.0; TreeTraits::COUNT])
        };
        let reaches = [0.0, 0.99, 1.4, 24.95, 39.88, 40.4, 1e9].map(|path| with(path).reach());
        assert_eq!(reaches, [0, 0, 0, 24, 39, 39, u16::MAX]);
    }
}
