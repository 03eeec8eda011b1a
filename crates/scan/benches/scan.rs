//! Points a second of each pattern, on one thread unless the feature `parallel` is on.
#![allow(missing_docs, reason = "the macros of divan make items")]
#![allow(clippy::unwrap_used, reason = "a benchmark without its tree has failed")]

use deeptree_graph::Seed;
use deeptree_growth::{Profile, Species, grow};
use deeptree_mesh::{WoodOptions, wood};
use deeptree_scan::{Kind, Pattern, Target, scan};
use divan::Bencher;
use divan::counter::ItemsCount;

fn main() {
    divan::main();
}

fn oak() -> Target {
    let parameters = Species::named("oak").unwrap().parameters(Profile::Reference).clone();
    let tree = grow("oak", &parameters, Seed(3)).unwrap().tree;
    Target::new(&tree, &wood(&tree, &WoodOptions::default()), &[])
}

#[divan::bench(args = [Kind::Paper, Kind::Terrestrial, Kind::Mobile, Kind::Airborne], sample_count = 3, sample_size = 1)]
fn points_of_an_oak(bencher: Bencher<'_, '_>, kind: Kind) {
    let target = oak();
    let pattern = Pattern::usual(kind);
    let points = scan(&target, &pattern, Seed(1)).len();
    bencher
        .counter(ItemsCount::new(points))
        .bench_local(|| scan(divan::black_box(&target), &pattern, Seed(1)));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn hierarchy_of_an_oak(bencher: Bencher<'_, '_>) {
    let parameters = Species::named("oak").unwrap().parameters(Profile::Reference).clone();
    let tree = grow("oak", &parameters, Seed(3)).unwrap().tree;
    let mesh = wood(&tree, &WoodOptions::default());
    let count = ItemsCount::new(mesh.triangle_count());
    bencher.counter(count).bench_local(|| Target::new(divan::black_box(&tree), &mesh, &[]));
}
