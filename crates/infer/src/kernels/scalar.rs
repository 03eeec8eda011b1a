//! The definition: one row and one output at a time.

use super::{Activation, Job, LANES};

pub(super) fn run(job: Job<'_>) {
    let Job { layer, activation, rows, inputs, input_stride, outputs } = job;
    for row in 0..rows {
        let x = &inputs[row * input_stride..][..layer.inputs];
        let y = &mut outputs[row * layer.output_stride()..][..layer.output_stride()];
        for (panel, (bias, y)) in layer.bias.iter().zip(y.as_chunks_mut::<LANES>().0).enumerate() {
            let weights = &layer.weights[panel * layer.inputs..][..layer.inputs];
            for (lane, y) in y.iter_mut().enumerate() {
                *y = bias.0[lane];
                for (x, w) in x.iter().zip(weights) {
                    *y += x * w.0[lane];
                }
                if activation == Activation::Relu {
                    *y = if *y > 0.0 { *y } else { 0.0 };
                }
            }
        }
    }
}
