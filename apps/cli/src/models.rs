//! The models that ship, and models from files.

use std::borrow::Cow;
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
        Weights::from_bytes(&self.bytes()?).with_context(|| self.no_model())
    }

    /// The bytes of the model's file.
    pub(crate) fn bytes(&self) -> Result<Cow<'static, [u8]>> {
        Ok(match self.model.to_str() {
            Some("situated") => SITUATED.into(),
            Some("paper") => PAPER.into(),
            _ => read_file(&self.model)?.into(),
        })
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

fn read_file(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).with_context(|| {
        format!(
            "cannot read the model {}; the models that ship are situated and paper",
            path.display()
        )
    })
}
