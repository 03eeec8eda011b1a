//! Multilayer perceptrons over batches of rows.

use core::ops::Range;

use crate::kernels::{self, Activation, Full, Job, LANES, Lanes, Packed, Rows, SimdPath};

/// Rows that go through all layers together: few enough that their activations and a panel of
/// weights share the first-level cache, enough that weights are seldom read from the second.
/// Changes speed only.
const BLOCK: usize = 64;

/// Most inputs or outputs of a layer: bounds the memory a hostile file can ask for.
const MAX_WIDTH: usize = 1 << 14;

/// Why numbers are not a network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MlpError {
    #[error("a network of no layers; give at least one")]
    NoLayers,
    #[error("layer {layer} has {inputs} inputs and {outputs} outputs; both must be at least 1")]
    EmptyLayer { layer: usize, inputs: usize, outputs: usize },
    #[error("layer {layer} has {inputs} inputs and {outputs} outputs; at most {limit} are allowed")]
    TooWide { layer: usize, inputs: usize, outputs: usize, limit: usize },
    #[error("layer {layer} reads {inputs} values, but the layer before it gives {previous}")]
    Chain { layer: usize, inputs: usize, previous: usize },
    #[error("{given} weights for a layer of {inputs} inputs and {outputs} outputs")]
    WeightCount { given: usize, inputs: usize, outputs: usize },
    #[error("{given} biases for a layer of {outputs} outputs")]
    BiasCount { given: usize, outputs: usize },
    #[error("{given} gains for {classes} classes of a layer of {outputs} outputs")]
    GainCount { given: usize, classes: usize, outputs: usize },
    #[error("layer {layer} has gains by {classes} classes, the network {inputs} inputs")]
    Classes { layer: usize, classes: usize, inputs: usize },
    #[error("layer {layer} is the last and has gains; only hidden layers have")]
    LastGains { layer: usize },
    #[error("{part}[{index}] is {value}; every number of a network must be finite")]
    NotFinite { part: &'static str, index: usize, value: f32 },
}

/// A dense layer: `y[o] = bias[o] + Σᵢ x[i] · weight[i][o]`, over the inputs that are not zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense {
    outputs: usize,
    packed: Packed,
    /// `[classes, outputs]`; empty of a layer without.
    gains: Vec<f32>,
}

impl Dense {
    /// A layer of its numbers.
    ///
    /// # Shapes
    ///
    /// `weight: [inputs, outputs]` with the outputs next to each other, `bias: [outputs]`.
    ///
    /// # Errors
    ///
    /// When the counts do not fit together or a number is not finite: the same weights must give
    /// the same bits everywhere, and the bits of a NaN are up to the processor.
    pub fn new(
        inputs: usize,
        outputs: usize,
        weight: &[f32],
        bias: &[f32],
    ) -> Result<Self, MlpError> {
        if inputs.checked_mul(outputs) != Some(weight.len()) {
            return Err(MlpError::WeightCount { given: weight.len(), inputs, outputs });
        }
        if bias.len() != outputs {
            return Err(MlpError::BiasCount { given: bias.len(), outputs });
        }
        all_finite("weight", weight)?;
        all_finite("bias", bias)?;
        Ok(Self { outputs, packed: pack(inputs, outputs, weight, bias), gains: Vec::new() })
    }

    /// The layer with gains: the first inputs of the *network*, a one-hot of `classes`, scale what the
    /// rectifier leaves of its outputs, `y[o] · (1 + Σ_c x[c] · gains[c][o])`.
    ///
    /// # Shapes  gains: `[classes, outputs]`
    ///
    /// # Errors
    ///
    /// When the counts do not fit together or a number is not finite.
    pub fn with_gains(self, classes: usize, gains: &[f32]) -> Result<Self, MlpError> {
        let outputs = self.outputs;
        if classes.checked_mul(outputs) != Some(gains.len()) {
            return Err(MlpError::GainCount { given: gains.len(), classes, outputs });
        }
        all_finite("gain", gains)?;
        Ok(Self { gains: gains.to_vec(), ..self })
    }

    /// Classes that scale the outputs.
    fn classes(&self) -> usize {
        self.gains.len().checked_div(self.outputs).unwrap_or(0)
    }

    /// Scales the outputs of a row by the one-hot that the network's inputs begin with.
    fn scale(&self, (indexes, inputs): (&[u32], &[f32]), outputs: &mut [f32]) {
        let told = indexes.partition_point(|&index| (index as usize) < self.classes());
        let gains = |class: u32| &self.gains[class as usize * self.outputs..][..self.outputs];
        if let &[class] = &indexes[..told] {
            for (output, gain) in outputs.iter_mut().zip(gains(class)) {
                *output *= 1.0 + inputs[0] * gain;
            }
            return;
        }
        for (o, output) in outputs.iter_mut().enumerate().take(self.outputs) {
            let told = indexes[..told].iter().zip(inputs);
            *output *= told.fold(1.0, |sum, (&class, input)| sum + input * gains(class)[o]);
        }
    }

    /// Values the layer reads of each row.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.packed.inputs
    }

    /// Values the layer gives for each row.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.outputs
    }
}

fn all_finite(part: &'static str, values: &[f32]) -> Result<(), MlpError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(MlpError::NotFinite { part, index, value: values[index] }),
        None => Ok(()),
    }
}

fn pack(inputs: usize, outputs: usize, weight: &[f32], bias: &[f32]) -> Packed {
    let panels = outputs.div_ceil(LANES);
    let mut packed = Packed {
        inputs,
        weights: vec![Lanes::ZERO; panels * inputs],
        bias: vec![Lanes::ZERO; panels],
    };
    for o in 0..outputs {
        let (panel, lane) = (o / LANES, o % LANES);
        packed.bias[panel].0[lane] = bias[o];
        for i in 0..inputs {
            packed.weights[panel * inputs + i].0[lane] = weight[i * outputs + o];
        }
    }
    packed
}

/// A multilayer perceptron: dense layers with a rectifier (`v > 0 ? v : 0`) between them, and gains
/// where they have some; the last layer is linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Mlp {
    layers: Vec<Dense>,
}

/// Memory that [`Mlp::forward`] works in. One for each thread; once it has served the largest
/// batch, no call allocates.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// What was given with its zeros.
    inputs: Rows,
    /// What the layer at work gives.
    values: Vec<f32>,
    /// What of it the next layer reads.
    active: Rows,
    outputs: Vec<f32>,
}

impl Mlp {
    /// A network of its layers, first to last.
    ///
    /// # Errors
    ///
    /// When there are none, one is empty, or one does not read what the one before it gives.
    pub fn new(layers: Vec<Dense>) -> Result<Self, MlpError> {
        if layers.is_empty() {
            return Err(MlpError::NoLayers);
        }
        for (layer, dense) in layers.iter().enumerate() {
            let (inputs, outputs) = (dense.inputs(), dense.outputs());
            if inputs == 0 || outputs == 0 {
                return Err(MlpError::EmptyLayer { layer, inputs, outputs });
            }
            if inputs.max(outputs) > MAX_WIDTH {
                return Err(MlpError::TooWide { layer, inputs, outputs, limit: MAX_WIDTH });
            }
            let previous = layer.checked_sub(1).map_or(inputs, |before| layers[before].outputs());
            if inputs != previous {
                return Err(MlpError::Chain { layer, inputs, previous });
            }
            let (classes, inputs) = (dense.classes(), layers[0].inputs());
            if classes > inputs {
                return Err(MlpError::Classes { layer, classes, inputs });
            }
            if classes > 0 && layer + 1 == layers.len() {
                return Err(MlpError::LastGains { layer });
            }
        }
        Ok(Self { layers })
    }

    /// Values the network reads of each row.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers[0].inputs()
    }

    /// Values the network gives for each row.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.layers[self.layers.len() - 1].outputs()
    }

    /// How many dense layers the network has.
    #[must_use]
    pub fn layer_count(&self) -> usize {
        self.layers.len()
    }

    /// How many weights, biases and gains the network has.
    #[must_use]
    pub fn weight_count(&self) -> usize {
        let count = |dense: &Dense| (dense.inputs() + 1) * dense.outputs() + dense.gains.len();
        self.layers.iter().map(count).sum()
    }

    /// Sends rows through the network, and gives its outputs, which live in `scratch`.
    ///
    /// The outputs of a row depend on that row only, and are the same bits on every path, as long
    /// as inputs are finite and no sum overflows; a caller refuses outputs that are not finite.
    ///
    /// # Shapes
    ///
    /// `inputs: [rows, self.inputs()]` → `[rows, self.outputs()]`, for any number of rows.
    ///
    /// # Panics
    ///
    /// When `inputs` is not a whole number of rows.
    pub fn forward<'s>(
        &self,
        path: SimdPath,
        inputs: &[f32],
        scratch: &'s mut Scratch,
    ) -> &'s [f32] {
        let width = self.inputs();
        assert!(
            inputs.len().is_multiple_of(width),
            "{} inputs are no whole number of rows of {width}",
            inputs.len()
        );
        let mut rows = core::mem::take(&mut scratch.inputs);
        rows.clear();
        kernels::thin(path, Full { values: inputs, width, first: 0 }, &mut rows);
        let done = self.run(path, &rows, scratch);
        scratch.inputs = rows;
        &scratch.outputs[..done]
    }

    /// [`Mlp::forward`] of rows without their zeros.
    pub(crate) fn forward_rows<'s>(
        &self,
        path: SimdPath,
        inputs: &Rows,
        scratch: &'s mut Scratch,
    ) -> &'s [f32] {
        let done = self.run(path, inputs, scratch);
        &scratch.outputs[..done]
    }

    /// Leaves the outputs at the front of `scratch.outputs`, and gives how many they are.
    fn run(&self, path: SimdPath, inputs: &Rows, scratch: &mut Scratch) -> usize {
        scratch.reserve(self, inputs.count());
        let outputs = self.outputs();
        let mut done = 0;
        for block in inputs.blocks(BLOCK) {
            let rows = block.len();
            let stride = self.run_block(path, inputs, block, scratch);
            for row in scratch.values.chunks_exact(stride).take(rows) {
                scratch.outputs[done..][..outputs].copy_from_slice(&row[..outputs]);
                done += outputs;
            }
        }
        done
    }

    /// Leaves the outputs of at most [`BLOCK`] rows in `scratch.values`, and gives their stride.
    fn run_block(
        &self,
        path: SimdPath,
        inputs: &Rows,
        rows: Range<usize>,
        scratch: &mut Scratch,
    ) -> usize {
        let count = rows.len();
        let mut stride = 0;
        for (index, dense) in self.layers.iter().enumerate() {
            let layer = &dense.packed;
            let last = index + 1 == self.layers.len();
            let (given, first) = (inputs, rows.start);
            let (inputs, rows) =
                if index == 0 { (inputs, rows.clone()) } else { (&scratch.active, 0..count) };
            kernels::run(
                path,
                Job {
                    layer,
                    activation: if last { Activation::Linear } else { Activation::Relu },
                    inputs,
                    rows,
                    outputs: &mut scratch.values,
                },
            );
            stride = layer.output_stride();
            if !last {
                let values = &mut scratch.values[..count * stride];
                if !dense.gains.is_empty() {
                    for (row, values) in values.chunks_exact_mut(stride).enumerate() {
                        dense.scale(given.row(first + row), values);
                    }
                }
                // What pads the last panel is zero.
                let values = &scratch.values[..count * stride];
                scratch.active.clear();
                kernels::thin(path, Full { values, width: stride, first: 0 }, &mut scratch.active);
            }
        }
        stride
    }
}

impl Scratch {
    /// Memory that grows when it is first used.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn reserve(&mut self, mlp: &Mlp, rows: usize) {
        let widest = mlp.layers.iter().map(|dense| dense.packed.output_stride()).max();
        let block = rows.min(BLOCK) * widest.unwrap_or(0);
        for (buffer, len) in [(&mut self.values, block), (&mut self.outputs, rows * mlp.outputs())]
        {
            if buffer.len() < len {
                buffer.resize(len, 0.0);
            }
        }
    }
}
