//! Trees that stand together look as one that has all their surfaces does.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_graph::testing::random_tree;
use deeptree_graph::{Quat, Vec3};
use deeptree_mesh::{Blade, Dressed, Foliage, Leaf, Mesh, WoodOptions, wood};
use deeptree_render::{
    Camera, Ground, Kind, Light, Options, RenderError, Scene, Standing, View, marks, plain_bark,
    render,
};

/// A tree with a triangle of a leaf at each tip.
fn dressed(seed: u64) -> Dressed {
    let tree = random_tree(seed, 40);
    let tips = tree.nodes().iter().zip(0..).filter(|(node, _)| node.child_count() == 0);
    let leaf = |(node, number): (&deeptree_graph::Node, u32)| Leaf {
        position: node.position,
        rotation: node.orientation * Quat::from_rotation_z(number as f32),
        scale: 0.4,
        node: number,
    };
    let blade = Blade {
        positions: vec![Vec3::ZERO, Vec3::new(0.5, 0.0, -1.0), Vec3::new(-0.5, 0.0, -1.0)],
        normals: vec![Vec3::Y; 3],
        uvs: vec![[0.0; 2]; 3],
        indices: vec![0, 1, 2],
    };
    let material = plain_bark();
    let foliage = vec![Foliage { blade, leaves: tips.map(leaf).collect(), material, woody: false }];
    Dressed { wood: wood(&tree, &WoodOptions::lod(3)), bark: plain_bark(), foliage }
}

/// Seven places, the last far from the others: more than are looked at one by one.
fn places() -> Vec<Vec3> {
    let place = |i: usize| Vec3::new(3.0 * (i % 3) as f32 - 2.0, 0.0, 4.0 * (i / 3) as f32);
    (0..6).map(place).chain([Vec3::new(25.0, 0.0, -9.0)]).collect()
}

/// One tree that has the surfaces of all.
fn together(trees: &[Dressed], places: &[Vec3]) -> Dressed {
    let mut all = Dressed { wood: Mesh::default(), bark: plain_bark(), foliage: Vec::new() };
    for (tree, &at) in trees.iter().zip(places) {
        let (first, nodes) = (all.wood.positions.len() as u32, all.wood.internodes.len() as u32);
        all.wood.positions.extend(tree.wood.positions.iter().map(|&p| p + at));
        all.wood.normals.extend(&tree.wood.normals);
        all.wood.uvs.extend(&tree.wood.uvs);
        all.wood.nodes.extend(tree.wood.nodes.iter().map(|node| node + nodes));
        all.wood.internodes.extend(tree.wood.internodes.iter().cloned());
        all.wood.indices.extend(tree.wood.indices.iter().map(|i| i + first));
        all.foliage.extend(tree.foliage.iter().cloned().map(|mut foliage| {
            for leaf in &mut foliage.leaves {
                leaf.position += at;
                leaf.node += nodes;
            }
            foliage
        }));
    }
    all
}

#[test]
fn a_stand_is_seen_as_its_trees_in_one_mesh_are() {
    let places = places();
    let trees: Vec<Dressed> = (0..places.len() as u64).map(dressed).collect();
    let one = together(&trees, &places);
    let standing: Vec<Standing<'_>> =
        trees.iter().zip(&places).map(|(tree, &at)| Standing { tree, at }).collect();
    let light = Light::daylight(0.7, -0.6, 3.0).unwrap();
    let stand = Scene::of(&standing, light.clone(), Ground::Meadow).unwrap();
    let one = Scene::new(&one, light, Ground::Meadow).unwrap();
    let camera = Camera::framing(one.points(), View::Quarter, 1.0, 0.6).unwrap();
    let options = Options { size: [160, 160], samples: 16, error: 0.0, ..Options::default() };

    let (a, b) =
        (marks(&stand, &camera, &options).unwrap(), marks(&one, &camera, &options).unwrap());
    let nodes = |tree: u32| trees[..tree as usize].iter().map(|t| t.wood.internodes.len() as u32);
    let same = a.iter().zip(&b).filter(|(a, b)| {
        let node = a.node + nodes(a.tree).sum::<u32>();
        (a.kind, a.order, node) == (b.kind, b.order, b.node) && (a.depth - b.depth).abs() < 1e-3
    });
    // A ray that touches an edge may go either way.
    assert!(same.count() + 3 >= a.len());
    let is_tree = |kind| matches!(kind, Kind::Wood | Kind::Leaf);
    let seen = |tree| a.iter().any(|mark| is_tree(mark.kind) && mark.tree == tree);
    assert!((0..7).filter(|&tree| seen(tree)).count() >= 6);

    let mean = |scene| render(scene, &camera, &options, |_| ()).unwrap().mean();
    let (a, b) = (mean(&stand), mean(&one));
    assert!(a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 2e-3), "{a:?} {b:?}");
}

#[test]
fn what_is_no_stand_is_refused() {
    let tree = dressed(1);
    let light = Light::uniform();
    let of = |trees: &[Standing<'_>]| Scene::of(trees, light.clone(), Ground::None).err();
    assert_eq!(of(&[]), Some(RenderError::Empty));
    let lost = Standing { tree: &tree, at: Vec3::new(0.0, f32::NAN, 0.0) };
    let first = Standing { tree: &tree, at: Vec3::ZERO };
    let error = of(&[first, lost]).unwrap();
    assert!(matches!(error, RenderError::NotFinite { vertex: 1, .. }), "{error}");
    let bare = Dressed { wood: Mesh::default(), bark: plain_bark(), foliage: Vec::new() };
    assert_eq!(of(&[first, Standing { tree: &bare, at: Vec3::X }]), Some(RenderError::Empty));
}
