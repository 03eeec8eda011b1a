//! Meshes keep within a number of triangles.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::check;
use deeptree_graph::testing::random_tree;
use deeptree_mesh::{WoodOptions, tubes, within, wood};

#[test]
fn any_budget_above_the_least_is_kept_and_used_and_the_mesh_is_closed() {
    let tree = random_tree(7, 600);
    let options = WoodOptions::default();
    let least = within(&tree, 0, &options, wood).unwrap_err().least;
    let finest = wood(&tree, &options).triangle_count();
    assert!(least < 400 && finest > 10_000, "{least} {finest}");
    let mut before = 0;
    for budget in [least, 1000, 3000, 6000, 10_000, finest, 10 * finest] {
        let mesh = within(&tree, budget, &options, wood).unwrap();
        check(&mesh).unwrap();
        let count = mesh.triangle_count();
        assert!(count <= budget && count >= before, "{count} of {budget}, before {before}");
        before = count;
    }
    assert_eq!(before, finest);
    assert!(within(&tree, least - 1, &options, wood).is_err());
    assert!(within(&tree, 2000, &options, tubes).unwrap().triangle_count() <= 2000);
}
