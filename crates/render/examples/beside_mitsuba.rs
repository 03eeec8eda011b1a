//! One scene for two renderers: writes the wood of a grown tree, what Mitsuba 3 needs to know of the
//! scene, and our picture of it. `tools/beside_mitsuba.py` renders the same with Mitsuba and compares.
//!
//! `cargo run --release -p deeptree-render --example beside_mitsuba -- FOLDER [ROUGHNESS]`; as rough as bark, 0.7, if none is
//! given.

#![allow(clippy::unwrap_used, reason = "an example that cannot go on stops")]

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

use deeptree_graph::{Seed, Vec3};
use deeptree_growth::{Profile, Species, grow};
use deeptree_mesh::{Dressed, Material, Mesh, WoodOptions, wood};
use deeptree_render::files::exr_bytes;
use deeptree_render::{Camera, Ground, Light, Options, Scene, View, plain_bark, render};

const SIZE: u32 = 256;
const SAMPLES: u32 = 256;
const ANGLE: f32 = 0.56;
const ALBEDO: [f32; 3] = [0.5, 0.35, 0.2];
const GROUND: f32 = 0.3;
const SUN: [f32; 2] = [0.7, -0.9];
const SUN_SHARE: f32 = 0.6;

/// The same triangles with normals of their own: what renderers do where rounded normals turn away
/// from who looks is a matter of taste.
fn faceted(wood: &Mesh) -> Mesh {
    let mut flat = Mesh { internodes: wood.internodes.clone(), ..Mesh::default() };
    for t in wood.indices.as_chunks::<3>().0 {
        let [a, b, c] = t.map(|i| wood.positions[i as usize]);
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
        for &i in t {
            flat.indices.push(flat.positions.len() as u32);
            flat.positions.push(wood.positions[i as usize]);
            flat.normals.push(normal);
            flat.uvs.push(wood.uvs[i as usize]);
            flat.nodes.push(wood.nodes[i as usize]);
        }
    }
    flat
}

fn main() {
    let folder = PathBuf::from(std::env::args().nth(1).expect("a folder"));
    fs::create_dir_all(&folder).unwrap();
    let roughness: f32 = std::env::args().nth(2).map_or(0.7, |text| text.parse().unwrap());
    let species = Species::named("oak").unwrap();
    let tree = grow("oak", species.parameters(Profile::Reference), Seed(7)).unwrap().tree;
    let wood = faceted(&wood(&tree, &WoodOptions::default()));
    let mut obj = String::new();
    for (p, n) in wood.positions.iter().zip(&wood.normals) {
        writeln!(obj, "v {} {} {}\nvn {} {} {}", p.x, p.y, p.z, n.x, n.y, n.z).unwrap();
    }
    for t in wood.indices.as_chunks::<3>().0 {
        let [a, b, c] = t.map(|i| i + 1);
        writeln!(obj, "f {a}//{a} {b}//{b} {c}//{c}").unwrap();
    }
    fs::write(folder.join("wood.obj"), obj).unwrap();

    let color = [ALBEDO[0], ALBEDO[1], ALBEDO[2], 1.0];
    let bark = Material { color, roughness, ..plain_bark() };
    let tree = Dressed { wood, bark, foliage: Vec::new() };
    let light = Light::overcast(SUN[0], SUN[1], SUN_SHARE).unwrap();
    let scene = Scene::new(&tree, light, Ground::Plain(Vec3::splat(GROUND))).unwrap();
    let camera = Camera::framing(scene.points(), View::Quarter, 1.0, ANGLE).unwrap();
    let (from, [_, up, forward]) = (camera.position(), camera.axes());
    let (sin, cos) = SUN[1].sin_cos();
    let (high, flat) = SUN[0].sin_cos();
    let sun = [flat * sin, high, flat * cos];
    let text = format!(
        "{{\"size\": {SIZE}, \"samples\": {SAMPLES}, \"angle\": {ANGLE}, \"albedo\": {ALBEDO:?}, \
         \"alpha\": {}, \"ground\": {GROUND}, \"sun\": {sun:?}, \"sun_irradiance\": {}, \
         \"dome\": {}, \"from\": {:?}, \"up\": {:?}, \"forward\": {:?}}}",
        roughness * roughness,
        std::f32::consts::PI * SUN_SHARE / high,
        1.0 - SUN_SHARE,
        from.to_array(),
        up.to_array(),
        forward.to_array()
    );
    fs::write(folder.join("scene.json"), text).unwrap();

    let options = Options { size: [SIZE; 2], samples: SAMPLES, error: 0.0, ..Options::default() };
    let picture = render(&scene, &camera, &options, |_| ()).unwrap();
    fs::write(folder.join("ours.exr"), exr_bytes(&picture, &[]).unwrap()).unwrap();
    println!("mean radiance {:?}", picture.mean());
}
