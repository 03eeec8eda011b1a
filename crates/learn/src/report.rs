//! How a model was made and how well it does: what is written beside it.

use std::collections::BTreeMap;

use deeptree_infer::{Model, ReadWeightsError, Weights};
use serde::{Deserialize, Serialize};

use crate::{Kind, TrainError, TrainOptions};

/// Bins of the reliability table.
const BINS: usize = 10;

/// How a model was made, and its figures on the validation trees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Tells the training data from other data.
    pub data_hash: String,
    /// The species, in the order of the model's tables.
    pub species: Vec<String>,
    /// Training trees.
    pub training_trees: usize,
    /// Nodes of the training trees.
    pub training_nodes: usize,
    /// Validation trees.
    pub validation_trees: usize,
    /// Time to train in seconds, the runs before a resume included.
    pub seconds: f64,
    /// Weights, biases and gains of all networks.
    pub weight_count: usize,
    /// Size of the model file in bytes.
    pub bytes: usize,
    /// SHA-256 of the model file, in hexadecimal.
    pub sha256: String,
    /// The options.
    pub options: TrainOptions,
    /// The trees that its trend was fitted to, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trend: Option<TrendReport>,
    /// The networks, by name.
    pub networks: BTreeMap<String, NetworkReport>,
}

/// What a trend over age and gravitropism was fitted to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrendReport {
    /// Tells the trees from others.
    pub data_hash: String,
    /// How many trees.
    pub trees: usize,
}

impl Report {
    /// The text of the file beside the model.
    ///
    /// # Errors
    ///
    /// [`TrainError::Toml`], when a number is out of the range of TOML.
    pub fn to_toml(&self) -> Result<String, TrainError> {
        Ok(toml::to_string(self)?)
    }

    /// Reads the text of such a file.
    ///
    /// # Errors
    ///
    /// [`TrainError::Report`], when it is none.
    pub fn from_toml(text: &str) -> Result<Self, TrainError> {
        toml::from_str(text).map_err(TrainError::Report)
    }

    /// Refuses a model that this is no report of, and one of another kind.
    pub(crate) fn check(&self, model: &Weights, kind: Kind) -> Result<(), TrainError> {
        let what = if hexadecimal(model.sha256()) != self.sha256 {
            "the file beside it tells of another model; put its own there"
        } else if model.kind() != kind.into() || self.options.kind != kind {
            "it is of another kind; name one of the kind that is trained"
        } else {
            return Ok(());
        };
        Err(TrainError::OtherModel { what })
    }

    /// What is told of the same model with another network, of which `weights` is the file.
    pub(crate) fn with(
        &self,
        name: &str,
        network: NetworkReport,
        weights: &[u8],
    ) -> Result<Self, ReadWeightsError> {
        let mut report = self.clone();
        report.networks.insert(name.into(), network);
        report.seconds = report.networks.values().map(|one| one.seconds).sum();
        report.tell(weights)?;
        Ok(report)
    }

    /// What is told of the same model with another trend, of which `weights` is the file.
    pub(crate) fn with_trend(
        &self,
        trend: TrendReport,
        weights: &[u8],
    ) -> Result<Self, ReadWeightsError> {
        let mut report = Self { trend: Some(trend), ..self.clone() };
        report.tell(weights)?;
        Ok(report)
    }

    /// Tells of the file `weights`, which must be what inference reads.
    fn tell(&mut self, weights: &[u8]) -> Result<(), ReadWeightsError> {
        let read = Weights::from_bytes(weights)?;
        self.weight_count = Model::from_weights(&read)?.weight_count();
        (self.bytes, self.sha256) = (weights.len(), hexadecimal(read.sha256()));
        Ok(())
    }
}

/// Bytes as hexadecimal digits.
pub(crate) fn hexadecimal(bytes: [u8; 32]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// How one network was trained, and its figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NetworkReport {
    /// Widths of the layers, inputs first.
    pub sizes: Vec<usize>,
    /// Weights, biases and gains.
    pub weight_count: usize,
    /// Samples in the training trees.
    pub samples: usize,
    /// Steps of the optimiser.
    pub steps: u64,
    /// Time to train in seconds, without validation.
    pub seconds: f64,
    /// Training samples a second.
    pub samples_per_second: f64,
    /// Tells the training data from other data; where they are not those of the whole model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data_hash: Option<String>,
    /// Figures of all validation trees.
    pub total: Figures,
    /// Figures by species.
    pub species: BTreeMap<String, Figures>,
}

/// Figures of a network on validation samples.
///
/// | figure | of | what |
/// |---|---|---|
/// | `cross_entropy` | existence | mean −ln p of what happened |
/// | `accuracy` | existence | share of nodes whose class is the likeliest |
/// | `children_predicted`, `children_actual`, `children_excess` | existence | mean number of children, as predicted and in truth, and the difference |
/// | `heir_predicted`, `heir_actual` | reach | share of heirs where it is asked, as predicted and in truth, over all questions |
/// | `nll` | split, reach, size, rotation | mean −ln p of what happened, rotations in deviations |
/// | `aligned_predicted`, `aligned_actual` | rotation | mean probability that a swing is aligned, share that is |
/// | `<law>`, `<law>_without`, `<law>_base` | points | mean −ln p of trees that are known by a scan: of the networks that hear the points, of the same where no points are told, and of the model itself |
/// | `accuracy`, `accuracy_all_three` | classifier, joint | share of children told right at 0.5; of nodes with all three right |
/// | `mse` | classifier, regressor, joint | mean squared error; of thickness and length in m², but for the classifier |
/// | `mse`, `mse_open` | outlook | mean squared error of all outputs, of trees in environments and in the open field; states in deviations of the species, offsets over 4 m |
/// | `mse_<output>`, `r2_<output>` | outlook | of trees in environments: mean squared error, and what part of the variance is foreseen |
/// | `mse_<state>`, `r2_<state>` | competition | mean squared error of the shift in its deviations, and what part of its variance is foreseen |
/// | `scatter_nodes` | competition | root mean square of what ln nodes are off, over that of the foreseen shift |
/// | `existence_mse` | joint | mean squared error of the probabilities of children |
/// | `cosine_distance` | regressor, joint | mean 1 − cos of the quaternions |
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Samples looked at.
    pub samples: u64,
    /// The figures by name.
    #[serde(flatten)]
    pub values: BTreeMap<String, f64>,
    /// Predicted against actual frequency of children, where a network predicts them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reliability: Vec<ReliabilityBin>,
}

/// Children that were predicted with a probability in one tenth of 0 … 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReliabilityBin {
    /// How many children were predicted so.
    pub count: u64,
    /// Mean of the predicted probabilities.
    pub predicted: f64,
    /// Share that exists.
    pub actual: f64,
}

/// Sums of which [`Figures`] are the means.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    samples: u64,
    /// Sum of each value, and of how many samples or parts of samples.
    sums: Vec<(f64, u64)>,
    /// Count, sum of the probabilities, children that exist.
    bins: [(u64, f64, u64); BINS],
}

impl Tally {
    /// Counts one sample with its values, in the order of the task's measures.
    pub(crate) fn count(&mut self, values: &[f64]) {
        self.samples += 1;
        self.count_parts(0, &[values]);
    }

    /// Counts values of the parts that the sample just counted has, such as its children, as the
    /// measures from `first` on.
    pub(crate) fn count_parts<V: AsRef<[f64]>>(&mut self, first: usize, parts: &[V]) {
        for values in parts.iter().map(AsRef::as_ref) {
            let end = self.sums.len().max(first + values.len());
            self.sums.resize(end, (0.0, 0));
            for (sum, value) in self.sums[first..].iter_mut().zip(values) {
                *sum = (sum.0 + value, sum.1 + 1);
            }
        }
    }

    /// Notes that a child was predicted with probability `p`, and whether it exists.
    pub(crate) fn rely(&mut self, p: f64, exists: bool) {
        let bin = &mut self.bins[((p * BINS as f64) as usize).min(BINS - 1)];
        bin.0 += 1;
        bin.1 += p;
        bin.2 += u64::from(exists);
    }

    /// Adds what another tally counted.
    pub(crate) fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.sums.resize(self.sums.len().max(other.sums.len()), (0.0, 0));
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            *sum = (sum.0 + more.0, sum.1 + more.1);
        }
        for (bin, other) in self.bins.iter_mut().zip(&other.bins) {
            *bin = (bin.0 + other.0, bin.1 + other.1, bin.2 + other.2);
        }
    }

    /// The means, named.
    pub(crate) fn figures(&self, names: &[&str]) -> Figures {
        let mean = |(sum, count): &(f64, u64)| sum / *count as f64;
        let values = names.iter().map(|&name| name.to_owned()).zip(self.sums.iter().map(mean));
        let bin = |&(count, predicted, actual): &(u64, f64, u64)| ReliabilityBin {
            count,
            predicted: predicted / count.max(1) as f64,
            actual: actual as f64 / count.max(1) as f64,
        };
        let relied = self.bins.iter().any(|bin| bin.0 > 0);
        let reliability = if relied { self.bins.iter().map(bin).collect() } else { Vec::new() };
        Figures { samples: self.samples, values: values.collect(), reliability }
    }
}
