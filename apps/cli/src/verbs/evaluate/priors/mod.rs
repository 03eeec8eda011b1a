//! Chapter 7: what age and gravitropism do to the growth model's trees and to those of the networks.

mod gaps;
mod show;

use anyhow::{Context, Result};
use deeptree_eval::development::Development;
use deeptree_eval::report::Chapter;
use deeptree_generate::{GenerateError, Limits, Request, generate, germ};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::{GrowError, Parameters, Species, grow};
use deeptree_infer::{Model, Workspace};
use serde::{Deserialize, Serialize};

use super::estimate::Estimate;
use super::study::{Study, short};
use super::trees;
use gaps::Seen;

/// Trees of each species, setting and set.
const FULL: u32 = 200;
const QUICK: u32 = 3;

/// What is varied; the other one stays as the species has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Axis {
    Age,
    Gravitropism,
}

/// A value of an axis, and the trees that grew there.
#[derive(Debug, Serialize, Deserialize)]
struct Setting {
    axis: Axis,
    species: String,
    value: f32,
    p: Measured,
    dt: Learner,
}

/// What the networks made of a setting.
#[derive(Debug, Serialize, Deserialize)]
enum Learner {
    /// There are no networks in this run.
    NotAsked,
    /// The model refuses the setting: it has seen this range only.
    NotSeen { what: String, low: f32, high: f32 },
    Grown {
        trees: Measured,
        /// Some training tree was of the setting.
        trained: bool,
    },
}

/// The numbers of [`Development`] over trees.
#[derive(Debug, Serialize, Deserialize)]
struct Measured {
    numbers: [Estimate; 4],
    /// Trees of which nothing had grown yet; they are not in the numbers.
    nothing: u32,
    /// Trees that their budget cut short; they are in the numbers as far as they got.
    cut: u32,
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("priors", "Priors: age and gravitropism");
    let species = looked_at(study);
    let mut settings = Vec::new();
    for axis in Axis::BOTH {
        for species in &species {
            settings.extend(measure(study, axis, species)?);
        }
    }
    show::text(&mut chapter, &settings, study.model.as_ref().map(Seen::of).as_ref());
    for axis in Axis::BOTH {
        let own: Vec<&Setting> = settings.iter().filter(|s| s.axis == axis).collect();
        chapter.heading(axis.title());
        show::charts(&mut chapter, axis, &own)?;
        let oak = species.iter().find(|species| species.name == "oak").or(species.first());
        if let Some(species) = oak {
            show::pictures(study, &mut chapter, axis, species)?;
        }
        show::table(&mut chapter, axis, &own);
    }
    show::save(study, &settings)?;
    Ok(chapter)
}

/// All species of the run; of a quick one oak and willow, or else the first.
fn looked_at<'a>(study: &'a Study<'_>) -> Vec<&'a Species> {
    let all: Vec<&Species> = study.species.iter().collect();
    if !study.verb.quick {
        return all;
    }
    let few = |species: &&&Species| ["oak", "willow"].contains(&species.name.as_str());
    let few: Vec<&Species> = all.iter().filter(few).copied().collect();
    if few.is_empty() { all.into_iter().take(1).collect() } else { few }
}

impl Axis {
    const BOTH: [Self; 2] = [Self::Age, Self::Gravitropism];

    const fn name(self) -> &'static str {
        match self {
            Self::Age => "age",
            Self::Gravitropism => "gravitropism",
        }
    }

    const fn title(self) -> &'static str {
        match self {
            Self::Age => "Age",
            Self::Gravitropism => "Gravitropism",
        }
    }

    /// The values that are measured: those of the figure, and the middle of what training has left
    /// out between them; of a quick run one such.
    fn values(self, study: &Study<'_>) -> Vec<f32> {
        let mut values = self.figure(study);
        let [first, last] = self.range();
        let seen = study.model.as_ref().map(Seen::of);
        let gaps = seen.map_or_else(Vec::new, |seen| match self {
            Self::Age => seen.age_gaps(),
            Self::Gravitropism => seen.gravitropism_gaps(),
        });
        let mut middles: Vec<f32> = gaps
            .into_iter()
            .filter(|(low, high)| !values.iter().any(|value| (low..=high).contains(&value)))
            .map(|(low, high)| match self {
                Self::Age => (0.5 * (low + high)).floor(),
                Self::Gravitropism => (50.0 * (low + high)).round() / 100.0,
            })
            .filter(|middle| (first..=last).contains(middle))
            .collect();
        if study.verb.quick && middles.len() > 1 {
            middles = vec![middles[middles.len() / 2]];
        }
        values.extend(middles);
        values.sort_by(f32::total_cmp);
        values
    }

    /// The range of the paper's figure.
    const fn range(self) -> [f32; 2] {
        match self {
            Self::Age => [10.0, 40.0],
            Self::Gravitropism => [-0.4, 0.4],
        }
    }

    /// The range of the paper's figure, in steps of its own: 10 to 40 cycles, −0.4 to 0.4.
    fn figure(self, study: &Study<'_>) -> Vec<f32> {
        let steps: &[i8] = match (self, study.verb.quick) {
            (Self::Age, false) => &[10, 15, 20, 25, 30, 35, 40],
            (Self::Age, true) => &[10, 25, 35],
            (Self::Gravitropism, false) => &[-40, -30, -20, -10, 0, 10, 20, 30, 40],
            (Self::Gravitropism, true) => &[-40, -10, 20, 40],
        };
        let unit = if self == Self::Age { 1.0 } else { 100.0 };
        steps.iter().map(|&step| f32::from(step) / unit).collect()
    }

    /// The value, as it is written.
    fn write(self, value: f32) -> String {
        match self {
            Self::Age => format!("{value:.0}"),
            Self::Gravitropism => {
                format!("{}{}", if value < 0.0 { "" } else { "+" }, short(value.into(), 2))
            }
        }
    }
}

/// The species' numbers with one of them set.
fn parameters(study: &Study<'_>, axis: Axis, species: &Species, value: f32) -> Parameters {
    let mut parameters = species.parameters(study.verb.profile).clone();
    match axis {
        Axis::Age => parameters.age = value,
        Axis::Gravitropism => parameters.gravitropism = value,
    }
    parameters
}

/// The same setting for the networks: both numbers are given, so that both sides grow under the
/// same conditions.
fn request(species: &Species, parameters: &Parameters, seed: u64) -> Request {
    Request {
        age: Some(parameters.age as u16),
        gravitropism: Some(parameters.gravitropism),
        ..Request::new(&species.name, Seed(seed))
    }
}

/// All settings of a species along an axis.
fn measure(study: &Study<'_>, axis: Axis, species: &Species) -> Result<Vec<Setting>> {
    let values = axis.values(study);
    study.part(&format!("priors-{}-{}", axis.name(), species.name), || {
        values
            .iter()
            .map(|&value| {
                let parameters = parameters(study, axis, species, value);
                let at = || format!("{} at {} {}", species.name, axis.name(), axis.write(value));
                Ok(Setting {
                    axis,
                    species: species.name.clone(),
                    value,
                    p: grown(study, species, &parameters, &at()).with_context(at)?,
                    dt: generated(study, species, &parameters, &at()).with_context(at)?,
                })
            })
            .collect()
    })
}

/// What one tree gives: its numbers if it has grown at all, and whether it was cut short.
type One = (Option<[f64; 4]>, bool);

fn count(study: &Study<'_>) -> u32 {
    study.scale(FULL, QUICK).min(study.trees())
}

fn grown(
    study: &Study<'_>,
    species: &Species,
    parameters: &Parameters,
    at: &str,
) -> Result<Measured> {
    let trees =
        trees::many(study, &format!("{at} P"), study.verb.seed, count(study), |_, seed| {
            let tree = teacher_tree(species, parameters, seed)?;
            Ok((tree.as_ref().map(|(tree, _)| numbers(tree)), tree.is_some_and(|(_, cut)| cut)))
        })?;
    Ok(Measured::of(&trees))
}

/// A tree of the growth model and whether it was cut short; none where nothing has grown yet.
fn teacher_tree(
    species: &Species,
    parameters: &Parameters,
    seed: u64,
) -> Result<Option<(BranchGraph, bool)>> {
    match grow(&species.name, parameters, Seed(seed)) {
        Ok(grown) => Ok(Some((grown.tree, grown.hit_budget))),
        Err(GrowError::NothingGrown { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

fn generated(
    study: &Study<'_>,
    species: &Species,
    parameters: &Parameters,
    at: &str,
) -> Result<Learner> {
    let Some(model) = &study.model else { return Ok(Learner::NotAsked) };
    if let Err(error) = germ(model, &request(species, parameters, study.verb.seed)) {
        return match error {
            GenerateError::OutOfRange { what, low, high, .. } => {
                Ok(Learner::NotSeen { what: what.to_owned(), low, high })
            }
            GenerateError::NotSeen { near_age: age, .. } => {
                Ok(Learner::NotSeen { what: "age".to_owned(), low: age, high: age })
            }
            error => Err(error.into()),
        };
    }
    let count = count(study);
    let trees = trees::many(study, &format!("{at} DT"), study.verb.seed, count, |work, seed| {
        let (tree, cut) = learner_tree(model, species, parameters, seed, work)?;
        Ok((Some(numbers(&tree)), cut))
    })?;
    let trained = Seen::of(model).has(&species.name, parameters.age, parameters.gravitropism);
    Ok(Learner::Grown { trees: Measured::of(&trees), trained })
}

fn learner_tree(
    model: &Model,
    species: &Species,
    parameters: &Parameters,
    seed: u64,
    work: &mut Workspace,
) -> Result<(BranchGraph, bool)> {
    let request = request(species, parameters, seed);
    let grown = generate(model, &request, Limits::default(), work)?;
    Ok((grown.tree, grown.hit_budget))
}

fn numbers(tree: &BranchGraph) -> [f64; 4] {
    Development::of(tree).to_array()
}

impl Measured {
    fn of(trees: &[One]) -> Self {
        let alive = || trees.iter().filter_map(|(numbers, _)| *numbers);
        Self {
            numbers: std::array::from_fn(|i| Estimate::of(alive().map(move |all| all[i]))),
            nothing: trees.iter().filter(|(numbers, _)| numbers.is_none()).count() as u32,
            cut: trees.iter().filter(|(_, cut)| *cut).count() as u32,
        }
    }
}
