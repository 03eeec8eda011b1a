//! What rays meet of all trees: a hierarchy of boxes over them, each with its own below.

use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::RayHit;
use rayon::prelude::*;

use crate::error::RenderError;
use crate::geometry::{Geometry, Hit};
use crate::ray::Ray;
use crate::scene::Standing;

/// So many trees are looked at one after the other, which is quicker than a hierarchy.
const FEW: usize = 4;

/// The surfaces of all trees, ready for rays.
pub(crate) struct Grove {
    trees: Vec<Stood>,
    bounds: (Vec3, Vec3),
    /// None for a few.
    bvh: Option<CwBvh>,
}

/// A tree in its own space, and where its foot stands.
struct Stood {
    at: Vec3,
    geometry: Geometry,
}

/// What a ray met first: of which tree, and where there in its own space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Met {
    pub(crate) tree: usize,
    pub(crate) hit: Hit,
}

impl Grove {
    /// Builds the hierarchies; what they cannot hold is refused.
    pub(crate) fn new(trees: &[Standing<'_>]) -> Result<Self, RenderError> {
        if trees.is_empty() {
            return Err(RenderError::Empty);
        }
        if let Some(tree) = trees.iter().position(|one| !one.at.is_finite()) {
            return Err(RenderError::NotFinite { part: "the places of trees", vertex: tree });
        }
        let stood =
            |one: &Standing<'_>| Ok(Stood { at: one.at, geometry: Geometry::new(one.tree)? });
        let trees: Vec<Stood> = trees.par_iter().map(stood).collect::<Result<_, _>>()?;
        let each: Vec<Aabb> = trees.iter().map(Stood::bounds).collect();
        let whole = each.iter().fold(Aabb::INVALID, |all, one| all.union(one));
        let bvh = (trees.len() > FEW)
            .then(|| build_cwbvh(&each, BvhBuildParams::medium_build(), &mut Duration::default()));
        Ok(Self { trees, bounds: (whole.min.into(), whole.max.into()), bvh })
    }

    /// The lowest and the highest coordinates of a box around all trees.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// What the ray meets first, where `is_there` says that there is something: leaves have holes.
    pub(crate) fn first(&self, ray: &Ray, is_there: impl Fn(&Met) -> bool) -> Option<Met> {
        let mut best: Option<Met> = None;
        let mut ray = *ray;
        let traversal = ray.traversal();
        let mut look = |tree: usize| {
            let stood = &self.trees[tree];
            let met = |&hit: &Hit| Met { tree, hit };
            let found = stood.geometry.first(&stood.local(&ray), |hit| is_there(&met(hit)));
            match found {
                Some(hit) => {
                    ray.most = hit.meeting.distance;
                    best = Some(met(&hit));
                    ray.most
                }
                None => f32::INFINITY,
            }
        };
        match &self.bvh {
            None => (0..self.trees.len()).for_each(|tree| {
                look(tree);
            }),
            Some(bvh) => {
                bvh.ray_traverse(traversal, &mut RayHit::none(), |_, at| {
                    look(bvh.primitive_indices[at] as usize)
                });
            }
        }
        best
    }

    /// Is anything in the ray's way?
    pub(crate) fn any(&self, ray: &Ray, is_there: impl Fn(&Met) -> bool) -> bool {
        let is_hit = |tree: usize| {
            let stood = &self.trees[tree];
            stood.geometry.any(&stood.local(ray), |&hit| is_there(&Met { tree, hit }))
        };
        match &self.bvh {
            None => (0..self.trees.len()).any(is_hit),
            Some(bvh) => !bvh.ray_traverse_miss(ray.traversal(), |_, at| {
                if is_hit(bvh.primitive_indices[at] as usize) { 0.0 } else { f32::INFINITY }
            }),
        }
    }
}

impl Stood {
    /// The ray in the tree's own space.
    fn local(&self, ray: &Ray) -> Ray {
        Ray { origin: ray.origin - self.at, ..*ray }
    }

    /// What it takes of the world, and a little more than rounding.
    fn bounds(&self) -> Aabb {
        let (low, high) = self.geometry.bounds();
        let (low, high) = (low + self.at, high + self.at);
        let margin = 1e-5 * low.abs().max(high.abs()).max_element();
        Aabb::new((low - margin).into(), (high + margin).into())
    }
}
