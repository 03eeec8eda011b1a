//! A quick picture of a tree that was just made, or of a stand.

use anyhow::Result;
use deeptree_graph::{BranchGraph, Vec3};
use deeptree_render::{Camera, Developing, Ground, Light, Options, Scene, View, develop, render};

use super::{ANGLE, FileKind, HAZE, SUN, write_image};
use crate::args::{Out, UsageError};
use crate::batch::Made;
use crate::dressing::{all_dressed, standing};

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

/// Writes the preview of a tree, where one is asked for: as meshes are, with the same leaves, but
/// without fissures of bark and even texels.
pub(crate) fn take(out: &Out, tree: &BranchGraph) -> Result<()> {
    picture(out, &[(tree, Vec3::ZERO)], View::Front)
}

/// Writes the preview of trees that stand together, likewise.
pub(crate) fn take_stand(out: &Out, trees: &[Made]) -> Result<()> {
    let trees: Vec<(&BranchGraph, Vec3)> = trees.iter().map(|made| (&made.tree, made.at)).collect();
    picture(out, &trees, if trees.len() == 1 { View::Front } else { View::Quarter })
}

fn picture(out: &Out, trees: &[(&BranchGraph, Vec3)], view: View) -> Result<()> {
    let Some(path) = &out.preview else { return Ok(()) };
    let trees = all_dressed(trees, &out.mesh.look.pictured(out.mesh.lod)?)?;
    let [elevation, azimuth] = SUN.map(f32::to_radians);
    let light = Light::daylight(elevation, azimuth, HAZE)?;
    let scene = Scene::of(&standing(&trees), light, Ground::Meadow)?;
    let camera = Camera::framing(scene.points(), view, 1.0, ANGLE.to_radians())?;
    let options = Options { size: [SIZE; 2], samples: SAMPLES, error: ERROR, ..Options::default() };
    let picture = render(&scene, &camera, &options, |_| ())?;
    write_image(path, &develop(&picture, &Developing::default()))
}
