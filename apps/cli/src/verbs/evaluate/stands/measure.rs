//! Stands of both sides.

use std::collections::BTreeMap;

use anyhow::Result;
use deeptree_eval::intersections_between;
use deeptree_generate::{Limits, Planted, Request, generate_stand};
use deeptree_graph::signature::outlook::crown_offset;
use deeptree_graph::{BranchGraph, Draws, Lineage, Purpose, Seed, TreeTraits, Vec3};
use deeptree_growth::{Planted as Grown, Species, grow_stand};
use deeptree_infer::{Model, Workspace};

use crate::verbs::evaluate::around::{Measured, Places, SECOND_SAMPLE, SIDES, Sample};
use crate::verbs::evaluate::study::Study;
use crate::verbs::evaluate::trees;

/// Trees on a side of a stand, and of a stand.
const SIDE: usize = 5;
pub(super) const TREES: usize = SIDE * SIDE;

/// Distances of neighbours in metres; stands take turns.
pub(super) const SPACINGS: [f32; 4] = [3.0, 5.0, 8.0, 12.0];

/// Part of the spacing that a tree stands off its place, at most.
const JITTER: f64 = 0.2;

/// Side of the cells that crowns are compared in, in metres.
const CELL: f32 = 2.0;

/// A tree of a plan: its species, its seed and its place.
pub(super) struct Row<'a> {
    species: &'a Species,
    seed: Seed,
    at: Vec3,
}

/// The plan of stand `number`: its trees have consecutive seeds.
pub(super) fn plan<'a>(species: &[&'a Species], first: u64, number: u64) -> Vec<Row<'a>> {
    let spacing = f64::from(SPACINGS[number as usize % SPACINGS.len()]);
    let seed = Seed(first).of_tree(number * TREES as u64);
    let mut draws = seed.draws(Lineage::ROOT, Purpose::Evaluation);
    let place = |draws: &mut Draws, cell: usize| {
        (spacing * (cell as f64 + JITTER * (2.0 * draws.uniform() - 1.0))) as f32
    };
    (0..TREES)
        .map(|i| {
            let at = Vec3::new(place(&mut draws, i % SIDE), 0.0, place(&mut draws, i / SIDE));
            let species = species[draws.index(species.len())];
            Row { species, seed: seed.of_tree(i as u64), at }
        })
        .collect()
}

/// The growth model's trees of a plan, at their places; `later` is added to their seeds.
pub(super) fn teacher(study: &Study<'_>, plan: &[Row<'_>], later: u64) -> Result<Vec<BranchGraph>> {
    let planted: Vec<Grown<'_>> = plan
        .iter()
        .map(|row| Grown {
            species: &row.species.name,
            parameters: row.species.parameters(study.verb.profile),
            seed: row.seed.of_tree(later),
            at: row.at,
        })
        .collect();
    let grown = grow_stand(&planted)?;
    Ok(grown.into_iter().zip(plan).map(|(grown, row)| grown.tree.moved(row.at)).collect())
}

/// The networks' trees of a plan, at their places, and whether a budget cut any off.
pub(super) fn learner(
    model: &Model,
    plan: &[Row<'_>],
    work: &Workspace,
) -> Result<(Vec<BranchGraph>, bool)> {
    let requests: Vec<Request> =
        plan.iter().map(|row| Request::new(&row.species.name, row.seed)).collect();
    let planted: Vec<Planted<'_>> = requests
        .iter()
        .zip(plan)
        .map(|(request, row)| Planted { request, at: row.at, site: None })
        .collect();
    let grown = generate_stand(model, &planted, Limits::default(), work)?;
    let hit_budget = grown.iter().any(|tree| tree.hit_budget);
    let grown = grown.into_iter().zip(plan);
    Ok((grown.map(|(grown, row)| grown.tree.moved(row.at)).collect(), hit_budget))
}

/// The same trees in the open field, set side by side.
pub(super) fn untold(
    model: &Model,
    plan: &[Row<'_>],
    work: &mut Workspace,
) -> Result<Vec<BranchGraph>> {
    let one = |row: &Row<'_>| {
        let grown = trees::generated(model, &row.species.name, row.seed.0, work)?;
        Ok(grown.tree.moved(row.at))
    };
    plan.iter().map(one).collect()
}

/// Stands of these species, in the order of [`SIDES`].
pub(super) fn places(
    study: &Study<'_>,
    model: &Model,
    name: &str,
    species: &[&Species],
    count: u32,
) -> Result<Places> {
    study.part(&format!("stands-{name}"), || {
        let first = study.verb.seed;
        let what = format!("{name} stands");
        let places = trees::many(study, &what, 0, count, |work, number| {
            let plan = plan(species, first, number);
            let (told, hit_budget) = learner(model, &plan, work)?;
            let sides: [Vec<BranchGraph>; SIDES.len()] = [
                teacher(study, &plan, 0)?,
                teacher(study, &plan, SECOND_SAMPLE)?,
                told,
                untold(model, &plan, work)?,
            ];
            Ok(sides.map(|trees| Measured {
                nodes: trees.iter().map(|tree| tree.len() as u64).sum(),
                misplaced: [0, 0],
                redrawn: 0,
                given_up: 0,
                hit_budget,
                samples: samples(&trees, &plan),
            }))
        })?;
        Ok(Places { species: name.to_owned(), places })
    })
}

/// What is measured of a stand whose trees are at their places.
fn samples(trees: &[BranchGraph], plan: &[Row<'_>]) -> Vec<Sample> {
    let count = trees.len() as f64;
    let middle = plan.iter().map(|row| row.at).sum::<Vec3>() / plan.len() as f32;
    let mut sums = [0.0; 4];
    let mut logs = Vec::new();
    for (tree, row) in trees.iter().zip(plan) {
        let own = tree.clone().moved(-row.at);
        let traits = TreeTraits::of(&own);
        let offset = crown_offset(&own);
        let away = (row.at - middle).normalize_or_zero();
        let lean = offset.x * away.x + offset.y * away.z;
        let values = [traits.nodes, traits.height, traits.crown_radius, lean];
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
        logs.push(f64::from(traits.nodes).ln());
    }
    let mean = logs.iter().sum::<f64>() / count;
    let variance =
        logs.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0).max(1.0);
    let [nodes, height, radius, lean] = sums.map(|sum| [sum, count]);
    let pairs = intersections_between(trees) as f64;
    vec![nodes, [variance.sqrt(), 1.0], height, radius, lean, shared(trees), [pairs, 1.0]]
}

/// The nodes in cells where another tree has nodes, too, and all nodes.
fn shared(trees: &[BranchGraph]) -> Sample {
    let cell = |p: Vec3| (p / CELL).to_array().map(|x| x.floor() as i32);
    let mut owners: BTreeMap<[i32; 3], (usize, bool)> = BTreeMap::new();
    for (number, tree) in trees.iter().enumerate() {
        for node in tree.nodes() {
            let found = owners.entry(cell(node.position)).or_insert((number, false));
            found.1 |= found.0 != number;
        }
    }
    let nodes = || trees.iter().flat_map(BranchGraph::nodes);
    let is_shared = |node: &&deeptree_graph::Node| owners[&cell(node.position)].1;
    [nodes().filter(is_shared).count() as f64, nodes().count() as f64]
}
