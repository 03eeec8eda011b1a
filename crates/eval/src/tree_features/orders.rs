//! The tree order by order.

use deeptree_graph::{BranchGraph, Node, branches};

use super::recorder::{Recorder, mean};

/// Gravelius orders 0 to 4; what is above is left to the features of the whole tree.
const ORDERS: u16 = 5;

/// For each order its counts, and the means of its nodes.
pub(super) fn orders(tree: &BranchGraph, out: &mut Recorder) {
    let branches = branches(tree);
    let foot = tree.root().base();
    for order in 0..ORDERS {
        let nodes: Vec<&Node> = tree.nodes().iter().filter(|node| node.order == order).collect();
        let lengths: Vec<f64> = branches
            .iter()
            .filter(|branch| tree.node(branch.nodes[0]).order == order)
            .map(|branch| f64::from(branch.length(tree)))
            .collect();
        let average = |what: &dyn Fn(&Node) -> f32| {
            mean(&nodes.iter().map(|node| f64::from(what(node))).collect::<Vec<_>>())
        };
        let mut push = |name: &str, value| out.push(format!("o{order}/{name}"), value);
        push("nodes", nodes.len() as f64);
        push("nodes_share", nodes.len() as f64 / tree.len() as f64);
        push("branches", lengths.len() as f64);
        push("branch_length", mean(&lengths));
        // Rise of the mean direction: 1 straight up, −1 straight down.
        push("direction", average(&|node| node.front().y));
        push("height", average(&|node| node.position.y - foot.y));
        push("radius", average(&|node| (node.position - foot).with_y(0.0).length()));
        push("edge_length", average(&|node| node.length));
        push("thickness", average(&|node| node.thickness));
        push("children", average(&|node| f32::from(node.child_count())));
    }
}
