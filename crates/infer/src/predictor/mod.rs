//! From signatures to children: what a model proposes for the nodes of a frontier.

mod joint;
mod paper;
mod roots;
mod sampling;
mod situated;

use deeptree_graph::{
    ChildSignature, Lineage, MAX_CHILDREN, Node, Plan, Seed, Sense, signature::TreeConditions,
};

use crate::kernels::SimdPath;
use crate::mlp::{Mlp, Scratch};
use crate::outlook::Outlook;
use crate::weights::{ModelKind, ReadWeightsError, Weights};
use joint::Joint;
use paper::Paper;
pub(crate) use roots::check_positive;
pub use roots::{ROOT_COLUMNS, Root};
use situated::Situated;

/// A node whose children are to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Active<'a> {
    /// The node.
    pub node: &'a Node,
    /// Its lineage, which keys the draws.
    pub lineage: Lineage,
    /// The seed of its tree.
    pub seed: Seed,
    /// What all nodes of its tree share.
    pub tree: TreeConditions,
    /// What is to grow below it, as its parent has left it; kind `situated` only.
    pub plan: Plan,
    /// What it sees of what has grown so far; kind `situated` only.
    pub sense: Sense,
}

/// The children of a node, by slot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branchlet {
    /// Their signatures.
    pub children: [Option<ChildSignature>; MAX_CHILDREN],
    /// What is to grow below each; kind `situated` only, otherwise nothing.
    pub plans: [Plan; MAX_CHILDREN],
}

/// Memory that a prediction works in, and the instruction set it runs on; one for each thread.
#[derive(Clone, Debug)]
pub struct Workspace {
    path: SimdPath,
    scratch: Scratch,
    /// Features of the frontier's nodes, a row each.
    nodes: Vec<f32>,
    /// Inputs of the network at work.
    inputs: Vec<f32>,
}

impl Workspace {
    /// Memory for predictions on the given path.
    #[must_use]
    pub fn new(path: SimdPath) -> Self {
        Self { path, scratch: Scratch::new(), nodes: Vec::new(), inputs: Vec::new() }
    }

    /// Runs a network on a batch of rows: for each item, the features of its node and then what
    /// `context` writes into the rest of the row.
    fn run<T>(
        &mut self,
        network: &Mlp,
        features: usize,
        items: &[T],
        row_of: impl Fn(&T) -> usize,
        mut context: impl FnMut(&T, &mut [f32]),
    ) -> &[f32] {
        let width = network.inputs();
        self.inputs.resize(items.len() * width, 0.0);
        for (item, row) in items.iter().zip(self.inputs.chunks_exact_mut(width)) {
            let (own, rest) = row.split_at_mut(features);
            own.copy_from_slice(&self.nodes[row_of(item) * features..][..features]);
            context(item, rest);
        }
        network.forward(self.path, &self.inputs, &mut self.scratch)
    }
}

impl Default for Workspace {
    /// Memory for predictions on the widest path this processor has.
    fn default() -> Self {
        Self::new(SimdPath::detect())
    }
}

/// The numbers of a model overflowed: its weights are not those of a trained network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the model's numbers overflow; train it or get it again")]
pub struct Overflow {
    /// Index in the frontier of a node they overflowed at.
    pub row: usize,
}

/// What draws the children of nodes. Generation sees nothing else of a model.
pub trait Predictor: Sync {
    /// The species the model knows.
    fn species(&self) -> &[String];

    /// The roots of the trees that the model was trained on, of species number `species`.
    fn roots(&self, species: usize) -> &[Root];

    /// Radius of a tip of species number `species`, in metres.
    fn tip_radius(&self, species: usize) -> f32;

    /// Which model this is: the start of the SHA-256 of its file.
    fn hash(&self) -> [u8; 16];

    /// What the model says an environment makes of a tree; `None` where it has learned nothing of
    /// environments.
    fn outlook(&self) -> Option<&Outlook> {
        None
    }

    /// Draws the branchlet of each node of the frontier into `branchlets`, in its order.
    ///
    /// The branchlet of a node depends on that node, its lineage, its plan, its sense, its tree's
    /// seed and conditions only: neither on the rest of the frontier nor on the path.
    ///
    /// # Errors
    ///
    /// When the model's numbers overflow.
    fn branchlets(
        &self,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        branchlets: &mut Vec<Branchlet>,
    ) -> Result<(), Overflow>;
}

/// A model file, ready to predict.
#[derive(Clone, Debug)]
pub struct Model {
    species: Vec<String>,
    tip_radius: Vec<f32>,
    roots: Vec<Vec<Root>>,
    hash: [u8; 16],
    weight_count: usize,
    networks: Networks,
    outlook: Option<Outlook>,
}

#[derive(Clone, Debug)]
enum Networks {
    Situated(Situated),
    Paper(Paper),
    Joint(Joint),
}

impl Model {
    /// Reads a model file.
    ///
    /// # Errors
    ///
    /// When the file is damaged, or its networks do not read what [`deeptree_graph::signature`]
    /// writes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadWeightsError> {
        Self::from_weights(&Weights::from_bytes(bytes)?)
    }

    /// The model of some weights.
    ///
    /// # Errors
    ///
    /// When a table or network is missing, or has another shape than the kind of model needs.
    pub fn from_weights(weights: &Weights) -> Result<Self, ReadWeightsError> {
        let species = weights.species().to_vec();
        let count = species.len();
        let tip_radius = weights.table("tip_radius", &[Some(count)])?.values().to_vec();
        roots::check_positive("tip_radius", &tip_radius)?;
        let networks = match weights.kind() {
            ModelKind::Situated => Networks::Situated(Situated::new(weights)?),
            ModelKind::Paper => Networks::Paper(Paper::new(weights)?),
            ModelKind::Joint => Networks::Joint(Joint::new(weights)?),
        };
        let mut hash = [0; 16];
        hash.copy_from_slice(&weights.sha256()[..16]);
        let roots =
            species.iter().map(|name| roots::read(weights, name)).collect::<Result<_, _>>()?;
        let outlook = match networks {
            Networks::Situated(_) => Outlook::read(weights)?,
            Networks::Paper(_) | Networks::Joint(_) => None,
        };
        let weight_count = match &networks {
            Networks::Situated(networks) => networks.weight_count(),
            Networks::Paper(networks) => networks.weight_count(),
            Networks::Joint(network) => network.weight_count(),
        } + outlook.as_ref().map_or(0, Outlook::weight_count);
        Ok(Self { species, tip_radius, roots, hash, weight_count, networks, outlook })
    }

    /// The kind of the model.
    #[must_use]
    pub const fn kind(&self) -> ModelKind {
        match self.networks {
            Networks::Situated(_) => ModelKind::Situated,
            Networks::Paper(_) => ModelKind::Paper,
            Networks::Joint(_) => ModelKind::Joint,
        }
    }

    /// Weights and biases of all networks together.
    #[must_use]
    pub const fn weight_count(&self) -> usize {
        self.weight_count
    }
}

impl Predictor for Model {
    fn species(&self) -> &[String] {
        &self.species
    }

    fn roots(&self, species: usize) -> &[Root] {
        &self.roots[species]
    }

    fn tip_radius(&self, species: usize) -> f32 {
        self.tip_radius[species]
    }

    fn hash(&self) -> [u8; 16] {
        self.hash
    }

    fn outlook(&self) -> Option<&Outlook> {
        self.outlook.as_ref()
    }

    fn branchlets(
        &self,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        branchlets: &mut Vec<Branchlet>,
    ) -> Result<(), Overflow> {
        branchlets.clear();
        branchlets.resize(frontier.len(), Branchlet::default());
        match &self.networks {
            Networks::Situated(networks) => {
                networks.branchlets(self.species.len(), frontier, work, branchlets)
            }
            Networks::Paper(networks) => {
                networks.branchlets(self.species.len(), frontier, work, branchlets)
            }
            Networks::Joint(network) => {
                network.branchlets(self.species.len(), frontier, work, branchlets)
            }
        }
    }
}

/// A network of the model, of the widths the kind needs.
pub(crate) fn network(
    weights: &Weights,
    name: &str,
    inputs: usize,
    outputs: usize,
) -> Result<Mlp, ReadWeightsError> {
    let network = weights.mlp(name)?;
    if (network.inputs(), network.outputs()) == (inputs, outputs) {
        Ok(network)
    } else {
        Err(ReadWeightsError::NetworkWidth {
            network: name.to_owned(),
            inputs: network.inputs(),
            outputs: network.outputs(),
            expected_inputs: inputs,
            expected_outputs: outputs,
        })
    }
}
