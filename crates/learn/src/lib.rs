//! Training: the only crate that knows Burn.
//!
//! [`train`] takes trees in memory and gives the bytes of a model file, with a report on how it
//! was made and how well it does on trees it has not seen. Three kinds of model:
//!
//! | kind | networks | what they learn |
//! |---|---|---|
//! | [`Kind::Situated`] | `existence`, `split`, `reach`, `size`, `rotation1` … `rotation3` | the factors of p(children \| node) by the chain rule, each a distribution |
//! | | `outlook` | what an environment makes of a tree as a whole; where some trees have grown in one |
//! | | `competition` | what the trees around make of a tree, from stands: [`train_competition`] |
//! | [`Kind::Joint`] | `joint` | the same from one network, which the paper compares its own with |
//! | [`Kind::Paper`] | `classifier`, `regressor1` … `regressor3` | as published: which children exist, and their mean signatures |
//!
//! [`train_points`] adds networks to a model of kind `situated` that hear of the points around a
//! node; the model itself stays as it is.
//!
//! Every network trains by itself, one thread each, several side by side. After each epoch its
//! whole state goes into a checkpoint; a run that was cut off continues from there and ends with
//! the same bits. Randomness is keyed by the seed: initial weights, the order of the samples and
//! the noise on them depend on nothing else.

#![forbid(unsafe_code)]

mod adam;
mod checkpoint;
mod competition;
mod course;
mod device;
mod error;
mod kept;
mod loss;
mod mlp;
mod model;
mod options;
mod order;
mod progress;
mod report;
mod rotations;
mod scan;
mod set;
mod surroundings;
mod tables;
mod tasks;
mod training;
mod trend;

pub use competition::{Rivalries, Rivalry, train_competition};
pub use device::Processor;
pub use error::TrainError;
pub use model::{TrainedModel, retrain, train, train_points};
pub use options::{Kind, NetworkOptions, TrainOptions};
pub use progress::{Silent, TrainEvent, TrainProgress};
pub use report::{Figures, NetworkReport, ReliabilityBin, Report, TrendReport};
pub use scan::{Scan, Scans};
pub use set::TrainingSet;
pub use surroundings::Surroundings;
pub use trend::{Surveyed, train_trend};
