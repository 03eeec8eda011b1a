//! The kernels for every vector instruction set.
//!
//! A strip of panels keeps the sums of a row in registers while its numbers pass by. `*` and `+` of
//! vectors are never fused, so every instance gives the bits of the scalar path.

use core::array;

use fearless_simd::{Simd, f32x16, prelude::*};

use super::{Activation, Full, Job, LANES, Lanes, Rows};

/// Sends all rows through strips of at most `PANELS` panels.
#[inline(always)]
pub(super) fn run<S: Simd, const PANELS: usize>(simd: S, mut job: Job<'_>) {
    let panels = job.layer.bias.len();
    let mut panel = 0;
    while panel < panels {
        let left = panels - panel;
        panel += match left {
            _ if left >= PANELS => sweep::<S, PANELS>(simd, &mut job, panel),
            6.. if PANELS > 6 => sweep::<S, 6>(simd, &mut job, panel),
            4.. if PANELS > 4 => sweep::<S, 4>(simd, &mut job, panel),
            2.. if PANELS > 2 => sweep::<S, 2>(simd, &mut job, panel),
            _ => sweep::<S, 1>(simd, &mut job, panel),
        };
    }
}

/// One strip over all rows, so that its weights stay in the cache; gives its width.
#[inline(always)]
fn sweep<S: Simd, const PANELS: usize>(simd: S, job: &mut Job<'_>, panel: usize) -> usize {
    let layer = job.layer;
    let n = layer.inputs;
    let w: [&[Lanes]; PANELS] = array::from_fn(|p| &layer.weights[(panel + p) * n..][..n]);
    let bias: [f32x16<S>; PANELS] =
        array::from_fn(|p| f32x16::load_array_ref(simd, &layer.bias[panel + p].0));
    let outputs = job.outputs.chunks_exact_mut(layer.output_stride());
    for (row, y) in job.rows.clone().zip(outputs) {
        let mut sums = bias;
        let (indexes, values) = job.inputs.row(row);
        for (&index, &x) in indexes.iter().zip(values) {
            let x = f32x16::splat(simd, x);
            for p in 0..PANELS {
                sums[p] += x * f32x16::load_array_ref(simd, &w[p][index as usize].0);
            }
        }
        let y = &mut y[panel * LANES..][..PANELS * LANES];
        for (sums, y) in sums.into_iter().zip(y.as_chunks_mut::<LANES>().0) {
            activate(simd, job.activation, sums).store_slice(y);
        }
    }
    PANELS
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

/// Leaves the zeros of rows out, a register at a time.
#[inline(always)]
pub(super) fn thin<S: Simd>(simd: S, full: Full<'_>, rows: &mut Rows) {
    let lanes = <S::f32s as SimdBase<S>>::LEN;
    let zero = S::f32s::splat(simd, 0.0);
    let start = S::u32s::from_fn(simd, |lane| full.first + lane as u32);
    let step = S::u32s::splat(simd, lanes as u32);
    for row in full.values.chunks_exact(full.width) {
        // Whole registers are stored, of which the next overwrites what is not kept.
        let (free_indexes, free_values) = rows.free(full.width.next_multiple_of(lanes));
        let (mut len, mut indexes) = (0, start);
        for part in row.chunks(lanes) {
            let x = if part.len() == lanes {
                S::f32s::from_slice(simd, part)
            } else {
                let mut padded = [0.0; LANES];
                padded[..part.len()].copy_from_slice(part);
                S::f32s::from_slice(simd, &padded[..lanes])
            };
            let kept = x.simd_ne(zero);
            x.compress(kept).store_slice(&mut free_values[len..][..lanes]);
            indexes.compress(kept).store_slice(&mut free_indexes[len..][..lanes]);
            indexes += step;
            len += kept.to_bitmask().count_ones() as usize;
        }
        rows.add(len);
        rows.end_row();
    }
}
