//! Every path gives the bits of the scalar one, for any shape and any split of a batch.
#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{bits, draws, layers, mlp, values};
use deeptree_infer::{Scratch, SimdPath};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..Default::default() })]

    #[test]
    fn every_path_gives_the_bits_of_the_scalar_path(
        seed: u64,
        widths in prop::collection::vec(1usize..300, 2..5),
        rows in 0usize..140,
    ) {
        let mut draws = draws(seed);
        let mlp = mlp(&layers(&mut draws, &widths));
        let inputs = values(&mut draws, rows * widths[0], 1.0);
        let mut scratch = Scratch::new();
        let expected = bits(mlp.forward(SimdPath::Scalar, &inputs, &mut scratch));
        prop_assert_eq!(expected.len(), rows * mlp.outputs());
        for path in SimdPath::available() {
            prop_assert_eq!(&expected, &bits(mlp.forward(path, &inputs, &mut scratch)), "{}", path);
        }
    }

    #[test]
    fn a_row_does_not_depend_on_the_rows_beside_it(
        seed: u64,
        widths in prop::collection::vec(1usize..100, 2..5),
        rows in 1usize..140,
        split in 1usize..140,
    ) {
        let mut draws = draws(seed);
        let mlp = mlp(&layers(&mut draws, &widths));
        let inputs = values(&mut draws, rows * widths[0], 1.0);
        let mut scratch = Scratch::new();
        for path in SimdPath::available() {
            let whole = bits(mlp.forward(path, &inputs, &mut scratch));
            for size in [1, split] {
                let parts: Vec<u32> = inputs
                    .chunks(size * widths[0])
                    .flat_map(|part| bits(mlp.forward(path, part, &mut scratch)))
                    .collect();
                prop_assert_eq!(&whole, &parts, "{} in parts of {}", path, size);
            }
        }
    }
}

/// A layer by its formula, zeros and all, in index order.
fn full_sum((inputs, outputs, weight, bias): &common::Numbers, x: &[f32]) -> Vec<f32> {
    let mut y = bias.clone();
    for i in 0..*inputs {
        for o in 0..*outputs {
            y[o] += x[i] * weight[i * outputs + o];
        }
    }
    y
}

#[test]
fn leaving_zeros_out_changes_no_sum() {
    let mut scratch = Scratch::new();
    for (case, kept) in [0, 1, 2, 8, 60, 199, 200].into_iter().enumerate() {
        let mut draws = draws(case as u64);
        let layers = layers(&mut draws, &[200, 97, 50, 7]);
        let mut inputs = values(&mut draws, 40 * 200, 1.0);
        for row in inputs.chunks_exact_mut(200) {
            // The order of 200 draws is a random one; the first of it are kept.
            let keys = values(&mut draws, 200, 1.0);
            let mut order: Vec<usize> = (0..200).collect();
            order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
            order[kept..].iter().for_each(|&i| row[i] = if i % 2 == 0 { 0.0 } else { -0.0 });
        }
        for depth in 1..=3 {
            let rows = inputs.chunks_exact(200).flat_map(|row| {
                let mut x = row.to_vec();
                for (i, layer) in layers[..depth].iter().enumerate() {
                    if i > 0 {
                        x.iter_mut().for_each(|v| *v = if *v > 0.0 { *v } else { 0.0 });
                    }
                    x = full_sum(layer, &x);
                }
                x
            });
            let expected: Vec<f32> = rows.collect();
            let mlp = mlp(&layers[..depth]);
            for path in SimdPath::available() {
                // As numbers: the sign of a zero may differ.
                let got = mlp.forward(path, &inputs, &mut scratch);
                assert!(got == expected, "{path}, {kept} of 200 inputs, {depth} layers");
            }
        }
    }
}

#[test]
fn every_count_of_rows_and_of_outputs_near_a_block_edge_gives_the_scalar_bits() {
    let mut scratch = Scratch::new();
    for outputs in [1, 15, 16, 17, 31, 32, 33, 48, 63, 64, 65, 96, 129] {
        let mut draws = draws(outputs as u64);
        let mlp = mlp(&layers(&mut draws, &[5, outputs, 3]));
        for rows in 0..70 {
            let inputs = values(&mut draws, rows * 5, 1.0);
            let expected = bits(mlp.forward(SimdPath::Scalar, &inputs, &mut scratch));
            for path in SimdPath::available() {
                let got = bits(mlp.forward(path, &inputs, &mut scratch));
                assert_eq!(got, expected, "{path}, {rows} rows, {outputs} outputs");
            }
        }
    }
}

/// Signed zeros, subnormals, and what multiplies or adds up to them.
const SPECIAL: [f32; 11] =
    [0.0, -0.0, 1e-45, -1e-45, 1.1e-38, -1.1e-38, f32::MIN_POSITIVE, 1e-20, -1e-20, 1.0, -1.0];

#[test]
fn subnormals_and_signed_zeros_give_the_scalar_bits() {
    let n = SPECIAL.len();
    let cycle = |count: usize| -> Vec<f32> { SPECIAL.into_iter().cycle().take(count).collect() };
    // The first layer meets every combination of input, weight and bias.
    let biases = (0..n * n).map(|o| SPECIAL[o / n]).collect();
    let layers: Vec<common::Numbers> =
        vec![(1, n * n, cycle(n * n), biases), (n * n, 33, cycle(n * n * 33), cycle(33))];
    let inputs = cycle(70);
    let mut scratch = Scratch::new();
    for depth in 1..=2 {
        let mlp = mlp(&layers[..depth]);
        let expected = bits(mlp.forward(SimdPath::Scalar, &inputs, &mut scratch));
        if depth == 1 {
            for b in [0, 0x8000_0000, 1, 0x8000_0001] {
                assert!(expected.contains(&b), "{b:#x} was not met");
            }
        }
        for path in SimdPath::available() {
            assert_eq!(bits(mlp.forward(path, &inputs, &mut scratch)), expected, "{path}");
        }
    }
}

#[test]
fn the_rectifier_gives_plus_zero_for_minus_zero() {
    // −0 through the first layer; then 0 · −1 = −0 if the rectifier gave +0, but +0 if it gave −0.
    let layers: [common::Numbers; 2] =
        [(1, 40, vec![-0.0; 40], vec![-0.0; 40]), (40, 1, vec![-1.0; 40], vec![-0.0])];
    for path in SimdPath::available() {
        let out = mlp(&layers).forward(path, &[1.0; 9], &mut Scratch::new()).to_vec();
        assert_eq!(bits(&out), [0x8000_0000; 9], "{path}");
    }
}
