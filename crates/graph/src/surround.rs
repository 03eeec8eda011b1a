//! What a node sees of what stands around its tree.

use glam::Vec3;

use crate::graph::Node;
use crate::occupancy::Occupancy;

/// Where branches can go.
pub trait Room: core::fmt::Debug + Sync {
    /// What is in the way of an edge from `base` to `tip`, in metres?
    fn passage(&self, base: Vec3, tip: Vec3) -> Passage;
}

/// Whether an edge may be, and what a shoot does where it may not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// Nothing is in its way.
    Free,
    /// It would enter an obstacle: the shoot ends.
    Blocked,
    /// It would leave the volume that growth is kept in: the shoot turns along its bounds, so that
    /// the volume is filled.
    Outside,
    /// It would leave the way from the foot to that volume: the trunk turns, other shoots end.
    Astray,
}

/// How many neighbouring places a node looks at: Z, the 3³ cells around it.
pub const NEIGHBOURS: usize = 27;

/// What a node sees of what stands around its tree: nothing, in the open field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surround {
    /// Z: bit i is 1 where the voxel at place i is taken. The places stand 2 m apart, in the node's
    /// own frame: place `i` is `(i mod 3 − 1, i / 3 mod 3 − 1, i / 9 − 1)` steps to the right, up and
    /// back, so that what lies ahead is told alike wherever the node looks to.
    pub taken: u32,
    /// The hidden part of the sky: 0 in the open, 1 in a closed room.
    pub shade: f32,
    /// The horizontal direction to the free part of the sky, in the world; zero where no side is
    /// freer.
    pub bright: Vec3,
}

impl Surround {
    /// Z of a node.
    ///
    /// # Source
    ///
    /// DeepTree, "Environmental Response". The paper takes the cells along the world's axes; in the
    /// node's own frame, as all else that is told of it, no yaw of the tree has to be learned.
    #[must_use]
    pub fn taken_around(node: &Node, taken: &Occupancy) -> u32 {
        let step = |i: usize| (i % 3) as f32 - 1.0;
        (0..NEIGHBOURS)
            .map(|i| {
                let own = Vec3::new(step(i), step(i / 3), step(i / 9)) * Occupancy::VOXEL;
                u32::from(taken.at(node.position + node.orientation * own)) << i
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BranchGraph, ChildSignature, Quat, TreeInfo, Voxel};

    /// A node at (0.5, 10, 0.5) that looks along x, with its up axis up.
    fn looking_along_x() -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let rotation = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        let root = ChildSignature { rotation, thickness: 0.1, length: 1.0 };
        BranchGraph::new(info, Vec3::new(-0.5, 11.0, 0.5), root)
    }

    #[test]
    fn a_wall_ahead_is_ahead_and_one_to_the_right_is_to_the_right() {
        let tree = looking_along_x();
        assert!(tree.root().position.distance(Vec3::new(0.5, 11.0, 0.5)) < 1e-5);
        let seen = |places: [f32; 3]| {
            let mut taken = Occupancy::EMPTY;
            taken.set(Voxel::holding(places.into()).unwrap());
            Surround::taken_around(tree.root(), &taken)
        };
        let place =
            |right: i32, up: i32, back: i32| 1 << ((right + 1) + 3 * (up + 1) + 9 * (back + 1));
        assert_eq!(seen([2.5, 11.0, 0.5]), place(0, 0, -1));
        // To the right of x, with y up, lies z.
        assert_eq!(seen([0.5, 11.0, 2.5]), place(1, 0, 0));
        assert_eq!(seen([0.5, 13.0, 0.5]), place(0, 1, 0));
        assert_eq!(seen([0.5, 11.0, 0.5]), place(0, 0, 0));
        assert_eq!(seen([6.5, 11.0, 0.5]), 0);
    }
}
