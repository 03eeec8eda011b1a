//! The networks compute what they should, and keep computing it.
#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{Numbers, draws, layers, mlp, values};
use deeptree_infer::{Dense, Mlp, MlpError, Scratch, SimdPath};
use sha2::{Digest, Sha256};

/// One row through the layers in `f64`, and the sum of the sizes of what was added up for each
/// output: what rounding errors are relative to.
fn reference(layers: &[Numbers], row: &[f32]) -> Vec<(f64, f64)> {
    let mut x: Vec<(f64, f64)> = row.iter().map(|&v| (v.into(), v.abs().into())).collect();
    for (index, (inputs, outputs, weight, bias)) in layers.iter().enumerate() {
        let last = index + 1 == layers.len();
        x = (0..*outputs)
            .map(|o| {
                let mut sum = (f64::from(bias[o]), f64::from(bias[o].abs()));
                for i in 0..*inputs {
                    let w = f64::from(weight[i * outputs + o]);
                    sum.0 += x[i].0 * w;
                    sum.1 += x[i].1 * w.abs();
                }
                if last { sum } else { (sum.0.max(0.0), sum.1) }
            })
            .collect();
    }
    x
}

#[test]
fn outputs_are_those_of_double_precision() {
    for (seed, widths) in [&[23, 160, 160, 160, 6][..], &[120, 128, 128, 32], &[1, 1], &[7, 300, 2]]
        .into_iter()
        .enumerate()
    {
        let mut draws = draws(seed as u64);
        let layers = layers(&mut draws, widths);
        let mlp = mlp(&layers);
        let inputs = values(&mut draws, 20 * widths[0], 1.0);
        let mut scratch = Scratch::new();
        let outputs = mlp.forward(SimdPath::detect(), &inputs, &mut scratch);
        for (row, out) in inputs.chunks(widths[0]).zip(outputs.chunks(mlp.outputs())) {
            for (got, (expected, size)) in out.iter().zip(reference(&layers, row)) {
                assert!((f64::from(*got) - expected).abs() < 1e-5 * size, "{got} {expected}");
            }
        }
    }
}

#[test]
fn a_network_worked_out_by_hand() {
    let first = Dense::new(2, 3, &[1.0, -1.0, 0.5, 2.0, 1.0, -1.0], &[0.0, 0.25, 0.0]).unwrap();
    let second = Dense::new(3, 1, &[1.0, 10.0, 100.0], &[-1.0]).unwrap();
    let mlp = Mlp::new(vec![first, second]).unwrap();
    assert_eq!((mlp.inputs(), mlp.outputs(), mlp.weight_count()), (2, 1, 13));
    // (1, 1) → (3, 0.25, −0.5 → 0) → 3 + 2.5 − 1; (2, −1) → (0, −2.75 → 0, 2) → 200 − 1.
    for path in SimdPath::available() {
        let mut scratch = Scratch::new();
        assert_eq!(mlp.forward(path, &[1.0, 1.0, 2.0, -1.0], &mut scratch), [4.5, 199.0]);
    }
}

#[test]
fn gains_scale_what_the_rectifier_leaves_by_the_class_of_the_row() {
    let first = Dense::new(2, 3, &[1.0, -1.0, 0.5, 2.0, 1.0, -1.0], &[0.0, 0.25, 0.0]).unwrap();
    let first = first.with_gains(1, &[1.0, -2.0, 0.5]).unwrap();
    let second = Dense::new(3, 1, &[1.0, 10.0, 100.0], &[-1.0]).unwrap();
    let mlp = Mlp::new(vec![first, second]).unwrap();
    assert_eq!(mlp.weight_count(), 16);
    // (1, 1) → (3, 0.25, 0) · (2, −1, 1.5) → 6 − 2.5 − 1; (0, −1) → (0, 0, 1) · 1 → 100 − 1.
    for path in SimdPath::available() {
        let mut scratch = Scratch::new();
        assert_eq!(mlp.forward(path, &[1.0, 1.0, 0.0, -1.0], &mut scratch), [2.5, 99.0]);
    }
}

/// SHA-256 of the output bits of a fixed pseudo-random network.
const GOLDEN: &str = "81d07099b366ed0b72aefde0fe397af29c86754592295bc81f6174624ea0f36a";

#[test]
fn outputs_of_a_fixed_network_have_not_changed() {
    let mut draws = draws(0);
    let mlp = mlp(&layers(&mut draws, &[23, 160, 160, 160, 6]));
    let inputs = values(&mut draws, 100 * 23, 1.0);
    for path in SimdPath::available() {
        let mut hash = Sha256::new();
        for output in mlp.forward(path, &inputs, &mut Scratch::new()) {
            hash.update(output.to_le_bytes());
        }
        let hash: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(
            hash, GOLDEN,
            "path {path} gives other bits than the release that minted the constant: every tree \
             stored as its seed would change. If that is meant, put the new hash here and say so \
             under `Results changed` in the changelog; otherwise an order of operations, a fused \
             multiply-add or a flush-to-zero has come in."
        );
    }
}

#[test]
fn an_empty_batch_gives_no_outputs() {
    let mlp = mlp(&layers(&mut draws(1), &[4, 8, 2]));
    for path in SimdPath::available() {
        assert!(mlp.forward(path, &[], &mut Scratch::new()).is_empty());
    }
}

#[test]
#[should_panic(expected = "7 inputs are no whole number of rows of 4")]
fn a_part_of_a_row_is_refused() {
    let mlp = mlp(&layers(&mut draws(1), &[4, 2]));
    mlp.forward(SimdPath::Scalar, &[0.0; 7], &mut Scratch::new());
}

#[test]
fn numbers_that_are_no_network_are_refused() {
    let dense = |i, o| Dense::new(i, o, &vec![0.0; i * o], &vec![0.0; o]).unwrap();
    assert_eq!(Mlp::new(vec![]), Err(MlpError::NoLayers));
    assert_eq!(
        Mlp::new(vec![dense(2, 3), dense(4, 1)]),
        Err(MlpError::Chain { layer: 1, inputs: 4, previous: 3 })
    );
    assert_eq!(
        Mlp::new(vec![dense(2, 0)]),
        Err(MlpError::EmptyLayer { layer: 0, inputs: 2, outputs: 0 })
    );
    assert!(matches!(Mlp::new(vec![dense(1, 20_000)]), Err(MlpError::TooWide { .. })));
    let gained = |i, o, classes| dense(i, o).with_gains(classes, &vec![0.0; classes * o]).unwrap();
    assert_eq!(
        Mlp::new(vec![dense(2, 3), gained(3, 4, 3), dense(4, 1)]),
        Err(MlpError::Classes { layer: 1, classes: 3, inputs: 2 })
    );
    assert_eq!(Mlp::new(vec![dense(2, 3), gained(3, 4, 1)]), Err(MlpError::LastGains { layer: 1 }));
    let short = dense(2, 3).with_gains(2, &[0.0; 5]);
    assert!(matches!(short, Err(MlpError::GainCount { given: 5, classes: 2, outputs: 3 })));
    let bad = dense(1, 1).with_gains(1, &[f32::NAN]);
    assert!(matches!(bad, Err(MlpError::NotFinite { part: "gain", index: 0, .. })));
    assert!(matches!(Dense::new(2, 2, &[0.0; 3], &[0.0; 2]), Err(MlpError::WeightCount { .. })));
    assert!(matches!(Dense::new(usize::MAX, 2, &[], &[0.0; 2]), Err(MlpError::WeightCount { .. })));
    assert!(matches!(Dense::new(2, 2, &[0.0; 4], &[0.0; 3]), Err(MlpError::BiasCount { .. })));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(matches!(
            Dense::new(1, 2, &[0.0, bad], &[0.0; 2]),
            Err(MlpError::NotFinite { part: "weight", index: 1, .. })
        ));
    }
}

#[test]
fn path_names_are_read_back() {
    for path in SimdPath::ALL {
        assert_eq!(path.name().parse(), Ok(path));
    }
    assert!("sse9".parse::<SimdPath>().is_err());
    assert_eq!(SimdPath::available().first(), Some(&SimdPath::Scalar));
    assert_eq!(SimdPath::available().last(), Some(&SimdPath::detect()));
}
