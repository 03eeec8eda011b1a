//! The wood of any tree is one closed surface, broken trees included.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{check, signature_tree};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
use deeptree_mesh::{WoodOptions, wood};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_tree_has_closed_wood_of_one_piece(tree in signature_tree(), level in 0u8..4) {
        check(&wood(&tree, &WoodOptions::lod(level)))?;
    }

    #[test]
    fn trees_far_from_the_origin_have_it_too(seed in any::<u64>(), level in 0u8..4) {
        check(&wood(&random_tree(seed, 300), &WoodOptions::lod(level)))?;
    }
}

#[test]
fn where_rings_cross_no_triangle_is_none() {
    // Found by the test above: one vertex of a ring stood at the very place of one of the ring before.
    let tree = random_tree(11_903_926_446_726_529_444, 300);
    check(&wood(&tree, &WoodOptions::lod(2))).unwrap();
}

#[test]
fn a_tree_without_extent_is_a_burl() {
    let info = TreeInfo { species: "point".into(), age: 0, gravitropism: 0.0, seed: 0 };
    let root = ChildSignature { rotation: Quat::IDENTITY, thickness: 0.1, length: 0.0 };
    check(&wood(&BranchGraph::new(info, Vec3::ZERO, root), &WoodOptions::default())).unwrap();
}
