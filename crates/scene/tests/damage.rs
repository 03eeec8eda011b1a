//! Damaged scene and mesh files: errors, or scenes that answer; never a panic.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use std::path::Path;

use deeptree_graph::testing::mutated;
use deeptree_graph::{Seed, Vec3};
use deeptree_scene::{Environment, Scene, SceneMesh, TriangleMesh};

/// Asks a scene everything.
fn ask(scene: &Scene) {
    let point = Vec3::new(0.3, 2.0, -0.4);
    assert!(!scene.contains(point) || scene.crosses(point, Vec3::ZERO));
    assert!((0.0..=1.0).contains(&scene.sky(point).free));
    assert!(!scene.is_empty() || scene.occupancy().is_empty());
}

fn ask_mesh(name: &str, bytes: &[u8]) {
    let Ok(mesh) = TriangleMesh::from_bytes(name, bytes) else { return };
    let mesh = SceneMesh { file: name.to_owned(), mesh };
    if let Ok(scene) = Scene::new(Vec::new(), vec![mesh]) {
        ask(&scene);
    }
}

/// Corners and faces of a wedge beside the tree.
const WEDGE: &str = "o wedge\nv 2 0 -4\nv 2 0 4\nv 5 0 4\nv 5 0 -4\nv 5 6 4\nv 5 6 -4\n\
                     f 1 4 3 2\nf 3 4 6 5\nf 1 2 5 6\nf 2 3 5\nf 1 6 4\n";

fn glb() -> Vec<u8> {
    let json = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0,"translation":[4,0,0],"children":[1]},{"mesh":0,"scale":[2,3,1]}],
        "meshes":[{"primitives":[{"mode":4,"attributes":{"POSITION":0},"indices":1}]}],
        "accessors":[
          {"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
          {"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],
        "buffers":[{"byteLength":72}]}"#;
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut numbers: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    numbers.extend([0u16, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    let word = |value: usize| (value as u32).to_le_bytes();
    let total = 12 + 8 + json.len() + 8 + numbers.len();
    let mut file = [&b"glTF"[..], &word(2), &word(total), &word(json.len()), b"JSON"].concat();
    file.extend(json);
    file.extend(word(numbers.len()));
    file.extend(b"BIN\0");
    file.extend(numbers);
    file
}

#[test]
fn a_whole_file_of_each_format_is_a_solid_mesh() {
    for (name, bytes, faces) in [("a.obj", WEDGE.as_bytes().to_vec(), 8), ("a.glb", glb(), 8)] {
        let mesh = TriangleMesh::from_bytes(name, &bytes).unwrap();
        assert_eq!((mesh.triangles().len(), mesh.open_edges()), (faces, 0), "{name}");
    }
}

#[test]
fn damaged_files_are_errors_or_scenes() {
    let glb = glb();
    for seed in 0..6000 {
        ask_mesh("a.obj", &mutated(WEDGE.as_bytes(), seed));
        ask_mesh("a.glb", &mutated(&glb, seed));
        let text = Scene::random(Seed(seed % 50)).to_toml();
        let text = mutated(text.as_bytes(), seed);
        if let Ok(scene) = Scene::parse(&String::from_utf8_lossy(&text), Path::new("")) {
            ask(&scene);
            assert_eq!(Scene::parse(&scene.to_toml(), Path::new("")).unwrap(), scene);
        }
        let _ = Environment::parse(&String::from_utf8_lossy(&text), Path::new(""));
    }
}
