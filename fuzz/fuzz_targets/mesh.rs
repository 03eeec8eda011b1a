//! Meshes: any bytes are an error or triangles that answer every question.
#![no_main]

use deeptree_graph::Vec3;
use deeptree_scene::{Scene, SceneMesh, TriangleMesh};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    for file in ["a.obj", "a.glb"] {
        let Ok(mesh) = TriangleMesh::from_bytes(file, bytes) else { continue };
        assert!(mesh.triangles().iter().flatten().all(|corner| corner.is_finite()));
        let Ok(scene) = Scene::new(Vec::new(), vec![SceneMesh { file: file.to_owned(), mesh }])
        else {
            continue;
        };
        let p = Vec3::new(0.5, 2.0, -0.5);
        assert!(!scene.contains(p) || scene.crosses(p, Vec3::ZERO));
        assert!((0.0..=1.0).contains(&scene.sky(p).free));
    }
});
