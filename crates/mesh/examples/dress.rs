//! Dresses a grown tree and writes what it is made of: pictures as PNG, leaves and wood as OBJ.
//!
//!     cargo run --release -p deeptree-mesh --example dress -- oak autumn 1024 0 out
//!
//! Prints the leaf area and the leaf area index, which is 3 to 8 for closed crowns of broad leaves.

#![allow(clippy::unwrap_used, reason = "an example fails by panicking")]

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use deeptree_graph::Seed;
use deeptree_growth::{Profile, Species, grow};
use deeptree_mesh::{Dressed, Image, Look, Season, WoodOptions, dress, wood};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize, other: &str| words.get(k).map_or(other, |w| w).to_owned();
    let species = word(0, "oak");
    let season = word(1, "summer");
    let season = Season::ALL.into_iter().find(|s| s.name() == season).unwrap();
    let texture_size = word(2, "1024").parse().unwrap();
    let lod = word(3, "0").parse().unwrap();
    let folder = word(4, "dressed");
    let health = word(5, "1").parse().unwrap();
    let seed = word(6, "1").parse().unwrap();
    let parameters = Species::named(&species).unwrap().parameters(Profile::Reference).clone();
    let tree = grow(&species, &parameters, Seed(seed)).unwrap().tree;
    let mesh = wood(&tree, &WoodOptions::lod(lod));
    let began = Instant::now();
    let look = Look { season, texture_size, lod, health, ..Look::default() };
    let dressed = dress(&tree, mesh, &look).unwrap();
    let took = began.elapsed();

    println!("{species} {}: dressed in {:.2} s", season.name(), took.as_secs_f64());
    let triangles = dressed.wood.triangle_count();
    println!("  wood: {triangles} triangles");
    for foliage in &dressed.foliage {
        let shoots = foliage.leaves.len();
        let triangles = foliage.blade.indices.len() / 3;
        println!("  {shoots} shoots of {triangles} triangles: {}", shoots * triangles);
    }
    println!("  {:.0} m² of leaves, index {:.1}", dressed.leaf_area(), dressed.leaf_area_index());

    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder).unwrap();
    let name = |what: &str| folder.join(format!("{species}-{what}"));
    let mut materials = vec![("bark", &dressed.bark)];
    materials.extend(dressed.foliage.first().map(|f| ("leaf", &f.material)));
    for (what, material) in materials {
        for (kind, image) in [
            ("color", &material.color_image),
            ("normal", &material.normal_image),
            ("roughness", &material.roughness_image),
        ] {
            if let Some(image) = image {
                png(image, &name(&format!("{what}-{kind}.png")));
            }
        }
    }
    obj(&dressed, &name("wood.obj"), &name("leaves.obj"));
}

fn png(image: &Image, path: &Path) {
    let out = BufWriter::new(File::create(path).unwrap());
    let mut encoder = png::Encoder::new(out, image.width, image.height);
    encoder.set_color(match image.channels {
        1 => png::ColorType::Grayscale,
        3 => png::ColorType::Rgb,
        _ => png::ColorType::Rgba,
    });
    encoder.set_compression(png::Compression::Fast);
    encoder.write_header().unwrap().write_image_data(&image.pixels).unwrap();
}

fn obj(dressed: &Dressed, wood: &Path, leaves: &Path) {
    let mut out = BufWriter::new(File::create(wood).unwrap());
    let mesh = &dressed.wood;
    for ((p, n), [u, v]) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs) {
        let lines = format!("v {} {} {}\nvn {} {} {}\nvt {u} {v}", p.x, p.y, p.z, n.x, n.y, n.z);
        writeln!(out, "{lines}").unwrap();
    }
    for t in mesh.indices.as_chunks::<3>().0 {
        let [a, b, c] = t.map(|i| i + 1);
        writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").unwrap();
    }
    let mut out = BufWriter::new(File::create(leaves).unwrap());
    let mut first = 1;
    for foliage in &dressed.foliage {
        let blade = &foliage.blade;
        for leaf in &foliage.leaves {
            for ((&p, &n), [u, v]) in blade.positions.iter().zip(&blade.normals).zip(&blade.uvs) {
                let p = leaf.place(p);
                let n = leaf.rotation * n;
                let (a, b) = (format!("v {:.4} {:.4} {:.4}", p.x, p.y, p.z), n);
                writeln!(out, "{a}\nvn {:.3} {:.3} {:.3}\nvt {u:.4} {v:.4}", b.x, b.y, b.z)
                    .unwrap();
            }
            for t in blade.indices.as_chunks::<3>().0 {
                let [a, b, c] = t.map(|i| i + first);
                writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").unwrap();
            }
            first += blade.positions.len() as u32;
        }
    }
}
