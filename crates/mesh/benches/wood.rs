//! How fast wood is meshed, in vertices per second.

use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
use deeptree_mesh::{WoodOptions, tubes, wood};
use divan::Bencher;
use divan::counter::ItemsCount;

/// A tree that forks the same way `depth` times: two laterals at every node that has the depth.
fn recursive_tree(depth: u32) -> BranchGraph {
    let info = TreeInfo { species: "recursive".into(), age: depth, gravitropism: 0.0, seed: 0 };
    let edge = |depth: u32, yaw: f32, pitch: f32| ChildSignature {
        rotation: Quat::from_rotation_z(yaw) * Quat::from_rotation_x(pitch),
        thickness: 0.004 * 1.3f32.powi(depth as i32),
        length: 0.1 + 0.03 * depth as f32,
    };
    let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(depth, 0.0, 1.57));
    let mut open = vec![(0, depth)];
    while let Some((node, depth)) = open.pop() {
        if depth < 2 {
            continue;
        }
        let signatures = [
            Some(edge(depth - 1, 1.2, 0.15)),
            Some(edge(depth - 2, 0.4, 0.8)),
            (depth % 3 == 0).then(|| edge(depth - 2, 2.6, 0.7)),
        ];
        let ids = tree.grow(node, signatures);
        for (slot, id) in ids.into_iter().enumerate() {
            open.extend(id.map(|id| (id, depth - 1 - u32::from(slot > 0))));
        }
    }
    tree
}

/// The argument is the depth: about 500, 6 000 and 75 000 nodes.
#[divan::bench(args = [10, 15, 20])]
fn vertices(bencher: Bencher, depth: u32) {
    let tree = recursive_tree(depth);
    let options = WoodOptions::default();
    let count = wood(&tree, &options).vertex_count();
    bencher.counter(ItemsCount::new(count)).bench(|| wood(&tree, &options));
}

/// The simple way.
#[divan::bench(args = [10, 15, 20])]
fn vertices_of_tubes(bencher: Bencher, depth: u32) {
    let tree = recursive_tree(depth);
    let options = WoodOptions::default();
    let count = tubes(&tree, &options).vertex_count();
    bencher.counter(ItemsCount::new(count)).bench(|| tubes(&tree, &options));
}

fn main() {
    for depth in [10, 15, 20] {
        let tree = recursive_tree(depth);
        let mesh = wood(&tree, &WoodOptions::default());
        println!("depth {depth}: {} nodes, {} vertices", tree.len(), mesh.vertex_count());
    }
    divan::main();
}
