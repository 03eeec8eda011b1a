//! Regrowth: a tree is pruned, and grows again from its wounds.
//!
//! What is kept is not touched. A node that has kept some of its children gets back the others, as
//! thick as they were, and only how they lie is drawn; a node that has lost all of them branches
//! anew, but bears the tips and reaches as far as before. So thickness is conserved, and a regrown
//! tree is one that can be regrown again.

use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{
    BranchGraph, ChildSignature, Cut, Lineage, MAX_CHILDREN, Node, NodeId, PruneError, Pruned,
    Seed, TreeInfo, TreeTraits, Vec3, prune, reaches,
};
use deeptree_infer::{Active, Branchlet, Former, Predictor, Settled, Workspace};

use crate::aim;
use crate::{GenerateError, Limits, Request, number_of};

/// How far from the origin the foot of a tree may be, in metres.
const FOOT_TOLERANCE: f32 = 1.0;

/// A tree follows the pipe model when at most one in so many of its nodes does not.
const ONE_IN: usize = 10;

/// A tree that was pruned and has grown again.
#[derive(Clone, Debug, PartialEq)]
pub struct Regrown {
    /// The tree; its seed is that of the regrowth.
    pub tree: BranchGraph,
    /// The tree in between, with its wounds.
    pub pruned: Pruned,
    /// For each node of the tree before, its number in [`Self::tree`]; none where it was cut off.
    pub kept: Vec<Option<NodeId>>,
    /// Some branches had not ended when the budget was spent.
    pub hit_budget: bool,
}

/// Why a tree cannot be regrown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum RegrowError {
    #[error(transparent)]
    Prune(#[from] PruneError),
    #[error(transparent)]
    Generate(#[from] GenerateError),
    #[error(
        "the foot of the tree is at x {}, y {}, z {}; trees grow from the origin, so move it there",
        foot.x, foot.y, foot.z
    )]
    Foot { foot: Vec3 },
    #[error(
        "{off} of the tree's {nodes} nodes are not as thick as what they bear: the square of a \
         radius must be the sum of those of the children, and a tip {tip_radius} m thick; correct \
         the radii, or regrow it with a model of kind paper"
    )]
    NoPipes { off: usize, nodes: usize, tip_radius: f32 },
}

/// Prunes a tree and grows it again from its wounds.
///
/// Species, age and gravitropism are those that the tree says it has. What is drawn for a node
/// depends on the new seed, its lineage, what the tree before was like, and what a node can see of
/// the levels up to its own: so far, the same wound grows again the same, whatever else was cut.
/// When the budget is spent, what was kept is kept still.
///
/// # Errors
///
/// When a cut makes no sense or takes all; the model does not know the species, or has not seen
/// such an age or gravitropism; the foot is not at the origin; or the model conserves tips and the
/// tree's radii do not.
///
/// # Source
///
/// DeepTree §6, "Regrowth": Algorithm 1 from the outermost nodes of a pruned tree.
pub fn regrow(
    model: &impl Predictor,
    tree: &BranchGraph,
    cuts: &[Cut],
    seed: Seed,
    limits: Limits,
    work: &mut Workspace,
) -> Result<Regrown, RegrowError> {
    let conditions = conditions(model, tree)?;
    let foot = tree.root().base();
    // Written so that a foot that is no number is off, too.
    let is_near = foot.length() <= FOOT_TOLERANCE;
    if !is_near {
        return Err(RegrowError::Foot { foot });
    }
    if model.conserves_tips() {
        check_pipes(tree, conditions.tip_radius)?;
    }
    let pruned = prune(tree, cuts)?;
    let mut regrowth = Regrowth::new(tree, &pruned, conditions, seed);
    while regrowth.next < regrowth.tree.len() {
        regrowth.step(model, limits, work)?;
    }
    let Regrowth { tree, kept, hit_budget, .. } = regrowth;
    Ok(Regrown { tree, pruned, kept, hit_budget })
}

/// What all nodes of a tree share, as it says itself.
fn conditions(model: &impl Predictor, tree: &BranchGraph) -> Result<TreeConditions, GenerateError> {
    let TreeInfo { species: name, age, gravitropism, .. } = &tree.info;
    let species = number_of(model, name)?;
    let tip_radius = model.tip_radius(species);
    let request = Request {
        age: Some(u16::try_from(*age).unwrap_or(u16::MAX)),
        gravitropism: Some(*gravitropism),
        ..Request::new(name, Seed(tree.info.seed))
    };
    aim::check(model.roots(species), tip_radius, &request)?;
    Ok(TreeConditions {
        age: *age as f32,
        gravitropism: *gravitropism,
        species,
        tip_radius,
        root_tips: tip_count(tree.root().thickness, tip_radius),
        traits: TreeTraits::of(tree),
    })
}

/// Refuses trees whose radii say nothing of what their nodes bear.
fn check_pipes(tree: &BranchGraph, tip_radius: f32) -> Result<(), RegrowError> {
    let tips = |node: &Node| f64::from(tip_count(node.thickness, tip_radius));
    let is_off = |node: &&Node| {
        let borne: f64 = node.children.iter().flatten().map(|&id| tips(tree.node(id))).sum();
        let own = tips(node);
        // A tenth for radii of few digits; three tips that are no nodes.
        !(0.9 * borne - 0.5..=1.1 * borne + 3.5).contains(&own)
    };
    let (off, nodes) = (tree.nodes().iter().filter(is_off).count(), tree.len());
    if off > nodes.div_ceil(ONE_IN) {
        return Err(RegrowError::NoPipes { off, nodes, tip_radius });
    }
    Ok(())
}

/// A pruned tree on its way back, in level order.
struct Regrowth<'a> {
    /// The tree before it was pruned.
    before: &'a BranchGraph,
    reaches: Vec<u16>,
    pruned: &'a Pruned,
    conditions: TreeConditions,
    seed: Seed,
    tree: BranchGraph,
    /// What each node has from its parent, beside its signature.
    heritage: Vec<Heritage>,
    /// For each node before, its number in the tree.
    kept: Vec<Option<NodeId>>,
    /// Nodes that are kept but do not stand in the tree yet.
    waiting: usize,
    /// The first node that has not been asked for its children.
    next: usize,
    branchlets: Vec<Branchlet>,
    hit_budget: bool,
}

/// What a node has from its parent, beside its signature.
#[derive(Clone, Copy, Debug)]
struct Heritage {
    lineage: Lineage,
    reach: u16,
    /// Its number in the tree before, if it was kept.
    before: Option<NodeId>,
}

impl<'a> Regrowth<'a> {
    /// Nothing but the root.
    fn new(
        before: &'a BranchGraph,
        pruned: &'a Pruned,
        conditions: TreeConditions,
        seed: Seed,
    ) -> Self {
        let reaches = reaches(before);
        let root = Heritage { lineage: Lineage::ROOT, reach: reaches[0], before: Some(0) };
        let mut tree = before.root_only();
        tree.info.seed = seed.0;
        let mut kept = vec![None; before.len()];
        kept[0] = Some(0);
        Self {
            before,
            reaches,
            pruned,
            conditions,
            seed,
            tree,
            heritage: vec![root],
            kept,
            waiting: pruned.tree.len() - 1,
            next: 0,
            branchlets: Vec::new(),
            hit_budget: false,
        }
    }

    /// Gives some of the nodes that have not been asked yet their children.
    fn step(
        &mut self,
        model: &impl Predictor,
        limits: Limits,
        work: &mut Workspace,
    ) -> Result<(), GenerateError> {
        let start = self.next;
        let end = self.tree.len().min(start + limits.batch.max(1));
        let settled: Vec<Option<Settled>> = (start..end).map(|id| self.settled(id)).collect();
        let is_asked = |id: &usize| {
            !self.hit_budget && settled[id - start].is_none_or(|settled| !settled.is_whole())
        };
        let asked: Vec<usize> = (start..end).filter(is_asked).collect();
        let active = |&id: &usize| Active {
            node: &self.tree.nodes()[id],
            lineage: self.heritage[id].lineage,
            seed: self.seed,
            tree: self.conditions,
            reach: self.heritage[id].reach,
            settled: settled[id - start].as_ref(),
        };
        let frontier: Vec<Active<'_>> = asked.iter().map(active).collect();
        let mut branchlets = std::mem::take(&mut self.branchlets);
        model
            .branchlets(&frontier, work, &mut branchlets)
            .map_err(|overflow| GenerateError::Overflow { node: asked[overflow.row] })?;
        let mut drawn = asked.into_iter().zip(&branchlets).peekable();
        for (id, settled) in (start..end).zip(settled) {
            let drawn = drawn.next_if(|(asked, _)| *asked == id).map(|(_, drawn)| drawn);
            self.add(id, settled, drawn, limits.budget);
        }
        self.branchlets = branchlets;
        self.next = end;
        Ok(())
    }

    /// The children that a node has kept, and those that it shall have back; none where all are to
    /// be drawn: for a node that has grown, and for one that has lost every child.
    fn settled(&self, id: usize) -> Option<Settled> {
        let before = self.before.node(self.heritage[id].before?);
        let former = |child: NodeId| {
            let node = self.before.node(child);
            let stands = self.pruned.kept[child as usize].is_some();
            Former {
                thickness: node.thickness,
                reach: self.reaches[child as usize],
                standing: stands.then(|| node.as_child()),
            }
        };
        let settled = Settled { children: before.children.map(|child| child.map(former)) };
        let is_bare = settled.standing().iter().all(Option::is_none);
        (before.child_count() == 0 || !is_bare).then_some(settled)
    }

    /// Adds the children of a node: those that were drawn, unless the budget is spent, and those
    /// that stand.
    fn add(
        &mut self,
        id: usize,
        settled: Option<Settled>,
        drawn: Option<&Branchlet>,
        budget: usize,
    ) {
        let standing = settled.map_or([None; MAX_CHILDREN], |settled| settled.standing());
        self.waiting -= count(&standing);
        let mut children = standing;
        let mut reaches = [0; MAX_CHILDREN];
        if let Some(drawn) = drawn {
            let nodes = self.tree.len() + self.waiting + count(&drawn.children);
            self.hit_budget |= nodes > budget;
            if !self.hit_budget {
                children = drawn.children;
                reaches = drawn.reaches;
            }
        }
        let Heritage { lineage, before, .. } = self.heritage[id];
        let ids = self.tree.grow(id as NodeId, children);
        for (slot, child) in ids.into_iter().enumerate() {
            let Some(child) = child else { continue };
            let (lineage, mut reach) = (lineage.child(slot as u8), reaches[slot]);
            let before = before.filter(|_| standing[slot].is_some());
            let before = before.and_then(|before| self.before.node(before).children[slot]);
            if let Some(before) = before {
                self.kept[before as usize] = Some(child);
                reach = self.reaches[before as usize];
            }
            self.heritage.push(Heritage { lineage, reach, before });
        }
    }
}

fn count(children: &[Option<ChildSignature>]) -> usize {
    children.iter().flatten().count()
}
