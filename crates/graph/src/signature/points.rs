//! What the networks hear of the points around a node.
//!
//! Each point within [`RADIUS`] is told in the node's own frame, so that nothing depends on where
//! the tree stands or how it is turned. A small network reads one point at a time; the largest that
//! it says of any, channel by channel, goes with [`summary`] into the *code* of the node's
//! surroundings. Small networks, one for each law that hears of points, read that code and what the
//! law's own network said, and add to it.
//!
//! # Source
//!
//! DeepTree, "Point-based Modeling", after PointNet (Qi et al. 2017). Deviation: there the feature
//! is added to the embedding of the signature inside each network; here it corrects what the network
//! says, so that without points it says what it always does, to the last bit.

use glam::Vec3;

use super::Writer;
use crate::graph::Node;

/// r_s: how far from a node points are heard, in metres of the growth space.
pub const RADIUS: f32 = 2.0;

/// Points that are heard of at most.
pub const MOST_POINTS: usize = 512;

/// Numbers that a point is told by.
pub const POINT_LEN: usize = 7;

/// Widths of the hidden layer and of the output of the network that reads one point.
pub const POINT_WIDTHS: [usize; 2] = [16, 32];

/// Numbers that all points together are told by, beside what the network says.
pub const SUMMARY_LEN: usize = 2;

/// Numbers of the code.
pub const CODE: usize = 12;

/// Width of the hidden layer of the networks that correct.
pub const HIDDEN: usize = 16;

/// What a law's network said is told to that which corrects it within these bounds, over
/// [`SAID_SCALE`].
pub const MOST_SAID: f32 = 8.0;

/// See [`MOST_SAID`].
pub const SAID_SCALE: f32 = 4.0;

/// Writes what is heard of one point: its direction in the node's frame (x to the right, y up, −z
/// ahead), its distance over [`RADIUS`], and the product of both, which is its place. Of a direction
/// and a distance, a rectifier makes a cone that a child may lie in; of a place alone, it cannot.
///
/// # Panics
///
/// When `out` is shorter than [`POINT_LEN`].
pub fn encode(node: &Node, point: Vec3, out: &mut [f32]) {
    let from = node.orientation.inverse() * (point - node.position) / RADIUS;
    let mut w = Writer { out, at: 0 };
    w.put3(from.normalize_or_zero());
    w.put(from.length());
    w.put3(from);
}

/// How many points there are, `ln(1 + n) / 4`, and what share of them is ahead of the node.
#[must_use]
pub fn summary(node: &Node, points: &[Vec3]) -> [f32; SUMMARY_LEN] {
    let front = node.orientation * Vec3::NEG_Z;
    let ahead = points.iter().filter(|&&point| (point - node.position).dot(front) > 0.0).count();
    let count = points.len() as f32;
    [libm::logf(1.0 + count) / 4.0, ahead as f32 / count.max(1.0)]
}

/// What is told of a number that a law's network said.
#[must_use]
pub fn said(value: f32) -> f32 {
    value.clamp(-MOST_SAID, MOST_SAID) / SAID_SCALE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random_tree;
    use glam::Quat;

    #[test]
    fn a_turned_tree_with_its_cloud_is_told_the_same() {
        let tree = random_tree(1, 60);
        let (turn, shift) =
            (Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -2.0), Vec3::ONE * 3.0);
        for node in tree.nodes() {
            let points: Vec<Vec3> =
                (0..9).map(|i| node.position + Vec3::new(0.1 * i as f32, 0.5, -0.7)).collect();
            let mut moved = node.clone();
            moved.position = turn * node.position + shift;
            moved.orientation = (turn * node.orientation).normalize();
            let placed: Vec<Vec3> = points.iter().map(|&point| turn * point + shift).collect();
            for (&point, &there) in points.iter().zip(&placed) {
                let (mut a, mut b) = ([0.0; POINT_LEN], [0.0; POINT_LEN]);
                encode(node, point, &mut a);
                encode(&moved, there, &mut b);
                assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4), "{a:?} {b:?}");
            }
            assert_eq!(summary(node, &points)[0], summary(&moved, &placed)[0]);
        }
    }

    #[test]
    fn a_point_an_internode_ahead_is_told_as_such() {
        let mut node = random_tree(1, 2).nodes()[0].clone();
        (node.position, node.orientation) = (Vec3::new(1.0, 2.0, 3.0), Quat::IDENTITY);
        let mut out = [0.0; POINT_LEN];
        encode(&node, Vec3::new(1.0, 2.0, 2.0), &mut out);
        assert_eq!(out, [0.0, 0.0, -1.0, 0.5, 0.0, 0.0, -0.5]);
        let points = [Vec3::new(1.0, 2.0, 2.0), Vec3::new(1.0, 2.0, 3.5)];
        assert_eq!(summary(&node, &points), [libm::logf(3.0) / 4.0, 0.5]);
        assert_eq!(summary(&node, &[]), [0.0, 0.0]);
    }
}
