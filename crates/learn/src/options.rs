//! How to train.

use std::collections::BTreeMap;
use std::ops::Range;

use deeptree_graph::signature::{paper, situated};
use deeptree_infer::ModelKind;
use serde::{Deserialize, Serialize};

use crate::{Processor, TrainError, tasks::Network};

/// Trees a step of `outlook`: its samples are grids of 65 536 values, and there are few.
const OUTLOOK_BATCH: usize = 64;

/// `outlook` takes one step where the networks of nodes take so many.
const OUTLOOK_PART: u64 = 10;

/// Which networks to train.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A distribution for each factor of the chain rule.
    Situated,
    /// As published: a classifier and a cascade of regressors.
    Paper,
    /// The published classifier and regressors as heads of one network.
    Joint,
}

impl From<Kind> for ModelKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Situated => Self::Situated,
            Kind::Paper => Self::Paper,
            Kind::Joint => Self::Joint,
        }
    }
}

/// How to train a model. All but `workers` decide what comes out; on another `device` the last bits
/// differ, so a checkpoint is of one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainOptions {
    /// Which networks.
    pub kind: Kind,
    /// Seed of the initial weights, the order of the samples and the noise; below 2⁶³, as TOML
    /// writes it.
    pub seed: u64,
    /// Samples a step; 64 for `outlook`, whose samples are whole trees.
    pub batch: usize,
    /// Epochs; a checkpoint and a validation follow each.
    pub epochs: u32,
    /// Steps an epoch; without it, as many as visit every sample once. Fewer steps do not leave
    /// samples out: the next epoch goes on where the last one stopped. `outlook` takes a tenth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_per_epoch: Option<u64>,
    /// Learning rate after the warm-up.
    pub learning_rate: f64,
    /// Learning rate at the end; a cosine leads there.
    pub final_learning_rate: f64,
    /// Steps in which the learning rate rises linearly from 0.
    pub warmup_steps: u64,
    /// Decay of the running average of the weights that is validated and written; 0 for the
    /// weights themselves. 0.999 averages over the last thousand steps or so.
    pub average_decay: f64,
    /// Standard deviation of the noise on positions, in the unit cube; kind `paper` only.
    pub position_noise: f64,
    /// Samples of the validation trees, evenly spread, that an epoch is judged by; the report at
    /// the end looks at all.
    pub validation_samples: usize,
    /// What differs for single networks, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub networks: BTreeMap<String, NetworkOptions>,
    /// What to train on.
    #[serde(default)]
    pub device: Processor,
    /// Networks that train side by side, one thread each.
    pub workers: usize,
}

/// What differs for one network; what is `None` is as in [`TrainOptions`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkOptions {
    /// Widths of the hidden layers; otherwise 160-160-160 for kind `paper`, and for kind `situated`
    /// 106-106 (`existence`), 64-64 (`split`, `reach`, `size`), 96-96 (`rotation1`),
    /// 80-80 (`rotation2`, `rotation3`) and 48 (`outlook`, behind its convolutions).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hidden: Option<Vec<usize>>,
    /// Epochs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u32>,
    /// Steps an epoch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_per_epoch: Option<u64>,
    /// Learning rate after the warm-up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning_rate: Option<f64>,
    /// The attributes of the node that the network reads, by the names in
    /// [`deeptree_graph::signature::paper::ATTRIBUTES`], for kind `situated` in
    /// [`deeptree_graph::signature::situated::ATTRIBUTES`]. The others are zeros in training, and
    /// the model that is written has no weights for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reads: Option<Vec<String>>,
    /// Draw nodes with 0, 1, 2 and 3 children equally often; for `existence`, which is calibrated
    /// without. Only to show what becomes of trees then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub balanced: Option<bool>,
}

impl TrainOptions {
    /// The settings a model of this kind is trained with by default.
    ///
    /// # Source
    ///
    /// For kind `paper` DeepTree §5.2: Adam, learning rate 1e-4, batch 512, noise 1e-4; epochs of
    /// 10 000 steps, since 150 passes over all nodes are out of reach of a processor.
    ///
    /// For kind `situated` ours: growth is critical, so a bias of a hundredth in the number of
    /// children is a tenth of the nodes, and existence trains long; `rotation1`, whose laws are the
    /// sharpest, longest.
    #[must_use]
    pub fn new(kind: Kind) -> Self {
        let situated = Self {
            kind,
            seed: 1,
            batch: 1024,
            epochs: 18,
            steps_per_epoch: Some(5_000),
            learning_rate: 2e-3,
            final_learning_rate: 1e-5,
            warmup_steps: 200,
            average_decay: 0.999,
            position_noise: 0.0,
            validation_samples: 1 << 16,
            networks: BTreeMap::new(),
            device: Processor::Cpu,
            workers: std::thread::available_parallelism().map_or(1, Into::into),
        };
        let epochs = |epochs| NetworkOptions { epochs: Some(epochs), ..NetworkOptions::default() };
        match kind {
            Kind::Situated => Self {
                networks: [30, 12, 12, 8, 12, 4, 18]
                    .into_iter()
                    .zip([
                        "rotation1",
                        "rotation2",
                        "rotation3",
                        "split",
                        "reach",
                        "size",
                        "outlook",
                    ])
                    .map(|(count, name)| (name.to_owned(), epochs(count)))
                    .collect(),
                ..situated
            },
            Kind::Paper | Kind::Joint => Self {
                batch: 512,
                epochs: 6,
                steps_per_epoch: Some(10_000),
                learning_rate: 1e-4,
                final_learning_rate: 1e-4,
                warmup_steps: 0,
                average_decay: 0.0,
                position_noise: 1e-4,
                ..situated
            },
        }
    }

    /// The settings of [`crate::train_points`] by default. `batch` counts all laws together.
    #[must_use]
    pub fn points() -> Self {
        Self {
            batch: 384,
            epochs: 6,
            steps_per_epoch: Some(500),
            validation_samples: 1 << 11,
            workers: 1,
            networks: BTreeMap::new(),
            ..Self::new(Kind::Situated)
        }
    }

    /// Checks that every setting is one that can be trained with.
    ///
    /// # Errors
    ///
    /// [`TrainError::Option`], for the first that cannot.
    pub fn validate(&self) -> Result<(), TrainError> {
        let check = |ok: bool, option: &str, value: String, expected| {
            let error = || TrainError::Option { option: option.into(), value, expected };
            if ok { Ok(()) } else { Err(error()) }
        };
        let rate = |x: f64| x.is_finite() && x > 0.0;
        check(i64::try_from(self.seed).is_ok(), "seed", self.seed.to_string(), "below 2⁶³")?;
        check(self.batch > 0, "batch", self.batch.to_string(), "at least 1")?;
        check(self.workers > 0, "workers", self.workers.to_string(), "at least 1")?;
        let (first, last) = (self.learning_rate, self.final_learning_rate);
        check(rate(first), "learning_rate", first.to_string(), "above 0")?;
        check(rate(last), "final_learning_rate", last.to_string(), "above 0")?;
        let decay = self.average_decay;
        check((0.0..1.0).contains(&decay), "average_decay", decay.to_string(), "in [0, 1)")?;
        let noise = self.position_noise;
        check(
            noise.is_finite() && noise >= 0.0,
            "position_noise",
            noise.to_string(),
            "at least 0",
        )?;
        let known = Network::all(self.kind);
        for (name, one) in &self.networks {
            let found = known.iter().any(|network| network.name() == name);
            check(found, "networks", format!("`{name}`"), "the name of a network of this kind")?;
            let rates = one.learning_rate.is_none_or(rate);
            check(rates, "learning_rate", format!("{:?}", one.learning_rate), "above 0")?;
            let widths = one.hidden.iter().flatten().all(|&width| width > 0);
            check(widths, "hidden", format!("{:?}", one.hidden), "widths of at least 1")?;
            if name == Network::Outlook.name() {
                let all = one.reads.is_none();
                check(all, "reads", format!("of `{name}`"), "unset: it reads no nodes")?;
            }
            for attribute in one.reads.iter().flatten() {
                let known = self.attribute(attribute, 1).is_some();
                check(known, "reads", format!("`{attribute}`"), "an attribute that the kind has")?;
            }
        }
        known.iter().try_for_each(|&network| {
            let plan = self.schedule(network, 1);
            check(plan.epochs > 0, "epochs", plan.epochs.to_string(), "at least 1")?;
            let steps = plan.steps_per_epoch;
            check(steps > 0, "steps_per_epoch", steps.to_string(), "at least 1")
        })
    }

    /// The inputs that a network does not read, of a model of so many species.
    pub(crate) fn unread(&self, network: Network, species: usize) -> Vec<Range<usize>> {
        let Some(reads) = self.networks.get(network.name()).and_then(|own| own.reads.as_ref())
        else {
            return Vec::new();
        };
        let hidden = |name: &&&str| !reads.iter().any(|read| read == **name);
        let range = |name: &&str| self.attribute(name, species);
        let all: &[&str] = match self.kind {
            Kind::Situated => &situated::ATTRIBUTES,
            Kind::Paper | Kind::Joint => &paper::ATTRIBUTES,
        };
        all.iter().filter(hidden).filter_map(range).collect()
    }

    /// Where an attribute stands among the inputs.
    fn attribute(&self, name: &str, species: usize) -> Option<Range<usize>> {
        match self.kind {
            Kind::Situated => situated::attribute(name, species),
            Kind::Paper | Kind::Joint => paper::attribute(name, species),
        }
    }

    /// What holds for one network of so many samples. Without any (no species has children in the
    /// last slot, say) nothing is trained: the network of the initial weights is never asked.
    pub(crate) fn schedule(&self, network: Network, samples: usize) -> Schedule {
        let own = self.networks.get(network.name()).cloned().unwrap_or_default();
        let is_outlook = network == Network::Outlook;
        let batch = if is_outlook { OUTLOOK_BATCH } else { self.batch };
        let all = samples.div_ceil(batch.max(1)) as u64;
        let shared = |steps: u64| if is_outlook { steps.div_ceil(OUTLOOK_PART) } else { steps };
        let steps = own.steps_per_epoch.or(self.steps_per_epoch.map(shared));
        Schedule {
            hidden: own.hidden.unwrap_or_else(|| network.hidden().to_vec()),
            batch,
            epochs: if samples > 0 { own.epochs.unwrap_or(self.epochs) } else { 0 },
            steps_per_epoch: steps.unwrap_or(all),
            learning_rate: own.learning_rate.unwrap_or(self.learning_rate),
            final_learning_rate: self.final_learning_rate,
            warmup_steps: self.warmup_steps,
            average_decay: self.average_decay,
        }
    }
}

/// How one network trains.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Schedule {
    pub(crate) hidden: Vec<usize>,
    pub(crate) batch: usize,
    pub(crate) epochs: u32,
    pub(crate) steps_per_epoch: u64,
    learning_rate: f64,
    final_learning_rate: f64,
    warmup_steps: u64,
    pub(crate) average_decay: f64,
}

impl Schedule {
    /// Steps of all epochs.
    pub(crate) fn steps(&self) -> u64 {
        u64::from(self.epochs) * self.steps_per_epoch
    }

    /// The learning rate of step `step`, which counts from 0: a linear rise, then a cosine.
    ///
    /// `λ = λ_end + (λ_0 − λ_end) (1 + cos πx) / 2`, x from 0 after the warm-up to 1 at the end.
    pub(crate) fn learning_rate(&self, step: u64) -> f64 {
        if step < self.warmup_steps {
            return self.learning_rate * (step + 1) as f64 / self.warmup_steps as f64;
        }
        let rest = self.steps().saturating_sub(self.warmup_steps).max(1);
        let done = (step - self.warmup_steps) as f64 / rest as f64;
        let wave = 0.5 * (1.0 + libm::cos(core::f64::consts::PI * done.min(1.0)));
        self.final_learning_rate + (self.learning_rate - self.final_learning_rate) * wave
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_learning_rate_rises_linearly_then_falls_as_a_cosine() {
        let options = TrainOptions { epochs: 2, ..TrainOptions::new(Kind::Situated) };
        let options = TrainOptions { steps_per_epoch: Some(1100), warmup_steps: 200, ..options };
        let schedule = options.schedule(Network::Existence, 1);
        let near = |step, expected: f64| {
            let rate = schedule.learning_rate(step);
            assert!((rate - expected).abs() < 1e-6, "step {step}: {rate}");
        };
        near(99, 1e-3);
        near(200, 2e-3);
        near(1200, (2e-3 + 1e-5) / 2.0);
        near(2200, 1e-5);
    }

    #[test]
    fn the_four_networks_of_the_paper_fit_in_its_913_kilobytes() {
        let (species, mut count) = (8, 0);
        for (earlier, network) in [0, 0, 1, 2].into_iter().zip(Network::all(Kind::Paper)) {
            use deeptree_graph::signature::paper::{CHILD_LEN, len};
            let outputs = if network == Network::Classifier { 3 } else { 6 };
            let inputs = len(species) + earlier * CHILD_LEN;
            count += crate::mlp::Mlp::new(inputs, network.hidden(), outputs).parameters();
        }
        assert!(4 * count <= 913_000, "{} bytes", 4 * count);
    }

    #[test]
    fn options_survive_toml_and_bad_ones_are_named() {
        let mut options = TrainOptions::new(Kind::Paper);
        let own = NetworkOptions { hidden: Some(vec![8]), ..NetworkOptions::default() };
        options.networks.insert("classifier".into(), own);
        let text = toml::to_string(&options).unwrap();
        assert_eq!(toml::from_str::<TrainOptions>(&text).unwrap(), options);
        assert!(options.validate().is_ok());

        options.networks.insert("existence".into(), NetworkOptions::default());
        let message = options.validate().unwrap_err().to_string();
        assert!(message.contains("existence"), "{message}");
        let zero = TrainOptions { batch: 0, ..TrainOptions::new(Kind::Situated) };
        assert!(
            matches!(zero.validate(), Err(TrainError::Option { option, .. }) if option == "batch")
        );
    }
}
