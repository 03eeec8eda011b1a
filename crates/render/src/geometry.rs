//! What rays meet: the triangles of the wood and copies of leaves, in one hierarchy of boxes; each
//! kind of leaf has its own triangles below it.

use std::time::Duration;

use deeptree_mesh::{Blade, Dressed, Foliage, Leaf, Mesh};
use glam::{Quat, Vec3};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::RayHit;

use crate::error::RenderError;
use crate::ray::{Meeting, Ray, Triangle};

/// Bounds grow by this share of their farthest coordinate: more than the rounding in the test of
/// a ray against them.
const MARGIN: f32 = 2e-6;

/// The surfaces of a tree, ready for rays.
pub(crate) struct Geometry {
    bvh: CwBvh,
    /// In the order of the hierarchy's leaves.
    parts: Vec<Part>,
    triangles: Vec<Triangle>,
    blades: Vec<BladeGeometry>,
    leaves: Vec<Placed>,
}

/// What the hierarchy ends in.
#[derive(Clone, Copy, Debug)]
enum Part {
    Wood(u32),
    Leaf(u32),
}

/// A copy of a blade.
#[derive(Clone, Copy, Debug)]
struct Placed {
    kind: u32,
    number: u32,
    position: Vec3,
    /// Blade from world.
    rotation: Quat,
    inverse_scale: f32,
}

struct BladeGeometry {
    triangles: Vec<Triangle>,
    /// None where looking at all triangles is quicker.
    bvh: Option<CwBvh>,
}

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    pub(crate) meeting: Meeting,
    pub(crate) what: What,
}

/// Of what a triangle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// A triangle of the wood.
    Wood { triangle: u32 },
    /// A triangle of leaf `number` of foliage `kind`.
    Leaf { kind: u32, number: u32, triangle: u32 },
}

impl Geometry {
    /// Builds the hierarchy; what it cannot hold is refused.
    pub(crate) fn new(tree: &Dressed) -> Result<Self, RenderError> {
        check_wood(&tree.wood)?;
        let triangles: Vec<Triangle> = tree.wood.triangles().map(Triangle::new).collect();
        let mut bounds: Vec<Aabb> =
            tree.wood.triangles().map(|corners| bounds_of(corners.into_iter())).collect();
        let mut parts: Vec<Part> = (0..triangles.len() as u32).map(Part::Wood).collect();
        let (mut blades, mut leaves) = (Vec::new(), Vec::new());
        for (kind, foliage) in tree.foliage.iter().enumerate() {
            check_foliage(foliage)?;
            blades.push(BladeGeometry::new(&foliage.blade));
            for (number, leaf) in foliage.leaves.iter().enumerate() {
                let corners = foliage.blade.positions.iter().map(|&p| world_from_blade(leaf, p));
                bounds.push(bounds_of(corners));
                parts.push(Part::Leaf(leaves.len() as u32));
                leaves.push(Placed {
                    kind: kind as u32,
                    number: number as u32,
                    position: leaf.position,
                    rotation: leaf.rotation.conjugate(),
                    inverse_scale: 1.0 / leaf.scale,
                });
            }
        }
        if parts.is_empty() {
            return Err(RenderError::Empty);
        }
        let bvh = build(&bounds);
        let parts = bvh.primitive_indices.iter().map(|&i| parts[i as usize]).collect();
        Ok(Self { bvh, parts, triangles, blades, leaves })
    }

    /// What the ray meets first, where `is_there` says that there is something: leaves have holes.
    pub(crate) fn first(&self, ray: &Ray, is_there: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let mut best = None;
        let mut ray = *ray;
        self.bvh.ray_traverse(ray.traversal(), &mut RayHit::none(), |_, at| {
            match self.meet(self.parts[at], &ray, &is_there) {
                Some(hit) => {
                    ray.most = hit.meeting.distance;
                    best = Some(hit);
                    ray.most
                }
                None => f32::INFINITY,
            }
        });
        best
    }

    /// Is anything in the ray's way?
    pub(crate) fn any(&self, ray: &Ray, is_there: impl Fn(&Hit) -> bool) -> bool {
        !self.bvh.ray_traverse_miss(ray.traversal(), |_, at| {
            match self.meet(self.parts[at], ray, &is_there) {
                Some(hit) => hit.meeting.distance,
                None => f32::INFINITY,
            }
        })
    }

    fn meet(&self, part: Part, ray: &Ray, is_there: &impl Fn(&Hit) -> bool) -> Option<Hit> {
        match part {
            Part::Wood(triangle) => {
                let meeting = self.triangles[triangle as usize].meet(ray)?;
                let hit = Hit { meeting, what: What::Wood { triangle } };
                is_there(&hit).then_some(hit)
            }
            Part::Leaf(leaf) => {
                let leaf = &self.leaves[leaf as usize];
                let local = Ray {
                    origin: leaf.rotation * (ray.origin - leaf.position) * leaf.inverse_scale,
                    // Not of unit length: so distances stay those of the world.
                    direction: leaf.rotation * ray.direction * leaf.inverse_scale,
                    most: ray.most,
                };
                let &Placed { kind, number, .. } = leaf;
                self.blades[kind as usize].first(&local, |meeting, triangle| {
                    let hit = Hit { meeting, what: What::Leaf { kind, number, triangle } };
                    is_there(&hit).then_some(hit)
                })
            }
        }
    }
}

impl BladeGeometry {
    /// Blades of more triangles than this get a hierarchy of their own.
    const FEW: usize = 8;

    fn new(blade: &Blade) -> Self {
        let corners = || {
            let triangles = blade.indices.as_chunks::<3>().0.iter();
            triangles.map(|t| t.map(|i| blade.positions[i as usize]))
        };
        let bounds: Vec<Aabb> = corners().map(|c| bounds_of(c.into_iter())).collect();
        let bvh = (bounds.len() > Self::FEW).then(|| build(&bounds));
        Self { triangles: corners().map(Triangle::new).collect(), bvh }
    }

    /// The nearest hit that `accept` makes of a meeting and a triangle.
    fn first(&self, ray: &Ray, accept: impl Fn(Meeting, u32) -> Option<Hit>) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let traversal = ray.traversal();
        let mut ray = *ray;
        let mut look = |triangle: u32| {
            let met = self.triangles[triangle as usize].meet(&ray);
            match met.and_then(|meeting| accept(meeting, triangle)) {
                Some(hit) => {
                    ray.most = hit.meeting.distance;
                    best = Some(hit);
                    ray.most
                }
                None => f32::INFINITY,
            }
        };
        match &self.bvh {
            None => {
                for triangle in 0..self.triangles.len() as u32 {
                    look(triangle);
                }
            }
            Some(bvh) => {
                bvh.ray_traverse(traversal, &mut RayHit::none(), |_, at| {
                    look(bvh.primitive_indices[at])
                });
            }
        }
        best
    }
}

/// `p_world = position + scale · R(rotation) · p_blade`.
pub(crate) fn world_from_blade(leaf: &Leaf, point: Vec3) -> Vec3 {
    leaf.position + leaf.rotation * (point * leaf.scale)
}

/// A hierarchy that is quick to trace, in a build that takes a few seconds for a million triangles.
fn build(bounds: &[Aabb]) -> CwBvh {
    build_cwbvh(bounds, BvhBuildParams::fast_build(), &mut Duration::default())
}

fn bounds_of(points: impl Iterator<Item = Vec3>) -> Aabb {
    let (low, high) = points
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let margin = Vec3::splat(MARGIN * low.abs().max(high.abs()).max_element().max(1e-3));
    Aabb::new((low - margin).into(), (high + margin).into())
}

fn check_wood(wood: &Mesh) -> Result<(), RenderError> {
    let part = "the wood";
    check(part, &wood.positions, &wood.indices)?;
    let count = wood.normals.len().min(wood.uvs.len()).min(wood.nodes.len());
    if count < wood.positions.len() {
        return Err(RenderError::Index { part, vertex: count as u32, count });
    }
    let internodes = wood.internodes.len();
    match wood.nodes.iter().find(|&&node| node as usize >= internodes) {
        Some(&vertex) => Err(RenderError::Index { part, vertex, count: internodes }),
        None => Ok(()),
    }
}

fn check_foliage(foliage: &Foliage) -> Result<(), RenderError> {
    let (part, blade) = ("a leaf", &foliage.blade);
    check(part, &blade.positions, &blade.indices)?;
    let count = blade.normals.len().min(blade.uvs.len());
    if blade.positions.is_empty() || count < blade.positions.len() {
        return Err(RenderError::Index { part, vertex: count as u32, count });
    }
    let is_sound = |leaf: &Leaf| {
        leaf.position.is_finite() && leaf.rotation.is_finite() && leaf.scale.is_normal()
    };
    match foliage.leaves.iter().position(|leaf| !is_sound(leaf)) {
        Some(vertex) => Err(RenderError::NotFinite { part, vertex }),
        None => Ok(()),
    }
}

fn check(part: &'static str, positions: &[Vec3], indices: &[u32]) -> Result<(), RenderError> {
    if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
        return Err(RenderError::NotFinite { part, vertex });
    }
    match indices.iter().find(|&&i| i as usize >= positions.len()) {
        Some(&vertex) => Err(RenderError::Index { part, vertex, count: positions.len() }),
        None => Ok(()),
    }
}
