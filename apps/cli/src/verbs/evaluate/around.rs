//! Trees of both sides among what stands around, measured side by side.
//!
//! Each place, a scene or a form, holds a tree of the teacher, one of the teacher with another seed
//! as a control, one of the learner, and one of the learner that is not told of the place.

use anyhow::Result;
use deeptree_eval::jackknife::leave_one_out;
use deeptree_eval::report::{Cell, Tone};
use deeptree_eval::{Metric, TreeMetrics};
use deeptree_generate::{Avoided, Limits, Request, generate_in};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::{Species, grow_around};
use deeptree_infer::{Model, Workspace};
use deeptree_scene::{Environment, Site};
use serde::{Deserialize, Serialize};

use super::estimate::Difference;
use super::study::{Study, short};
use super::trees;

/// From the seeds of one sample of the teacher to those of the other.
pub(super) const SECOND_SAMPLE: u64 = 1_000_000;

/// The trees of a place: teacher, its control, learner, learner not told.
pub(super) const SIDES: [&str; 4] = ["P", "P2", "DT", "DT not told"];
pub(super) const TEACHER: usize = 0;
pub(super) const CONTROL: usize = 1;
pub(super) const LEARNER: usize = 2;
pub(super) const UNTOLD: usize = 3;

/// What is measured of trees, and how near the learner shall be.
pub(super) struct Quantity {
    pub(super) name: &'static str,
    /// Is a difference told as a part of the teacher's mean, or in the quantity's own unit?
    pub(super) in_parts: bool,
    /// How far the learner may be off, where there is a goal.
    pub(super) goal: Option<f64>,
}

/// A sum over samples of a tree, and how many they are: a mean over trees or over all their
/// branches is the sum of the sums over that of the counts.
pub(super) type Sample = [f64; 2];

/// What is kept of a tree.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Measured {
    pub(super) nodes: u64,
    /// Nodes where no branch may be, and edges through obstacles.
    pub(super) misplaced: [u64; 2],
    pub(super) redrawn: u64,
    pub(super) given_up: u64,
    pub(super) hit_budget: bool,
    pub(super) samples: Vec<Sample>,
}

/// The trees of one species, place by place, in the order of [`SIDES`].
#[derive(Serialize, Deserialize)]
pub(super) struct Places {
    pub(super) species: String,
    pub(super) places: Vec<[Measured; SIDES.len()]>,
}

/// Grows and generates the trees of a place and seed.
pub(super) fn four(
    study: &Study<'_>,
    model: &Model,
    species: &Species,
    seed: u64,
    environment: &Environment,
    work: &mut Workspace,
    samples: impl Fn(&BranchGraph) -> Vec<Sample>,
) -> Result<[Measured; SIDES.len()]> {
    let site = Site::new(environment.clone());
    let teacher = |seed| {
        let grown = teacher(study, species, seed, environment)?;
        Ok::<_, anyhow::Error>((grown.0, Avoided::default(), grown.1))
    };
    let (first, second) = (teacher(seed)?, teacher(seed.wrapping_add(SECOND_SAMPLE))?);
    let told = learner(model, species, seed, &site, work)?;
    let untold = trees::generated(model, &species.name, seed, work)?;
    let untold = (untold.tree, untold.avoided, untold.hit_budget);
    Ok([first, second, told, untold].map(|(tree, avoided, hit_budget)| {
        let nodes = tree.nodes();
        let is_misplaced = |n: &&deeptree_graph::Node| !environment.admits(n.position);
        let crosses = |n: &&deeptree_graph::Node| environment.scene.crosses(n.base(), n.position);
        Measured {
            nodes: nodes.len() as u64,
            misplaced: [
                nodes.iter().filter(is_misplaced).count() as u64,
                nodes.iter().filter(crosses).count() as u64,
            ],
            redrawn: avoided.redrawn,
            given_up: avoided.given_up,
            hit_budget,
            samples: samples(&tree),
        }
    }))
}

/// The teacher's tree at a place, and whether the budget cut it off.
pub(super) fn teacher(
    study: &Study<'_>,
    species: &Species,
    seed: u64,
    environment: &Environment,
) -> Result<(BranchGraph, bool)> {
    let parameters = species.parameters(study.verb.profile);
    let grown = grow_around(&species.name, parameters, Seed(seed), environment)?;
    Ok((grown.tree, grown.hit_budget))
}

/// The learner's tree at a place, what it avoided, and whether the budget cut it off.
pub(super) fn learner(
    model: &Model,
    species: &Species,
    seed: u64,
    site: &Site,
    work: &mut Workspace,
) -> Result<(BranchGraph, Avoided, bool)> {
    let request = Request::new(&species.name, Seed(seed));
    let grown = generate_in(model, &request, site, Limits::default(), work)?;
    Ok((grown.tree, grown.avoided, grown.hit_budget))
}

/// Nodes, branches and the lengths of branches, which every place is asked for.
pub(super) fn of_any_tree(tree: &BranchGraph) -> [Sample; 3] {
    let metrics = TreeMetrics::of(tree);
    let pooled = |metric: Metric| {
        let [count, mean, _] = metrics.moments[metric as usize].parts();
        [mean * count, count]
    };
    let nodes = [tree.len() as f64, 1.0];
    [nodes, pooled(Metric::BranchNumber), pooled(Metric::BranchLength)]
}

/// The mean of a quantity on one side, over all samples of all trees.
pub(super) fn mean(of: &Places, side: usize, quantity: usize) -> f64 {
    mean_but(of, side, quantity, None)
}

fn mean_but(of: &Places, side: usize, quantity: usize, without: Option<usize>) -> f64 {
    let places = of.places.iter().enumerate().filter(|(i, _)| Some(*i) != without);
    let samples = places.map(|(_, trees)| trees[side].samples[quantity]);
    let [sum, count] = samples.fold([0.0; 2], |[s, n], [sum, count]| [s + sum, n + count]);
    sum / count
}

/// How far a side is from the teacher on average of some species. Places are what is drawn, so the
/// error is the jackknife's, leaving out one place after the other for all species and both sides.
pub(super) fn difference(
    of: &[&Places],
    side: usize,
    quantity: usize,
    in_parts: bool,
) -> Difference {
    let places = of.iter().map(|of| of.places.len()).max().unwrap_or(0);
    let (by, error) = leave_one_out(places, |without| {
        let each = of.iter().map(|of| {
            let [p, x] = [TEACHER, side].map(|side| mean_but(of, side, quantity, without));
            if in_parts { x / p - 1.0 } else { x - p }
        });
        each.sum::<f64>() / of.len() as f64
    });
    Difference { by, error }
}

/// A difference within its goal is good, one beyond it by more than two standard errors bad; what
/// lies between says neither.
fn tone(found: &Difference, goal: f64) -> Tone {
    if found.by.abs() <= goal {
        Tone::Good
    } else if found.by.abs() > goal + 2.0 * found.error {
        Tone::Bad
    } else {
        Tone::Plain
    }
}

fn text(found: &Difference, quantity: &Quantity) -> String {
    if quantity.in_parts { found.percent() } else { found.plain(2) }
}

/// Four rows of a species, or three of the mean of all: the teacher's means, and how far the others
/// are off. Each begins with `names`.
pub(super) fn rows(names: &[&str], of: &[&Places], quantities: &[Quantity]) -> Vec<Vec<Cell>> {
    let means = (of.len() == 1).then(|| {
        let of_one = |i| Cell::new(short(mean(of[0], TEACHER, i), 4), Tone::Quiet);
        (TEACHER, (0..quantities.len()).map(of_one).collect::<Vec<_>>())
    });
    let others = [CONTROL, LEARNER, UNTOLD].map(|side| {
        let cells = quantities.iter().enumerate().map(|(i, quantity)| {
            let found = difference(of, side, i, quantity.in_parts);
            let tone = match quantity.goal {
                _ if side != LEARNER => Tone::Quiet,
                None => Tone::Plain,
                Some(goal) => tone(&found, goal),
            };
            Cell::new(text(&found, quantity), tone)
        });
        (side, cells.collect())
    });
    let row = |(side, cells): (usize, Vec<Cell>)| {
        let head = names.iter().map(|&name| Cell::from(name)).chain([SIDES[side].into()]);
        head.chain(cells).collect()
    };
    means.into_iter().chain(others).map(row).collect()
}

/// What a side's trees have in sum.
pub(super) fn sum(of: &[&Places], side: usize, what: impl Fn(&Measured) -> u64) -> u64 {
    of.iter().flat_map(|of| &of.places).map(|trees| what(&trees[side])).sum()
}

/// A sentence of how far the learner is off on average of all species, beside its control.
pub(super) fn sentence(of: &[&Places], quantities: &[Quantity]) -> String {
    let one = |(i, quantity): (usize, &Quantity)| {
        let of_side = |side| text(&difference(of, side, i, quantity.in_parts), quantity);
        format!("{} {} (control {})", quantity.name, of_side(LEARNER), of_side(CONTROL))
    };
    quantities.iter().enumerate().map(one).collect::<Vec<_>>().join("; ")
}

/// How many of the differences of a goal are within it, and how many beyond it by more than chance.
pub(super) fn goals(all: &[Vec<&Places>], quantities: &[Quantity]) -> String {
    let [mut count, mut good, mut bad] = [0, 0, 0];
    for of in all {
        for (i, quantity) in quantities.iter().enumerate() {
            let Some(goal) = quantity.goal else { continue };
            let tone = tone(&difference(of, LEARNER, i, quantity.in_parts), goal);
            count += 1;
            good += usize::from(tone == Tone::Good);
            bad += usize::from(tone == Tone::Bad);
        }
    }
    format!("of {count}, {good} are within their goal and {bad} beyond it by two standard errors")
}

/// Lines of a table, one a side and quantity, each beginning with `names`.
pub(super) fn csv(names: &str, of: &Places, quantities: &[Quantity]) -> String {
    let mut text = String::new();
    for (side, symbol) in SIDES.iter().enumerate() {
        for (i, quantity) in quantities.iter().enumerate() {
            let found = difference(&[of], side, i, quantity.in_parts);
            let unit = if quantity.in_parts { "part" } else { "plain" };
            text += &format!(
                "{names},{symbol},{},{},{},{},{},{unit}\n",
                of.places.len(),
                quantity.name,
                mean(of, side, i),
                found.by,
                found.error,
            );
        }
    }
    text
}

/// The columns of [`csv`] after its names.
pub(super) const CSV: &str = "side,trees,quantity,mean,difference,standard_error,difference_as";

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(samples: [Sample; 2]) -> Measured {
        let samples = samples.to_vec();
        let zero = [0, 0];
        Measured { nodes: 1, misplaced: zero, redrawn: 0, given_up: 0, hit_budget: false, samples }
    }

    #[test]
    fn differences_and_their_errors_are_those_worked_out_by_hand() {
        // Two places; of the teacher 4 and 8, of the learner 5 and 7; and lengths of 2 and 1
        // branches, 3 m and 3 m against 4 m and 2 m of as many.
        let place = |p: f64, x: f64, branches: f64, metres: [f64; 2]| {
            let teacher = tree([[p, 1.0], [metres[0], branches]]);
            let other = tree([[x, 1.0], [metres[1], branches]]);
            [teacher.clone(), teacher, other.clone(), other]
        };
        let places = vec![place(4.0, 5.0, 2.0, [3.0, 4.0]), place(8.0, 7.0, 1.0, [3.0, 2.0])];
        let of = Places { species: "oak".into(), places };
        assert_eq!((mean(&of, TEACHER, 0), mean(&of, LEARNER, 0)), (6.0, 6.0));
        assert_eq!((mean(&of, TEACHER, 1), mean(&of, LEARNER, 1)), (2.0, 2.0));
        let parts = difference(&[&of], LEARNER, 0, true);
        // Without the first place 7/8 − 1, without the second 5/4 − 1: half of what is between.
        assert!(parts.by.abs() < 1e-12 && (parts.error - 0.375 / 2.0).abs() < 1e-12);
        // Without each: 2 − 3, and 2 − 1.5 metres.
        let plain = difference(&[&of], LEARNER, 1, false);
        assert!(plain.by.abs() < 1e-12 && (plain.error - 0.75).abs() < 1e-12);
        let control = difference(&[&of], CONTROL, 0, true);
        assert_eq!((control.by, control.error), (0.0, 0.0));
        // Two species alike are as sure as one: they stand in the same places.
        assert!((difference(&[&of, &of], LEARNER, 0, true).error - 0.375 / 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_goal_is_met_missed_or_left_open() {
        let of = |by| tone(&Difference { by, error: 0.1 }, 0.25);
        assert_eq!([of(0.2), of(-0.2)], [Tone::Good; 2]);
        assert_eq!([of(0.4), of(-0.4)], [Tone::Plain; 2]);
        assert_eq!([of(0.5), of(-0.5)], [Tone::Bad; 2]);
    }
}
