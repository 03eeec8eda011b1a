//! The trees to learn from, and the samples they hold.

use deeptree_graph::signature::situated::Branching;
use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{
    BranchGraph, Kin, MAX_CHILDREN, Node, NodeId, Plan, Sense, plans, senses, senses_in,
};
use deeptree_scene::Site;

use crate::{Surroundings, TrainError};

/// The trees a model is trained on and judged by.
#[derive(Clone, Debug)]
pub struct TrainingSet {
    /// The species of the model; trees name one of them.
    pub species: Vec<String>,
    /// Trees to learn from.
    pub train: Vec<BranchGraph>,
    /// Trees to judge by; none of the training trees.
    pub validation: Vec<BranchGraph>,
    /// What stood around each training tree; `None` in the open field.
    pub train_surroundings: Vec<Option<Surroundings>>,
    /// What stood around each validation tree.
    pub validation_surroundings: Vec<Option<Surroundings>>,
    /// What tells this data from other data, such as a hash of its files. A checkpoint is only
    /// continued with the same.
    pub data_hash: String,
}

impl TrainingSet {
    /// Checks what all kinds need: trees in both parts, known species, thicknesses above 0, and an
    /// environment for each tree or for none.
    pub(crate) fn check(&self) -> Result<(), TrainError> {
        for (part, trees, around) in [
            ("training", &self.train, &self.train_surroundings),
            ("validation", &self.validation, &self.validation_surroundings),
        ] {
            if trees.is_empty() {
                return Err(TrainError::NoTrees { part });
            }
            if trees.len() != around.len() {
                let (trees, given) = (trees.len(), around.len());
                return Err(TrainError::SurroundingsCount { part, trees, given });
            }
            for (tree, graph) in trees.iter().enumerate() {
                let bad = |node: &Node| !(node.thickness > 0.0 && node.thickness.is_finite());
                if let Some(node) = graph.nodes().iter().position(bad) {
                    let thickness = graph.nodes()[node].thickness;
                    return Err(TrainError::Thickness { part, tree, node, thickness });
                }
            }
        }
        Ok(())
    }
}

/// Trees of one part of the set, each with what its nodes share.
pub(crate) struct Corpus<'a> {
    part: &'static str,
    pub(crate) trees: &'a [BranchGraph],
    /// Of each tree; `None` in the open field.
    pub(crate) surroundings: &'a [Option<Surroundings>],
    pub(crate) conditions: Vec<TreeConditions>,
    /// What grows below each node of each tree.
    plans: Vec<Vec<Plan>>,
    /// What each node of each tree saw.
    senses: Vec<Vec<Sense>>,
    /// Number of the first node of each tree, counted over all trees, and of the end.
    starts: Vec<usize>,
}

/// A node of a tree of a corpus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Spot {
    pub(crate) tree: u32,
    pub(crate) node: NodeId,
}

impl<'a> Corpus<'a> {
    /// `species` gives each tree's number in the set's list, `tip_radius` and `kin` those of each
    /// species; no kin where nothing reads a standing.
    pub(crate) fn new(
        part: &'static str,
        trees: &'a [BranchGraph],
        surroundings: &'a [Option<Surroundings>],
        species: &[usize],
        tip_radius: &[f32],
        kin: &[Kin],
    ) -> Self {
        let conditions = trees.iter().zip(species).map(|(tree, &species)| {
            TreeConditions::of(tree, species, tip_radius[species], kin.get(species))
        });
        let conditions: Vec<TreeConditions> = conditions.collect();
        let mut starts = vec![0];
        starts.extend(trees.iter().scan(0, |end, tree| {
            *end += tree.len();
            Some(*end)
        }));
        let plans: Vec<Vec<Plan>> = trees.iter().map(plans).collect();
        let known = trees.iter().zip(&conditions).zip(&plans).zip(surroundings);
        let known = known.map(|(((tree, all), plans), around)| match around {
            None => senses(tree, all.tip_radius, plans),
            Some(around) => {
                let site = Site::new(around.environment().clone());
                senses_in(tree, all.tip_radius, plans, |node| site.surround(node))
            }
        });
        let senses = known.collect();
        Self { part, trees, surroundings, conditions, plans, senses, starts }
    }

    /// Has any tree grown in an environment?
    pub(crate) fn has_surroundings(&self) -> bool {
        self.surroundings.iter().any(Option::is_some)
    }

    /// Checks that each species has trees of the open field, which is what environments are told
    /// against and where the roots of new trees come from.
    pub(crate) fn check_open_field(&self, species: &[String]) -> Result<(), TrainError> {
        for (number, name) in species.iter().enumerate() {
            let mut trees = self.conditions.iter().zip(self.surroundings);
            if !trees.any(|(tree, around)| tree.species == number && around.is_none()) {
                return Err(TrainError::NoOpenField { species: name.clone() });
            }
        }
        Ok(())
    }

    /// How many nodes all trees have.
    pub(crate) fn nodes(&self) -> usize {
        self.starts[self.trees.len()]
    }

    /// The node of this number, counted over all trees.
    pub(crate) fn spot(&self, number: usize) -> Spot {
        let tree = self.starts.partition_point(|&start| start <= number) - 1;
        Spot { tree: tree as u32, node: (number - self.starts[tree]) as NodeId }
    }

    /// The number of a node: the inverse of [`Self::spot`].
    pub(crate) fn number(&self, spot: Spot) -> usize {
        self.starts[spot.tree as usize] + spot.node as usize
    }

    /// All nodes that `wanted` accepts.
    pub(crate) fn select(&self, wanted: impl Fn(&Node) -> bool) -> Vec<Spot> {
        let mut spots = Vec::new();
        for (tree, graph) in self.trees.iter().enumerate() {
            let nodes = graph.nodes().iter().enumerate().filter(|(_, node)| wanted(node));
            spots.extend(nodes.map(|(id, _)| Spot { tree: tree as u32, node: id as NodeId }));
        }
        spots
    }

    /// Calls `visit` with each child, its parent, and what their tree's nodes share.
    pub(crate) fn each_child(&self, mut visit: impl FnMut(&TreeConditions, &Node, &Node)) {
        for (tree, conditions) in self.trees.iter().zip(&self.conditions) {
            for child in tree.nodes() {
                if let Some(parent) = child.parent {
                    visit(conditions, tree.node(parent), child);
                }
            }
        }
    }

    pub(crate) fn node(&self, spot: Spot) -> &'a Node {
        self.trees[spot.tree as usize].node(spot.node)
    }

    /// The parent of the node at `spot`.
    pub(crate) fn parent(&self, spot: Spot) -> Option<&'a Node> {
        let tree = &self.trees[spot.tree as usize];
        tree.node(spot.node).parent.map(|id| tree.node(id))
    }

    /// The child in `slot` of the node at `spot`.
    pub(crate) fn child(&self, spot: Spot, slot: usize) -> Option<&'a Node> {
        let tree = &self.trees[spot.tree as usize];
        tree.node(spot.node).children[slot].map(|id| tree.node(id))
    }

    pub(crate) fn conditions(&self, spot: Spot) -> &TreeConditions {
        &self.conditions[spot.tree as usize]
    }

    /// What grows below the node at `spot`.
    pub(crate) fn plan(&self, spot: Spot) -> Plan {
        self.plans[spot.tree as usize][spot.node as usize]
    }

    /// What the node at `spot` saw of what had grown so far.
    pub(crate) fn sense(&self, spot: Spot) -> &Sense {
        &self.senses[spot.tree as usize][spot.node as usize]
    }

    /// How the tips and the plan of the node at `spot` are shared out.
    pub(crate) fn shares(&self, spot: Spot) -> Shares {
        let radius = self.conditions(spot).tip_radius;
        let (tree, node) = (&self.trees[spot.tree as usize], self.node(spot));
        let tips = |node: &Node| tip_count(node.thickness, radius);
        let mut shares = Shares { tips: tips(node), plan: self.plan(spot), ..Shares::default() };
        for (slot, child) in node.children.into_iter().enumerate() {
            let Some(id) = child else { continue };
            shares.subset |= 1 << slot;
            shares.children[slot] = tips(tree.node(id));
            let below = self.plan(Spot { node: id, ..spot });
            (shares.reaches[slot], shares.nodes[slot]) = (below.reach, below.nodes);
        }
        shares
    }

    /// Checks that every node keeps the pipe model, so that its branching is a possible class.
    pub(crate) fn check_pipe_model(&self) -> Result<(), TrainError> {
        for (tree, graph) in self.trees.iter().enumerate() {
            for node in 0..graph.len() {
                let shares = self.shares(Spot { tree: tree as u32, node: node as NodeId });
                if !shares.is_possible() {
                    return Err(TrainError::PipeModel {
                        part: self.part,
                        tree,
                        node,
                        tips: shares.tips,
                        children_tips: shares.children.iter().sum(),
                    });
                }
            }
        }
        Ok(())
    }
}

/// How many tips a node bears and what grows below it, and so for each child.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shares {
    pub(crate) tips: u32,
    pub(crate) plan: Plan,
    /// Bit i: the child in slot i exists.
    pub(crate) subset: u8,
    /// By slot; 0 where there is no child.
    pub(crate) children: [u32; MAX_CHILDREN],
    /// By slot; 0 where there is no child.
    pub(crate) reaches: [u16; MAX_CHILDREN],
    /// By slot; 0 where there is no child.
    pub(crate) nodes: [u32; MAX_CHILDREN],
}

impl Shares {
    fn is_possible(&self) -> bool {
        let borne: u32 = self.children.iter().sum();
        let dropped = self.tips.checked_sub(borne).filter(|&dropped| dropped <= 3);
        dropped.is_some_and(|dropped| {
            Branching { subset: self.subset, dropped: dropped as u8 }.is_possible(self.tips)
        })
    }

    /// Which children exist, and how many tips were dropped; for a corpus that was checked.
    pub(crate) fn branching(&self) -> Branching {
        let borne: u32 = self.children.iter().sum();
        Branching { subset: self.subset, dropped: (self.tips - borne) as u8 }
    }
}

/// The number of each tree's species in `species`.
pub(crate) fn species_numbers(
    part: &'static str,
    trees: &[BranchGraph],
    species: &[String],
) -> Result<Vec<usize>, TrainError> {
    let number = |(tree, graph): (usize, &BranchGraph)| {
        let name = &graph.info.species;
        species.iter().position(|known| known == name).ok_or_else(|| TrainError::UnknownSpecies {
            part,
            tree,
            species: name.clone(),
        })
    };
    trees.iter().enumerate().map(number).collect()
}
