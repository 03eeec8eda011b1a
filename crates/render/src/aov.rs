//! What is where, for machines that learn to see: depth, normals and labels.

use glam::Vec3;
use rayon::prelude::*;

use crate::camera::Camera;
use crate::error::RenderError;
use crate::film::Options;
use crate::scene::{Label, Scene};

/// What a pixel shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// The sky, or nothing.
    #[default]
    Nothing = 0,
    /// The ground.
    Ground = 1,
    /// Trunk or branches.
    Wood = 2,
    /// A leaf or needle.
    Leaf = 3,
}

/// What the ray through the middle of a pixel meets first, with a lens without size: nothing is
/// mixed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mark {
    /// What it is.
    pub kind: Kind,
    /// Distance along the camera's axis in metres; 0 where there is nothing.
    pub depth: f32,
    /// Unit normal in the space of the tree, on the side that is seen; 0 where there is nothing.
    pub normal: [f32; 3],
    /// Branch of the internode, as an index into [`deeptree_graph::branches`]; of a leaf, of the
    /// internode it stands on. 0 where there is no tree, as the next ones.
    pub branch: u32,
    /// Gravelius order of the branch.
    pub order: u16,
    /// The internode's node.
    pub node: u32,
    /// Number of the tree in the scene.
    pub tree: u32,
}

/// Looks along one ray a pixel; of `options`, the size counts. Row by row from above.
///
/// # Errors
///
/// When an option is out of its range.
pub fn marks(
    scene: &Scene<'_>,
    camera: &Camera,
    options: &Options,
) -> Result<Vec<Mark>, RenderError> {
    options.validate()?;
    let [width, height] = options.size;
    let camera = camera.with_aperture(0.0);
    let one = |i: usize| {
        let (x, y) = (i % width as usize, i / width as usize);
        let at = [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32];
        mark(scene, &camera, at)
    };
    Ok((0..width as usize * height as usize).into_par_iter().map(one).collect())
}

fn mark(scene: &Scene<'_>, camera: &Camera, at: [f32; 2]) -> Mark {
    let ray = camera.ray(at, [0.0; 2]);
    let Some(surface) = scene.meet(&ray) else { return Mark::default() };
    let facing: Vec3 = surface.facing();
    let depth = camera.project(surface.point).map_or(0.0, |(_, depth)| depth);
    let of_tree = |kind, node: u32| {
        let internode = scene.internode(surface.tree, node);
        let tree = surface.tree as u32;
        let (branch, order) = internode.map_or((0, 0), |one| (one.branch, one.order));
        Mark { kind, depth, normal: facing.into(), branch, order, node, tree }
    };
    match surface.label {
        Label::Ground => {
            Mark { kind: Kind::Ground, depth, normal: facing.into(), ..Mark::default() }
        }
        Label::Wood(node) => of_tree(Kind::Wood, node),
        Label::Leaf(node) => of_tree(Kind::Leaf, node),
    }
}
