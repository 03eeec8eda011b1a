//! What a caller can follow and stop.

use std::time::Duration;

use crate::report::Figures;

/// Something that happened while networks train. Networks train side by side: their events mix.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TrainEvent {
    /// A network starts, or continues from a checkpoint.
    Start {
        /// Its name.
        network: &'static str,
        /// Its training samples.
        samples: usize,
        /// Its weights, biases and gains.
        parameters: usize,
        /// Epochs that a checkpoint holds already.
        epochs_done: u32,
        /// Epochs in all.
        epochs: u32,
        /// Steps in all.
        steps: u64,
    },
    /// Some more steps are done.
    Step {
        /// The network's name.
        network: &'static str,
        /// The epoch under way, from 1.
        epoch: u32,
        /// Steps done, of all epochs.
        step: u64,
        /// Loss of the last batch.
        loss: f32,
        /// Speed since this run started.
        samples_per_second: f64,
        /// What is left of this network at that speed.
        left: Duration,
    },
    /// An epoch is done, and its checkpoint written.
    Epoch {
        /// The network's name.
        network: &'static str,
        /// The epoch, from 1.
        epoch: u32,
        /// Figures on some validation samples, all species together.
        figures: Figures,
    },
    /// A network is done.
    Done {
        /// Its name.
        network: &'static str,
    },
}

/// A caller that follows the training. Called from several threads.
pub trait TrainProgress: Sync {
    /// Takes note of an event; must return soon.
    fn event(&self, event: TrainEvent);

    /// Whether to go on; asked after the checkpoint of each epoch.
    fn keep_going(&self) -> bool {
        true
    }
}

/// A caller that follows nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl TrainProgress for Silent {
    fn event(&self, _event: TrainEvent) {}
}

impl<F: Fn(TrainEvent) + Sync> TrainProgress for F {
    fn event(&self, event: TrainEvent) {
        self(event);
    }
}
