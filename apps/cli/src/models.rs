//! The models that ship, and models from files.

use std::path::Path;

use anyhow::{Context, Result};
use deeptree_infer::{Model, Weights, Workspace};

use crate::args::{ModelChoice, UsageError};

const SITUATED: &[u8] = include_bytes!("../../../models/situated.safetensors");
const PAPER: &[u8] = include_bytes!("../../../models/paper.safetensors");

impl ModelChoice {
    /// Loads the model: one that ships by its name, else a file.
    pub(crate) fn load(&self) -> Result<Model> {
        Model::from_weights(&self.weights()?).with_context(|| self.no_model())
    }

    /// The numbers of the model.
    pub(crate) fn weights(&self) -> Result<Weights> {
        match self.model.to_str() {
            Some("situated") => Ok(Weights::from_bytes(SITUATED)?),
            Some("paper") => Ok(Weights::from_bytes(PAPER)?),
            _ => Weights::from_bytes(&read(&self.model)?).with_context(|| self.no_model()),
        }
    }

    fn no_model(&self) -> String {
        format!("{} is no model", self.model.display())
    }

    /// Memory for predictions on the chosen instruction set.
    pub(crate) fn workspace(&self) -> Result<Workspace> {
        match self.simd {
            None => Ok(Workspace::default()),
            Some(path) if path.is_available() => Ok(Workspace::new(path)),
            Some(path) => {
                let known: Vec<&str> =
                    deeptree_infer::SimdPath::available().iter().map(|path| path.name()).collect();
                let known = known.join(", ");
                Err(UsageError(format!("this processor has no {path}; it has {known}")).into())
            }
        }
    }
}

fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).with_context(|| {
        format!(
            "cannot read the model {}; the models that ship are situated and paper",
            path.display()
        )
    })
}
