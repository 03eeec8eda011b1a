//! The species presets: one TOML file each, in two profiles.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::parameters::{self, ParameterError, Parameters};

/// Names of the eight species of the paper, in its order.
pub const SPECIES: [&str; 8] =
    ["beech", "corkscrew", "maple", "oak", "pine", "tulip", "walnut", "willow"];

const PRESETS: [&str; 8] = [
    include_str!("../species/beech.toml"),
    include_str!("../species/corkscrew.toml"),
    include_str!("../species/maple.toml"),
    include_str!("../species/oak.toml"),
    include_str!("../species/pine.toml"),
    include_str!("../species/tulip.toml"),
    include_str!("../species/walnut.toml"),
    include_str!("../species/willow.toml"),
];

/// Which numbers a species grows with; the engine is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Profile {
    /// Reproduces the statistics of the paper's procedural trees.
    #[default]
    Reference,
    /// The paper's printed table, with the least it needs besides.
    Published,
}

impl Profile {
    /// The name on the command line and in a corpus.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Published => "published",
        }
    }
}

impl std::str::FromStr for Profile {
    type Err = SpeciesError;

    fn from_str(name: &str) -> Result<Self, SpeciesError> {
        match name {
            "reference" => Ok(Self::Reference),
            "published" => Ok(Self::Published),
            _ => Err(SpeciesError::UnknownProfile { name: name.to_owned() }),
        }
    }
}

/// A species: its name and the numbers of both profiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// The name.
    pub name: String,
    reference: Parameters,
    published: Parameters,
}

/// Why a preset is no species.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SpeciesError {
    #[error("there is no profile '{name}'; the profiles are reference and published")]
    UnknownProfile { name: String },
    #[error("the preset '{species}' is not valid TOML: {message}")]
    Syntax { species: String, message: String },
    #[error("the preset '{species}' sets '{key}', which is no parameter")]
    UnknownKey { species: String, key: String },
    #[error("the preset '{species}': {source}")]
    Parameter { species: String, source: ParameterError },
}

/// The four tables of a preset; later ones override.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Preset {
    table: BTreeMap<String, f32>,
    constants: BTreeMap<String, f32>,
    #[serde(default)]
    reference: BTreeMap<String, f32>,
    #[serde(default)]
    published: BTreeMap<String, f32>,
}

impl Species {
    /// One of the eight species of the paper.
    ///
    /// # Panics
    ///
    /// Never: a test reads every preset that ships.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let index = SPECIES.iter().position(|&known| known == name)?;
        #[expect(clippy::expect_used, reason = "tested for every preset that ships")]
        Some(Self::from_toml(name, PRESETS[index]).expect("a preset that ships is valid"))
    }

    /// Reads a preset.
    ///
    /// # Errors
    ///
    /// When it is not TOML, names an unknown parameter, or a value is out of range.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, SpeciesError> {
        let preset: Preset = toml::from_str(text).map_err(|error| SpeciesError::Syntax {
            species: name.to_owned(),
            message: error.message().to_owned(),
        })?;
        let read = |overrides| {
            let mut values = Parameters::default();
            for table in [&preset.table, &preset.constants, overrides] {
                apply(name, table, &mut values)?;
            }
            values
                .validate()
                .map_err(|source| SpeciesError::Parameter { species: name.to_owned(), source })?;
            Ok(values)
        };
        Ok(Self {
            name: name.to_owned(),
            reference: read(&preset.reference)?,
            published: read(&preset.published)?,
        })
    }

    /// The numbers of a profile.
    #[must_use]
    pub const fn parameters(&self, profile: Profile) -> &Parameters {
        match profile {
            Profile::Reference => &self.reference,
            Profile::Published => &self.published,
        }
    }
}

fn apply(
    species: &str,
    table: &BTreeMap<String, f32>,
    values: &mut Parameters,
) -> Result<(), SpeciesError> {
    for (key, &value) in table {
        let row = parameters::find(key).ok_or_else(|| SpeciesError::UnknownKey {
            species: species.to_owned(),
            key: key.clone(),
        })?;
        (row.set)(values, value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_that_ships_is_valid() {
        for name in SPECIES {
            let species = Species::named(name).unwrap();
            assert_eq!(species.parameters(Profile::Reference).validate(), Ok(()));
        }
        assert_eq!(Species::named("elm"), None);
    }

    #[test]
    fn every_preset_has_the_papers_24_values_each_and_no_other_in_its_table() {
        for text in PRESETS {
            let preset: Preset = toml::from_str(text).unwrap();
            let mut keys: Vec<&str> = parameters::TABLE[..24].iter().map(|row| row.key).collect();
            keys.sort_unstable();
            assert_eq!(preset.table.keys().collect::<Vec<_>>(), keys);
        }
    }

    #[test]
    fn growth_is_one_internode_length_a_try_in_every_preset() {
        for name in SPECIES {
            let p = Species::named(name).unwrap().parameters(Profile::Published).clone();
            assert!((p.growth_scale * p.growth_rate - 1.0).abs() < 1e-6, "{name}");
        }
    }

    #[test]
    fn a_wrong_preset_says_what_is_wrong() {
        let read = |text| Species::from_toml("elm", text).unwrap_err().to_string();
        assert!(read("[table]\nage = 5\n[constants]\nleaves = 3").contains("'leaves'"));
        assert!(read("[table]\nage = 500\n[constants]").contains("age (t) is 500"));
        assert!(read("[table\n").contains("not valid TOML"));
    }
}
