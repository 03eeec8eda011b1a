//! What all chapters share: the models, the options, and the folder of the report.

use std::fs;
use std::io::Write;

use anyhow::{Context, Result};
use deeptree_export::write_atomically;
use deeptree_growth::Species;
use deeptree_infer::{Model, Predictor};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::args::{self, Args};
use crate::verbs::{presets, unknown_species};

/// Folder of the parts of a run, in that of the report.
const PARTS: &str = "parts";

pub(crate) struct Study<'a> {
    pub(crate) args: &'a Args,
    pub(crate) verb: &'a args::Evaluate,
    pub(crate) species: Vec<Species>,
    /// The model that is judged; none where only the growth model is measured.
    pub(crate) model: Option<Model>,
}

impl<'a> Study<'a> {
    pub(crate) fn new(args: &'a Args, verb: &'a args::Evaluate) -> Result<Self> {
        let species = presets(&verb.species)?;
        let model = if verb.side == "p" { None } else { Some(verb.model.load()?) };
        verb.model.workspace()?;
        if let Some(model) = &model
            && let Some(missing) = species.iter().find(|s| !model.species().contains(&s.name))
        {
            return Err(unknown_species(&missing.name, model.species()).into());
        }
        Ok(Self { args, verb, species, model })
    }

    /// The number for a full run, or that for a quick one.
    pub(crate) fn scale(&self, full: u32, quick: u32) -> u32 {
        if self.verb.quick { quick } else { full }
    }

    /// Trees of each species and set.
    pub(crate) fn trees(&self) -> u32 {
        self.verb.trees.unwrap_or_else(|| self.scale(500, 24))
    }

    /// What was measured and how, for the head of the report.
    pub(crate) fn facts(&self) -> Vec<(String, String)> {
        let names: Vec<&str> = self.species.iter().map(|species| species.name.as_str()).collect();
        let facts = [
            ("species", names.join(", ")),
            ("trees a species and set", self.trees().to_string()),
            ("first seed", self.verb.seed.to_string()),
            ("growth model", self.verb.profile.name().to_owned()),
            ("model", self.verb.model.model.display().to_string()),
            ("model hash", self.model_hash()),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ];
        facts.map(|(name, value)| (name.to_owned(), value)).to_vec()
    }

    fn model_hash(&self) -> String {
        let hash = self.model.as_ref().map(Model::hash);
        hash.iter().flatten().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The part of this name: read where an earlier run with the same options and model left it,
    /// else made and left for the next.
    #[cfg_attr(not(feature = "train"), expect(dead_code, reason = "training leaves parts"))]
    pub(crate) fn part<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        let path = self.verb.output.join(PARTS).join(format!("{name}.json"));
        let of = json!({ "facts": self.facts(), "quick": self.verb.quick });
        if let Ok(text) = fs::read_to_string(&path)
            && let Ok(Value::Object(mut part)) = serde_json::from_str(&text)
            && part.get("of") == Some(&of)
            && let Some(value) = part.remove("value")
            && let Ok(value) = serde_json::from_value(value)
        {
            return Ok(value);
        }
        let value = make()?;
        let part = json!({ "of": of, "value": serde_json::to_value(&value)? });
        let folder = self.verb.output.join(PARTS);
        fs::create_dir_all(&folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        write_atomically(&path, |out| out.write_all(part.to_string().as_bytes()))?;
        Ok(value)
    }

    /// Writes a file of the report.
    pub(crate) fn save(&self, name: &str, bytes: &[u8]) -> Result<()> {
        Ok(write_atomically(&self.verb.output.join(name), |out| out.write_all(bytes))?)
    }
}
