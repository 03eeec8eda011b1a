//! All that a tree meets outside itself: obstacles, and the volume it is kept in.

use std::path::Path;

use deeptree_graph::{Occupancy, Vec3};

use crate::error::SceneError;
use crate::scene::Scene;
use crate::sky::Sky;
use crate::text;
use crate::volume::Volume;

/// Obstacles and a volume; without either the open field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    /// The obstacles.
    pub scene: Scene,
    /// Where growth is kept in.
    pub volume: Option<Volume>,
}

impl Environment {
    /// Is it the open field?
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.scene.is_empty() && self.volume.is_none()
    }

    /// May a branch be here?
    #[must_use]
    pub fn admits(&self, point: Vec3) -> bool {
        self.volume.as_ref().is_none_or(|volume| volume.admits(point))
            && !self.scene.contains(point)
    }

    /// May the edge of a node run from `base` to `tip`? It may when the tip is within the volume
    /// and the edge enters no obstacle.
    #[must_use]
    pub fn admits_edge(&self, base: Vec3, tip: Vec3) -> bool {
        self.volume.as_ref().is_none_or(|volume| volume.admits(tip))
            && !self.scene.crosses(base, tip)
    }

    /// The sky at a point; volumes hide nothing of it.
    #[must_use]
    pub fn sky(&self, point: Vec3) -> Sky {
        self.scene.sky(point)
    }

    /// The voxels that obstacles take or that lie outside of the volume: Y of the networks.
    #[must_use]
    pub fn occupancy(&self) -> Occupancy {
        let mut grid = self.scene.occupancy();
        if let Some(volume) = &self.volume {
            grid.unite(&volume.occupancy());
        }
        grid
    }

    /// The text of a scene, with the line `form = "…"` before it where there is a volume. Meshes
    /// are named, not held. Numbers read back as the same bits.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let form =
            self.volume.as_ref().map(|volume| format!("form = {}\n", text::quoted(volume.name())));
        form.unwrap_or_default() + &self.scene.to_toml()
    }

    /// The environment of a text of [`Self::to_toml`], whose meshes are named from `folder`.
    ///
    /// # Errors
    ///
    /// As [`Scene::read`] and [`Volume::named`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self, SceneError> {
        let (scene, form) = text::read_environment(text, folder)?;
        let volume = form.map(|form| Volume::named(&form, folder)).transpose()?;
        Ok(Self { scene, volume })
    }
}
