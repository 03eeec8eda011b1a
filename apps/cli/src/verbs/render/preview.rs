//! A quick picture of a tree that was just made.

use anyhow::Result;
use deeptree_graph::BranchGraph;
use deeptree_render::{Camera, Developing, Ground, Light, Options, Scene, View, develop, render};

use super::{ANGLE, FileKind, HAZE, SUN, write_image};
use crate::args::{Out, UsageError};
use crate::dressing::dressed;

/// Pixels a side, most light paths a pixel, and the error that is good enough.
const SIZE: u32 = 512;
const SAMPLES: u32 = 32;
const ERROR: f32 = 0.04;

/// Refuses what is no name of a preview, before anything is made.
pub(crate) fn check(out: &Out) -> Result<(), UsageError> {
    match &out.preview {
        Some(path) if FileKind::of(path)? != FileKind::Png => {
            Err(UsageError(format!("{}: a preview is a .png; name it so", path.display())))
        }
        _ => Ok(()),
    }
}

/// Writes the preview, where one is asked for: as meshes are, with the same leaves.
pub(crate) fn take(out: &Out, tree: &BranchGraph) -> Result<()> {
    let Some(path) = &out.preview else { return Ok(()) };
    let tree = dressed(tree, &out.mesh.look.pictured(out.mesh.lod)?)?;
    let [elevation, azimuth] = SUN.map(f32::to_radians);
    let light = Light::daylight(elevation, azimuth, HAZE)?;
    let scene = Scene::new(&tree, light, Ground::Meadow)?;
    let camera = Camera::framing(scene.points(), View::Front, 1.0, ANGLE.to_radians())?;
    let options = Options { size: [SIZE; 2], samples: SAMPLES, error: ERROR, ..Options::default() };
    let picture = render(&scene, &camera, &options, |_| ())?;
    write_image(path, &develop(&picture, &Developing::default()))
}
