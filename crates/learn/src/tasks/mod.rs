//! What each network learns: which samples there are, what is read of one, and how an answer is
//! judged.

mod classifier;
mod existence;
mod joint;
mod reach;
mod regressor;
mod rotation;
mod size;
mod split;
mod swing;

use burn::tensor::Tensor;
pub(crate) use classifier::noise_draws;
use deeptree_graph::signature::{TreeConditions, situated};
use deeptree_graph::{Draws, MAX_CHILDREN};
pub(crate) use existence::{ln_class, tell_branching};
#[cfg(test)]
pub(crate) use split::bin_probability;
pub(crate) use swing::SwingTarget;

use crate::order::Order;
use crate::report::Tally;
use crate::rotations::Rotations;
use crate::set::{Corpus, Spot};
use crate::{Kind, TrainOptions};

/// A network of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Network {
    Existence,
    Split,
    Reach,
    Size,
    /// Of whole trees; it learns in a course of its own.
    Outlook,
    /// All that hear of points; they learn in a course of their own.
    Points,
    /// Of the child in a slot.
    Rotation(usize),
    Classifier,
    /// Of the child in a slot.
    Regressor(usize),
    Joint,
}

impl Network {
    /// The networks of a model, those that take longest first.
    pub(crate) fn all(kind: Kind) -> Vec<Self> {
        let slots = 0..MAX_CHILDREN;
        match kind {
            Kind::Situated => [Self::Existence]
                .into_iter()
                .chain(slots.map(Self::Rotation))
                .chain([Self::Split, Self::Reach, Self::Size, Self::Outlook])
                .collect(),
            Kind::Paper => {
                [Self::Classifier].into_iter().chain(slots.map(Self::Regressor)).collect()
            }
            Kind::Joint => vec![Self::Joint],
        }
    }

    pub(crate) fn name(self) -> &'static str {
        const ROTATIONS: [&str; MAX_CHILDREN] = ["rotation1", "rotation2", "rotation3"];
        const REGRESSORS: [&str; MAX_CHILDREN] = ["regressor1", "regressor2", "regressor3"];
        match self {
            Self::Existence => "existence",
            Self::Split => "split",
            Self::Reach => "reach",
            Self::Size => "size",
            Self::Outlook => "outlook",
            Self::Points => "points",
            Self::Rotation(slot) => ROTATIONS[slot],
            Self::Classifier => "classifier",
            Self::Regressor(slot) => REGRESSORS[slot],
            Self::Joint => "joint",
        }
    }

    /// Keys the network's draws. Changing a number changes every model that is trained after.
    pub(crate) fn key(self) -> u64 {
        match self {
            Self::Existence => 1,
            Self::Split => 2,
            Self::Rotation(slot) => 3 + slot as u64,
            Self::Reach => 6,
            Self::Size => 7,
            // And 9, for its trees of the open field.
            Self::Outlook => 8,
            Self::Points => 10,
            Self::Classifier => 11,
            Self::Regressor(slot) => 12 + slot as u64,
            Self::Joint => 21,
        }
    }

    /// Do its hidden units have gains by species? Its inputs begin with that of a node of kind
    /// `situated`, whose first are the one-hot of the species.
    pub(crate) const fn has_gains(self) -> bool {
        matches!(self, Self::Existence | Self::Split | Self::Reach | Self::Size | Self::Rotation(_))
    }

    /// Widths of the hidden layers, unless an option says otherwise.
    pub(crate) fn hidden(self) -> &'static [usize] {
        match self {
            Self::Existence => &[106, 106],
            Self::Split | Self::Reach | Self::Size => &[64, 64],
            Self::Rotation(0) => &[96, 96],
            Self::Rotation(_) => &[80, 80],
            Self::Outlook => &[48],
            // Theirs are set beside what they read.
            Self::Points => &[],
            // Four networks of 160-160-160 have the 913 kB of the paper.
            Self::Classifier | Self::Regressor(_) | Self::Joint => &[160, 160, 160],
        }
    }
}

/// What one network learns from one corpus.
pub(crate) trait Task: Sync {
    /// Values the network reads of a sample.
    fn inputs(&self) -> usize;

    /// Values the network gives for a sample.
    fn outputs(&self) -> usize;

    /// Values that the loss compares the outputs with.
    fn targets(&self) -> usize;

    /// How many samples there are.
    fn samples(&self) -> usize;

    /// The sample to train on at `position`, which counts on from epoch to epoch.
    fn pick(&self, position: u64, order: &mut Order) -> usize {
        order.sample(position)
    }

    /// The species of a sample.
    fn species(&self, sample: usize) -> usize;

    /// Writes what the network reads of a sample, and what the loss compares with.
    fn encode(&self, sample: usize, inputs: &mut [f32], targets: &mut [f32]);

    /// Disturbs the inputs of a training sample; `draws` are the sample's own.
    fn disturb(&self, _draws: Draws, _inputs: &mut [f32]) {}

    /// Whether [`Task::disturb`] does anything.
    fn is_disturbed(&self) -> bool {
        false
    }

    /// The mean loss of a batch.
    ///
    /// # Shapes  outputs: `[batch, outputs]`; targets: `[batch, targets]`; result: `[1]`
    fn loss(&self, outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1>;

    /// Names of the means that [`Task::measure`] takes.
    fn measures(&self) -> &'static [&'static str];

    /// Judges the answer to one sample, which is to be counted in `tally`.
    fn measure(&self, outputs: &[f32], targets: &[f32], tally: &mut Tally);
}

/// Standard deviation of the noise on where a tree stands among its kin.
const STANDING_NOISE: f64 = 0.2;

/// What the networks learn from.
pub(crate) struct Lesson<'a> {
    pub(crate) corpus: &'a Corpus<'a>,
    pub(crate) species: usize,
    /// Of the training trees; kind `situated` only.
    pub(crate) rotations: Option<&'a Rotations>,
    pub(crate) position_noise: f64,
    /// Whether nodes are balanced by how many children they have.
    pub(crate) balanced_existence: bool,
}

impl<'a> Lesson<'a> {
    pub(crate) fn new(
        corpus: &'a Corpus<'a>,
        species: usize,
        rotations: Option<&'a Rotations>,
        options: &TrainOptions,
    ) -> Self {
        let own = options.networks.get(Network::Existence.name());
        let balanced_existence = own.and_then(|own| own.balanced).unwrap_or(false);
        let position_noise = options.position_noise;
        Self { corpus, species, rotations, position_noise, balanced_existence }
    }

    /// What `network` learns.
    pub(crate) fn task(&'a self, network: Network) -> Box<dyn Task + 'a> {
        match (network, self.rotations) {
            (Network::Rotation(slot), Some(rotations)) => {
                Box::new(rotation::Rotation::new(self, rotations, slot))
            }
            (Network::Split, _) => Box::new(split::Split::new(self)),
            (Network::Reach, _) => Box::new(reach::Reach::new(self)),
            (Network::Size, _) => Box::new(size::Size::new(self)),
            (Network::Classifier, _) => Box::new(classifier::Classifier::new(self)),
            (Network::Regressor(slot), _) => Box::new(regressor::Regressor::new(self, slot)),
            (Network::Joint, _) => Box::new(joint::Joint::new(self)),
            (Network::Existence, _) => Box::new(existence::Existence::new(self)),
            (Network::Rotation(_), None) => {
                unreachable!("kind `situated`, which has these networks, has their tables")
            }
            (Network::Outlook | Network::Points, _) => {
                unreachable!("they learn in courses of their own")
            }
        }
    }

    /// Noise on where a tree stands: so many exact numbers name a training tree, and a network would
    /// learn its twigs by heart. Between trees each spreads by 1.
    fn blur(&self, mut draws: Draws, inputs: &mut [f32]) {
        for x in &mut inputs[situated::standing(self.species)] {
            *x += (STANDING_NOISE * draws.normal()) as f32;
        }
    }

    fn conditions(&self, spot: Spot) -> &TreeConditions {
        self.corpus.conditions(spot)
    }

    /// Encodes the node at `spot` as kind `situated` reads it; gives what is left of `inputs`.
    fn encode<'i>(&self, spot: Spot, inputs: &'i mut [f32]) -> &'i mut [f32] {
        let (node, rest) = inputs.split_at_mut(situated::len(self.species));
        let (tree, plan) = (self.conditions(spot), self.corpus.plan(spot));
        let sense = self.corpus.sense(spot);
        situated::encode(self.corpus.node(spot), tree, plan, sense, self.species, node);
        rest
    }
}
