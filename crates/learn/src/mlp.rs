//! A multilayer perceptron whose parameters are one flat tensor.
//!
//! Flat, because then the optimiser, the running average, a checkpoint and the hand-over to the
//! model file each are one operation on one array, whatever the shape of the network.

use burn::tensor::{Device, Gradients, Tensor, TensorData, activation::relu, module::linear};
use deeptree_graph::Draws;
use deeptree_infer::{ReadWeightsError, Table, gain_name, layer_names};

/// Widths of the layers of a network, inputs first: `sizes.len() - 1` dense layers with ReLU
/// between them and nothing after the last.
///
/// A network of several species can have gains: the first inputs, a one-hot of the species, scale
/// what each hidden unit gives, `y = relu(x W + b) · (1 + s G)`, so that the species share what units
/// look at and not how much it counts.
///
/// # Source
///
/// Perez et al. 2018, "FiLM: Visual reasoning with a general conditioning layer", without its shifts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mlp {
    sizes: Vec<usize>,
    /// Inputs that scale hidden units; 0 of a network without gains.
    species: usize,
}

/// One dense layer of the flat parameters.
///
/// # Shapes
///
/// weight: `[inputs, outputs]`, row-major; bias: `[outputs]`; gains: `[species, outputs]`, row-major, of
/// hidden layers; in this order
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LayerSpan {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Rows of gains.
    species: usize,
    /// Where the weight starts.
    pub(crate) start: usize,
}

impl LayerSpan {
    /// Where the bias starts.
    pub(crate) const fn bias(&self) -> usize {
        self.start + self.inputs * self.outputs
    }

    /// Where the gains start.
    const fn gains(&self) -> usize {
        self.bias() + self.outputs
    }

    /// One past the last parameter.
    pub(crate) const fn end(&self) -> usize {
        self.gains() + self.species * self.outputs
    }
}

/// The layers as tensors: what a forward pass reads and a backward pass gives gradients for.
pub(crate) struct Layers(Vec<Layer>);

struct Layer {
    weight: Tensor<2>,
    bias: Tensor<1>,
    gains: Option<Tensor<2>>,
}

impl Mlp {
    pub(crate) fn new(inputs: usize, hidden: &[usize], outputs: usize) -> Self {
        let sizes = std::iter::once(inputs).chain(hidden.iter().copied()).chain([outputs]);
        Self { sizes: sizes.collect(), species: 0 }
    }

    /// The network with gains: its first inputs are a one-hot of so many species.
    pub(crate) fn with_gains(self, species: usize) -> Self {
        Self { species, ..self }
    }

    /// Widths of the layers, inputs first.
    pub(crate) fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// The layers in the order of the flat parameters.
    pub(crate) fn spans(&self) -> impl Iterator<Item = LayerSpan> + '_ {
        let (mut start, last) = (0, self.sizes.len() - 2);
        self.sizes.windows(2).enumerate().map(move |(layer, pair)| {
            let species = if layer < last { self.species } else { 0 };
            let span = LayerSpan { inputs: pair[0], outputs: pair[1], species, start };
            start = span.end();
            span
        })
    }

    /// How many parameters the network has.
    pub(crate) fn parameters(&self) -> usize {
        self.spans().last().map_or(0, |span| span.end())
    }

    /// Initial parameters: weights uniform in ±√(6 / inputs), biases and gains 0.
    ///
    /// # Source
    ///
    /// He et al. 2015, "Delving deep into rectifiers", Eq. 10.
    pub(crate) fn initial(&self, draws: &Draws) -> Vec<f32> {
        let mut flat = vec![0.0; self.parameters()];
        for (layer, span) in self.spans().enumerate() {
            let bound = (6.0 / span.inputs as f64).sqrt();
            let mut draws = draws.clone().at(layer as u64);
            for weight in &mut flat[span.start..span.bias()] {
                *weight = (bound * (2.0 * draws.uniform() - 1.0)) as f32;
            }
        }
        flat
    }

    /// The tensors of the model file, with their names, of the network `name`.
    pub(crate) fn tensors(
        &self,
        name: &str,
        flat: &[f32],
    ) -> Result<Vec<(String, Table)>, ReadWeightsError> {
        let mut tensors = Vec::new();
        for (layer, span) in (0..).zip(self.spans()) {
            let [weight, bias] = layer_names(name, layer);
            let shape = vec![span.inputs, span.outputs];
            tensors.push((weight, Table::new(shape, flat[span.start..span.bias()].to_vec())?));
            let values = flat[span.bias()..span.gains()].to_vec();
            tensors.push((bias, Table::new(vec![span.outputs], values)?));
            if span.species > 0 {
                let shape = vec![span.species, span.outputs];
                let gains = Table::new(shape, flat[span.gains()..span.end()].to_vec())?;
                tensors.push((gain_name(name, layer), gains));
            }
        }
        Ok(tensors)
    }

    /// Cuts the flat parameters into layers on `device`; they track gradients where it does.
    pub(crate) fn layers(&self, flat: &Tensor<1>, track: bool) -> Layers {
        let part = |start, end| {
            let part = flat.clone().narrow(0, start, end - start);
            if track { part.autodiff() } else { part }
        };
        let matrix = |start, rows, columns| {
            let matrix = part(start, start + rows * columns).reshape([rows, columns]);
            if track { matrix.require_grad() } else { matrix }
        };
        let layers = self.spans().map(|span| {
            let bias = part(span.bias(), span.gains());
            Layer {
                weight: matrix(span.start, span.inputs, span.outputs),
                bias: if track { bias.require_grad() } else { bias },
                gains: (span.species > 0).then(|| matrix(span.gains(), span.species, span.outputs)),
            }
        });
        Layers(layers.collect())
    }
}

impl Layers {
    /// # Shapes  inputs: `[batch, inputs]`; result: `[batch, outputs]`
    pub(crate) fn forward(&self, inputs: Tensor<2>) -> Tensor<2> {
        let last = self.0.len() - 1;
        let mut x = inputs.clone();
        for (i, Layer { weight, bias, gains }) in self.0.iter().enumerate() {
            x = linear(x, weight.clone(), Some(bias.clone()));
            if i < last {
                x = relu(x);
            }
            if let Some(gains) = gains {
                let species = inputs.clone().narrow(1, 0, gains.dims()[0]);
                x = x * (species.matmul(gains.clone()) + 1.0);
            }
        }
        x
    }

    /// The gradient of the flat parameters; `None` when the loss does not depend on some layer.
    pub(crate) fn gradient(&self, gradients: &mut Gradients) -> Option<Tensor<1>> {
        let mut parts = Vec::with_capacity(3 * self.0.len());
        for Layer { weight, bias, gains } in &self.0 {
            parts.push(weight.grad_remove(gradients)?.flatten::<1>(0, 1));
            parts.push(bias.grad_remove(gradients)?);
            if let Some(gains) = gains {
                parts.push(gains.grad_remove(gradients)?.flatten::<1>(0, 1));
            }
        }
        Some(Tensor::cat(parts, 0))
    }
}

/// A flat tensor of `values` on `device`.
pub(crate) fn flat(values: Vec<f32>, device: &Device) -> Tensor<1> {
    let length = values.len();
    Tensor::from_data(TensorData::new(values, [length]), device)
}

/// The values of a tensor.
pub(crate) fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().iter::<f32>().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};
    use deeptree_infer::{Dense, Mlp as Kernels, Scratch, SimdPath};

    fn draws(seed: u64) -> Draws {
        Seed(seed).draws(Lineage::ROOT, Purpose::InitialWeights)
    }

    #[test]
    fn burn_and_the_inference_kernels_give_the_same_outputs() {
        let (net, rows) = (Mlp::new(37, &[64, 21], 9).with_gains(5), 150);
        let mut draws = draws(4);
        let parameters: Vec<f32> =
            (0..net.parameters()).map(|_| (0.2 * draws.normal()) as f32).collect();
        let mut inputs: Vec<f32> = (0..rows * 37).map(|_| draws.normal() as f32).collect();
        // Every second row begins with a one-hot.
        for (row, inputs) in inputs.chunks_exact_mut(37).enumerate().step_by(2) {
            inputs[..5].fill(0.0);
            inputs[row / 2 % 5] = 1.0;
        }

        let device = Device::flex();
        let batch = Tensor::from_data(TensorData::new(inputs.clone(), [rows, 37]), &device);
        let layers = net.layers(&flat(parameters.clone(), &device), false);
        let burn = values(layers.forward(batch));

        let dense = net.spans().map(|span| {
            let (weight, bias) = (span.start..span.bias(), span.bias()..span.gains());
            let [weight, bias, gains] =
                [weight, bias, span.gains()..span.end()].map(|part| &parameters[part]);
            let dense = Dense::new(span.inputs, span.outputs, weight, bias).unwrap();
            dense.with_gains(span.species, gains).unwrap()
        });
        let kernels = Kernels::new(dense.collect()).unwrap();
        let mut scratch = Scratch::new();
        let ours = kernels.forward(SimdPath::detect(), &inputs, &mut scratch);
        assert_eq!(ours.len(), burn.len());
        for (a, b) in ours.iter().zip(&burn) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }

    #[test]
    fn initial_weights_have_the_variance_that_keeps_activations_alive() {
        let net = Mlp::new(200, &[300], 10).with_gains(3);
        let flat = net.initial(&draws(1));
        for span in net.spans() {
            let weights = &flat[span.start..span.bias()];
            let variance = weights.iter().map(|w| w * w).sum::<f32>() / weights.len() as f32;
            // He et al. 2015: 2 over the number of inputs.
            assert!((variance * span.inputs as f32 / 2.0 - 1.0).abs() < 0.05);
            assert!(flat[span.bias()..span.end()].iter().all(|&bias| bias == 0.0));
        }
        assert_eq!(net.parameters(), flat.len());
        assert_ne!(flat, net.initial(&draws(2)));
    }
}
