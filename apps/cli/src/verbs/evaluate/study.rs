//! What all chapters share: the models, the options, and the folder of the report.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use deeptree_export::write_atomically;
use deeptree_growth::Species;
use deeptree_infer::{Model, Predictor};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::args::{self, Args, ModelChoice};
use crate::output::hex;
use crate::verbs::{presets, unknown_species};

/// Folder of the parts of a run, in that of the report.
const PARTS: &str = "parts";

pub(crate) struct Study<'a> {
    pub(crate) args: &'a Args,
    pub(crate) verb: &'a args::Evaluate,
    pub(crate) species: Vec<Species>,
    /// The model that is judged; none where only the growth model is measured.
    pub(crate) model: Option<Model>,
    /// The shipped model of kind `paper`, where it is not the one that is judged.
    pub(crate) paper: Option<Model>,
    /// What tells this build of the program from others: a part that another one has left may mean
    /// something else, and is made anew.
    pub(crate) program: String,
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
        let paper = ModelChoice { model: "paper".into(), simd: verb.model.simd }.load()?;
        let paper = model.as_ref().filter(|model| model.hash() != paper.hash()).map(|_| paper);
        Ok(Self { args, verb, species, model, paper, program: program()? })
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
            ("program hash", self.program.clone()),
        ];
        facts.map(|(name, value)| (name.to_owned(), value)).to_vec()
    }

    fn model_hash(&self) -> String {
        self.model.as_ref().map(|model| hex(model.hash())).unwrap_or_default()
    }

    /// The part of this name: read where an earlier run of the same program with the same options
    /// and model left it, else made and left for the next.
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
        self.leave(&format!("{name}.json"), part.to_string().as_bytes())?;
        Ok(value)
    }

    /// Leaves a file among the parts, for a program that reads it, and says where.
    pub(crate) fn leave(&self, name: &str, bytes: &[u8]) -> Result<PathBuf> {
        let folder = self.verb.output.join(PARTS);
        fs::create_dir_all(&folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        let path = folder.join(name);
        write_atomically(&path, |out| out.write_all(bytes))?;
        Ok(path)
    }

    /// Writes a file of the report.
    pub(crate) fn save(&self, name: &str, bytes: &[u8]) -> Result<()> {
        Ok(write_atomically(&self.verb.output.join(name), |out| out.write_all(bytes))?)
    }
}

/// The start of the SHA-256 of the program that runs.
fn program() -> Result<String> {
    let path = std::env::current_exe().context("cannot find the program's own file")?;
    let bytes =
        fs::read(&path).with_context(|| format!("cannot read the program {}", path.display()))?;
    let mut start = [0; 16];
    start.copy_from_slice(&Sha256::digest(&bytes)[..16]);
    Ok(hex(start))
}

/// Places after the point that a number needs for so many digits that count.
pub(crate) fn places(x: f64, digits: i32) -> usize {
    let text = format!("{:.*e}", (digits - 1).max(0) as usize, x);
    let exponent = text.rsplit('e').next().and_then(|part| part.parse::<i32>().ok());
    (digits - 1 - exponent.unwrap_or(0)).clamp(0, 9) as usize
}

/// A number to so many digits that count, without zeros at its end.
pub(crate) fn short(x: f64, digits: i32) -> String {
    let text = format!("{x:.*}", places(x, digits));
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_have_the_digits_that_count_and_no_more() {
        let texts = [
            short(0.0123456, 3),
            short(27.68, 2),
            short(6.13, 2),
            short(3499.7, 3),
            short(0.9996, 2),
            short(0.5, 3),
            short(-0.000_012_34, 2),
            short(0.0, 3),
        ];
        assert_eq!(texts, ["0.0123", "28", "6.1", "3500", "1", "0.5", "-0.000012", "0"]);
    }
}
