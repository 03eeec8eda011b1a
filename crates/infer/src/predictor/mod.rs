//! From signatures to children: what a model proposes for the nodes of a frontier.

mod foretold;
mod joint;
mod laws;
mod paper;
mod roots;
mod sampling;
mod settled;
mod situated;
mod trend;

use deeptree_graph::{
    ChildSignature, CloudIndex, Kin, Lineage, MAX_CHILDREN, Node, Plan, Room, Seed, Sense,
    signature::TreeConditions,
};

use crate::competition::Competition;
use crate::kernels::{self, Full, Rows, SimdPath};
use crate::mlp::{Mlp, Scratch};
use crate::outlook::Outlook;
use crate::points::Heard;
use crate::weights::{ModelKind, ReadWeightsError, Weights, check_positive};
pub use foretold::{Chance, Foretold, Known, KnownChild, KnownTree, Rank};
use joint::Joint;
use paper::Paper;
pub use roots::{ROOT_COLUMNS, Root};
pub use settled::{Former, Settled};
use situated::Situated;
pub use trend::{TREND_COLUMNS, Trend};

/// A node whose children are to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Active<'a> {
    /// The node.
    pub node: &'a Node,
    /// Its parent; none at the root.
    pub parent: Option<&'a Node>,
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
    /// What of its branchlet is settled; none where all of it is to be drawn.
    pub settled: Option<&'a Settled>,
    /// Where branches can go; none in the open field.
    pub room: Option<&'a dyn Room>,
    /// The cloud that the tree is to be the tree of, in its frame; none where there is none. Counts
    /// for models that have learned to hear of points.
    pub points: Option<&'a CloudIndex>,
}

/// The children of a node, by slot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branchlet {
    /// Their signatures.
    pub children: [Option<ChildSignature>; MAX_CHILDREN],
    /// What is to grow below each; kind `situated` only, otherwise nothing.
    pub plans: [Plan; MAX_CHILDREN],
    /// How often a child was drawn again because of the room or the ground; kind `situated` only.
    pub redrawn: u8,
    /// How many children were given up because of them.
    pub given_up: u8,
    /// Tips that those were to bear.
    pub lost_tips: u32,
    /// Those children, and the nodes that were to grow below them.
    pub lost_nodes: u32,
}

/// Memory that a prediction works in, and the instruction set it runs on; one for each thread.
#[derive(Clone, Debug)]
pub struct Workspace {
    path: SimdPath,
    scratch: Scratch,
    /// Features of the frontier's nodes.
    nodes: Features,
    /// What the network at work is told besides.
    contexts: Features,
    /// Inputs of the network at work.
    inputs: Rows,
    /// What is heard of points at the frontier's nodes.
    heard: Option<Heard>,
}

/// Rows of features, with their zeros and without.
#[derive(Clone, Debug, Default)]
struct Features {
    full: Vec<f32>,
    rows: Rows,
}

impl Features {
    /// Writes a row of so many features for each item; `first` is where they stand in the inputs.
    fn write<'a, T>(
        &mut self,
        path: SimdPath,
        items: &'a [T],
        width: usize,
        first: usize,
        mut write: impl FnMut(usize, &'a T, &mut [f32]),
    ) {
        self.full.resize(items.len() * width, 0.0);
        self.rows.clear();
        if width > 0 {
            for ((i, item), row) in items.iter().enumerate().zip(self.full.chunks_exact_mut(width))
            {
                write(i, item, row);
            }
            let full = Full { values: &self.full, width, first: first as u32 };
            kernels::thin(path, full, &mut self.rows);
        } else {
            items.iter().for_each(|_| self.rows.end_row());
        }
    }
}

impl Workspace {
    /// Memory for predictions on the given path.
    #[must_use]
    pub fn new(path: SimdPath) -> Self {
        Self {
            path,
            scratch: Scratch::new(),
            nodes: Features::default(),
            contexts: Features::default(),
            inputs: Rows::default(),
            heard: None,
        }
    }

    /// Encodes the node of each item, in so many features.
    fn encode<'a, T>(
        &mut self,
        items: &'a [T],
        features: usize,
        encode: impl FnMut(usize, &'a T, &mut [f32]),
    ) {
        self.nodes.write(self.path, items, features, 0, encode);
    }

    /// Runs a network on the features of all encoded nodes.
    fn run_nodes(&mut self, network: &Mlp) -> &[f32] {
        network.forward_rows(self.path, &self.nodes.rows, &mut self.scratch)
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
        let rest = network.inputs() - features;
        self.contexts.write(self.path, items, rest, features, |_, item, row| context(item, row));
        self.inputs.clear();
        for (i, item) in items.iter().enumerate() {
            self.inputs.put_row(self.nodes.rows.row(row_of(item)));
            self.inputs.put_row(self.contexts.rows.row(i));
            self.inputs.end_row();
        }
        network.forward_rows(self.path, &self.inputs, &mut self.scratch)
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

    /// How the trees of species number `species` change with age and gravitropism, where the model
    /// knows it better than from its roots.
    fn trend(&self, _species: usize) -> Option<&Trend> {
        None
    }

    /// The law by which trees of species number `species` stand among each other; none where the model
    /// reads no standing.
    fn kin(&self, _species: usize) -> Option<&Kin> {
        None
    }

    /// Radius of a tip of species number `species`, in metres.
    fn tip_radius(&self, species: usize) -> f32;

    /// Do the radii that it draws say how many tips a node bears, by the pipe model?
    fn conserves_tips(&self) -> bool;

    /// Which model this is: the start of the SHA-256 of its file.
    fn hash(&self) -> [u8; 16];

    /// What the model says an environment makes of a tree; `None` where it has learned nothing of
    /// environments.
    fn outlook(&self) -> Option<&Outlook> {
        None
    }

    /// Has the model learned to hear of points?
    fn hears_points(&self) -> bool {
        false
    }

    /// What the model says the trees around make of a tree; `None` where it has learned nothing of
    /// stands.
    fn competition(&self) -> Option<&Competition> {
        None
    }

    /// Draws the branchlet of each node of the frontier into `branchlets`, in its order.
    ///
    /// The branchlet of a node depends on that node and its parent, its lineage, its plan, its
    /// sense, what of it is settled, its room, the points around it, and its tree's seed and
    /// conditions only: neither on the rest of the frontier nor on the path.
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
    trends: Vec<Option<Trend>>,
    /// By species; empty where the model has none.
    kin: Vec<Kin>,
    hash: [u8; 16],
    weight_count: usize,
    networks: Networks,
    outlook: Option<Outlook>,
    competition: Option<Competition>,
}

#[derive(Clone, Debug)]
enum Networks {
    Situated(Box<Situated>),
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
        check_positive("tip_radius", &tip_radius)?;
        let networks = match weights.kind() {
            ModelKind::Situated => Networks::Situated(Box::new(Situated::new(weights)?)),
            ModelKind::Paper => Networks::Paper(Paper::new(weights)?),
            ModelKind::Joint => Networks::Joint(Joint::new(weights)?),
        };
        let mut hash = [0; 16];
        hash.copy_from_slice(&weights.sha256()[..16]);
        let roots =
            species.iter().map(|name| roots::read(weights, name)).collect::<Result<_, _>>()?;
        let trends =
            species.iter().map(|name| Trend::read(weights, name)).collect::<Result<_, _>>()?;
        let kin = weights.kin()?;
        let (outlook, competition) = match networks {
            Networks::Situated(_) => (Outlook::read(weights)?, Competition::read(weights)?),
            Networks::Paper(_) | Networks::Joint(_) => (None, None),
        };
        let weight_count = match &networks {
            Networks::Situated(networks) => networks.weight_count(),
            Networks::Paper(networks) => networks.weight_count(),
            Networks::Joint(network) => network.weight_count(),
        } + outlook.as_ref().map_or(0, Outlook::weight_count)
            + competition.as_ref().map_or(0, Competition::weight_count);
        Ok(Self {
            species,
            tip_radius,
            roots,
            trends,
            kin,
            hash,
            weight_count,
            networks,
            outlook,
            competition,
        })
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

    /// Weights, biases and gains of all networks together.
    #[must_use]
    pub const fn weight_count(&self) -> usize {
        self.weight_count
    }

    /// What the model says of branchlets that are known, law by law, each law told all that was
    /// decided before it as it truly was. Nothing is drawn.
    ///
    /// # Errors
    ///
    /// When the model's numbers overflow.
    pub fn foretell(
        &self,
        known: &[Known<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<Foretold>, Overflow> {
        let species = self.species.len();
        match &self.networks {
            Networks::Situated(networks) => networks.foretell(species, known, work),
            Networks::Paper(networks) => networks.foretell(species, known, work),
            Networks::Joint(network) => network.foretell(species, known, work),
        }
    }
}

impl Predictor for Model {
    fn species(&self) -> &[String] {
        &self.species
    }

    fn roots(&self, species: usize) -> &[Root] {
        &self.roots[species]
    }

    fn trend(&self, species: usize) -> Option<&Trend> {
        self.trends[species].as_ref()
    }

    fn kin(&self, species: usize) -> Option<&Kin> {
        self.kin.get(species)
    }

    fn tip_radius(&self, species: usize) -> f32 {
        self.tip_radius[species]
    }

    fn conserves_tips(&self) -> bool {
        self.kind() == ModelKind::Situated
    }

    fn hash(&self) -> [u8; 16] {
        self.hash
    }

    fn outlook(&self) -> Option<&Outlook> {
        self.outlook.as_ref()
    }

    fn hears_points(&self) -> bool {
        match &self.networks {
            Networks::Situated(networks) => networks.hears_points(),
            Networks::Paper(_) | Networks::Joint(_) => false,
        }
    }

    fn competition(&self) -> Option<&Competition> {
        self.competition.as_ref()
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
