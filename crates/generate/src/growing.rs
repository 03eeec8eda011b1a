//! A tree on its way, level by level: from its root, or from what is kept of a tree before.

use deeptree_graph::signature::TreeConditions;
use deeptree_graph::{
    Balance, BranchGraph, ChildSignature, Lineage, MAX_CHILDREN, Neighbourhood, NodeId, Plan,
    Pruned, Room, Seed, Sense, Surround, Vec3, plans,
};
use deeptree_infer::{Active, Branchlet, Former, Predictor, Settled, Workspace};
use deeptree_scene::Site;

use crate::legacy::{Heir, Legacy, pass_on};
use crate::{GenerateError, Limits};

/// A tree on its way.
///
/// Levels alternate between two steps: [`Self::enter_level`] makes the nodes of the next level known
/// to all, [`Self::grow_level`] asks them for their children.
pub(crate) struct Growing<'a> {
    tree: BranchGraph,
    conditions: TreeConditions,
    seed: Seed,
    site: Option<&'a Site>,
    heritage: Vec<Heritage>,
    before: Option<Before<'a>>,
    balance: Balance,
    /// The nodes of the level at hand.
    level: Vec<NodeId>,
    /// Those of the next level.
    next: Vec<NodeId>,
    branchlets: Vec<Branchlet>,
    /// Of the level at hand.
    legacies: Vec<Legacy>,
    hit_budget: bool,
    avoided: Avoided,
}

/// What a node has from its parent, beside its signature.
#[derive(Clone, Copy, Debug)]
struct Heritage {
    lineage: Lineage,
    plan: Plan,
    /// Its number in the tree before, if it was kept.
    before: Option<NodeId>,
}

/// The tree before it was pruned, and what is kept of it.
struct Before<'a> {
    tree: &'a BranchGraph,
    plans: Vec<Plan>,
    pruned: &'a Pruned,
    /// For each node before, its number in the tree that grows.
    kept: Vec<Option<NodeId>>,
    /// Nodes that are kept but do not stand in the tree yet.
    waiting: usize,
}

/// How often a branch would have gone into the ground, into an obstacle, or out of its volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Avoided {
    /// Times that a child was drawn again.
    pub redrawn: u64,
    /// Children that were given up, with all that would have grown on them.
    pub given_up: u64,
}

/// A tree that has stopped growing.
pub(crate) struct Grown {
    pub(crate) tree: BranchGraph,
    /// For each node of the tree before, its number in the tree; empty without one.
    pub(crate) kept: Vec<Option<NodeId>>,
    /// Some branches had not ended when the budget was spent.
    pub(crate) hit_budget: bool,
    pub(crate) avoided: Avoided,
}

impl<'a> Growing<'a> {
    /// A tree of nothing but its root.
    pub(crate) fn new(
        tree: BranchGraph,
        conditions: TreeConditions,
        seed: Seed,
        site: Option<&'a Site>,
    ) -> Self {
        let plan = conditions.traits.plan();
        Self {
            tree,
            conditions,
            seed,
            site,
            heritage: vec![Heritage { lineage: Lineage::ROOT, plan, before: None }],
            before: None,
            balance: Balance::default(),
            level: Vec::new(),
            next: vec![0],
            branchlets: Vec::new(),
            legacies: Vec::new(),
            hit_budget: false,
            avoided: Avoided::default(),
        }
    }

    /// What is kept of a pruned tree, to grow again from its wounds.
    pub(crate) fn again(
        before: &'a BranchGraph,
        pruned: &'a Pruned,
        conditions: TreeConditions,
        seed: Seed,
        site: Option<&'a Site>,
    ) -> Self {
        let plans = plans(before);
        let root = Heritage { lineage: Lineage::ROOT, plan: plans[0], before: Some(0) };
        let mut tree = before.root_only();
        tree.info.seed = seed.0;
        let mut kept = vec![None; before.len()];
        kept[0] = Some(0);
        let waiting = pruned.tree.len() - 1;
        Self {
            heritage: vec![root],
            before: Some(Before { tree: before, plans, pruned, kept, waiting }),
            ..Self::new(tree, conditions, seed, site)
        }
    }

    /// Grows the tree by itself until it is finished.
    ///
    /// # Errors
    ///
    /// When the model's numbers overflow.
    pub(crate) fn grow(
        mut self,
        model: &impl Predictor,
        limits: Limits,
        work: &mut Workspace,
    ) -> Result<Grown, GenerateError> {
        let mut neighbourhood = Neighbourhood::of_a_tree();
        while self.enter_level(&mut neighbourhood) {
            self.grow_level(model, &neighbourhood, limits, work)?;
        }
        Ok(self.finish())
    }

    /// Goes on to the next level, whose nodes are counted; false when the tree is finished.
    pub(crate) fn enter_level(&mut self, neighbourhood: &mut Neighbourhood) -> bool {
        self.level.clear();
        std::mem::swap(&mut self.level, &mut self.next);
        for &id in &self.level {
            neighbourhood.add(self.tree.node(id).position);
        }
        let reach = |id: NodeId| self.heritage[id as usize].plan.reach;
        self.balance.add_level(&self.tree, &self.level, self.conditions.tip_radius, reach);
        !self.level.is_empty()
    }

    /// Where the nodes of the level are.
    pub(crate) fn level(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.level.iter().map(|&id| self.tree.node(id).position)
    }

    /// Asks the nodes of the level for their children.
    ///
    /// # Errors
    ///
    /// When the model's numbers overflow.
    pub(crate) fn grow_level(
        &mut self,
        model: &impl Predictor,
        neighbourhood: &Neighbourhood,
        limits: Limits,
        work: &mut Workspace,
    ) -> Result<(), GenerateError> {
        let level = std::mem::take(&mut self.level);
        let mut branchlets = std::mem::take(&mut self.branchlets);
        for batch in level.chunks(limits.batch.max(1)) {
            let settled: Vec<Option<Settled>> = batch.iter().map(|&id| self.settled(id)).collect();
            let is_asked = |settled: &Option<Settled>| {
                !self.hit_budget && settled.is_none_or(|settled| !settled.is_whole())
            };
            let asked = batch.iter().zip(&settled).filter(|(_, settled)| is_asked(settled));
            let frontier: Vec<Active<'_>> = asked
                .clone()
                .map(|(&id, settled)| self.active(id, settled.as_ref(), neighbourhood))
                .collect();
            model.branchlets(&frontier, work, &mut branchlets).map_err(|overflow| {
                let node = asked.clone().nth(overflow.row).map_or(0, |(&id, _)| id as usize);
                GenerateError::Overflow { node }
            })?;
            let is_asked: Vec<bool> = settled.iter().map(is_asked).collect();
            let mut drawn = branchlets.iter();
            for ((&id, settled), is_asked) in batch.iter().zip(settled).zip(is_asked) {
                let drawn = if is_asked { drawn.next() } else { None };
                self.add(id, settled, drawn, limits.budget);
            }
        }
        (self.level, self.branchlets) = (level, branchlets);
        self.settle_legacies();
        Ok(())
    }

    /// Lets the next level have what those of this one could not grow.
    fn settle_legacies(&mut self) {
        if self.legacies.is_empty() {
            return;
        }
        let heir = |&node: &NodeId| Heir { node, nodes: self.heritage[node as usize].plan.nodes };
        let heirs: Vec<Heir> = self.next.iter().map(heir).collect();
        let tip_radius = self.conditions.tip_radius;
        let (tree, balance) = (&mut self.tree, &mut self.balance);
        let gained = pass_on(&self.legacies, &heirs, tree, balance, tip_radius);
        for (heir, more) in heirs.iter().zip(gained) {
            self.heritage[heir.node as usize].plan.nodes += more;
        }
        self.legacies.clear();
    }

    /// A node as the model is asked for its children.
    fn active<'t>(
        &'t self,
        id: NodeId,
        settled: Option<&'t Settled>,
        neighbourhood: &Neighbourhood,
    ) -> Active<'t> {
        let node = self.tree.node(id);
        let [centre, outlook] = self.balance.centres();
        let [near, wide] = neighbourhood.around(node.position);
        let surround = self.site.map_or_else(Surround::default, |site| site.surround(node));
        let Heritage { lineage, plan, .. } = self.heritage[id as usize];
        Active {
            node,
            parent: node.parent.map(|id| self.tree.node(id)),
            lineage,
            seed: self.seed,
            tree: self.conditions,
            plan,
            sense: Sense { centre, outlook, near, wide, surround },
            settled,
            room: self.site.map(|site| site as &dyn Room),
            points: None,
        }
    }

    /// The children that a node has kept, and those that it shall have back; none where all are to
    /// be drawn: for a node that has grown, and for one that has lost every child.
    fn settled(&self, id: NodeId) -> Option<Settled> {
        let before = self.before.as_ref()?;
        let node = before.tree.node(self.heritage[id as usize].before?);
        let former = |child: NodeId| {
            let node = before.tree.node(child);
            let stands = before.pruned.kept[child as usize].is_some();
            Former {
                thickness: node.thickness,
                plan: before.plans[child as usize],
                standing: stands.then(|| node.as_child()),
            }
        };
        let settled = Settled { children: node.children.map(|child| child.map(former)) };
        let is_bare = settled.standing().iter().all(Option::is_none);
        (node.child_count() == 0 || !is_bare).then_some(settled)
    }

    /// Adds the children of a node: those that were drawn, unless the budget is spent, and those
    /// that stand.
    fn add(
        &mut self,
        id: NodeId,
        settled: Option<Settled>,
        drawn: Option<&Branchlet>,
        budget: usize,
    ) {
        let standing = settled.map_or([None; MAX_CHILDREN], |settled| settled.standing());
        let waiting = self.before.as_mut().map_or(0, |before| {
            before.waiting -= count(&standing);
            before.waiting
        });
        let mut children = standing;
        let mut plans = [Plan::default(); MAX_CHILDREN];
        if let Some(drawn) = drawn {
            let nodes = self.tree.len() + waiting + count(&drawn.children);
            self.hit_budget |= nodes > budget;
            if !self.hit_budget {
                (children, plans) = (drawn.children, drawn.plans);
                self.avoided.redrawn += u64::from(drawn.redrawn);
                self.avoided.given_up += u64::from(drawn.given_up);
                // A tree that was pruned is as it was where nothing was cut.
                if self.before.is_none() && drawn.lost_nodes > 0 {
                    let (tips, nodes) = (drawn.lost_tips, drawn.lost_nodes);
                    self.legacies.push(Legacy { node: id, tips, nodes });
                }
            }
        }
        let Heritage { lineage, before, .. } = self.heritage[id as usize];
        let ids = self.tree.grow(id, children);
        for (slot, child) in ids.into_iter().enumerate() {
            let Some(child) = child else { continue };
            let mut heir =
                Heritage { lineage: lineage.child(slot as u8), plan: plans[slot], before: None };
            if let (Some(known), Some(_)) = (&mut self.before, standing[slot]) {
                heir.before = before.and_then(|before| known.tree.node(before).children[slot]);
                if let Some(before) = heir.before {
                    known.kept[before as usize] = Some(child);
                    heir.plan = known.plans[before as usize];
                }
            }
            self.heritage.push(heir);
            self.next.push(child);
        }
    }

    /// The tree as it stands.
    pub(crate) fn finish(self) -> Grown {
        let Self { tree, before, hit_budget, avoided, .. } = self;
        Grown {
            tree,
            kept: before.map_or_else(Vec::new, |before| before.kept),
            hit_budget,
            avoided,
        }
    }
}

fn count(children: &[Option<ChildSignature>]) -> usize {
    children.iter().flatten().count()
}
