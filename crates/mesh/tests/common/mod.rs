//! What a closed surface is, and trees of all kinds.

#![allow(dead_code, reason = "no test file uses everything")]

use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
use deeptree_mesh::{MIN_RADIUS, Mesh};
use proptest::prelude::*;

/// Edges of all kinds: straight on, straight back, right angles, anywhere; lengths and radii from 0.
pub(crate) fn signature() -> impl Strategy<Value = ChildSignature> {
    let angle = || {
        prop_oneof![
            2 => Just(0.0f32),
            1 => Just(core::f32::consts::PI),
            1 => Just(core::f32::consts::FRAC_PI_2),
            6 => -3.2f32..3.2,
        ]
    };
    let size = |most: f32| prop_oneof![1 => Just(0.0f32), 2 => 0.0..0.01f32, 6 => 0.0..most];
    (angle(), angle(), size(0.5), size(2.0)).prop_map(|(yaw, pitch, thickness, length)| {
        let rotation = Quat::from_rotation_z(yaw) * Quat::from_rotation_x(pitch);
        ChildSignature { rotation, thickness, length }
    })
}

prop_compose! {
    pub(crate) fn signature_tree()(
        root in signature(),
        branchlets in proptest::collection::vec(
            (any::<prop::sample::Index>(), proptest::array::uniform3(proptest::option::of(signature()))),
            0..30,
        ),
    ) -> BranchGraph {
        let info = TreeInfo { species: "random".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, root);
        for (at, children) in branchlets {
            let at = at.index(tree.len()) as u32;
            if tree.node(at).child_count() == 0 {
                tree.grow(at, children);
            }
        }
        tree
    }
}

/// Twice the area of a triangle.
pub(crate) fn double_area([a, b, c]: [Vec3; 3]) -> f32 {
    (b - a).cross(c - a).length()
}

/// The bits of all that a mesh draws.
pub(crate) fn words(mesh: &Mesh) -> Vec<u32> {
    let floats = |v: &[Vec3]| v.iter().flat_map(|p| p.to_array()).map(f32::to_bits).collect();
    let positions: Vec<u32> = floats(&mesh.positions);
    let normals: Vec<u32> = floats(&mesh.normals);
    let uvs = mesh.uvs.as_flattened().iter().map(|x| x.to_bits()).collect();
    [positions, normals, uvs, mesh.indices.clone()].concat()
}

/// FNV-1a over the bytes of some words.
pub(crate) fn hash(words: &[u32]) -> u64 {
    words.iter().flat_map(|word| word.to_le_bytes()).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// What holds of the wood of any tree: each edge has two faces, one to each side; the faces around
/// each vertex are one fan; one piece with the Euler characteristic of a sphere; no degenerate
/// triangle; copies stand where their originals do.
pub(crate) fn check(mesh: &Mesh) -> Result<(), TestCaseError> {
    let welded = mesh.welded();
    for &[copy, original] in &mesh.seams {
        let place = |i: u32| mesh.positions[i as usize].to_array().map(f32::to_bits);
        prop_assert_eq!(place(copy), place(original));
    }
    // Half edges by their ends, each with the third corner of its face.
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(welded.len());
    for t in welded.chunks(3) {
        prop_assert!(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        edges.extend([([t[0], t[1]], t[2]), ([t[1], t[2]], t[0]), ([t[2], t[0]], t[1])]);
    }
    edges.sort_unstable();
    let find = |a: u32, b: u32| edges.binary_search_by_key(&[a, b], |edge| edge.0).ok();
    for pair in edges.windows(2) {
        prop_assert!(pair[0].0 != pair[1].0, "edge {:?} is run along twice", pair[0].0);
    }
    for &([a, b], _) in &edges {
        prop_assert!(find(b, a).is_some(), "edge {a}-{b} is open");
    }

    // Around each vertex: following faces from one to the next must visit all of them in one turn.
    let mut vertices = 0;
    for fan in edges.chunk_by(|a, b| a.0[0] == b.0[0]) {
        let ([v, start], _) = fan[0];
        let (mut at, mut steps) = (start, 0);
        loop {
            at = edges[find(v, at).unwrap()].1;
            steps += 1;
            if at == start || steps > fan.len() {
                break;
            }
        }
        prop_assert_eq!(steps, fan.len(), "vertex {} has several fans", v);
        vertices += 1;
    }

    // One piece: union of the corners of all faces.
    let mut piece: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    fn root(piece: &mut [u32], mut i: u32) -> u32 {
        while piece[i as usize] != i {
            piece[i as usize] = piece[piece[i as usize] as usize];
            i = piece[i as usize];
        }
        i
    }
    for t in welded.chunks(3) {
        for pair in t.windows(2) {
            let (a, b) = (root(&mut piece, pair[0]), root(&mut piece, pair[1]));
            piece[a as usize] = b;
        }
    }
    let own = |fan: &[([u32; 2], u32)]| piece[fan[0].0[0] as usize] == fan[0].0[0];
    let pieces = edges.chunk_by(|a, b| a.0[0] == b.0[0]).filter(|fan| own(fan)).count();
    prop_assert_eq!(pieces, 1);
    let faces = welded.len() as i64 / 3;
    prop_assert_eq!(vertices - edges.len() as i64 / 2 + faces, 2);

    prop_assert!(mesh.positions.iter().all(|p| p.is_finite()));
    prop_assert!(mesh.uvs.iter().flatten().all(|x| x.is_finite()));
    for normal in &mesh.normals {
        prop_assert!((normal.length() - 1.0).abs() < 1e-3, "{normal}");
    }
    for (i, corners) in mesh.triangles().enumerate() {
        // The thinnest sliver of a ring of the smallest radius is far above this.
        let least = 1e-6 * MIN_RADIUS * MIN_RADIUS;
        prop_assert!(double_area(corners) > least, "triangle {i}: {corners:?}");
    }
    prop_assert!(mesh.indices.iter().all(|&i| (i as usize) < mesh.vertex_count()));
    prop_assert_eq!(mesh.nodes.len(), mesh.vertex_count());
    Ok(())
}
