//! Where trees grow: obstacles and forms, from the command line.

use std::path::Path;

use anyhow::{Context, Result};
use deeptree_scene::{Environment, Scene, SceneError, Site, Volume};

use crate::args::{Place, UsageError};

impl Place {
    /// The environment that is asked for; the open field where nothing is.
    pub(crate) fn load(&self) -> Result<Environment> {
        Ok(Environment {
            scene: self.obstacles.as_deref().map(scene).transpose()?.unwrap_or_default(),
            volume: self.form.as_deref().map(form).transpose()?,
        })
    }

    /// What stands around a tree that the networks grow; none in the open field.
    pub(crate) fn site(&self) -> Result<Option<Site>> {
        let environment = self.load()?;
        Ok((!environment.is_open()).then(|| Site::new(environment)))
    }
}

/// The scene of a file.
pub(crate) fn scene(path: &Path) -> Result<Scene> {
    Scene::read(path).with_context(|| format!("{} is not usable", path.display()))
}

/// The volume of a name, or of a mesh's file.
pub(crate) fn form(name: &str) -> Result<Volume> {
    Volume::named(name, Path::new("")).map_err(|error| match error {
        SceneError::UnknownForm { .. } => UsageError(error.to_string()).into(),
        error => anyhow::Error::from(error),
    })
}
