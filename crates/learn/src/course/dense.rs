//! A multilayer perceptron that learns a task.

use std::ops::Range;

use burn::tensor::{Device, Tensor, TensorData};
use deeptree_graph::{Draws, Seed};
use deeptree_infer::{ReadWeightsError, Table};

use super::Course;
use crate::mlp::{self, Mlp};
use crate::order::Order;
use crate::report::{Figures, Tally};
use crate::tasks::{Network, Task, noise_draws};

/// Samples that a validation sends through the network at once.
const VALIDATION_BATCH: usize = 2048;

/// A network that reads one row a sample.
pub(crate) struct Dense<'a> {
    pub(crate) network: Network,
    pub(crate) mlp: Mlp,
    pub(crate) train: Box<dyn Task + 'a>,
    pub(crate) validation: Box<dyn Task + 'a>,
    /// Samples a step.
    pub(crate) batch: usize,
    /// Inputs that the network does not read.
    pub(crate) unread: Vec<Range<usize>>,
    pub(crate) seed: Seed,
    pub(crate) species: usize,
    pub(crate) device: Device,
}

impl Dense<'_> {
    /// The batch of a step, on the device.
    fn batch(&self, step: u64) -> (Tensor<2>, Tensor<2>) {
        let (rows, task) = (self.batch, &*self.train);
        let mut order = Order::new(self.seed, self.network.key(), task.samples());
        let mut buffers = Buffers::new(task, rows);
        let first = step * rows as u64;
        for (row, (inputs, targets)) in buffers.rows().enumerate() {
            let position = first + row as u64;
            task.encode(task.pick(position, &mut order), inputs, targets);
            if task.is_disturbed() {
                task.disturb(noise_draws(self.seed, self.network.key(), position), inputs);
            }
        }
        buffers.blank(&self.unread);
        let (inputs, targets) = buffers.into_tensors(&self.device);
        (inputs.autodiff(), targets.autodiff())
    }
}

impl Course for Dense<'_> {
    fn samples(&self) -> usize {
        self.train.samples()
    }

    fn sizes(&self) -> Vec<usize> {
        self.mlp.sizes().to_vec()
    }

    fn parameters(&self) -> usize {
        self.mlp.parameters()
    }

    fn initial(&self, draws: &Draws) -> Vec<f32> {
        self.mlp.initial(draws)
    }

    fn descend(&self, parameters: &Tensor<1>, step: u64) -> (Tensor<1>, Tensor<1>) {
        let (inputs, targets) = self.batch(step);
        let layers = self.mlp.layers(parameters, true);
        let loss = self.train.loss(layers.forward(inputs), targets);
        let mut gradients = loss.backward();
        let gradient = layers.gradient(&mut gradients);
        (loss, gradient.unwrap_or_else(|| parameters.zeros_like()))
    }

    fn validate(&self, parameters: &Tensor<1>, limit: usize) -> Vec<Tally> {
        let task = &*self.validation;
        let layers = self.mlp.layers(parameters, false);
        let mut tallies = vec![Tally::default(); self.species];
        let stride = task.samples().div_ceil(limit.max(1)).max(1);
        let samples: Vec<usize> = (0..task.samples()).step_by(stride).collect();
        for chunk in samples.chunks(VALIDATION_BATCH) {
            let mut buffers = Buffers::new(task, chunk.len());
            for (&sample, (inputs, targets)) in chunk.iter().zip(buffers.rows()) {
                task.encode(sample, inputs, targets);
            }
            buffers.blank(&self.unread);
            let targets = std::mem::take(&mut buffers.targets);
            let outputs = mlp::values(layers.forward(buffers.inputs_tensor(&self.device)));
            let rows =
                outputs.chunks_exact(task.outputs()).zip(targets.chunks_exact(task.targets()));
            for (&sample, (outputs, targets)) in chunk.iter().zip(rows) {
                task.measure(outputs, targets, &mut tallies[task.species(sample)]);
            }
        }
        tallies
    }

    fn figures(&self, tally: &Tally) -> Figures {
        tally.figures(self.validation.measures())
    }

    fn tensors(&self, parameters: &[f32]) -> Result<Vec<(String, Table)>, ReadWeightsError> {
        let mut parameters = parameters.to_vec();
        // An attribute that was not read must not count, whatever it is.
        if let Some(first) = self.mlp.spans().next() {
            for rows in &self.unread {
                parameters[rows.start * first.outputs..rows.end * first.outputs].fill(0.0);
            }
        }
        self.mlp.tensors(self.network.name(), &parameters)
    }
}

/// The samples of a batch, row by row. The tensors take the memory over, without a copy.
struct Buffers {
    rows: usize,
    inputs: Vec<f32>,
    targets: Vec<f32>,
    widths: (usize, usize),
}

impl Buffers {
    fn new(task: &dyn Task, rows: usize) -> Self {
        let widths = (task.inputs(), task.targets());
        let (inputs, targets) = (vec![0.0; rows * widths.0], vec![0.0; rows * widths.1]);
        Self { rows, inputs, targets, widths }
    }

    /// Inputs and targets of each row.
    fn rows(&mut self) -> impl Iterator<Item = (&mut [f32], &mut [f32])> {
        self.inputs
            .chunks_exact_mut(self.widths.0)
            .zip(self.targets.chunks_exact_mut(self.widths.1))
    }

    /// Zeros in the place of what is not read.
    fn blank(&mut self, unread: &[Range<usize>]) {
        for inputs in self.inputs.chunks_exact_mut(self.widths.0) {
            unread.iter().for_each(|range| inputs[range.clone()].fill(0.0));
        }
    }

    fn inputs_tensor(self, device: &Device) -> Tensor<2> {
        Tensor::from_data(TensorData::new(self.inputs, [self.rows, self.widths.0]), device)
    }

    fn into_tensors(mut self, device: &Device) -> (Tensor<2>, Tensor<2>) {
        let targets = std::mem::take(&mut self.targets);
        let targets = TensorData::new(targets, [self.rows, self.widths.1]);
        (self.inputs_tensor(device), Tensor::from_data(targets, device))
    }
}
