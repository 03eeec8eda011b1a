//! What foresters ask of a tree.

use deeptree_graph::BranchGraph;

use crate::fit::ORDERS;

/// Height above the foot at which a stem is measured, in metres.
pub const BREAST_HEIGHT: f32 = 1.3;

/// Figures of a tree; metres, cubic metres. What counts as up is y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// From the foot to the highest node.
    pub height: f32,
    /// Diameter of the trunk 1.3 m above the foot, between its nodes on a straight line; none where
    /// the trunk does not reach so high.
    pub dbh: Option<f32>,
    /// Distance of the outermost node from the vertical through the foot.
    pub crown_radius: f32,
    /// Volume of the wood: each internode a frustum between its parent's radius and its own.
    pub volume: f64,
    /// Length of all edges.
    pub length: f64,
    /// The same by Gravelius order; deeper ones share the last.
    pub length_of_order: [f64; ORDERS],
    /// Gravelius branches.
    pub branches: usize,
}

impl Figures {
    /// The figures of a tree.
    #[must_use]
    pub fn of(tree: &BranchGraph) -> Self {
        let foot = tree.root().base();
        let mut figures = Self {
            height: 0.0,
            dbh: None,
            crown_radius: 0.0,
            volume: 0.0,
            length: 0.0,
            length_of_order: [0.0; ORDERS],
            branches: 0,
        };
        for node in tree.nodes() {
            let from = node.position - foot;
            figures.height = figures.height.max(from.y);
            figures.crown_radius = figures.crown_radius.max(from.with_y(0.0).length());
            let length = f64::from(node.length);
            figures.length += length;
            figures.length_of_order[usize::from(node.order).min(ORDERS - 1)] += length;
            figures.branches += usize::from(node.parent.is_none() || node.slot > 0);
            let parent = node.parent.map_or(node, |id| tree.node(id));
            // A lateral starts as thick as it is, not as its parent.
            let start = if node.slot > 0 { node.thickness } else { parent.thickness };
            let [r, s] = [start, node.thickness].map(f64::from);
            figures.volume += core::f64::consts::PI / 3.0 * length * (r * r + r * s + s * s);
            let (low, high) = (node.base().y - foot.y, from.y);
            if node.order == 0
                && figures.dbh.is_none()
                && low <= BREAST_HEIGHT
                && high >= BREAST_HEIGHT
            {
                let share = if high > low { (BREAST_HEIGHT - low) / (high - low) } else { 0.0 };
                figures.dbh = Some(2.0 * (start + (node.thickness - start) * share));
            }
        }
        figures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{ChildSignature, Quat, TreeInfo, Vec3};

    #[test]
    fn a_cone_has_the_volume_and_the_diameter_that_geometry_says() {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let rotation = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let edge = |rotation, thickness, length| ChildSignature { rotation, thickness, length };
        let foot = Vec3::new(4.0, -2.0, 1.0);
        let mut tree = BranchGraph::new(info, foot, edge(rotation, 0.3, 0.0));
        let aside = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2);
        tree.grow(0, [Some(edge(Quat::IDENTITY, 0.0, 3.0)), Some(edge(aside, 0.0, 2.0)), None]);
        let figures = Figures::of(&tree);
        assert!((figures.volume - core::f64::consts::PI * 0.09).abs() < 1e-6);
        assert!((figures.dbh.unwrap() - 2.0 * 0.3 * (1.7 / 3.0)).abs() < 1e-6);
        assert!((figures.height - 3.0).abs() < 1e-5 && (figures.crown_radius - 2.0).abs() < 1e-5);
        assert_eq!(figures.length_of_order[..2], [3.0, 2.0]);
        assert_eq!((figures.branches, figures.length), (2, 5.0));
    }
}
