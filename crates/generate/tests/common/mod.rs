//! What several tests need.
#![allow(dead_code, reason = "each test file uses a part of it")]
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_graph::BranchGraph;
use deeptree_infer::Model;

/// The model that ships.
pub(crate) fn shipped() -> Model {
    Model::from_bytes(include_bytes!("../../../../models/situated.safetensors")).unwrap()
}

/// How far each node is from the root, in nodes.
pub(crate) fn depths(tree: &BranchGraph) -> Vec<usize> {
    let mut depths = vec![0; tree.len()];
    for (id, node) in tree.nodes().iter().enumerate().skip(1) {
        depths[id] = depths[node.parent.unwrap() as usize] + 1;
    }
    depths
}
