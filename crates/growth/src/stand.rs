//! Stands: trees that grow together and crowd each other.

use deeptree_graph::{Seed, Vec3};

use crate::cycle::Growth;
use crate::parameters::Parameters;
use crate::surroundings::{OpenField, Surroundings};
use crate::{DEFAULT_BUDGET, GrowError, Grown, finish};

/// A tree of a stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Planted<'a> {
    /// Species, by name.
    pub species: &'a str,
    /// What it grows by.
    pub parameters: &'a Parameters,
    /// Its seed.
    pub seed: Seed,
    /// Where its foot is, in metres.
    pub at: Vec3,
}

impl Planted<'_> {
    fn age(&self) -> u32 {
        self.parameters.age as u32
    }

    /// Orders the trees of a stand whatever order they were named in.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let place = |t: &Self| t.at.to_array();
        let by_place = place(self)
            .iter()
            .zip(place(other))
            .fold(std::cmp::Ordering::Equal, |so_far, (a, b)| so_far.then(a.total_cmp(&b)));
        by_place
            .then_with(|| self.species.cmp(other.species))
            .then_with(|| self.seed.cmp(&other.seed))
            .then_with(|| self.parameters.age.total_cmp(&other.parameters.age))
    }
}

/// Grows the trees of a stand in the open field; see [`grow_stand_in`].
///
/// # Errors
///
/// As [`grow_stand_in`].
pub fn grow_stand(plan: &[Planted<'_>]) -> Result<Vec<Grown>, GrowError> {
    grow_stand_in(plan, &vec![OpenField; plan.len()], DEFAULT_BUDGET)
}

/// Grows the trees of a stand together, cycle by cycle: the crown density D around an internode
/// counts those of all trees, as they were at the start of the cycle. The trees are all done in the
/// same cycle, so a younger one starts later.
///
/// Gives the trees in the order of the plan, each in its own frame, with its foot at the origin.
/// What a tree becomes depends on the other trees and where they are, not on the order in which
/// they are named; a tree without others within its density radius is the same, to the last bit, as
/// by itself. `surroundings` are those of each tree, in its own frame; `budget` holds for each.
///
/// # Errors
///
/// As [`grow_in`](crate::grow_in), for the first tree that fails.
///
/// # Panics
///
/// When there are not as many surroundings as trees.
pub fn grow_stand_in<S: Surroundings>(
    plan: &[Planted<'_>],
    surroundings: &[S],
    budget: usize,
) -> Result<Vec<Grown>, GrowError> {
    assert_eq!(plan.len(), surroundings.len(), "each tree has surroundings of its own");
    for tree in plan {
        tree.parameters.validate()?;
    }
    // Sums of floats depend on their order: it must not be the plan's.
    let mut order: Vec<usize> = (0..plan.len()).collect();
    order.sort_by(|&a, &b| plan[a].cmp(&plan[b]));

    let mut growths: Vec<Growth<'_>> =
        plan.iter().map(|tree| Growth::new(tree.parameters, tree.seed)).collect();
    let mut hit_budget = vec![false; plan.len()];
    let last = plan.iter().map(Planted::age).max().unwrap_or(0);
    for number in 0..last {
        let starts = |i: usize| last - plan[i].age();
        let bases: Vec<Vec<Vec3>> = growths
            .iter()
            .enumerate()
            .map(|(i, growth)| {
                let internodes = if number < starts(i) { &[][..] } else { &growth.internodes[..] };
                internodes.iter().map(|internode| internode.base).collect()
            })
            .collect();
        for i in 0..plan.len() {
            if number < starts(i) || hit_budget[i] {
                continue;
            }
            let others = others_near(i, plan, &bases, &order);
            growths[i].cycle(number - starts(i), &surroundings[i], &others);
            hit_budget[i] = growths[i].internodes.len() > budget;
        }
    }
    let trees = growths.into_iter().zip(plan).zip(surroundings).zip(hit_budget);
    trees
        .map(|(((growth, tree), surroundings), hit)| {
            finish(growth, tree.species, tree.parameters, tree.seed, surroundings, hit)
        })
        .collect()
}

/// The bases of other trees that can count at tree `i`, in its frame.
fn others_near(i: usize, plan: &[Planted<'_>], bases: &[Vec<Vec3>], order: &[usize]) -> Vec<Vec3> {
    let radius = plan[i].parameters.density_radius;
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &base in &bases[i] {
        (low, high) = (low.min(base), high.max(base));
    }
    let (low, high) = (low - radius, high + radius);
    let mut near = Vec::new();
    for &j in order.iter().filter(|&&j| j != i) {
        let shift = plan[j].at - plan[i].at;
        let shifted = bases[j].iter().map(|&base| base + shift);
        near.extend(shifted.filter(|base| base.cmpge(low).all() && base.cmple(high).all()));
    }
    near
}
