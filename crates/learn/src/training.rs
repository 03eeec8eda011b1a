//! The training loop of one network.

use std::ops::Range;
use std::path::Path;
use std::time::{Duration, Instant};

use burn::tensor::{Device, Tensor, TensorData};
use deeptree_graph::{Lineage, Purpose, Seed};

use crate::adam::State;
use crate::checkpoint::Checkpoint;
use crate::mlp::{self, Mlp};
use crate::options::Schedule;
use crate::order::Order;
use crate::report::{Figures, Tally};
use crate::tasks::{Network, Task, noise_draws};
use crate::{TrainError, TrainEvent, TrainProgress};

/// Steps between two looks at the loss: each waits for the device.
const REPORT_STEPS: u64 = 100;

/// Samples that a validation sends through the network at once.
const VALIDATION_BATCH: usize = 2048;

/// All that the training of one network needs.
pub(crate) struct Trainer<'a> {
    pub(crate) network: Network,
    pub(crate) train: &'a dyn Task,
    pub(crate) validation: &'a dyn Task,
    pub(crate) schedule: Schedule,
    /// Inputs that the network does not read.
    pub(crate) unread: &'a [Range<usize>],
    pub(crate) seed: Seed,
    pub(crate) validation_samples: usize,
    pub(crate) device: &'a Device,
    pub(crate) checkpoints: &'a Path,
    pub(crate) progress: &'a dyn TrainProgress,
}

/// A network that is done.
pub(crate) struct Trained {
    pub(crate) mlp: Mlp,
    /// Running average of the parameters.
    pub(crate) parameters: Vec<f32>,
    pub(crate) steps: u64,
    /// Time trained, without validation.
    pub(crate) seconds: f64,
    /// Figures on all validation samples, by species.
    pub(crate) tallies: Vec<Tally>,
}

/// How long the training took: validation and checkpoints are left out.
struct Clock {
    /// Since when the epoch under way has been training.
    start: Instant,
    first_step: u64,
    /// Of this run, before `start`.
    seconds: f64,
    seconds_before: f64,
}

impl Clock {
    /// Of this run.
    fn seconds(&self) -> f64 {
        self.seconds + self.start.elapsed().as_secs_f64()
    }
}

impl Trainer<'_> {
    /// Trains the network to the end of its schedule.
    pub(crate) fn run(&self, species: usize) -> Result<Trained, TrainError> {
        let mlp = Mlp::new(self.train.inputs(), &self.schedule.hidden, self.train.outputs());
        let path = Checkpoint::path(self.checkpoints, self.network.name());
        let (mut state, done, seconds_before) = self.restore(&mlp, &path)?;
        let start = Instant::now();
        let mut clock = Clock { start, first_step: state.step, seconds: 0.0, seconds_before };
        self.progress.event(TrainEvent::Start {
            network: self.network.name(),
            samples: self.train.samples(),
            parameters: mlp.parameters(),
            epochs_done: done,
            epochs: self.schedule.epochs,
            steps: self.schedule.steps(),
        });
        for epoch in done + 1..=self.schedule.epochs {
            clock.start = Instant::now();
            state = self.epoch(&mlp, state, epoch, &clock)?;
            clock.seconds = clock.seconds();
            clock.start = Instant::now();
            checkpoint(&state, epoch, clock.seconds_before + clock.seconds).write(&path)?;
            self.judge_epoch(&mlp, &state, epoch, species);
            if epoch < self.schedule.epochs && !self.progress.keep_going() {
                return Err(TrainError::Stopped { network: self.network.name().into(), epoch });
            }
        }
        let seconds = clock.seconds_before + clock.seconds;
        let tallies = self.validate(&mlp, &state.average, species, usize::MAX);
        self.progress.event(TrainEvent::Done { network: self.network.name() });
        let parameters = mlp::values(state.average);
        Ok(Trained { mlp, parameters, steps: state.step, seconds, tallies })
    }

    /// The state to go on from, with the epochs done and the seconds they took.
    fn restore(&self, mlp: &Mlp, path: &Path) -> Result<(State, u32, f64), TrainError> {
        let flat = |values| mlp::flat(values, self.device);
        let Some(saved) = Checkpoint::read(path, mlp.parameters())? else {
            let draws = self.seed.draws(Lineage::ROOT, Purpose::InitialWeights);
            let initial = mlp.initial(&draws.at(self.network.key()));
            return Ok((State::new(flat(initial)), 0, 0.0));
        };
        let [parameters, first, second, average] = saved.arrays.map(flat);
        let state = State { parameters, first, second, average, step: saved.step };
        Ok((state, saved.epochs, saved.seconds))
    }

    fn epoch(
        &self,
        mlp: &Mlp,
        mut state: State,
        epoch: u32,
        clock: &Clock,
    ) -> Result<State, TrainError> {
        let mut order = Order::new(self.seed, self.network.key(), self.train.samples());
        for in_epoch in 1..=self.schedule.steps_per_epoch {
            let (inputs, targets) = self.batch(state.step, &mut order);
            let layers = mlp.layers(&state.parameters, true);
            let loss = self.train.loss(layers.forward(inputs), targets);
            let mut gradients = loss.backward();
            let gradient = layers.gradient(&mut gradients).unwrap_or(state.first.zeros_like());
            // The layers share the parameters' memory: without them the update is in place.
            drop(layers);
            let rate = self.schedule.learning_rate(state.step);
            state = state.update(gradient, rate, self.schedule.average_decay);
            if in_epoch % REPORT_STEPS == 0 || in_epoch == self.schedule.steps_per_epoch {
                self.report(loss.into_scalar::<f32>(), epoch, state.step, clock)?;
            }
        }
        Ok(state)
    }

    /// The batch of a step, on the device.
    fn batch(&self, step: u64, order: &mut Order) -> (Tensor<2>, Tensor<2>) {
        let (rows, task) = (self.schedule.batch, self.train);
        let mut buffers = Buffers::new(task, rows);
        let first = step * rows as u64;
        for (row, (inputs, targets)) in buffers.rows().enumerate() {
            let position = first + row as u64;
            task.encode(task.pick(position, order), inputs, targets);
            if task.is_disturbed() {
                task.disturb(noise_draws(self.seed, self.network.key(), position), inputs);
            }
        }
        buffers.blank(self.unread);
        let (inputs, targets) = buffers.into_tensors(self.device);
        (inputs.autodiff(), targets.autodiff())
    }

    fn report(&self, loss: f32, epoch: u32, step: u64, clock: &Clock) -> Result<(), TrainError> {
        if !loss.is_finite() {
            return Err(TrainError::Diverged { network: self.network.name().into(), step, loss });
        }
        let done = (step - clock.first_step) as f64;
        let seconds = clock.seconds().max(1e-9);
        let left = (self.schedule.steps() - step) as f64 * seconds / done.max(1.0);
        self.progress.event(TrainEvent::Step {
            network: self.network.name(),
            epoch,
            step,
            loss,
            samples_per_second: done * self.schedule.batch as f64 / seconds,
            left: Duration::from_secs_f64(left),
        });
        Ok(())
    }

    fn judge_epoch(&self, mlp: &Mlp, state: &State, epoch: u32, species: usize) {
        let tallies = self.validate(mlp, &state.average, species, self.validation_samples);
        let figures = total(&tallies, self.validation.measures());
        self.progress.event(TrainEvent::Epoch { network: self.network.name(), epoch, figures });
    }

    /// Judges the network on at most `limit` samples of the validation trees, evenly spread.
    fn validate(
        &self,
        mlp: &Mlp,
        parameters: &Tensor<1>,
        species: usize,
        limit: usize,
    ) -> Vec<Tally> {
        let task = self.validation;
        let layers = mlp.layers(parameters, false);
        let mut tallies = vec![Tally::default(); species];
        let stride = task.samples().div_ceil(limit.max(1)).max(1);
        let samples: Vec<usize> = (0..task.samples()).step_by(stride).collect();
        for chunk in samples.chunks(VALIDATION_BATCH) {
            let mut buffers = Buffers::new(task, chunk.len());
            for (&sample, (inputs, targets)) in chunk.iter().zip(buffers.rows()) {
                task.encode(sample, inputs, targets);
            }
            buffers.blank(self.unread);
            let targets = std::mem::take(&mut buffers.targets);
            let outputs = mlp::values(layers.forward(buffers.inputs_tensor(self.device)));
            let rows =
                outputs.chunks_exact(task.outputs()).zip(targets.chunks_exact(task.targets()));
            for (&sample, (outputs, targets)) in chunk.iter().zip(rows) {
                task.measure(outputs, targets, &mut tallies[task.species(sample)]);
            }
        }
        tallies
    }
}

/// Figures of all species together.
pub(crate) fn total(tallies: &[Tally], names: &[&str]) -> Figures {
    let mut sum = Tally::default();
    tallies.iter().for_each(|tally| sum.add(tally));
    sum.figures(names)
}

fn checkpoint(state: &State, epochs: u32, seconds: f64) -> Checkpoint {
    let arrays = [&state.parameters, &state.first, &state.second, &state.average];
    let arrays = arrays.map(|tensor| mlp::values(tensor.clone()));
    Checkpoint { epochs, step: state.step, seconds, arrays }
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
