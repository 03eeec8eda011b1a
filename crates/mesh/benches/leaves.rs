//! How fast trees are dressed: pictures by their size, shoots a second.

use deeptree_graph::Seed;
use deeptree_growth::{Profile, Species, grow};
use deeptree_mesh::{Look, Mesh, Wardrobe};
use divan::Bencher;
use divan::counter::ItemsCount;

/// The pictures of leaves and bark of one species, by pixels a side.
#[divan::bench(args = [256, 512, 1024, 2048], sample_count = 3, sample_size = 1)]
fn pictures(bencher: Bencher, texture_size: u32) {
    let look = Look { texture_size, ..Look::default() };
    bencher.bench(|| Wardrobe::new("oak", &look));
}

/// Shoots a second on a grown oak, with the smallest pictures.
#[divan::bench(sample_count = 10, sample_size = 1)]
fn shoots(bencher: Bencher) {
    let Some(oak) = Species::named("oak") else { return };
    let Ok(grown) = grow("oak", oak.parameters(Profile::default()), Seed(1)) else { return };
    let look = Look { texture_size: 256, ..Look::default() };
    let Ok(wardrobe) = Wardrobe::new("oak", &look) else { return };
    let dress = || wardrobe.dress(&grown.tree, Mesh::default(), 0);
    let count: usize = dress().foliage.iter().map(|foliage| foliage.leaves.len()).sum();
    bencher.counter(ItemsCount::new(count)).bench(dress);
}

fn main() {
    divan::main();
}
