//! The training loop of one network.

use std::path::Path;
use std::time::{Duration, Instant};

use burn::tensor::Device;
use deeptree_graph::{Lineage, Purpose, Seed};

use crate::adam::State;
use crate::checkpoint::Checkpoint;
use crate::course::Course;
use crate::mlp;
use crate::options::Schedule;
use crate::report::Tally;
use crate::tasks::Network;
use crate::{TrainError, TrainEvent, TrainProgress};

/// Steps between two looks at the loss: each waits for the device.
const REPORT_STEPS: u64 = 100;

/// All that the training of one network needs.
pub(crate) struct Trainer<'a> {
    pub(crate) network: Network,
    pub(crate) course: &'a dyn Course,
    pub(crate) schedule: Schedule,
    pub(crate) seed: Seed,
    pub(crate) validation_samples: usize,
    pub(crate) device: &'a Device,
    pub(crate) checkpoints: &'a Path,
    pub(crate) progress: &'a dyn TrainProgress,
}

/// A network that is done.
pub(crate) struct Trained {
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
    pub(crate) fn run(&self) -> Result<Trained, TrainError> {
        let path = Checkpoint::path(self.checkpoints, self.network.name());
        let (mut state, done, seconds_before) = self.restore(&path)?;
        let start = Instant::now();
        let mut clock = Clock { start, first_step: state.step, seconds: 0.0, seconds_before };
        self.progress.event(TrainEvent::Start {
            network: self.network.name(),
            samples: self.course.samples(),
            parameters: self.course.parameters(),
            epochs_done: done,
            epochs: self.schedule.epochs,
            steps: self.schedule.steps(),
        });
        for epoch in done + 1..=self.schedule.epochs {
            clock.start = Instant::now();
            state = self.epoch(state, epoch, &clock)?;
            clock.seconds = clock.seconds();
            clock.start = Instant::now();
            checkpoint(&state, epoch, clock.seconds_before + clock.seconds).write(&path)?;
            self.judge_epoch(&state, epoch);
            if epoch < self.schedule.epochs && !self.progress.keep_going() {
                return Err(TrainError::Stopped { network: self.network.name().into(), epoch });
            }
        }
        let seconds = clock.seconds_before + clock.seconds;
        let tallies = self.course.validate(&state.average, usize::MAX);
        self.progress.event(TrainEvent::Done { network: self.network.name() });
        let parameters = mlp::values(state.average);
        Ok(Trained { parameters, steps: state.step, seconds, tallies })
    }

    /// The state to go on from, with the epochs done and the seconds they took.
    fn restore(&self, path: &Path) -> Result<(State, u32, f64), TrainError> {
        let flat = |values| mlp::flat(values, self.device);
        let Some(saved) = Checkpoint::read(path, self.course.parameters())? else {
            let draws = self.seed.draws(Lineage::ROOT, Purpose::InitialWeights);
            let initial = self.course.initial(&draws.at(self.network.key()));
            return Ok((State::new(flat(initial)), 0, 0.0));
        };
        let [parameters, first, second, average] = saved.arrays.map(flat);
        let state = State { parameters, first, second, average, step: saved.step };
        Ok((state, saved.epochs, saved.seconds))
    }

    fn epoch(&self, mut state: State, epoch: u32, clock: &Clock) -> Result<State, TrainError> {
        for in_epoch in 1..=self.schedule.steps_per_epoch {
            let (loss, gradient) = self.course.descend(&state.parameters, state.step);
            let rate = self.schedule.learning_rate(state.step);
            state = state.update(gradient, rate, self.schedule.average_decay);
            if in_epoch % REPORT_STEPS == 0 || in_epoch == self.schedule.steps_per_epoch {
                self.report(loss.into_scalar::<f32>(), epoch, state.step, clock)?;
            }
        }
        Ok(state)
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

    fn judge_epoch(&self, state: &State, epoch: u32) {
        let tallies = self.course.validate(&state.average, self.validation_samples);
        let figures = self.course.figures(&total(&tallies));
        self.progress.event(TrainEvent::Epoch { network: self.network.name(), epoch, figures });
    }
}

/// All species together.
pub(crate) fn total(tallies: &[Tally]) -> Tally {
    let mut sum = Tally::default();
    tallies.iter().for_each(|tally| sum.add(tally));
    sum
}

fn checkpoint(state: &State, epochs: u32, seconds: f64) -> Checkpoint {
    let arrays = [&state.parameters, &state.first, &state.second, &state.average];
    let arrays = arrays.map(|tensor| mlp::values(tensor.clone()));
    Checkpoint { epochs, step: state.step, seconds, arrays }
}
