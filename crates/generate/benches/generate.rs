//! Time of one generated tree, and nodes a second on each instruction set:
//! `cargo bench -p deeptree-generate`.

use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::Seed;
use deeptree_infer::{Model, SimdPath, Workspace};

const MODELS: [(&str, &[u8]); 2] = [
    ("situated", include_bytes!("../../../models/situated.safetensors")),
    ("paper", include_bytes!("../../../models/paper.safetensors")),
];

fn main() {
    divan::main();
}

fn model(name: &str) -> Model {
    let bytes = MODELS.iter().find(|(known, _)| *known == name).map_or(MODELS[0].1, |m| m.1);
    Model::from_bytes(bytes).expect("a model that ships is whole")
}

fn request(species: &str, seed: u64) -> Request {
    Request::new(species, Seed(seed))
}

/// Each sample generates the tree of the next seed, so the mean is one over trees.
#[divan::bench(args = ["beech", "corkscrew", "maple", "oak", "pine", "tulip", "walnut", "willow"], sample_count = 30, sample_size = 1)]
fn tree(bencher: divan::Bencher<'_, '_>, species: &str) {
    let model = model("situated");
    let mut work = Workspace::default();
    let mut seed = 0;
    bencher
        .with_inputs(|| {
            seed += 1;
            request(species, seed)
        })
        .bench_local_values(|request| generate(&model, &request, Limits::default(), &mut work));
}

/// One oak of the shipped model: nodes a second.
#[divan::bench(args = SimdPath::available(), sample_count = 10, sample_size = 1)]
fn situated_nodes(bencher: divan::Bencher<'_, '_>, path: SimdPath) {
    nodes(bencher, "situated", path);
}

/// The first 5 000 nodes of an oak of the published kind, which does not end: nodes a second.
#[divan::bench(args = SimdPath::available(), sample_count = 10, sample_size = 1)]
fn paper_nodes(bencher: divan::Bencher<'_, '_>, path: SimdPath) {
    nodes(bencher, "paper", path);
}

fn nodes(bencher: divan::Bencher<'_, '_>, kind: &str, path: SimdPath) {
    let model = model(kind);
    let mut work = Workspace::new(path);
    let limits = Limits { budget: 5_000, ..Limits::default() };
    let request = request("oak", 7);
    let grown = generate(&model, &request, limits, &mut work).expect("the model knows its species");
    bencher
        .counter(divan::counter::ItemsCount::new(grown.tree.len()))
        .bench_local(|| generate(&model, &request, limits, &mut work));
}
