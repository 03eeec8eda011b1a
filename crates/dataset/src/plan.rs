//! What a corpus holds: `corpus.toml`.

use std::ops::Range;
use std::path::Path;

use deeptree_graph::Seed;
use deeptree_scene::{Environment, Scene, Volume};
use serde::{Deserialize, Serialize};

use crate::priors::{self, Priors, Span, SpansError};

/// Name of the plan's file in the folder of a corpus.
pub const PLAN_FILE: &str = "corpus.toml";

/// The format of corpora that is written, and the only one that is read.
const FORMAT: i64 = 1;

/// Trees of a shard: few enough to lose little when a build is stopped.
const SHARD_TREES: u32 = 25;

/// What a corpus holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorpusPlan {
    /// The species, in the order in which they are built.
    pub species: Vec<String>,
    /// How many trees each species has, numbered from 0.
    pub trees: u32,
    /// How many of them are for training: those with the lowest numbers.
    pub training_trees: u32,
    /// The seed of tree 0 of every species; tree k has the k-th after it.
    pub first_seed: u64,
    /// The parameters that the trees were grown with, by name.
    pub profile: String,
    /// How many trees a shard has; the last of a species may have fewer.
    pub shard_trees: u32,
    /// Ages in growth cycles that each tree's is drawn from; without them all have the profile's.
    #[serde(default)]
    pub ages: Option<Vec<Span<u32>>>,
    /// Values that each tree's gravitropism is drawn from; without them all have the profile's.
    #[serde(default)]
    pub gravitropisms: Option<Vec<Span<f64>>>,
    /// Does each tree stand in the random scene of its seed?
    #[serde(default)]
    pub scenes: bool,
    /// The volumes that trees are kept in, by name: one after the other, again and again.
    #[serde(default)]
    pub forms: Option<Vec<String>>,
}

/// Which trees of a species.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Split {
    /// Those that networks are fitted to.
    Train,
    /// Those that networks are judged on and never see before.
    Validation,
    /// All.
    All,
}

/// Why a plan cannot be built, or a file holds no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PlanError {
    #[error("the plan has no species; name at least one")]
    NoSpecies,
    #[error("the plan has no trees, or shards without trees; ask for at least one tree")]
    NoTrees,
    #[error("the species `{name}` cannot name files; use letters, digits, `_` and `-`")]
    SpeciesName { name: String },
    #[error("the species `{name}` is in the plan twice; name it once")]
    SpeciesTwice { name: String },
    #[error("{training} of {trees} trees are for training; there are not so many")]
    Split { training: u32, trees: u32 },
    #[error("seeds from {first_seed} on do not fit into the plan's file; stay below 2^63 - 2^32")]
    SeedTooLarge { first_seed: u64 },
    #[error("the plan's {field}: {source}")]
    Spans { field: &'static str, source: SpansError },
    #[error("the plan's forms: `{name}` is not one of {}", Volume::NAMES.join(", "))]
    Form { name: String },
    #[error("the plan's forms: there is none, or one twice")]
    Forms,
    #[error("{PLAN_FILE} has format {found}; this program reads format {FORMAT}")]
    Format { found: i64 },
    #[error("{PLAN_FILE} names no format; it is not the plan of a corpus")]
    NoFormat,
    #[error("{PLAN_FILE} is not the plan of a corpus")]
    Toml(#[from] toml::de::Error),
}

impl CorpusPlan {
    /// A plan with four fifths of the trees for training, as the paper splits 500 trees into 400
    /// and 100.
    #[must_use]
    pub fn new(species: Vec<String>, trees: u32, first_seed: Seed, profile: &str) -> Self {
        Self {
            species,
            trees,
            // Divided first: 4 · trees might not fit.
            training_trees: trees - trees.div_ceil(5),
            first_seed: first_seed.0,
            profile: profile.to_owned(),
            shard_trees: SHARD_TREES,
            ages: None,
            gravitropisms: None,
            scenes: false,
            forms: None,
        }
    }

    /// The numbers of the trees of a split.
    #[must_use]
    pub fn numbers(&self, split: Split) -> Range<u32> {
        match split {
            Split::Train => 0..self.training_trees,
            Split::Validation => self.training_trees..self.trees,
            Split::All => 0..self.trees,
        }
    }

    /// The seed of a tree.
    #[must_use]
    pub fn seed(&self, number: u32) -> Seed {
        Seed(self.first_seed).of_tree(u64::from(number))
    }

    /// What a tree is grown at, where the plan says so.
    #[must_use]
    pub fn priors(&self, number: u32) -> Priors {
        Priors::draw(self.seed(number), self.ages.as_deref(), self.gravitropisms.as_deref())
    }

    /// What stands around a tree and where it is kept in: the random scene of its seed, and the
    /// form whose turn it is.
    #[must_use]
    pub fn environment(&self, number: u32) -> Environment {
        let scene = if self.scenes { Scene::random(self.seed(number)) } else { Scene::default() };
        let forms = self.forms.as_deref().unwrap_or_default();
        let form = forms.get(number as usize % forms.len().max(1));
        // Known by name, in a plan that was checked: no file is read.
        let volume = form.and_then(|form| Volume::named(form, Path::new("")).ok());
        Environment { scene, volume }
    }

    /// Do trees stand anywhere but in the open field?
    #[must_use]
    pub fn has_environments(&self) -> bool {
        self.scenes || self.forms.is_some()
    }

    /// Finds out whether the plan can be built.
    ///
    /// # Errors
    ///
    /// When it is empty, its species, split or seeds cannot be stored, or nothing can be drawn from
    /// its ranges.
    pub fn check(&self) -> Result<(), PlanError> {
        if self.species.is_empty() {
            return Err(PlanError::NoSpecies);
        }
        if self.trees == 0 || self.shard_trees == 0 {
            return Err(PlanError::NoTrees);
        }
        for (i, name) in self.species.iter().enumerate() {
            let plain = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
            if name.is_empty() || !name.chars().all(plain) {
                return Err(PlanError::SpeciesName { name: name.clone() });
            }
            if self.species[..i].contains(name) {
                return Err(PlanError::SpeciesTwice { name: name.clone() });
            }
        }
        if self.training_trees > self.trees {
            return Err(PlanError::Split { training: self.training_trees, trees: self.trees });
        }
        // TOML has no whole numbers above.
        if self.first_seed > i64::MAX as u64 - u64::from(u32::MAX) {
            return Err(PlanError::SeedTooLarge { first_seed: self.first_seed });
        }
        let at = |field| move |source| PlanError::Spans { field, source };
        if let Some(ages) = &self.ages {
            priors::check(ages, |_| true).map_err(at("ages"))?;
        }
        if let Some(values) = &self.gravitropisms {
            priors::check(values, f64::is_finite).map_err(at("gravitropisms"))?;
        }
        if let Some(forms) = &self.forms {
            if let Some(name) = forms.iter().find(|name| !Volume::NAMES.contains(&name.as_str())) {
                return Err(PlanError::Form { name: name.clone() });
            }
            let is_twice = |(i, name): (usize, &String)| forms[..i].contains(name);
            if forms.is_empty() || forms.iter().enumerate().any(is_twice) {
                return Err(PlanError::Forms);
            }
        }
        Ok(())
    }

    /// The text of the plan's file.
    pub(crate) fn to_toml(&self) -> String {
        let mut table = toml::Table::new();
        let names = self.species.iter().cloned().map(toml::Value::String).collect();
        table.insert("format".into(), FORMAT.into());
        table.insert("species".into(), toml::Value::Array(names));
        table.insert("trees".into(), i64::from(self.trees).into());
        table.insert("training_trees".into(), i64::from(self.training_trees).into());
        table.insert("first_seed".into(), self.first_seed.cast_signed().into());
        table.insert("profile".into(), self.profile.clone().into());
        table.insert("shard_trees".into(), i64::from(self.shard_trees).into());
        if let Some(ages) = &self.ages {
            table.insert("ages".into(), pairs(ages, |age| i64::from(age).into()));
        }
        if let Some(values) = &self.gravitropisms {
            table.insert("gravitropisms".into(), pairs(values, toml::Value::from));
        }
        if self.scenes {
            table.insert("scenes".into(), true.into());
        }
        if let Some(forms) = &self.forms {
            table.insert("forms".into(), forms.clone().into());
        }
        table.to_string()
    }

    /// Reads the text of a plan's file.
    pub(crate) fn from_toml(text: &str) -> Result<Self, PlanError> {
        let mut table: toml::Table = text.parse()?;
        match table.remove("format").as_ref().and_then(toml::Value::as_integer) {
            Some(FORMAT) => {}
            Some(found) => return Err(PlanError::Format { found }),
            None => return Err(PlanError::NoFormat),
        }
        let plan: Self = table.try_into()?;
        plan.check()?;
        Ok(plan)
    }

    /// The first field in which two plans differ, with its values here and there.
    pub(crate) fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let fields = |plan: &Self| {
            [
                ("species", plan.species.join(", ")),
                ("trees", plan.trees.to_string()),
                ("training_trees", plan.training_trees.to_string()),
                ("first_seed", plan.first_seed.to_string()),
                ("profile", plan.profile.clone()),
                ("shard_trees", plan.shard_trees.to_string()),
                ("ages", text_of(plan.ages.as_deref())),
                ("gravitropisms", text_of(plan.gravitropisms.as_deref())),
                ("scenes", plan.scenes.to_string()),
                ("forms", plan.forms.as_ref().map_or("none".to_owned(), |names| names.join(", "))),
            ]
        };
        let mut pairs = fields(self).into_iter().zip(fields(other));
        pairs.find(|(a, b)| a != b).map(|((name, here), (_, there))| (name, here, there))
    }
}

/// Ranges as a plan's file has them.
fn pairs<T: Copy>(spans: &[Span<T>], value: impl Fn(T) -> toml::Value) -> toml::Value {
    let pair = |span: &Span<T>| toml::Value::Array(vec![value(span.0), value(span.1)]);
    toml::Value::Array(spans.iter().map(pair).collect())
}

/// Ranges as the command line has them.
fn text_of<T: std::fmt::Display>(spans: Option<&[Span<T>]>) -> String {
    let text = |span: &Span<T>| format!("{}..{}", span.0, span.1);
    spans.map_or("the profile's".to_owned(), |spans| {
        spans.iter().map(text).collect::<Vec<_>>().join(",")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> CorpusPlan {
        CorpusPlan::new(vec!["oak".into(), "pine".into()], 500, Seed(7), "reference")
    }

    #[test]
    fn four_fifths_of_the_trees_are_for_training() {
        let counts = |trees| {
            let plan = CorpusPlan::new(plan().species, trees, Seed(0), "reference");
            (plan.numbers(Split::Train).len(), plan.numbers(Split::Validation).len())
        };
        assert_eq!(counts(500), (400, 100));
        assert_eq!(counts(5), (4, 1));
        assert_eq!(counts(1), (0, 1));
        assert_eq!(counts(u32::MAX).0, 3_435_973_836);
        assert_eq!(plan().numbers(Split::All), 0..500);
    }

    #[test]
    fn plans_come_back_from_their_text() {
        assert_eq!(CorpusPlan::from_toml(&plan().to_toml()).unwrap(), plan());
    }

    /// A plan with ranges.
    fn of_priors() -> CorpusPlan {
        let gravitropisms = Some(vec![Span(-0.4, -0.25), Span(-0.15, 0.15)]);
        CorpusPlan { ages: Some(vec![Span(10, 22), Span(28, 40)]), gravitropisms, ..plan() }
    }

    #[test]
    fn ranges_are_in_the_text_of_plans_that_have_them() {
        let text = of_priors().to_toml();
        assert!(text.starts_with("ages = [[10, 22], [28, 40]]\n"), "{text}");
        assert!(text.contains("\ngravitropisms = [[-0.4, -0.25], [-0.15, 0.15]]\n"), "{text}");
        assert_eq!(CorpusPlan::from_toml(&text).unwrap(), of_priors());
        assert_eq!(
            of_priors().difference(&plan()),
            Some(("ages", "10..22,28..40".to_owned(), "the profile's".to_owned()))
        );
    }

    #[test]
    fn scenes_and_forms_are_in_the_text_of_plans_that_have_them() {
        let forms = |names: &[&str]| Some(names.iter().map(ToString::to_string).collect());
        let of_scenes = CorpusPlan { scenes: true, forms: forms(&["ring", "cone"]), ..plan() };
        let text = of_scenes.to_toml();
        assert!(text.contains("\nscenes = true\n") && text.contains("forms = ["), "{text}");
        assert_eq!(CorpusPlan::from_toml(&text).unwrap(), of_scenes);
        assert!(of_scenes.has_environments() && !plan().has_environments());
        assert_eq!(plan().environment(3), Environment::default());

        // Tree 3 has the scene of seed 7 + 3, and the second form.
        let environment = of_scenes.environment(3);
        assert_eq!(environment.scene, Scene::random(Seed(10)));
        assert_eq!(environment.volume, Some(Volume::Cone));
        assert_eq!(of_scenes.environment(4).volume, Some(Volume::Ring));

        let error =
            |names: &[&str]| CorpusPlan { forms: forms(names), ..plan() }.check().unwrap_err();
        assert_eq!(error(&["ball"]), PlanError::Form { name: "ball".into() });
        assert_eq!(error(&[]), PlanError::Forms);
        assert_eq!(error(&["cone", "cone"]), PlanError::Forms);
    }

    #[test]
    fn ranges_that_nothing_can_be_drawn_from_are_told() {
        let ages = |spans: &[Span<u32>]| {
            CorpusPlan { ages: Some(spans.to_vec()), ..plan() }.check().unwrap_err()
        };
        let error = |source| PlanError::Spans { field: "ages", source };
        assert_eq!(ages(&[]), error(SpansError::Empty));
        assert_eq!(ages(&[Span(5, 4)]), error(SpansError::Reversed));
        assert_eq!(ages(&[Span(3, 5), Span(5, 6)]), error(SpansError::Order));
        let values = |low, high| {
            let gravitropisms = Some(vec![Span(low, high)]);
            CorpusPlan { gravitropisms, ..plan() }.check()
        };
        for (low, high) in [(f64::NAN, 0.0), (0.0, f64::INFINITY), (0.1, 0.0)] {
            assert!(matches!(values(low, high), Err(PlanError::Spans { .. })), "{low} {high}");
        }
        assert_eq!(values(0.1, 0.1), Ok(()));
    }

    #[test]
    fn the_text_of_format_1_stays_the_same() {
        let expected = "first_seed = 7\nformat = 1\nprofile = \"reference\"\n\
                        shard_trees = 25\nspecies = [\"oak\", \"pine\"]\n\
                        training_trees = 400\ntrees = 500\n";
        assert_eq!(plan().to_toml(), expected);
    }

    #[test]
    fn plans_that_cannot_be_built_are_told_why() {
        let species = |names: &[&str]| {
            let species = names.iter().map(ToString::to_string).collect();
            CorpusPlan { species, ..plan() }.check().unwrap_err()
        };
        assert_eq!(species(&[]), PlanError::NoSpecies);
        assert_eq!(species(&["../oak"]), PlanError::SpeciesName { name: "../oak".into() });
        assert_eq!(species(&["oak", "oak"]), PlanError::SpeciesTwice { name: "oak".into() });
        let none = CorpusPlan { trees: 0, ..plan() };
        assert_eq!(none.check().unwrap_err(), PlanError::NoTrees);
        let split = CorpusPlan { training_trees: 501, ..plan() };
        assert!(matches!(split.check(), Err(PlanError::Split { training: 501, trees: 500 })));
        let seed = CorpusPlan { first_seed: u64::MAX, ..plan() };
        assert!(matches!(seed.check(), Err(PlanError::SeedTooLarge { .. })));
    }

    #[test]
    fn files_that_hold_no_plan_are_told_why() {
        let read = |text: &str| CorpusPlan::from_toml(text).unwrap_err();
        assert!(matches!(read("trees = "), PlanError::Toml(_)));
        assert_eq!(read("trees = 5"), PlanError::NoFormat);
        assert_eq!(read("format = 2"), PlanError::Format { found: 2 });
        assert!(matches!(read("format = 1\ntrees = 5"), PlanError::Toml(_)));
        let negative = plan().to_toml().replace("500", "-500");
        assert!(matches!(read(&negative), PlanError::Toml(_)));
    }
}
