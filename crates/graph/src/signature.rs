//! What a network reads of one node: the only definition, for training and for inference.
//!
//! Two encodings of the same node, one a model kind:
//!
//! - [`paper`]: the attributes of Eq. 1, each scaled to about 1;
//! - [`situated`]: the same place told so that a small network can use it: integer tip counts of
//!   the pipe model, one-hots of distances that are nearly whole numbers, and all directions in the
//!   node's own frame, so that nothing depends on the yaw of the tree.

use glam::Vec3;

use crate::graph::{ChildSignature, Node};

/// Side of the growth space in metres: positions over this lie in the paper's unit cube.
pub const GROWTH_SPACE: f32 = 64.0;

/// What all nodes of a tree share, as the networks read it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeConditions {
    /// a: age in growth cycles.
    pub age: f32,
    /// v: gravitropism.
    pub gravitropism: f32,
    /// s: index of the species in the model's list.
    pub species: usize,
    /// Radius of a twig that bears one tip, in metres: the unit of the pipe model.
    pub tip_radius: f32,
}

/// The integer tip count N of the pipe model: `N = (t / t_tip)²`, at least 1.
///
/// All tips have the same radius, and a parent's cross-section is the sum of its children's, so N
/// counts the tips of the whole tree above a node, the ones an export dropped included.
#[must_use]
pub fn tip_count(thickness: f32, tip_radius: f32) -> u32 {
    let ratio = thickness / tip_radius;
    libm::roundf(ratio * ratio).clamp(1.0, 16_777_216.0) as u32
}

/// The radius of a branch that bears `tips` tips: `t = t_tip · √N`, in metres.
#[must_use]
pub fn thickness_of(tips: u32, tip_radius: f32) -> f32 {
    tip_radius * libm::sqrtf(tips as f32)
}

/// Writes features one after another.
struct Writer<'a> {
    out: &'a mut [f32],
    at: usize,
}

impl Writer<'_> {
    fn put(&mut self, value: f32) {
        self.out[self.at] = value;
        self.at += 1;
    }

    fn put3(&mut self, v: Vec3) {
        v.to_array().into_iter().for_each(|x| self.put(x));
    }

    /// `len` values, 1 at `index`, which is clamped into the range.
    fn one_hot(&mut self, index: usize, len: usize) {
        self.out[self.at..self.at + len].fill(0.0);
        self.out[self.at + index.min(len - 1)] = 1.0;
        self.at += len;
    }
}

/// The encoding of kind `paper`: Eq. 1 as published.
pub mod paper {
    use super::*;

    /// Length of an output signature u = (q, t, l) as the later regressors read it.
    pub const CHILD_LEN: usize = 6;

    /// Number of features for a model of `species` species.
    #[must_use]
    pub const fn len(species: usize) -> usize {
        15 + species
    }

    /// Where the three coordinates of the position stand, for the noise of the training recipe.
    pub const POSITION: std::ops::Range<usize> = 0..3;

    /// Encodes one node: p, t, d_r, d_s, q_p, l_p, o, m_p, a, v, s.
    ///
    /// # Units
    ///
    /// p, d_r and d_s over the growth space; t and l_p in metres; a per 64 cycles; s as a one-hot.
    ///
    /// # Panics
    ///
    /// When `out` is shorter than [`len`].
    pub fn encode(node: &Node, tree: &TreeConditions, species: usize, out: &mut [f32]) {
        let mut w = Writer { out, at: 0 };
        w.put3(node.position / GROWTH_SPACE);
        w.put(node.thickness);
        w.put(node.root_distance / GROWTH_SPACE);
        w.put(node.branch_distance / GROWTH_SPACE);
        node.rotation.to_array().into_iter().for_each(|x| w.put(x));
        w.put(node.length);
        w.put(f32::from(node.order) / 8.0);
        w.put(f32::from(node.sibling_count) / 3.0);
        w.put(tree.age / 64.0);
        w.put(tree.gravitropism);
        w.one_hot(tree.species, species);
        debug_assert_eq!(w.at, len(species));
    }

    /// Encodes the output signature of an earlier sibling: q, t, l; zeros where there is none.
    pub fn encode_child(child: Option<&ChildSignature>, out: &mut [f32]) {
        let out = &mut out[..CHILD_LEN];
        match child {
            Some(child) => {
                out[..4].copy_from_slice(&child.rotation.to_array());
                out[4] = child.thickness;
                out[5] = child.length;
            }
            None => out.fill(0.0),
        }
    }
}

/// The encoding of kind `situated`.
pub mod situated {
    use super::*;

    /// Tip counts up to this have a one-hot of their own.
    const SMALL_TIPS: usize = 16;
    /// One-hot steps of d_s, of the distance to the last fork, and of d_r, in metres.
    const BRANCH_STEPS: usize = 14;
    const FORK_STEPS: usize = 10;
    const ROOT_STEPS: usize = 40;
    /// Orders with a one-hot of their own; deeper ones share the last.
    const ORDERS: usize = 7;

    /// Number of features for a model of `species` species.
    #[must_use]
    pub const fn len(species: usize) -> usize {
        species
            + 2
            + (2 + SMALL_TIPS + 1)
            + (1 + BRANCH_STEPS)
            + (1 + FORK_STEPS)
            + (1 + ROOT_STEPS)
            + ORDERS
            + 3
            + 3
            + 4
            + 1
            + 2
            + 9
            + 3
    }

    /// Encodes one node.
    ///
    /// In order: s, a, v; ln N, 1/√N and a one-hot of small N; d_s, the distance to the last fork
    /// and d_r, each as a number and a one-hot of whole metres; o, m_p and the slot as one-hots;
    /// q_p and l_p; height and distance from the axis; gravity (as the height of front, up and right), the
    /// position and the outward direction, each in the node's own frame.
    ///
    /// # Panics
    ///
    /// When `out` is shorter than [`len`].
    ///
    /// # Source
    ///
    /// Eq. 1, with what q_p hides: the global frame, and the distance to the last fork.
    pub fn encode(node: &Node, tree: &TreeConditions, species: usize, out: &mut [f32]) {
        let mut w = Writer { out, at: 0 };
        w.one_hot(tree.species, species);
        w.put(tree.age / 50.0);
        w.put(2.0 * tree.gravitropism);

        let tips = tip_count(node.thickness, tree.tip_radius);
        w.put(libm::logf(tips as f32) / 8.0);
        w.put(1.0 / libm::sqrtf(tips as f32));
        w.one_hot(tips as usize - 1, SMALL_TIPS + 1);

        for (distance, scale, steps) in [
            (node.branch_distance, 16.0, BRANCH_STEPS),
            (node.fork_distance, 8.0, FORK_STEPS),
            (node.root_distance, 32.0, ROOT_STEPS),
        ] {
            w.put(distance / scale);
            w.one_hot(libm::roundf(distance.max(1.0)) as usize - 1, steps);
        }
        w.one_hot(usize::from(node.order), ORDERS);
        w.one_hot(usize::from(node.sibling_count.max(1)) - 1, 3);
        w.one_hot(usize::from(node.slot), 3);
        node.rotation.to_array().into_iter().for_each(|x| w.put(x));
        w.put(node.length);

        let axis_distance = Vec3::new(node.position.x, 0.0, node.position.z);
        let radius = axis_distance.length();
        w.put(node.position.y / 32.0);
        w.put(radius / 16.0);
        let own = node.orientation.inverse();
        w.put3(own * Vec3::Y);
        w.put3(own * (node.position / 32.0));
        // Outward from the trunk; fades out at the axis, where it has no direction.
        w.put3(own * (axis_distance / (radius + 0.5)));
        w.put3(own * outward_from_crown(node.position));
        debug_assert_eq!(w.at, len(species));
    }

    /// Direction from the axis at half of the node's height to the node: roughly away from the
    /// crown's centre, where the light of an open field comes from.
    fn outward_from_crown(position: Vec3) -> Vec3 {
        let from = position - Vec3::new(0.0, 0.7 * position.y, 0.0);
        from / (from.length() + 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{BranchGraph, TreeInfo};
    use glam::Quat;

    fn conditions() -> TreeConditions {
        TreeConditions { age: 35.0, gravitropism: -0.1, species: 2, tip_radius: 0.01 }
    }

    /// A trunk of two internodes with one lateral, turned by `yaw` about the vertical.
    fn tree(yaw: f32) -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 35, gravitropism: -0.1, seed: 0 };
        let upright =
            Quat::from_rotation_y(yaw) * Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let node = |rotation, thickness| ChildSignature { rotation, thickness, length: 1.0 };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, node(upright, 0.03));
        tree.grow(
            0,
            [
                Some(node(Quat::from_rotation_x(0.1), 0.02)),
                Some(node(Quat::from_rotation_x(0.8), 0.02)),
                None,
            ],
        );
        tree
    }

    #[test]
    fn situated_features_do_not_depend_on_the_yaw_of_the_tree() {
        let mut features = [vec![0.0; situated::len(8)], vec![0.0; situated::len(8)]];
        for id in 1..3 {
            for (yaw, out) in [0.0, 2.1].into_iter().zip(&mut features) {
                situated::encode(tree(yaw).node(id), &conditions(), 8, out);
            }
            for (a, b) in features[0].iter().zip(&features[1]) {
                assert!((a - b).abs() < 1e-5, "{a} {b}");
            }
        }
    }

    #[test]
    fn tip_counts_survive_the_way_through_a_radius() {
        for tips in (1..5000).chain([65_535, 1_000_000, 1 << 22]) {
            assert_eq!(tip_count(thickness_of(tips, 0.01), 0.01), tips);
        }
    }

    #[test]
    fn encodings_fill_every_feature() {
        let mut out = vec![f32::NAN; situated::len(8)];
        situated::encode(tree(0.3).node(2), &conditions(), 8, &mut out);
        assert!(out.iter().all(|x| x.is_finite()));
        let mut out = vec![f32::NAN; paper::len(8)];
        paper::encode(tree(0.3).node(2), &conditions(), 8, &mut out);
        assert!(out.iter().all(|x| x.is_finite()));
    }
}
