//! Time of one grown tree, by species: `cargo bench -p deeptree-growth`.

use deeptree_graph::Seed;
use deeptree_growth::{Profile, SPECIES, Species, grow};

fn main() {
    divan::main();
}

/// Each sample grows the tree of the next seed, so the mean is one over trees.
#[divan::bench(args = SPECIES, sample_count = 30, sample_size = 1)]
fn tree(bencher: divan::Bencher<'_, '_>, species: &str) {
    let preset = Species::named(species).expect("a species of the list");
    let mut seed = 0;
    bencher
        .with_inputs(|| {
            seed += 1;
            Seed(seed)
        })
        .bench_local_values(|seed| grow(species, preset.parameters(Profile::Reference), seed));
}
