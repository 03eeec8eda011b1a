//! What age and gravitropism do to a tree, in four numbers.

use deeptree_graph::{BranchGraph, TreeTraits};

/// A tree as age and gravitropism shape it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Nodes of the tree.
    pub nodes: f64,
    /// Height of the highest node, in metres.
    pub height: f64,
    /// Distance of the outermost node from the axis, in metres.
    pub crown_radius: f64,
    /// Mean direction of growth: the vertical part of the fronts, weighted by the length of the
    /// internodes, `Σ l · front_y / Σ l`. 1 is straight up, 0 level, −1 straight down.
    pub rise: f64,
}

impl Development {
    /// Measures a tree whose foot is the origin.
    #[must_use]
    pub fn of(tree: &BranchGraph) -> Self {
        let TreeTraits { nodes, height, crown_radius, .. } = TreeTraits::of(tree);
        let (rise, length) = tree.nodes().iter().fold((0.0, 0.0), |(rise, length), node| {
            let l = f64::from(node.length);
            (rise + l * f64::from(node.front().y), length + l)
        });
        Self {
            nodes: f64::from(nodes),
            height: f64::from(height),
            crown_radius: f64::from(crown_radius),
            rise: if length > 0.0 { rise / length } else { 0.0 },
        }
    }

    /// The numbers in the order of the fields.
    #[must_use]
    pub const fn to_array(self) -> [f64; 4] {
        [self.nodes, self.height, self.crown_radius, self.rise]
    }
}

#[cfg(test)]
mod tests {
    use deeptree_graph::{ChildSignature, Quat, TreeInfo, Vec3};

    use super::*;

    #[test]
    fn a_t_with_one_drooping_arm_is_what_it_was_worked_out_to_be() {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let edge = |degrees: f32, length| {
            let rotation = Quat::from_rotation_x(degrees.to_radians());
            Some(ChildSignature { rotation, thickness: 0.1, length })
        };
        // Two metres up; then an arm of 3 m to one side, level, and one of 4 m, 30° below level.
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(90.0, 2.0).unwrap());
        tree.grow(0, [None, Some(edge(90.0, 3.0).unwrap()), edge(-120.0, 4.0)]);
        let development = Development::of(&tree);
        // (2 · 1 + 3 · 0 + 4 · (−1/2)) / 9 = 0; the second arm reaches 4 cos 30° = 3.46 m.
        let expected = [3.0, 2.0, 2.0 * 3f64.sqrt(), 0.0];
        for (value, expected) in development.to_array().iter().zip(expected) {
            assert!((value - expected).abs() < 1e-5, "{development:?}");
        }
    }
}
