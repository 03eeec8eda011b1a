//! Trees to be written.

#![allow(dead_code, reason = "each test uses some of it")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

pub(crate) mod npm;

use deeptree_graph::testing::random_tree;
use deeptree_graph::{BranchGraph, NodeId, Quat, Vec3};
use deeptree_mesh::{Blade, Dressed, Foliage, Image, Leaf, Material, WoodOptions, wood};

/// A picture whose pixels all differ from their neighbours.
pub(crate) fn checker(width: u32, height: u32, channels: u8) -> Image {
    let value = |i: u32| (i % 2 * 200 + i / u32::from(channels) % 50) as u8;
    let pixels = (0..width * height * u32::from(channels)).map(value).collect();
    Image { width, height, channels, pixels }
}

/// A normal map that says nothing, but for one pixel.
fn flat(size: u32) -> Image {
    let mut pixels = [128, 128, 255].repeat((size * size) as usize);
    pixels[0] = 140;
    Image { width: size, height: size, channels: 3, pixels }
}

pub(crate) fn bark() -> Material {
    Material {
        name: "test bark".into(),
        color: [0.9, 0.8, 0.7, 1.0],
        color_image: Some(checker(16, 8, 3).into()),
        normal_image: Some(flat(8).into()),
        roughness: 0.9,
        roughness_image: Some(checker(8, 8, 1).into()),
        translucency: 0.0,
        alpha_cutoff: None,
        double_sided: false,
    }
}

pub(crate) fn leaf_material(name: &str) -> Material {
    Material {
        name: name.into(),
        color: [1.0; 4],
        color_image: Some(checker(8, 16, 4).into()),
        normal_image: Some(flat(4).into()),
        roughness: 0.6,
        roughness_image: None,
        translucency: 0.3,
        alpha_cutoff: Some(0.5),
        double_sided: true,
    }
}

/// A quad from the foot to the tip, a length of 1.
pub(crate) fn blade() -> Blade {
    let corner = |x, z| Vec3::new(x, 0.0, z);
    Blade {
        positions: vec![corner(-0.3, 0.0), corner(0.3, 0.0), corner(0.3, -1.0), corner(-0.3, -1.0)],
        normals: vec![Vec3::Y; 4],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        indices: vec![0, 1, 2, 0, 2, 3],
    }
}

/// A leaf at the tip of each node without children, turned some way.
pub(crate) fn leaves(tree: &BranchGraph) -> Vec<Leaf> {
    let leaf = |(i, node): (usize, &deeptree_graph::Node)| Leaf {
        position: node.position,
        rotation: (node.orientation * Quat::from_rotation_y(i as f32)).normalize(),
        scale: 0.1 + 0.01 * (i % 7) as f32,
        node: i as NodeId,
    };
    tree.nodes().iter().enumerate().filter(|(_, node)| node.child_count() == 0).map(leaf).collect()
}

/// A tree with bark and three kinds of leaf, of which the first and the last share a material.
pub(crate) fn dressed(seed: u64, nodes: usize) -> (BranchGraph, Dressed) {
    let tree = random_tree(seed, nodes);
    let mut first = leaves(&tree);
    let mut second = first.split_off(first.len() / 2);
    let third = second.split_off(second.len() / 2);
    let kind = |name, leaves| Foliage {
        blade: blade(),
        leaves,
        material: leaf_material(name),
        woody: false,
    };
    let all = [("test leaf", first), ("other leaf", second), ("test leaf", third)];
    let foliage = all.map(|(name, leaves)| kind(name, leaves)).to_vec();
    let dressed = Dressed { wood: wood(&tree, &WoodOptions::default()), bark: bark(), foliage };
    (tree, dressed)
}
