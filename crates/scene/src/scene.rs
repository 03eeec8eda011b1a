//! Scenes: obstacles, and what a tree asks of them.

use std::path::Path;

use deeptree_graph::{Occupancy, Vec3};

use crate::boxes::Cuboid;
use crate::error::SceneError;
use crate::files;
use crate::index::Index;
use crate::mesh::TriangleMesh;
use crate::sky::{self, Sky};
use crate::{text, voxels};

/// The line above the tree's foot that must be free, in metres: a little more than the first internode.
pub const FOOT: f32 = 1.1;

/// A mesh of a scene, and the file it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMesh {
    /// The file, as the scene names it.
    pub file: String,
    /// Its triangles.
    pub mesh: TriangleMesh,
}

/// The obstacles around a tree.
///
/// Boxes and closed meshes are solid. An open mesh is a sheet: it hides the sky, takes the voxels
/// that it touches and lets no branch through, but no point lies inside it.
#[derive(Clone, Debug)]
pub struct Scene {
    boxes: Vec<Cuboid>,
    meshes: Vec<SceneMesh>,
    /// Boxes first, then meshes.
    index: Index,
}

impl Default for Scene {
    fn default() -> Self {
        Self::unchecked(Vec::new(), Vec::new())
    }
}

impl PartialEq for Scene {
    /// The index follows from the rest.
    fn eq(&self, other: &Self) -> bool {
        self.boxes == other.boxes && self.meshes == other.meshes
    }
}

impl Scene {
    /// A scene of these obstacles.
    ///
    /// # Errors
    ///
    /// When one of them stands on the foot of the tree at the origin.
    pub fn new(boxes: Vec<Cuboid>, meshes: Vec<SceneMesh>) -> Result<Self, SceneError> {
        let scene = Self::unchecked(boxes, meshes);
        if scene.crosses(Vec3::ZERO, FOOT * Vec3::Y) {
            return Err(SceneError::OverRoot);
        }
        Ok(scene)
    }

    fn unchecked(boxes: Vec<Cuboid>, meshes: Vec<SceneMesh>) -> Self {
        let bounds = boxes.iter().map(Cuboid::bounds);
        let index = Index::new(bounds.chain(meshes.iter().map(|mesh| mesh.mesh.bounds())));
        Self { boxes, meshes, index }
    }

    /// Reads a scene file and the meshes it names.
    ///
    /// # Errors
    ///
    /// When a file cannot be read, says what no scene can be, or an obstacle stands on the foot of
    /// the tree.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = String::from_utf8(files::bytes(path)?)
            .map_err(|_| SceneError::NotText { path: path.to_owned() })?;
        Self::parse(&text, path.parent().unwrap_or(Path::new("")))
    }

    /// The scene of a text, whose meshes are named from `folder`.
    ///
    /// # Errors
    ///
    /// As [`Self::read`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self, SceneError> {
        text::read_scene(text, folder)
    }

    /// The text of the scene; meshes are named, not held. Numbers read back as the same bits.
    #[must_use]
    pub fn to_toml(&self) -> String {
        text::write_scene(self)
    }

    /// The boxes.
    #[must_use]
    pub fn boxes(&self) -> &[Cuboid] {
        &self.boxes
    }

    /// The meshes.
    #[must_use]
    pub fn meshes(&self) -> &[SceneMesh] {
        &self.meshes
    }

    /// Is nothing there?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty() && self.meshes.is_empty()
    }

    /// The lowest and the highest corner of all obstacles, in metres; none without obstacles.
    #[must_use]
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let boxes = self.boxes.iter().map(Cuboid::bounds);
        let all = boxes.chain(self.meshes.iter().map(|mesh| mesh.mesh.bounds()));
        all.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
    }

    /// The same obstacles for a tree whose foot is at `place`: what was at `place` is at the
    /// origin.
    ///
    /// # Errors
    ///
    /// When an obstacle stands on that foot, or comes to lie out of reach.
    pub fn seen_from(&self, place: Vec3) -> Result<Self, SceneError> {
        let boxes = self.boxes.iter().enumerate().map(|(i, cuboid)| {
            cuboid.moved(-place).map_err(|problem| SceneError::Box { number: i + 1, problem })
        });
        let meshes = self.meshes.iter().map(|SceneMesh { file, mesh }| {
            let mesh = mesh.moved(-place);
            let mesh = mesh.map_err(|problem| SceneError::Mesh { file: file.clone(), problem })?;
            Ok(SceneMesh { file: file.clone(), mesh })
        });
        Self::new(boxes.collect::<Result<_, _>>()?, meshes.collect::<Result<_, SceneError>>()?)
    }

    /// Does a point lie inside an obstacle?
    #[must_use]
    pub fn contains(&self, point: Vec3) -> bool {
        self.index.any_within(point, point, |i| match i.checked_sub(self.boxes.len()) {
            None => self.boxes[i].contains(point),
            Some(i) => self.meshes[i].mesh.contains(point),
        })
    }

    /// Does the segment from `a` to `b` enter an obstacle, or lie inside one?
    #[must_use]
    pub fn crosses(&self, a: Vec3, b: Vec3) -> bool {
        self.index.any_along(a, b - a, 1.0, |i| match i.checked_sub(self.boxes.len()) {
            None => self.boxes[i].meets(a, b - a, 1.0),
            Some(i) => {
                let mesh = &self.meshes[i].mesh;
                mesh.meets(a, b - a, 1.0) || mesh.contains(a)
            }
        })
    }

    /// The sky at a point: what part of it is free, and where that part is.
    #[must_use]
    pub fn sky(&self, point: Vec3) -> Sky {
        sky::look(|ray| {
            self.index.any_along(point, ray, f32::INFINITY, |i| {
                match i.checked_sub(self.boxes.len()) {
                    None => self.boxes[i].meets(point, ray, f64::INFINITY),
                    Some(i) => self.meshes[i].mesh.meets(point, ray, f64::INFINITY),
                }
            })
        })
    }

    /// The voxels of the growth space that an obstacle reaches into: Y of the networks.
    #[must_use]
    pub fn occupancy(&self) -> Occupancy {
        let mut grid = Occupancy::EMPTY;
        for cuboid in &self.boxes {
            voxels::take(&mut grid, cuboid.bounds(), |centre, half| cuboid.overlaps(centre, half));
        }
        for SceneMesh { mesh, .. } in &self.meshes {
            voxels::take(&mut grid, mesh.bounds(), |centre, half| {
                mesh.reaches(centre, half) || mesh.contains(centre.as_vec3())
            });
        }
        grid
    }
}
