//! Checks the wood of many trees of all species at every level of detail: each edge lies in exactly
//! two faces that run along it in opposite directions, the faces around each vertex are one fan, the
//! surface is one piece without holes, no triangle is degenerate, and the outside is outside.
//!
//!     cargo run --release -p deeptree-mesh --example closed -- 50
//!
//! Trees of the growth model and, of the same seeds, those of the networks that ship. Prints a row
//! for each species, and fails with the first surface that is not so.

#![allow(clippy::unwrap_used, reason = "an example fails by panicking")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use common::{check, double_area};
use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::{Profile, SPECIES, Species, grow};
use deeptree_infer::{Model, Workspace};
use deeptree_mesh::{WoodOptions, wood};

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/situated.safetensors");

/// What was seen of one species.
#[derive(Clone, Copy, Debug)]
struct Seen {
    surfaces: u64,
    triangles: u64,
    /// Area of the smallest triangle in square metres.
    smallest: f32,
}

impl Seen {
    const NOTHING: Self = Self { surfaces: 0, triangles: 0, smallest: f32::INFINITY };

    fn and(self, other: Self) -> Self {
        Self {
            surfaces: self.surfaces + other.surfaces,
            triangles: self.triangles + other.triangles,
            smallest: self.smallest.min(other.smallest),
        }
    }
}

fn main() {
    let seeds: u64 = std::env::args().nth(1).map_or(50, |text| text.parse().unwrap());
    let model = Model::from_bytes(&std::fs::read(MODEL).unwrap()).unwrap();
    let began = Instant::now();
    let mut all = Seen::NOTHING;
    println!("species    trees  surfaces  triangles  smallest, mm²");
    for species in SPECIES {
        let seen = on_threads(seeds, |seed, work| {
            let request = Request::new(species, Seed(seed));
            let learned = generate(&model, &request, Limits::default(), work).unwrap().tree;
            let named = |source| format!("{species} {seed}, {source}");
            levels(&grown(species, seed), &named("growth model"))
                .and(levels(&learned, &named("networks")))
        });
        row(species, 2 * seeds, seen);
        all = all.and(seen);
    }
    row("all", 2 * seeds * SPECIES.len() as u64, all);
    println!("all closed, edge-manifold and of one piece; {:.0} s", began.elapsed().as_secs_f64());
}

fn row(name: &str, trees: u64, seen: Seen) {
    let Seen { surfaces, triangles, smallest } = seen;
    println!("{name:10} {trees:5}  {surfaces:8}  {triangles:9}  {:.5}", smallest * 1e6);
}

fn grown(species: &str, seed: u64) -> BranchGraph {
    let preset = Species::named(species).unwrap();
    grow(species, preset.parameters(Profile::default()), Seed(seed)).unwrap().tree
}

/// The wood of a tree at each level of detail.
fn levels(tree: &BranchGraph, name: &str) -> Seen {
    let one = |level| {
        let mesh = wood(tree, &WoodOptions::lod(level));
        if let Err(error) = check(&mesh) {
            panic!("{name}, level {level}: {error}");
        }
        assert!(mesh.volume() > 0.0, "{name}, level {level}: inside out");
        let smallest = mesh.triangles().map(double_area).fold(f32::INFINITY, f32::min) / 2.0;
        Seen { surfaces: 1, triangles: mesh.triangle_count() as u64, smallest }
    };
    (0..4).map(one).fold(Seen::NOTHING, Seen::and)
}

/// Does something with all seeds on all threads.
fn on_threads(seeds: u64, one: impl Fn(u64, &mut Workspace) -> Seen + Sync) -> Seen {
    let next = AtomicU64::new(0);
    let turn = || {
        let mut work = Workspace::default();
        let mut seen = Seen::NOTHING;
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds {
                return seen;
            }
            seen = seen.and(one(seed, &mut work));
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let turns: Vec<_> = (0..threads).map(|_| scope.spawn(turn)).collect();
        turns.into_iter().map(|turn| turn.join().unwrap()).fold(Seen::NOTHING, Seen::and)
    })
}
