//! The blocked kernel, for every vector instruction set.
//!
//! A tile of `ROWS` rows × `PANELS` panels keeps its sums in registers and reads each weight once
//! for all of its rows. `*` and `+` of vectors are never fused, so every instance gives the bits of
//! the scalar path.

use core::array;

use fearless_simd::{Simd, f32x16, prelude::*};

use super::{Activation, Job, LANES, Lanes};

/// Sends `ROWS` rows through `PANELS` panels at a time, and the rows that are left over one by one
/// through `SINGLE` panels (enough independent sums to hide the latency of an addition).
#[inline(always)]
pub(super) fn run<S: Simd, const ROWS: usize, const PANELS: usize, const SINGLE: usize>(
    simd: S,
    mut job: Job<'_>,
) {
    let rows = job.rows;
    let whole = rows - rows % ROWS;
    sweep::<S, ROWS, PANELS>(simd, &mut job, 0, whole);
    sweep::<S, 1, SINGLE>(simd, &mut job, whole, rows);
}

/// All panels over the rows `from..to`; a panel stays in the cache while the rows pass by.
#[inline(always)]
fn sweep<S: Simd, const ROWS: usize, const PANELS: usize>(
    simd: S,
    job: &mut Job<'_>,
    from: usize,
    to: usize,
) {
    let panels = if from < to { job.layer.bias.len() } else { 0 };
    let whole = panels - panels % PANELS;
    for panel in (0..whole).step_by(PANELS) {
        for row in (from..to).step_by(ROWS) {
            tile::<S, ROWS, PANELS>(simd, job, row, panel);
        }
    }
    for panel in whole..panels {
        for row in (from..to).step_by(ROWS) {
            tile::<S, ROWS, 1>(simd, job, row, panel);
        }
    }
}

#[inline(always)]
fn tile<S: Simd, const ROWS: usize, const PANELS: usize>(
    simd: S,
    job: &mut Job<'_>,
    row: usize,
    panel: usize,
) {
    let layer = job.layer;
    let n = layer.inputs;
    let x: [&[f32]; ROWS] = array::from_fn(|r| &job.inputs[(row + r) * job.input_stride..][..n]);
    let w: [&[Lanes]; PANELS] = array::from_fn(|p| &layer.weights[(panel + p) * n..][..n]);
    let bias: [f32x16<S>; PANELS] =
        array::from_fn(|p| f32x16::load_array_ref(simd, &layer.bias[panel + p].0));
    let mut sums = [bias; ROWS];
    for i in 0..n {
        let w: [f32x16<S>; PANELS] = array::from_fn(|p| f32x16::load_array_ref(simd, &w[p][i].0));
        for r in 0..ROWS {
            let x = f32x16::splat(simd, x[r][i]);
            for p in 0..PANELS {
                sums[r][p] += x * w[p];
            }
        }
    }
    let stride = layer.output_stride();
    for (r, sums) in sums.into_iter().enumerate() {
        let y = &mut job.outputs[(row + r) * stride + panel * LANES..][..PANELS * LANES];
        for (sums, y) in sums.into_iter().zip(y.as_chunks_mut::<LANES>().0) {
            activate(simd, job.activation, sums).store_slice(y);
        }
    }
}

#[inline(always)]
fn activate<S: Simd>(simd: S, activation: Activation, sums: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(simd, 0.0);
    match activation {
        Activation::Linear => sums,
        // Not `max`: it may give −0, or NaN, or neither, by instruction set.
        Activation::Relu => sums.simd_gt(zero).select(sums, zero),
    }
}
