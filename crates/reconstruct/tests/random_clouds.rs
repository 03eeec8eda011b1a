//! Any cloud gives a sound tree or a typed error, never a panic.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_graph::Vec3;
use deeptree_infer::Model;
use deeptree_reconstruct::{Options, reconstruct};
use proptest::prelude::*;

/// Coordinates on a coarse grid now and then, so that many are equal, and wild ones seldom.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -10.0f32..10.0,
        4 => (-4i8..4).prop_map(f32::from),
        1 => prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(1e30), Just(-0.0), Just(1e-40)],
    ]
}

fn point() -> impl Strategy<Value = Vec3> {
    (coordinate(), coordinate(), coordinate()).prop_map(Vec3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_cloud_gives_a_sound_tree_or_an_error(
        points in prop::collection::vec(point(), 0..300),
        root in prop::option::of(point()),
        cover in prop::option::of(1e-3f32..10.0),
        complete in any::<bool>(),
    ) {
        let model = Model::from_bytes(include_bytes!("../../../models/situated.safetensors")).unwrap();
        let options = Options { root, cover, complete, prior: Some(&model), ..Options::default() };
        if let Ok(made) = reconstruct(&points, &options) {
            for node in made.tree.nodes() {
                prop_assert!(node.position.is_finite());
                prop_assert!(node.thickness.is_finite() && node.thickness > 0.0);
                let above = node.parent.map_or(node.thickness, |id| made.tree.node(id).thickness);
                prop_assert!(node.thickness <= above * 1.000_001);
            }
        }
    }
}
