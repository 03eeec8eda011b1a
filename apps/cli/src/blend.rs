//! A species between species: `oak:0.7,willow:0.3`.

use anyhow::{Context, Result};
use deeptree_graph::Share;
use deeptree_graph::codec::dtree::MOST_SHARES;
use deeptree_infer::{BlendError, Model, Weights};

use crate::args::UsageError;
use crate::verbs::unknown_species;

/// A share is told in parts of so many: what a blend is called and stored as.
const UNITS: f64 = 1e4;

/// The shares of a list of species with weights, in the order of the model's species.
pub(crate) fn shares(list: &str, known: &[String]) -> Result<Vec<Share>, UsageError> {
    let wrong = |text: String| UsageError(format!("--blend {list}: {text}"));
    let mut parts: Vec<(usize, f64)> = Vec::new();
    for part in list.split(',') {
        let Some((name, weight)) = part.split_once(':') else {
            return Err(wrong(format!("'{part}' is no species with a weight, such as oak:0.7")));
        };
        let Some(species) = known.iter().position(|known| known == name) else {
            return Err(unknown_species(name, known));
        };
        let weight = match weight.parse::<f64>() {
            Ok(weight) if weight.is_finite() && weight > 0.0 => weight,
            _ => {
                return Err(wrong(format!("the weight of {name} must be a finite number above 0")));
            }
        };
        if parts.iter().any(|part| part.0 == species) {
            return Err(wrong(format!("the species {name} is named twice")));
        }
        parts.push((species, weight));
    }
    if parts.len() < 2 || parts.len() > MOST_SHARES {
        return Err(wrong(format!("a blend has 2 to {MOST_SHARES} species")));
    }
    parts.sort_by_key(|part| part.0);
    // Divided first: the sum of two finite numbers may not be.
    let largest = parts.iter().map(|part| part.1).fold(0.0, f64::max);
    let sum: f64 = parts.iter().map(|part| part.1 / largest).sum();
    let share = |(species, weight): (usize, f64)| {
        let units = (weight / largest / sum * UNITS).round();
        if units < 1.0 {
            let name = &known[species];
            return Err(wrong(format!(
                "the weight of {name} is too small to matter; leave it out"
            )));
        }
        let number = u8::try_from(species);
        let species =
            number.map_err(|_| wrong("a blend is of the first 256 species".to_owned()))?;
        Ok(Share { species, weight: units as u16 })
    };
    parts.into_iter().map(share).collect()
}

/// The model of a blend. Shares that its species cannot be blended in are a wrong request.
pub(crate) fn model(weights: &Weights, shares: &[Share]) -> Result<Model> {
    let blended = weights.blend(shares).map_err(|error| match error {
        BlendError::Weights(error) => anyhow::Error::from(error),
        error => UsageError(error.to_string()).into(),
    })?;
    Model::from_weights(&blended).context("the blend is no model")
}
