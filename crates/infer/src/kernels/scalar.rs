//! The definition: one row, one output and one number at a time.

use super::{Activation, Full, Job, LANES, Rows};

pub(super) fn run(job: Job<'_>) {
    let Job { layer, activation, inputs, rows, outputs } = job;
    for (row, y) in rows.zip(outputs.chunks_exact_mut(layer.output_stride())) {
        let (indexes, values) = inputs.row(row);
        for (panel, (bias, y)) in layer.bias.iter().zip(y.as_chunks_mut::<LANES>().0).enumerate() {
            let weights = &layer.weights[panel * layer.inputs..][..layer.inputs];
            for (lane, y) in y.iter_mut().enumerate() {
                *y = bias.0[lane];
                for (&index, x) in indexes.iter().zip(values) {
                    *y += x * weights[index as usize].0[lane];
                }
                if activation == Activation::Relu {
                    *y = if *y > 0.0 { *y } else { 0.0 };
                }
            }
        }
    }
}

pub(super) fn thin(full: Full<'_>, rows: &mut Rows) {
    for row in full.values.chunks_exact(full.width) {
        let (indexes, values) = rows.free(full.width);
        let mut len = 0;
        for (index, &value) in (full.first..).zip(row) {
            // Written in any case, and kept if it is not zero: a jump would cost more.
            (indexes[len], values[len]) = (index, value);
            len += usize::from(value != 0.0);
        }
        rows.add(len);
        rows.end_row();
    }
}
