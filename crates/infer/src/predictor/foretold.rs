//! What a model says of branchlets that are known: the open loop, in which each law is asked on the
//! true states and judged by what truly came.

use deeptree_graph::signature::TreeConditions;
use deeptree_graph::{
    BranchGraph, Lineage, MAX_CHILDREN, Node, NodeId, Plan, Seed, Sense, plans, senses,
};

use super::{Active, Predictor};

/// A node whose children are known.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// The node; its lineage and seed, which key draws, do not matter.
    pub active: Active<'a>,
    /// Its children by slot.
    pub children: [Option<KnownChild<'a>>; MAX_CHILDREN],
}

/// A child of a node whose children are known.
#[derive(Clone, Copy, Debug)]
pub struct KnownChild<'a> {
    /// The child.
    pub node: &'a Node,
    /// What grows below it; kind `situated` only.
    pub plan: Plan,
}

/// A finished tree, whose nodes are told to a model as they were when it grew.
#[derive(Clone, Debug)]
pub struct KnownTree<'a> {
    tree: &'a BranchGraph,
    conditions: TreeConditions,
    plans: Vec<Plan>,
    senses: Vec<Sense>,
}

impl<'a> KnownTree<'a> {
    /// The tree as one of species number `species` of a model.
    #[must_use]
    pub fn new(model: &impl Predictor, species: usize, tree: &'a BranchGraph) -> Self {
        let tip_radius = model.tip_radius(species);
        let conditions = TreeConditions::of(tree, species, tip_radius, model.kin(species));
        let plans = plans(tree);
        let senses = senses(tree, tip_radius, &plans);
        Self { tree, conditions, plans, senses }
    }

    /// A node with its children.
    ///
    /// # Panics
    ///
    /// When the tree has no such node.
    #[must_use]
    pub fn node(&self, id: NodeId) -> Known<'_> {
        let (node, plan) = (self.tree.node(id), |id: NodeId| self.plans[id as usize]);
        let active = Active {
            node,
            parent: node.parent.map(|id| self.tree.node(id)),
            lineage: Lineage::ROOT,
            seed: Seed(self.tree.info.seed),
            tree: self.conditions,
            plan: plan(id),
            sense: self.senses[id as usize],
            settled: None,
            room: None,
            points: None,
        };
        let child = |id| KnownChild { node: self.tree.node(id), plan: plan(id) };
        Known { active, children: node.children.map(|id| id.map(child)) }
    }
}

/// A probability, and whether it happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chance {
    /// The probability that was told.
    pub probability: f64,
    /// Did it happen?
    pub happened: bool,
}

/// Where the true value stands in the law that was told: the probability of less, and of less or
/// the same. If the law is right, a place drawn evenly between both is uniform over 0 to 1
/// (Rosenblatt 1952; for whole numbers Czado, Gneiting and Held 2009).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// Probability of less.
    pub low: f64,
    /// Probability of less or the same.
    pub high: f64,
}

impl Rank {
    /// Where a value stands in a continuous law.
    pub(super) const fn at(share: f64) -> Self {
        Self { low: share, high: share }
    }
}

/// What a model says of a node whose children are known. By slot; none where nothing was asked, or
/// the kind of model has no such law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Foretold {
    /// Probability that there is a child.
    pub children: [f64; MAX_CHILDREN],
    /// Probability of the true branching: all children and the dropped tips together. Branchings that
    /// are seldom in the species, which growth leaves out, count like others.
    pub branching: Option<f64>,
    /// Tips of a child, of those that are left for it and later ones.
    pub splits: [Option<Rank>; MAX_CHILDREN],
    /// Has the child the longest path below?
    pub heirs: [Option<Chance>; MAX_CHILDREN],
    /// Reach of a child that has not.
    pub reaches: [Option<Rank>; MAX_CHILDREN],
    /// Nodes below a child, of those that are left for it and later ones.
    pub sizes: [Option<Rank>; MAX_CHILDREN],
    /// Roll of the apical child.
    pub roll: Option<Rank>,
    /// Is the swing of the child exactly aligned, as
    /// [`Alignment`](deeptree_graph::signature::situated::Alignment) has it?
    pub aligned: [Option<Chance>; MAX_CHILDREN],
    /// Swing of a child about its x; none of an apical child that goes straight on.
    pub swings_x: [Option<Rank>; MAX_CHILDREN],
    /// Swing about its y, given that about x, of a child that is not aligned.
    pub swings_y: [Option<Rank>; MAX_CHILDREN],
    /// Length of the edge to the child.
    pub lengths: [Option<Rank>; MAX_CHILDREN],
}
