//! A tree on its way, level by level.

use deeptree_graph::signature::TreeConditions;
use deeptree_graph::{Balance, BranchGraph, Lineage, Neighbourhood, NodeId, Plan, Seed, Sense};
use deeptree_infer::{Active, Branchlet, Predictor, Workspace};

use crate::{GenerateError, Limits};

/// A tree on its way.
///
/// Levels alternate between two steps: [`Self::enter_level`] makes the nodes of the next level known
/// to all, [`Self::grow_level`] asks them for their children. Trees of one stand take each step
/// together.
pub(crate) struct Growing {
    tree: BranchGraph,
    conditions: TreeConditions,
    seed: Seed,
    /// What each node has from its parent, beside its signature.
    heritage: Vec<Heritage>,
    balance: Balance,
    /// The nodes of the level at hand.
    level: Vec<NodeId>,
    /// Those of the next level.
    next: Vec<NodeId>,
    branchlets: Vec<Branchlet>,
    hit_budget: bool,
}

/// What a node has from its parent, beside its signature.
#[derive(Clone, Copy, Debug)]
struct Heritage {
    lineage: Lineage,
    plan: Plan,
}

impl Growing {
    /// A tree of nothing but its root.
    pub(crate) fn new(tree: BranchGraph, conditions: TreeConditions, seed: Seed) -> Self {
        let plan = conditions.traits.plan();
        Self {
            tree,
            conditions,
            seed,
            heritage: vec![Heritage { lineage: Lineage::ROOT, plan }],
            balance: Balance::default(),
            level: Vec::new(),
            next: vec![0],
            branchlets: Vec::new(),
            hit_budget: false,
        }
    }

    /// Goes on to the next level, whose nodes are counted; false when the tree is finished.
    pub(crate) fn enter_level(&mut self, neighbourhood: &mut Neighbourhood) -> bool {
        if self.hit_budget || self.next.is_empty() {
            return false;
        }
        self.level.clear();
        std::mem::swap(&mut self.level, &mut self.next);
        for &id in &self.level {
            neighbourhood.add(self.tree.node(id).position);
        }
        let reach = |id: NodeId| self.heritage[id as usize].plan.reach;
        self.balance.add_level(&self.tree, &self.level, self.conditions.tip_radius, reach);
        true
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
        let [centre, outlook] = self.balance.centres();
        let level = std::mem::take(&mut self.level);
        for batch in level.chunks(limits.batch.max(1)) {
            let active = |&id: &NodeId| {
                let node = self.tree.node(id);
                let [near, wide] = neighbourhood.around(node.position);
                let Heritage { lineage, plan } = self.heritage[id as usize];
                let sense = Sense { centre, outlook, near, wide };
                let parent = node.parent.map(|id| self.tree.node(id));
                Active {
                    node,
                    parent,
                    lineage,
                    seed: self.seed,
                    tree: self.conditions,
                    plan,
                    sense,
                }
            };
            let frontier: Vec<Active<'_>> = batch.iter().map(active).collect();
            model.branchlets(&frontier, work, &mut self.branchlets).map_err(|overflow| {
                GenerateError::Overflow { node: batch[overflow.row] as usize }
            })?;
            self.add(batch, limits.budget);
            if self.hit_budget {
                break;
            }
        }
        self.level = level;
        Ok(())
    }

    /// Adds the branchlets of some nodes, until the budget is spent.
    fn add(&mut self, nodes: &[NodeId], budget: usize) {
        for (&id, branchlet) in nodes.iter().zip(&self.branchlets) {
            if self.tree.len() + branchlet.children.iter().flatten().count() > budget {
                self.hit_budget = true;
                return;
            }
            let Heritage { lineage, .. } = self.heritage[id as usize];
            let ids = self.tree.grow(id, branchlet.children);
            for ((slot, child), plan) in (0u8..).zip(ids).zip(branchlet.plans) {
                if let Some(child) = child {
                    self.heritage.push(Heritage { lineage: lineage.child(slot), plan });
                    self.next.push(child);
                }
            }
        }
    }

    /// The tree, and whether its budget cut it short.
    pub(crate) fn finish(self) -> (BranchGraph, bool) {
        (self.tree, self.hit_budget)
    }
}
