//! Scenes: any text is an error or a scene that reads back as the same and answers every question.
#![no_main]

use std::path::Path;

use deeptree_graph::Vec3;
use deeptree_scene::{Environment, Scene};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    // A folder that is not there: no file is read.
    let nowhere = Path::new("/nonexistent");
    if let Ok(scene) = Scene::parse(text, nowhere) {
        let grid = scene.occupancy();
        for p in [Vec3::ZERO, Vec3::new(3.0, 8.0, -2.0), Vec3::new(-31.0, 63.0, 31.0)] {
            assert!(!scene.contains(p) || scene.crosses(p, Vec3::ZERO));
            assert!((0.0..=1.0).contains(&scene.sky(p).free));
        }
        assert!(!scene.is_empty() || grid.is_empty());
        assert_eq!(Scene::parse(&scene.to_toml(), nowhere).expect("it was written"), scene);
    }
    if let Ok(environment) = Environment::parse(text, nowhere) {
        let again = Environment::parse(&environment.to_toml(), nowhere).expect("it was written");
        assert_eq!(again, environment);
    }
});
