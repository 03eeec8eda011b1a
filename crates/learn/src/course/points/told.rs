//! What a tree looks like to networks that know it by a scan only.
//!
//! As in reconstruction: the nodes below which the scanner saw something are known, with their
//! places, directions and orders; how much a node bears is told from the share of the seen wood
//! beyond it, how far it reaches from the longest seen way, and what the tree as a whole is like
//! from a tree of the training data that is as wide for its height. What no scanner saw is told as
//! it is, since in reconstruction the networks draw it themselves.

use deeptree_graph::signature::situated::{Branching, Sibling, Turn};
use deeptree_graph::signature::{TreeConditions, thickness_of, tip_count};
use deeptree_graph::{
    BranchGraph, CloudIndex, Kin, MAX_CHILDREN, Neighbourhood, Node, Plan, Quat, Sense, Vec3, plans,
};
use deeptree_infer::{Model, Predictor, Root};

use crate::Scan;
use crate::rotations::Rotations;

/// A scanned tree as it is told.
pub(crate) struct Told {
    pub(crate) conditions: TreeConditions,
    pub(crate) nodes: Vec<Node>,
    pub(crate) tips: Vec<u32>,
    pub(crate) plans: Vec<Plan>,
    pub(crate) senses: Vec<Sense>,
    /// In the frame of the nodes.
    pub(crate) cloud: CloudIndex,
    /// How each node branches in truth.
    pub(crate) branchings: Vec<Branching>,
    /// Turns of each node against its parent as told, in deviations of its slot.
    pub(crate) turns: Vec<Turn>,
}

impl Told {
    /// `None` of a tree that no known one is like, or of which nothing was seen.
    pub(crate) fn new(
        tree: &BranchGraph,
        scan: &Scan,
        species: usize,
        model: &Model,
        rotations: &Rotations,
    ) -> Option<Self> {
        let most = |of: fn(&Vec3) -> f32| scan.points.iter().map(of).fold(0.0, f32::max);
        let (height, radius) = (most(|p| p.y), most(|p| p.with_y(0.0).length()));
        let root = Root::of_shape(model.roots(species), radius / height)?;
        let scale = root.traits.height / height;
        if !(scale.is_finite() && scale > 0.0) {
            return None;
        }
        let tip_radius = model.tip_radius(species);
        let conditions =
            root.conditions(species, tip_radius, model.kin(species), [0.0; Kin::HABITS]);
        let seen = Seen::new(tree, scan);
        let truth = plans(tree);
        let (mut nodes, mut all_tips, mut all_plans) = (Vec::new(), Vec::new(), Vec::new());
        for (id, node) in tree.nodes().iter().enumerate() {
            let (tips, plan) = seen.told(id, &conditions, scale).unwrap_or_else(|| {
                let tips = tip_count(node.thickness, tip_radius);
                (tips, truth[id].kept(tips))
            });
            let is_seen = seen.beyond[id] > 0;
            nodes.push(told(node, scale, thickness_of(tips, tip_radius), is_seen));
            all_tips.push(tips);
            all_plans.push(plan);
        }
        let turn = |node: &Node| {
            let slot = &rotations.slots[species][usize::from(node.slot)];
            let up = node.parent.map(|up| &nodes[up as usize]);
            up.map_or_else(Turn::default, |up| {
                slot.turn(node.rotation, up, conditions.gravitropism)
            })
        };
        let turns = tree.nodes().iter().map(turn).collect();
        let senses = senses(&nodes, &seen);
        let branching = |node: &Node| {
            let tips = |node: &Node| tip_count(node.thickness, tip_radius);
            let children = || node.children.iter().flatten().map(|&id| tree.node(id));
            let borne: u32 = children().map(tips).sum();
            let has = |slot: usize| u8::from(node.children[slot].is_some()) << slot;
            let dropped = tips(node).saturating_sub(borne).min(3) as u8;
            Branching { subset: (0..MAX_CHILDREN).map(has).sum(), dropped }
        };
        let branchings = tree.nodes().iter().map(branching).collect();
        let points: Vec<Vec3> = scan.points.iter().map(|&point| point * scale).collect();
        let cloud = CloudIndex::new(&points);
        let (tips, plans) = (all_tips, all_plans);
        Some(Self { conditions, nodes, tips, plans, senses, cloud, branchings, turns })
    }

    /// The child in a slot as those after it are told of it.
    pub(crate) fn sibling(&self, tree: &BranchGraph, node: usize, slot: usize) -> Option<Sibling> {
        let id = tree.nodes()[node].children[slot]? as usize;
        Some(Sibling { tips: self.tips[id], turn: self.turns[id] })
    }

    /// How a node is turned itself: of a node that was seen, that does not show.
    pub(crate) fn own_turn(&self, node: usize) -> Turn {
        if self.nodes[node].parent.is_none() { Turn::default() } else { self.turns[node] }
    }
}

/// A node as told. Of what was seen, neither its slot nor how it is turned shows; it counts as one
/// without a parent.
fn told(node: &Node, scale: f32, thickness: f32, is_seen: bool) -> Node {
    let placed = Node {
        position: node.position * scale,
        thickness,
        root_distance: node.root_distance * scale,
        branch_distance: node.branch_distance * scale,
        fork_distance: node.fork_distance * scale,
        ..node.clone()
    };
    if !is_seen {
        return placed;
    }
    Node {
        parent: None,
        slot: 0,
        sibling_count: 1,
        rotation: Quat::IDENTITY,
        length: 1.0,
        ..placed
    }
}

/// What of a tree a scanner saw.
struct Seen {
    /// Nodes that are seen, or lie on the way to one that is, at and above each node.
    beyond: Vec<u32>,
    /// The longest of these ways, in metres.
    reach: Vec<f32>,
}

impl Seen {
    fn new(tree: &BranchGraph, scan: &Scan) -> Self {
        let nodes = tree.nodes();
        let mut beyond = vec![0; nodes.len()];
        for &node in &scan.nodes {
            if let Some(beyond) = beyond.get_mut(node as usize) {
                *beyond = 1;
            }
        }
        let mut reach = vec![0.0f32; nodes.len()];
        // Children stand after their parents.
        for (id, node) in nodes.iter().enumerate().rev() {
            let children = || node.children.iter().flatten().map(|&child| child as usize);
            let above: u32 = children().map(|child| beyond[child]).sum();
            if above > 0 {
                beyond[id] = above + 1;
            }
            let way = |child: usize| {
                if beyond[child] > 0 { reach[child] + nodes[child].length } else { 0.0 }
            };
            reach[id] = children().map(way).fold(0.0, f32::max);
        }
        Self { beyond, reach }
    }

    /// Tips and plan of a node that was seen.
    fn told(&self, id: usize, all: &TreeConditions, scale: f32) -> Option<(u32, Plan)> {
        if self.beyond[id] == 0 {
            return None;
        }
        let share = self.beyond[id] as f32 / self.beyond[0].max(1) as f32;
        Some(Plan::guessed(all, share, self.reach[id] * scale))
    }
}

/// What each node sees of those that the scanner saw.
fn senses(nodes: &[Node], seen: &Seen) -> Vec<Sense> {
    let mut neighbourhood = Neighbourhood::of_a_tree();
    let (mut sum, mut count) = (Vec3::ZERO, 0.0f32);
    for (node, _) in nodes.iter().zip(&seen.beyond).filter(|(_, beyond)| **beyond > 0) {
        neighbourhood.add(node.position);
        sum += node.position;
        count += 1.0;
    }
    let centre = sum / count.max(1.0);
    let sense = |node: &Node| {
        let [near, wide] = neighbourhood.around(node.position);
        Sense { centre, outlook: centre, near, wide, ..Sense::default() }
    };
    nodes.iter().map(sense).collect()
}
