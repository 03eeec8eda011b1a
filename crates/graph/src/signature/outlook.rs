//! What the network of the environment reads of it and of a tree, and what it says.
//!
//! Two grids over the growth space, [`crate::Occupancy`], go through three 3D convolutions and a
//! dense layer into the *code* of the environment. A second, small network reads a tree's species,
//! age and gravitropism and that code, and says what to expect of the tree there.
//!
//! # Source
//!
//! DeepTree, "Environmental Response". Deviation: the paper adds the global feature to the local
//! one of every node before the heads; here it is told as what it means for the tree as a whole,
//! its traits and where its crown leans to, which every node reads.

use glam::Vec2;

use super::Writer;
use crate::graph::BranchGraph;
use crate::traits::TreeTraits;

/// Channels before, between and after the convolutions; the first two are the places that are taken
/// and those that shade. Each convolution has a kernel of 3³, stride 2, padding 1 of zeros, and a
/// rectifier after it: 32³ → 16³ → 8³ → 4³ places.
pub const CHANNELS: [usize; 4] = [2, 4, 8, 8];

/// Places of a kernel.
pub const KERNEL: usize = 27;

/// Values that the last convolution gives: 4³ places, x fastest, then y, then z, the channels of a
/// place next to each other.
pub const MAPS: usize = 4 * 4 * 4 * CHANNELS[3];

/// Numbers that an environment is told by.
pub const CODE: usize = 8;

/// What is said of a tree: its state ([`TreeTraits::state`]) in deviations from the mean of its
/// species, then the offset of its crown along x and z over [`OFFSET_SCALE`].
pub const OUTPUTS: usize = TreeTraits::STATES + 2;

/// Names of the [`OUTPUTS`].
pub const NAMES: [&str; OUTPUTS] = {
    let [tips, nodes, longest, branches, mean, radius, height, trunk] = TreeTraits::STATE_NAMES;
    [tips, nodes, longest, branches, mean, radius, height, trunk, "offset_x", "offset_z"]
};

/// Metres of the crown's offset that the network calls 1.
pub const OFFSET_SCALE: f32 = 4.0;

/// Values that tell a tree, of a model of so many species.
#[must_use]
pub const fn tree_len(species: usize) -> usize {
    species + 2
}

/// Values that the second network reads: those of the tree, then the [`CODE`].
#[must_use]
pub const fn len(species: usize) -> usize {
    tree_len(species) + CODE
}

/// Writes what tells a tree of species `number`: the species as a one-hot, a / 50, and 2 v.
///
/// # Panics
///
/// When `out` is shorter than [`tree_len`].
pub fn encode(species: usize, number: usize, age: f32, gravitropism: f32, out: &mut [f32]) {
    let mut w = Writer { out, at: 0 };
    w.one_hot(number, species);
    w.put(age / 50.0);
    w.put(2.0 * gravitropism);
}

/// How far the crown of a tree stands off the axis of its foot: the mean x and z of all nodes, in
/// metres.
#[must_use]
pub fn crown_offset(tree: &BranchGraph) -> Vec2 {
    let (mut x, mut z) = (0.0, 0.0);
    for node in tree.nodes() {
        x += f64::from(node.position.x);
        z += f64::from(node.position.z);
    }
    let nodes = tree.len() as f64;
    Vec2::new((x / nodes) as f32, (z / nodes) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChildSignature, Quat, TreeInfo, Vec3};

    #[test]
    fn a_tree_is_told_by_its_species_its_age_and_its_gravitropism() {
        let mut row = [9.0; len(3)];
        encode(3, 1, 25.0, -0.2, &mut row);
        assert_eq!(row[..5], [0.0, 1.0, 0.0, 0.5, -0.4]);
        assert_eq!(row[5..], [9.0; CODE]);
    }

    #[test]
    fn the_offset_of_a_crown_is_the_mean_place_of_its_nodes() {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let edge = |rotation, length| ChildSignature { rotation, thickness: 0.1, length };
        // Two metres up, then three towards −z, where the front of a frame points.
        let up = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(up, 2.0));
        tree.grow(0, [Some(edge(up.inverse(), 3.0)), None, None]);
        assert!((crown_offset(&tree) - Vec2::new(0.0, -1.5)).length() < 1e-6);
    }
}
