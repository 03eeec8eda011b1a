//! What holds of the tubes of any tree, broken ones included.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::collections::BTreeMap;

use common::{double_area, signature_tree};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
use deeptree_mesh::{MIN_RADIUS, Mesh, WoodOptions, tubes};
use proptest::prelude::*;

/// Half edges of a tube between places, each with the times it is run along less those against.
fn open_edges(mesh: &Mesh, indices: std::ops::Range<u32>) -> usize {
    let mut runs = BTreeMap::<_, i32>::new();
    for t in mesh.indices[indices.start as usize..indices.end as usize].chunks(3) {
        let place = |i: u32| mesh.positions[i as usize].to_array().map(f32::to_bits);
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let (a, b) = (place(a), place(b));
            *runs.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    runs.values().filter(|&&n| n != 0).count()
}

/// Closed, no slivers, finite: what holds of each tube of any wood.
fn check(mesh: &Mesh) -> Result<(), TestCaseError> {
    for corners in mesh.triangles() {
        // The thinnest sliver of a ring of the smallest radius is far above this.
        let least = 1e-6 * MIN_RADIUS * MIN_RADIUS;
        prop_assert!(double_area(corners) > least, "{corners:?}");
    }
    for tube in &mesh.tubes {
        prop_assert_eq!(open_edges(mesh, tube.indices.clone()), 0);
    }
    prop_assert!(mesh.positions.iter().all(|p| p.is_finite()));
    prop_assert!(mesh.uvs.iter().flatten().all(|x| x.is_finite()));
    for normal in &mesh.normals {
        prop_assert!((normal.length() - 1.0).abs() < 1e-4, "{normal}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn tubes_are_closed_without_degenerate_triangles_and_normals_are_unit(
        tree in signature_tree(),
        level in 0u8..4,
    ) {
        check(&tubes(&tree, &WoodOptions::lod(level)))?;
    }

    #[test]
    fn trees_far_from_the_origin_are_meshed_as_well(seed in any::<u64>()) {
        check(&tubes(&random_tree(seed, 300), &WoodOptions::default()))?;
    }

    #[test]
    fn tubes_cover_the_mesh_without_gaps_and_wind_outward(tree in signature_tree()) {
        let mesh = tubes(&tree, &WoodOptions::default());
        let (mut vertex, mut index) = (0, 0);
        for tube in &mesh.tubes {
            prop_assert_eq!((tube.vertices.start, tube.indices.start), (vertex, index));
            (vertex, index) = (tube.vertices.end, tube.indices.end);
            let own = &mesh.indices[tube.indices.start as usize..tube.indices.end as usize];
            prop_assert!(own.iter().all(|i| tube.vertices.contains(i)));
            let part = Mesh {
                positions: mesh.positions.clone(),
                indices: own.to_vec(),
                ..Mesh::default()
            };
            prop_assert!(part.volume() > 0.0, "{tube:?}");
        }
        prop_assert_eq!(vertex as usize, mesh.vertex_count());
        prop_assert_eq!(index as usize, mesh.indices.len());
        prop_assert_eq!(mesh.positions.capacity(), mesh.vertex_count());
        prop_assert_eq!(mesh.indices.capacity(), mesh.indices.len());
    }
}

#[test]
fn a_tree_without_extent_has_no_tubes() {
    let info = TreeInfo { species: "point".into(), age: 0, gravitropism: 0.0, seed: 0 };
    let root = ChildSignature { rotation: Quat::IDENTITY, thickness: 0.1, length: 0.0 };
    let mesh = tubes(&BranchGraph::new(info, Vec3::ZERO, root), &WoodOptions::default());
    assert_eq!((mesh.vertex_count(), mesh.bounds()), (0, None));
}
