//! The blocked kernel, in plain Rust: the compiler maps each row of lanes to vector registers.
//!
//! A tile of `ROWS` rows × `PANELS` panels keeps its sums in registers and reads each weight once
//! for all of its rows. The compiler may neither reorder nor fuse floating-point operations, so
//! every instantiation gives the bits of the scalar path.

use core::array;

use super::{Job, LANES, Lanes};

/// For the vector registers that every processor of the target has: 16 of 4 lanes (SSE2, wasm
/// simd128) or 32 of 4 lanes (NEON).
pub(super) fn baseline(job: Job<'_>) {
    run::<2, 1, 2>(job);
}

/// Sends `ROWS` rows through `PANELS` panels at a time, and the rows that are left over one by one
/// through `SINGLE` panels (enough independent sums to hide the latency of an addition).
#[inline(always)]
pub(super) fn run<const ROWS: usize, const PANELS: usize, const SINGLE: usize>(mut job: Job<'_>) {
    let whole = job.rows - job.rows % ROWS;
    sweep::<ROWS, PANELS>(&mut job, 0, whole);
    let rows = job.rows;
    sweep::<1, SINGLE>(&mut job, whole, rows);
}

/// All panels over the rows `from..to`; a panel stays in the cache while the rows pass by.
#[inline(always)]
fn sweep<const ROWS: usize, const PANELS: usize>(job: &mut Job<'_>, from: usize, to: usize) {
    let panels = if from < to { job.layer.bias.len() } else { 0 };
    let whole = panels - panels % PANELS;
    for panel in (0..whole).step_by(PANELS) {
        for row in (from..to).step_by(ROWS) {
            tile::<ROWS, PANELS>(job, row, panel);
        }
    }
    for panel in whole..panels {
        for row in (from..to).step_by(ROWS) {
            tile::<ROWS, 1>(job, row, panel);
        }
    }
}

#[inline(always)]
fn tile<const ROWS: usize, const PANELS: usize>(job: &mut Job<'_>, row: usize, panel: usize) {
    let layer = job.layer;
    let n = layer.inputs;
    let x: [&[f32]; ROWS] = array::from_fn(|r| &job.inputs[(row + r) * job.input_stride..][..n]);
    let w: [&[Lanes]; PANELS] = array::from_fn(|p| &layer.weights[(panel + p) * n..][..n]);
    let mut sums: [[[f32; LANES]; PANELS]; ROWS] =
        [array::from_fn(|p| layer.bias[panel + p].0); ROWS];
    for i in 0..n {
        for (sums, x) in sums.iter_mut().zip(x) {
            for (sums, w) in sums.iter_mut().zip(w) {
                for (sum, w) in sums.iter_mut().zip(w[i].0) {
                    *sum += x[i] * w;
                }
            }
        }
    }
    let stride = layer.output_stride();
    for (r, sums) in sums.iter_mut().enumerate() {
        for (p, sums) in sums.iter_mut().enumerate() {
            job.activation.apply(sums);
            job.outputs[(row + r) * stride + (panel + p) * LANES..][..LANES].copy_from_slice(sums);
        }
    }
}
