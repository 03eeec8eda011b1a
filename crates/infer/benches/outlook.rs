//! Codes of environments and expectations a second, on one core.
//!
//! `cargo bench -p deeptree-infer --bench outlook`

use deeptree_graph::signature::outlook::{CHANNELS, CODE, MAPS, OUTPUTS, len};
use deeptree_graph::{Draws, Lineage, Occupancy, Purpose, Seed, TreeTraits, Voxel};
use deeptree_infer::{ModelKind, Outlook, Table, Weights, WeightsBuilder};
use divan::Bencher;

const SPECIES: usize = 8;

fn main() {
    divan::main();
}

/// A table of small random numbers above 0.
fn table(draws: &mut Draws, shape: &[usize]) -> Table {
    let values = (0..shape.iter().product()).map(|_| 0.1 * draws.open_uniform() as f32).collect();
    Table::new(shape.to_vec(), values).expect("as many values as the shape has")
}

fn network() -> Outlook {
    let mut draws = Seed(1).draws(Lineage::ROOT, Purpose::InitialWeights);
    let names = (0..SPECIES).map(|i| format!("species{i}"));
    let mut model = WeightsBuilder::new(ModelKind::Situated, names);
    for (i, pair) in CHANNELS.windows(2).enumerate() {
        let name = format!("outlook.conv{}", i + 1);
        model.table(format!("{name}.weight"), table(&mut draws, &[3, 3, 3, pair[0], pair[1]]));
        model.table(format!("{name}.bias"), table(&mut draws, &[pair[1]]));
    }
    for (name, from, to) in
        [("outlook.code", MAPS, CODE), ("outlook.0", len(SPECIES), 48), ("outlook.1", 48, OUTPUTS)]
    {
        model.table(format!("{name}.weight"), table(&mut draws, &[from, to]));
        model.table(format!("{name}.bias"), table(&mut draws, &[to]));
    }
    for name in ["outlook.mean", "outlook.deviation"] {
        model.table(name, table(&mut draws, &[SPECIES, TreeTraits::STATES]));
    }
    let bytes = model.to_bytes().expect("a file that can be read");
    let weights = Weights::from_bytes(&bytes).expect("what was just written");
    Outlook::read(&weights).expect("all tensors").expect("a network")
}

/// The voxels that `wanted` accepts.
fn grid(wanted: impl Fn(i64, i64, i64) -> bool) -> Occupancy {
    let mut grid = Occupancy::EMPTY;
    for (x, y, z) in (0..32 * 32 * 32).map(|i| (i % 32, i / 32 % 32, i / 1024)) {
        if let Some(voxel) = Voxel::at(x, y, z).filter(|_| wanted(x, y, z)) {
            grid.set(voxel);
        }
    }
    grid
}

fn code(bencher: Bencher<'_, '_>, taken: &Occupancy, shading: &Occupancy) {
    let network = network();
    bencher.bench_local(|| network.code(divan::black_box(taken), divan::black_box(shading)));
}

#[divan::bench]
fn code_of_the_open_field(bencher: Bencher<'_, '_>) {
    code(bencher, &Occupancy::EMPTY, &Occupancy::EMPTY);
}

#[divan::bench]
fn code_of_a_wall(bencher: Bencher<'_, '_>) {
    let wall = grid(|x, y, _| x == 20 && y < 8);
    code(bencher, &wall, &wall);
}

/// Taken but for a cube around the tree.
#[divan::bench]
fn code_of_a_cube(bencher: Bencher<'_, '_>) {
    let outside = grid(|x, y, z| !((11..21).contains(&x) && (11..21).contains(&z) && y < 10));
    code(bencher, &outside, &Occupancy::EMPTY);
}

#[divan::bench]
fn expectation(bencher: Bencher<'_, '_>) {
    let network = network();
    let code = network.code(&Occupancy::EMPTY, &Occupancy::EMPTY);
    bencher.bench_local(|| network.expect(divan::black_box(&code), 3, 30.0, 0.1));
}
