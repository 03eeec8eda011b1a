//! Regrowth: a tree is pruned, and grows again from its wounds.
//!
//! What is kept is not touched. A node that has kept some of its children gets back the others, as
//! thick as they were, and only how they lie is drawn; a node that has lost all of them branches
//! anew, but bears the tips and reaches as far as before. So thickness is conserved, and a regrown
//! tree is one that can be regrown again.

use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{
    BranchGraph, Cut, Node, NodeId, PruneError, Pruned, Seed, TreeInfo, Vec3, prune,
};
use deeptree_infer::{Predictor, Workspace};
use deeptree_scene::Site;

use crate::aim;
use crate::density::Stock;
use crate::growing::{Avoided, Growing, Grown};
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
    /// How often a branch would have gone where none can.
    pub avoided: Avoided,
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
    regrow_in(model, tree, cuts, seed, None, limits, work)
}

/// As [`regrow`], around what stands at a site. What is kept stays, even where no branch could go.
///
/// # Errors
///
/// As [`regrow`].
pub fn regrow_in(
    model: &impl Predictor,
    tree: &BranchGraph,
    cuts: &[Cut],
    seed: Seed,
    site: Option<&Site>,
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
    let growing = Growing::again(tree, &pruned, conditions, seed, site);
    let Grown { tree, kept, hit_budget, avoided } = growing.grow(model, limits, work)?;
    Ok(Regrown { tree, pruned, kept, hit_budget, avoided })
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
    aim::check(Stock::of(model, species), &request)?;
    Ok(TreeConditions::of(tree, species, tip_radius, model.kin(species)))
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
