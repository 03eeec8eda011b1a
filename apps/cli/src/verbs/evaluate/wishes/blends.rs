//! Species between species, measured like their parents.

use anyhow::Result;
use deeptree_eval::{Metric, Moments, TreeMetrics, jackknife};
use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::{BranchGraph, Seed, TreeTraits};
use deeptree_infer::{Model, Predictor, Workspace};
use serde::{Deserialize, Serialize};

use crate::blend;
use crate::verbs::evaluate::study::Study;
use crate::verbs::evaluate::trees;

/// Trees of each blend and parent.
const FULL: u32 = 100;
const QUICK: u32 = 4;

/// The blends that are grown, as two species and the tenths of the second.
const BLENDS: [([&str; 2], u8); 6] = [
    (["oak", "willow"], 3),
    (["oak", "willow"], 5),
    (["oak", "willow"], 7),
    (["beech", "pine"], 5),
    (["corkscrew", "walnut"], 5),
    (["maple", "tulip"], 5),
];

/// Standard errors that parents must be apart by, for a place between them to mean anything.
const APART: f64 = 4.0;

/// What is measured of each tree.
pub(super) const QUANTITIES: [&str; 9] = [
    "BL, m",
    "BN",
    "BD, m",
    "A1, rad",
    "A2, rad",
    "A3, rad",
    "nodes",
    "height, m",
    "crown radius, m",
];
const METRICS: [Metric; 6] = [
    Metric::BranchLength,
    Metric::BranchNumber,
    Metric::BranchingDistance,
    Metric::AngleChild1,
    Metric::AngleChild2,
    Metric::AngleChild3,
];

/// Decimals of each quantity.
pub(super) const DECIMALS: [usize; 9] = [2, 0, 2, 3, 3, 3, 0, 1, 1];

/// Estimates of the quantities, in their order.
pub(super) type Figures = [jackknife::Estimate; QUANTITIES.len()];

/// A blend beside its parents.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Blend {
    /// As `--blend` takes it.
    pub(super) name: String,
    pub(super) parents: [String; 2],
    /// Of the second parent.
    pub(super) weight: f64,
    pub(super) of_parents: [Figures; 2],
    pub(super) own: Figures,
}

/// Where a blend lies between its parents: 0 is the first, 1 the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Between {
    pub(super) at: f64,
    pub(super) error: f64,
}

impl Between {
    /// Of three means with their errors; none where the parents do not differ.
    fn of(own: (f64, f64), first: (f64, f64), second: (f64, f64)) -> Option<Self> {
        let apart = second.0 - first.0;
        if apart.abs() <= APART * first.1.hypot(second.1) {
            return None;
        }
        let at = (own.0 - first.0) / apart;
        let error = own.1.hypot((1.0 - at) * first.1).hypot(at * second.1) / apart.abs();
        Some(Self { at, error })
    }

    /// Does it lie between them, but for two standard errors?
    pub(super) fn is_between(&self) -> bool {
        (-2.0 * self.error..=1.0 + 2.0 * self.error).contains(&self.at)
    }
}

impl Blend {
    /// Where it lies in a quantity.
    pub(super) fn between(&self, quantity: usize) -> Option<Between> {
        let of = |figures: &Figures| (figures[quantity].mean, figures[quantity].mean_error);
        Between::of(of(&self.own), of(&self.of_parents[0]), of(&self.of_parents[1]))
    }
}

/// The blends whose species are looked at.
pub(super) fn measure(study: &Study<'_>) -> Result<Vec<Blend>> {
    let mut all = Vec::new();
    for (parents, tenths) in BLENDS {
        let known = |name: &&str| study.species.iter().any(|species| species.name == **name);
        if parents.iter().all(known) {
            all.push(measure_one(study, parents, tenths)?);
        }
    }
    Ok(all)
}

fn measure_one(study: &Study<'_>, parents: [&str; 2], tenths: u8) -> Result<Blend> {
    let list = list(parents, tenths);
    let parent = |name: &str| {
        let Some(model) = &study.model else { anyhow::bail!("there is no model") };
        study.part(&format!("wishes-parent-{name}"), || figures(study, model, name))
    };
    let of_parents = [parent(parents[0])?, parent(parents[1])?];
    let file = format!("wishes-blend-{}", list.replace([':', ','], "-"));
    let own = study.part(&file, || {
        let model = model(study, &list)?;
        figures(study, &model, &model.species()[0])
    })?;
    let (weight, parents) = (f64::from(tenths) / 10.0, parents.map(str::to_owned));
    Ok(Blend { name: list, parents, weight, of_parents, own })
}

/// The blend as `--blend` takes it.
fn list([first, second]: [&str; 2], tenths: u8) -> String {
    format!("{first}:0.{},{second}:0.{tenths}", 10 - tenths)
}

/// The model of a blend.
pub(super) fn model(study: &Study<'_>, list: &str) -> Result<Model> {
    let weights = study.verb.model.weights()?;
    let shares = blend::shares(list, weights.species())?;
    blend::model(&weights, &shares)
}

/// The tree of a species or blend.
pub(super) fn tree(
    model: &Model,
    species: &str,
    seed: u64,
    work: &mut Workspace,
) -> Result<BranchGraph> {
    Ok(generate(model, &Request::new(species, Seed(seed)), Limits::default(), work)?.tree)
}

fn figures(study: &Study<'_>, model: &Model, species: &str) -> Result<Figures> {
    let count = study.scale(FULL, QUICK).min(study.trees()).max(2);
    let rows = trees::many(study, species, study.verb.seed, count, |work, seed| {
        Ok(numbers(&tree(model, species, seed, work)?))
    })?;
    Ok(std::array::from_fn(|quantity| {
        let trees: Vec<Moments> = rows.iter().map(|row| row[quantity]).collect();
        jackknife::Estimate::of(&trees)
    }))
}

/// The samples of a tree for each quantity.
fn numbers(tree: &BranchGraph) -> [Moments; QUANTITIES.len()] {
    let (metrics, traits) = (TreeMetrics::of(tree), TreeTraits::of(tree));
    let whole = [traits.nodes, traits.height, traits.crown_radius].map(|number| {
        let mut moments = Moments::default();
        moments.add(f64::from(number));
        moments
    });
    let mut all = [Moments::default(); QUANTITIES.len()];
    let pooled = METRICS.into_iter().map(|metric| metrics.moments[metric as usize]);
    for (moments, found) in all.iter_mut().zip(pooled.chain(whole)) {
        *moments = found;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_the_way_is_a_third_and_its_error_is_worked_out_by_hand() {
        let at = Between::of((12.0, 0.3), (10.0, 0.2), (16.0, 0.4)).unwrap();
        assert!((at.at - 1.0 / 3.0).abs() < 1e-12);
        let error = (0.3f64.powi(2) + (0.2 * 2.0 / 3.0f64).powi(2) + (0.4 / 3.0f64).powi(2)).sqrt();
        assert!((at.error - error / 6.0).abs() < 1e-12);
        assert!(at.is_between());
        assert!(!Between { at: 1.3, error: 0.1 }.is_between());
        assert!(Between { at: -0.15, error: 0.1 }.is_between());
    }

    #[test]
    fn parents_that_are_alike_have_no_between() {
        assert_eq!(Between::of((12.0, 0.3), (10.0, 0.3), (11.0, 0.4)), None);
    }

    #[test]
    fn lists_are_as_the_command_takes_them() {
        assert_eq!(list(["oak", "willow"], 3), "oak:0.7,willow:0.3");
        assert_eq!(list(["oak", "willow"], 7), "oak:0.3,willow:0.7");
    }
}
