//! Scenes as text: the TOML of design, and back.

use std::fmt::Write;
use std::path::Path;

use deeptree_graph::Vec3;
use serde::Deserialize;

use crate::boxes::{BoxProblem, BoxShape, Cuboid};
use crate::error::SceneError;
use crate::files;
use crate::scene::{Scene, SceneMesh};

/// The text of a scene.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneText {
    #[serde(default, rename = "box")]
    boxes: Vec<BoxText>,
    #[serde(default, rename = "mesh")]
    meshes: Vec<MeshText>,
}

/// The text of an environment: a scene, and the form of the volume that growth is kept in.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EnvironmentText {
    form: Option<String>,
    #[serde(default, rename = "box")]
    boxes: Vec<BoxText>,
    #[serde(default, rename = "mesh")]
    meshes: Vec<MeshText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxText {
    min: Option<[f32; 3]>,
    max: Option<[f32; 3]>,
    center: Option<[f32; 3]>,
    half: Option<[f32; 3]>,
    yaw: Option<f32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshText {
    file: String,
}

impl BoxText {
    fn shape(&self) -> Option<BoxShape> {
        let Self { min, max, center, half, yaw } = *self;
        match (min, max, center, half, yaw) {
            (Some(min), Some(max), None, None, None) => {
                Some(BoxShape::Aligned { min: min.into(), max: max.into() })
            }
            (None, None, Some(center), Some(half), yaw) => Some(BoxShape::Turned {
                center: center.into(),
                half: half.into(),
                yaw: yaw.unwrap_or(0.0),
            }),
            _ => None,
        }
    }
}

fn parsed<'a, T: Deserialize<'a>>(text: &'a str) -> Result<T, SceneError> {
    toml::from_str(text).map_err(|error| SceneError::Toml {
        line: error.span().map_or(1, |span| {
            1 + text.bytes().take(span.start).filter(|&byte| byte == b'\n').count()
        }),
        // The rest of the message shows the place, over several lines.
        message: error.message().split_whitespace().collect::<Vec<_>>().join(" "),
    })
}

fn scene(boxes: &[BoxText], meshes: Vec<MeshText>, folder: &Path) -> Result<Scene, SceneError> {
    let cuboid = |(i, text): (usize, &BoxText)| {
        let shape = text.shape().ok_or(BoxProblem::Form);
        let made = shape.and_then(Cuboid::new);
        made.map_err(|problem| SceneError::Box { number: i + 1, problem })
    };
    let boxes = boxes.iter().enumerate().map(cuboid).collect::<Result<_, _>>()?;
    let mesh = |text: MeshText| {
        let mesh = files::mesh(folder, &text.file)?;
        Ok(SceneMesh { file: text.file, mesh })
    };
    let meshes = meshes.into_iter().map(mesh).collect::<Result<_, SceneError>>()?;
    Scene::new(boxes, meshes)
}

/// The scene of a text, whose meshes are named from `folder`.
pub(crate) fn read_scene(text: &str, folder: &Path) -> Result<Scene, SceneError> {
    let text: SceneText = parsed(text)?;
    scene(&text.boxes, text.meshes, folder)
}

/// The scene and the name of the form of a text.
pub(crate) fn read_environment(
    text: &str,
    folder: &Path,
) -> Result<(Scene, Option<String>), SceneError> {
    let text: EnvironmentText = parsed(text)?;
    Ok((scene(&text.boxes, text.meshes, folder)?, text.form))
}

/// A float that reads back as the same bits: the shortest digits that do.
fn triple(v: Vec3) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

/// The text of a scene.
pub(crate) fn write_scene(scene: &Scene) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for cuboid in scene.boxes() {
        let _ = match cuboid.shape() {
            BoxShape::Aligned { min, max } => {
                writeln!(text, "[[box]]\nmin = {}\nmax = {}", triple(min), triple(max))
            }
            BoxShape::Turned { center, half, yaw } => writeln!(
                text,
                "[[box]]\ncenter = {}\nhalf = {}\nyaw = {yaw:?}",
                triple(center),
                triple(half)
            ),
        };
    }
    for mesh in scene.meshes() {
        let _ = writeln!(text, "[[mesh]]\nfile = {}", quoted(&mesh.file));
    }
    text
}

/// A string of TOML.
pub(crate) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
