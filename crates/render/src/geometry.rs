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

/// Bounds grow by this share of the reach of all that is in a hierarchy: more than the rounding in
/// the test of a ray that starts no farther away.
const MARGIN: f32 = 2e-6;

/// The surfaces of a tree, ready for rays.
pub(crate) struct Geometry {
    bvh: CwBvh,
    ball: Ball,
    /// In the order of the hierarchy's leaves.
    parts: Vec<Part>,
    blades: Vec<BladeGeometry>,
    leaves: Vec<Placed>,
}

/// What the hierarchy ends in.
#[derive(Clone, Copy, Debug)]
enum Part {
    Wood(u32, Triangle),
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
    ball: Ball,
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
        let (mut bounds, mut parts) = (Vec::new(), Vec::new());
        for (number, corners) in (0u32..).zip(tree.wood.triangles()) {
            bounds.push(bounds_of(corners.into_iter()));
            parts.push(Part::Wood(number, Triangle::new(corners)));
        }
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
        let (bvh, ball) = build(&mut bounds);
        let parts = bvh.primitive_indices.iter().map(|&i| parts[i as usize]).collect();
        Ok(Self { bvh, ball, parts, blades, leaves })
    }

    /// The lowest and the highest coordinates, but for rounding.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let Ball { middle, half, .. } = self.ball;
        (middle - half, middle + half)
    }

    /// What the ray meets first, where `is_there` says that there is something: leaves have holes.
    pub(crate) fn first(&self, ray: &Ray, is_there: impl Fn(&Hit) -> bool) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let (mut ray, skipped) = self.ball.near(ray);
        self.bvh.ray_traverse(ray.traversal(), &mut RayHit::none(), |_, at| {
            match self.meet(&self.parts[at], &ray, &is_there) {
                Some(hit) => {
                    ray.most = hit.meeting.distance;
                    best = Some(hit);
                    ray.most
                }
                None => f32::INFINITY,
            }
        });
        best.map(|hit| hit.farther(skipped))
    }

    /// Is anything in the ray's way?
    pub(crate) fn any(&self, ray: &Ray, is_there: impl Fn(&Hit) -> bool) -> bool {
        let (ray, _) = self.ball.near(ray);
        !self.bvh.ray_traverse_miss(ray.traversal(), |_, at| {
            match self.meet(&self.parts[at], &ray, &is_there) {
                Some(hit) => hit.meeting.distance,
                None => f32::INFINITY,
            }
        })
    }

    fn meet(&self, part: &Part, ray: &Ray, is_there: &impl Fn(&Hit) -> bool) -> Option<Hit> {
        match *part {
            Part::Wood(number, triangle) => {
                let meeting = triangle.meet(ray)?;
                let hit = Hit { meeting, what: What::Wood { triangle: number } };
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
        let mut bounds: Vec<Aabb> = corners().map(|c| bounds_of(c.into_iter())).collect();
        let (bvh, ball) = build(&mut bounds);
        let bvh = (bounds.len() > Self::FEW).then_some(bvh);
        Self { ball, triangles: corners().map(Triangle::new).collect(), bvh }
    }

    /// The nearest hit that `accept` makes of a meeting and a triangle.
    fn first(&self, ray: &Ray, accept: impl Fn(Meeting, u32) -> Option<Hit>) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let (mut ray, skipped) = self.ball.near(ray);
        let traversal = ray.traversal();
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
        best.map(|hit| hit.farther(skipped))
    }
}

/// `p_world = position + scale · R(rotation) · p_blade`.
pub(crate) fn world_from_blade(leaf: &Leaf, point: Vec3) -> Vec3 {
    leaf.position + leaf.rotation * (point * leaf.scale)
}

/// A ball around all that is in a hierarchy.
#[derive(Clone, Copy, Debug)]
struct Ball {
    middle: Vec3,
    /// Half of the sides of the box that it is around.
    half: Vec3,
    radius: f32,
}

impl Ball {
    /// The ray from where it comes near, and how far that is from where it started: from afar,
    /// rounding would make it miss thin things.
    fn near(&self, ray: &Ray) -> (Ray, f32) {
        let square = ray.direction.length_squared();
        let along = (self.middle - ray.origin).dot(ray.direction) / square;
        let skipped = (along - self.radius / square.sqrt()).max(0.0);
        let origin = ray.origin + ray.direction * skipped;
        (Ray { origin, most: ray.most - skipped, ..*ray }, skipped)
    }
}

impl Hit {
    /// The same hit, of a ray that starts farther away.
    fn farther(mut self, by: f32) -> Self {
        self.meeting.distance += by;
        self
    }
}

/// A hierarchy that is quick to trace, in a build that takes a few seconds for a million triangles,
/// and what lies around it.
fn build(bounds: &mut [Aabb]) -> (CwBvh, Ball) {
    let whole = bounds.iter().fold(Aabb::INVALID, |all, one| all.union(one));
    let (low, high) = (Vec3::from(whole.min), Vec3::from(whole.max));
    let ball = if bounds.is_empty() {
        Ball { middle: Vec3::ZERO, half: Vec3::ZERO, radius: 0.0 }
    } else {
        let half = (high - low) / 2.0;
        Ball { middle: (low + high) / 2.0, half, radius: half.length() }
    };
    let margin = MARGIN * (ball.middle.abs().max_element() + 2.0 * ball.radius).max(1e-6);
    for one in bounds.iter_mut() {
        *one = Aabb::new(one.min - margin, one.max + margin);
    }
    let hierarchy = build_cwbvh(bounds, BvhBuildParams::fast_build(), &mut Duration::default());
    (hierarchy, ball)
}

fn bounds_of(points: impl Iterator<Item = Vec3>) -> Aabb {
    let (low, high) = points
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    Aabb::new(low.into(), high.into())
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
