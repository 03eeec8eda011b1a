//! Stands: trees that grow together and crowd each other.
//!
//! All trees go on to their next level at once, so that each node sees what all trees have grown so
//! far. A tree counts the nodes of the others in a neighbourhood of its own and in its own frame:
//! the bits of a tree do not depend on the order in which the trees are named, or on the number of
//! threads, nor on where the stand lies as far as floats tell the distances alike; and a tree that no
//! other reaches is the same as by itself.

use deeptree_graph::signature::GROWTH_SPACE;
use deeptree_graph::signature::competition::{Contender, REACH};
use deeptree_graph::{Lineage, Neighbourhood, Purpose, Seed, Vec2, Vec3};
use deeptree_infer::{Predictor, Workspace};
use deeptree_scene::Site;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::growing::{Growing, Grown};
use crate::{GenerateError, Generated, Germ, Limits, Request, density, germ_in_or_open, sprout};

/// Standard deviation of what a tree truly loses over what it is expected to: in the growth model's
/// stands what is left unexplained grows with the shift, and is nearly the same for tips, nodes and
/// branches. `scatter_nodes` of the network, in the file beside the model, is as root mean square a
/// little more, as some are far off. Without it stands would be too even, and would have too few
/// nodes: the mean of logarithms is not the logarithm of the mean.
const SCATTER: f64 = 0.3;

/// How many of these a tree may be off.
const MOST_LUCK: f64 = 2.5;

/// A tree of a stand.
#[derive(Clone, Copy, Debug)]
pub struct Planted<'a> {
    /// What is asked of it.
    pub request: &'a Request,
    /// Where its foot is, in metres.
    pub at: Vec3,
    /// What stands around it besides trees, in its own frame; none in the open.
    pub site: Option<&'a Site>,
}

/// Why a stand could not be grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum StandError {
    #[error("the tree at x {}, z {}", at.x, at.z)]
    Tree { at: Vec3, source: GenerateError },
    #[error("a tree stands at x {}, y {}, z {}; give finite numbers", at.x, at.y, at.z)]
    NotFinite { at: Vec3 },
}

/// Grows the trees of a stand together, level by level. Gives them in the order of the plan, each in
/// its own frame, with its foot at the origin.
///
/// The budget holds for each tree. `work` is what each thread begins with.
///
/// # Errors
///
/// As [`crate::generate`], for the first tree of the plan that fails.
pub fn generate_stand(
    model: &impl Predictor,
    plan: &[Planted<'_>],
    limits: Limits,
    work: &Workspace,
) -> Result<Vec<Generated>, StandError> {
    let at = |i: usize| move |source| StandError::Tree { at: plan[i].at, source };
    if let Some(tree) = plan.iter().find(|tree| !tree.at.is_finite()) {
        return Err(StandError::NotFinite { at: tree.at });
    }
    let mut germs = Vec::with_capacity(plan.len());
    for (i, tree) in plan.iter().enumerate() {
        germs.push(germ_in_or_open(model, tree.request, tree.site).map_err(at(i))?);
    }
    compete(model, plan, &mut germs).map_err(|(i, source)| at(i)(source))?;
    let mut trees = Vec::with_capacity(plan.len());
    for (i, germ) in germs.into_iter().enumerate() {
        let growing = sprout(model, &germ, plan[i].site, limits).map_err(at(i))?;
        let neighbourhood = Neighbourhood::of_a_tree();
        trees.push(Tree { germ, growing, neighbourhood, others: others(plan, i), failed: None });
    }
    while enter_level(&mut trees) {
        see_others(&mut trees);
        each(&mut trees, work, |tree, work| {
            let grown = tree.growing.grow_level(model, &tree.neighbourhood, limits, work);
            tree.failed = grown.err();
        });
        // All have tried: the first of the plan is told, whichever thread was first.
        if let Some(i) = trees.iter().position(|tree| tree.failed.is_some())
            && let Some(error) = trees[i].failed.take()
        {
            return Err(at(i)(error));
        }
    }
    Ok(trees.into_iter().map(Tree::finish).collect())
}

/// Moves each tree's root by what the model expects that the others, as they would be by themselves,
/// make of it. A model that has not learned from stands moves nothing.
fn compete(
    model: &impl Predictor,
    plan: &[Planted<'_>],
    germs: &mut [Germ],
) -> Result<(), (usize, GenerateError)> {
    let Some(competition) = model.competition() else { return Ok(()) };
    let contender = |germ: &Germ| Contender {
        species: germ.species,
        age: germ.root.age,
        nodes: germ.root.traits.nodes,
        height: germ.root.traits.height,
    };
    let contenders: Vec<Contender> = germs.iter().map(contender).collect();
    for (i, germ) in germs.iter_mut().enumerate() {
        let from = |(at, &other): (Vec3, &Contender)| (Vec2::new(at.x, at.z), other);
        let others = others(plan, i).into_iter().map(|(j, at)| from((at, &contenders[j])));
        let others: Vec<(Vec2, Contender)> = others.filter(|(at, _)| at.length() < REACH).collect();
        if others.is_empty() {
            continue;
        }
        let overflow = |_| (i, GenerateError::Overflow { node: 0 });
        let shift = competition.shift(&contenders[i], &others).map_err(overflow)?;
        let tip_radius = model.tip_radius(germ.species);
        let luck = luck(germ.seed);
        germ.root = density::moved(germ.root, tip_radius, &shift.map(|shift| luck * shift));
    }
    Ok(())
}

/// What the expected shift of a tree is multiplied by: trees of the same chances fare differently.
fn luck(seed: Seed) -> f64 {
    let normal = seed.draws(Lineage::ROOT, Purpose::Competition).normal();
    1.0 + SCATTER * normal.clamp(-MOST_LUCK, MOST_LUCK)
}

/// A tree of a stand on its way.
struct Tree<'a> {
    germ: Germ,
    growing: Growing<'a>,
    neighbourhood: Neighbourhood,
    /// Trees whose nodes can count at this one, and where they stand as seen from it.
    others: Vec<(usize, Vec3)>,
    failed: Option<GenerateError>,
}

impl Tree<'_> {
    fn finish(self) -> Generated {
        let Grown { tree, hit_budget, avoided, .. } = self.growing.finish();
        Generated { tree, germ: self.germ, hit_budget, avoided }
    }
}

/// The trees whose growth space overlaps that of tree `i`.
fn others(plan: &[Planted<'_>], i: usize) -> Vec<(usize, Vec3)> {
    let from = |j: usize| (j, plan[j].at - plan[i].at);
    let reaches = |at: Vec3| at.x.abs().max(at.z.abs()) < GROWTH_SPACE;
    let all = (0..plan.len()).filter(|&j| j != i).map(from);
    all.filter(|&(_, at)| reaches(at)).collect()
}

/// Goes on to the next level; false when all trees are finished.
fn enter_level(trees: &mut [Tree<'_>]) -> bool {
    let mut is_any = false;
    for tree in trees {
        is_any |= tree.growing.enter_level(&mut tree.neighbourhood);
    }
    is_any
}

/// Makes the nodes of the level known to the trees around.
fn see_others(trees: &mut [Tree<'_>]) {
    let levels: Vec<Vec<Vec3>> = trees.iter().map(|tree| tree.growing.level().collect()).collect();
    for tree in trees {
        for &(other, at) in &tree.others {
            for &position in &levels[other] {
                tree.neighbourhood.add(position + at);
            }
        }
    }
}

/// Does something with each tree, on all threads.
#[cfg(feature = "parallel")]
fn each<'a>(
    trees: &mut [Tree<'a>],
    work: &Workspace,
    one: impl Fn(&mut Tree<'a>, &mut Workspace) + Sync,
) {
    trees.par_iter_mut().for_each_init(|| work.clone(), |work, tree| one(tree, work));
}

/// Does something with each tree.
#[cfg(not(feature = "parallel"))]
fn each<'a>(
    trees: &mut [Tree<'a>],
    work: &Workspace,
    one: impl Fn(&mut Tree<'a>, &mut Workspace) + Sync,
) {
    let mut work = work.clone();
    trees.iter_mut().for_each(|tree| one(tree, &mut work));
}
