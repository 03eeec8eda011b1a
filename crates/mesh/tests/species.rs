//! The wood of grown trees of all species: closed at every level of detail, and as large as their
//! internodes.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::check;
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::{Profile, SPECIES, Species, grow};
use deeptree_mesh::{Mesh, WoodOptions, within, wood};

fn grown(name: &str, seed: u64) -> BranchGraph {
    let species = Species::named(name).unwrap();
    grow(name, species.parameters(Profile::default()), Seed(seed)).unwrap().tree
}

/// How many trees of each species: one, or as many as `DEEPTREE_MESH_SEEDS` says.
fn seeds() -> u64 {
    std::env::var("DEEPTREE_MESH_SEEDS").map_or(1, |text| text.parse().unwrap())
}

/// The share of triangles that face away from the normals at their corners.
fn turned_over(mesh: &Mesh) -> f64 {
    let over = mesh.indices.chunks(3).filter(|t| {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| mesh.positions[i as usize]);
        let face = (b - a).cross(c - a).normalize();
        let normals = t.iter().map(|&i| mesh.normals[i as usize]);
        normals.sum::<deeptree_graph::Vec3>().dot(face) < 0.0
    });
    over.count() as f64 / mesh.triangle_count() as f64
}

#[test]
fn all_species_have_closed_wood_at_every_level() {
    for species in SPECIES {
        for seed in 0..seeds() {
            let tree = grown(species, seed);
            let counts: Vec<usize> = (0..4)
                .map(|level| {
                    let mesh = wood(&tree, &WoodOptions::lod(level));
                    check(&mesh).unwrap();
                    let over = turned_over(&mesh);
                    // Where tubes of three sides turn, corners hide what faces do.
                    let most = if level < 2 { 0.01 } else { 0.03 };
                    assert!(over < most, "{species} {seed} {level}: {over}");
                    mesh.triangle_count()
                })
                .collect();
            assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
            let bark = WoodOptions { bark: 0.02, ..WoodOptions::default() };
            check(&wood(&tree, &bark)).unwrap();
            let few = counts[3] / 2;
            let mesh = within(&tree, few, &WoodOptions::default(), wood).unwrap();
            check(&mesh).unwrap();
            assert!(mesh.triangle_count() <= few);
        }
    }
}

#[test]
fn the_volume_is_that_of_the_internodes() {
    // Round and fine, without flare and collars: what is left is the tree's own shape.
    let options = WoodOptions {
        min_sides: 24,
        max_sides: 48,
        tolerance: 1e-4,
        axis_tolerance: 1e-3,
        fluting: 0.0,
        foot_flare: 1.0,
        collar: 1.0,
        ..WoodOptions::default()
    };
    for species in SPECIES {
        let tree = grown(species, 5);
        // Frusta from node to node along branches; a lateral starts as thick as it ends.
        let frusta: f64 = tree
            .nodes()
            .iter()
            .map(|node| {
                let r = f64::from(node.thickness);
                let parent = node.parent.map(|id| f64::from(tree.node(id).thickness));
                let s = parent.filter(|_| node.slot == 0).unwrap_or(r);
                core::f64::consts::PI * f64::from(node.length) * (r * r + r * s + s * s) / 3.0
            })
            .sum();
        let volume = wood(&tree, &options).volume();
        println!("{}: {volume:.3} of {frusta:.3} m³, {:.3}", species, volume / frusta);
        // Laterals lose what lies in their parents, and twigs taper.
        assert!((0.88..1.02).contains(&(volume / frusta)), "{}", species);
    }
}
