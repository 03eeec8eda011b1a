//! How long a picture takes: a grown tree at 512² pixels and 64 paths each, on one thread.
//!
//! `cargo run --release -p deeptree-render --example figures -- oak 7`

#![allow(clippy::unwrap_used, reason = "an example that cannot go on stops")]

use std::time::Instant;

use deeptree_graph::Seed;
use deeptree_growth::{Profile, Species, grow};
use deeptree_mesh::{Dressed, WoodOptions, wood};
use deeptree_render::{Camera, Ground, Light, Options, Scene, View, plain_bark, render};

fn main() {
    let mut words = std::env::args().skip(1);
    let name = words.next().unwrap_or_else(|| "oak".to_owned());
    let seed = words.next().and_then(|word| word.parse().ok()).unwrap_or(7);
    let side = words.next().and_then(|word| word.parse().ok()).unwrap_or(512);
    let species = Species::named(&name).expect("a species");
    let tree = grow(&name, species.parameters(Profile::Reference), Seed(seed)).unwrap().tree;
    let wood = wood(&tree, &WoodOptions::default());
    let dressed = Dressed { wood, bark: plain_bark(), foliage: Vec::new() };

    let start = Instant::now();
    let light = Light::daylight(0.7, -0.9, 3.0).unwrap();
    let scene = Scene::new(&dressed, light, Ground::Meadow).unwrap();
    let camera = Camera::framing(scene.points(), View::Front, 1.0, 0.56).unwrap();
    let built = start.elapsed().as_secs_f64();
    let options = Options { size: [side; 2], samples: 64, error: 0.0, ..Options::default() };
    let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let start = Instant::now();
    let picture = threads.install(|| render(&scene, &camera, &options, |_| ())).unwrap();
    let traced = start.elapsed().as_secs_f64();
    println!(
        "{name} {seed}: {} triangles, built in {built:.2} s; {} paths in {traced:.1} s, {:.2} M/s; \
         mean radiance {:?}",
        dressed.wood.triangle_count(),
        picture.samples,
        picture.samples as f64 / traced / 1e6,
        picture.mean()
    );
}
