//! Rows per second of the kernels, by SIMD path and batch size, on one core. Random weights leave half
//! of the hidden activations above zero; trained ones of kind `situated` leave a fifth.
//!
//! `cargo bench -p deeptree-infer`. Compare paths within one run only.

use deeptree_graph::{Draws, Lineage, Purpose, Seed};
use deeptree_infer::{Dense, Mlp, Scratch, SimdPath};
use divan::{Bencher, counter::ItemsCount};

const BATCHES: [usize; 3] = [1, 16, 512];

fn main() {
    divan::main();
}

fn values(draws: &mut Draws, count: usize) -> Vec<f32> {
    (0..count).map(|_| draws.uniform() as f32 - 0.5).collect()
}

fn network(widths: &[usize]) -> Mlp {
    let mut draws = Seed(1).draws(Lineage::ROOT, Purpose::InitialWeights);
    let layers = widths
        .windows(2)
        .map(|w| {
            let weight = values(&mut draws, w[0] * w[1]);
            Dense::new(w[0], w[1], &weight, &values(&mut draws, w[1])).expect("a valid layer")
        })
        .collect();
    Mlp::new(layers).expect("a valid network")
}

fn cases() -> Vec<(SimdPath, usize)> {
    let with_batches = |path| BATCHES.map(|batch| (path, batch));
    SimdPath::available().into_iter().flat_map(with_batches).collect()
}

/// Of the inputs of a row about `share` are not zero.
fn bench(bencher: Bencher<'_, '_>, widths: &[usize], share: f64, (path, rows): (SimdPath, usize)) {
    let mlp = network(widths);
    let mut draws = Seed(2).draws(Lineage::ROOT, Purpose::Evaluation);
    let mut inputs = values(&mut draws, rows * mlp.inputs());
    inputs.iter_mut().for_each(|x| *x = if draws.uniform() < share { *x } else { 0.0 });
    let mut scratch = Scratch::new();
    bencher
        .counter(ItemsCount::new(rows))
        .bench_local(move || mlp.forward(path, divan::black_box(&inputs), &mut scratch)[0]);
}

/// 56 k weights: a network of the paper's size; all but one of eight species are zero.
#[divan::bench(args = cases().into_iter().map(Case), max_time = 0.5)]
fn paper(bencher: Bencher<'_, '_>, case: &Case) {
    bench(bencher, &[23, 160, 160, 160, 6], 0.7, case.0);
}

/// 46 k weights: wide input, mostly one-hots; a distribution as output.
#[divan::bench(args = cases().into_iter().map(Case), max_time = 0.5)]
fn situated(bencher: Bencher<'_, '_>, case: &Case) {
    bench(bencher, &[200, 128, 128, 32], 0.33, case.0);
}

struct Case((SimdPath, usize));

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, batch {}", self.0.0, self.0.1)
    }
}
