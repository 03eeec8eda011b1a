//! What is scanned: triangles, where they are, and what they belong to.

use deeptree_cloud::Class;
use deeptree_graph::{BranchGraph, NodeId, Vec3};
use deeptree_mesh::{Foliage, Internode, Mesh};
use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{Ray, RayHit};

use crate::triangle::Triangle;

/// A tree to be scanned, in metres, y up.
#[derive(Clone)]
pub struct Target {
    triangles: Vec<Triangle>,
    /// The node at each corner; of a leaf, thrice its own; of the ground, [`NO_NODE`].
    nodes: Vec<[NodeId; 3]>,
    /// Triangles before this one are wood, from it on leaves.
    first_leaf: usize,
    /// Triangles from this one on are ground.
    first_ground: usize,
    /// Base and tip of each internode.
    axes: Vec<[Vec3; 2]>,
    internodes: Vec<Internode>,
    bvh: Bvh2,
    tree: (Vec3, Vec3),
    all: (Vec3, Vec3),
}

/// The node of a point that lies on none.
pub(crate) const NO_NODE: NodeId = NodeId::MAX;

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// In metres.
    pub(crate) distance: f64,
    pub(crate) triangle: usize,
    shares: [f64; 2],
}

/// What a point lies on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Label {
    pub(crate) class: Class,
    pub(crate) node: NodeId,
    pub(crate) branch: u32,
    pub(crate) order: u16,
}

/// Bounds grow by this share of their farthest coordinate and by [`MARGIN`]: more than the rounding
/// in the test of a ray from 1 km away against them, so that only the triangles themselves decide.
const MARGIN_SHARE: f32 = 1e-5;
/// In metres.
const MARGIN: f32 = 2e-4;

impl std::fmt::Debug for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Target({} triangles)", self.triangles.len())
    }
}

impl Target {
    /// A tree's wood and perhaps its leaves.
    ///
    /// # Panics
    ///
    /// When `wood` or `foliage` has nodes that `tree` does not have.
    #[must_use]
    pub fn new(tree: &BranchGraph, wood: &Mesh, foliage: &[Foliage]) -> Self {
        Self::with(tree, wood, foliage, None)
    }

    /// The same on a level ground at height 0, which reaches `beyond` metres beyond the tree's
    /// bounding box.
    ///
    /// # Panics
    ///
    /// As [`Target::new`].
    #[must_use]
    pub fn on_ground(tree: &BranchGraph, wood: &Mesh, foliage: &[Foliage], beyond: f32) -> Self {
        Self::with(tree, wood, foliage, Some(beyond))
    }

    fn with(tree: &BranchGraph, wood: &Mesh, foliage: &[Foliage], ground: Option<f32>) -> Self {
        let mut triangles: Vec<Triangle> = wood.triangles().map(Triangle::new).collect();
        let corners = wood.indices.as_chunks::<3>().0;
        let mut nodes: Vec<[NodeId; 3]> =
            corners.iter().map(|t| t.map(|i| wood.nodes[i as usize])).collect();
        let first_leaf = triangles.len();
        for kind in foliage {
            push_leaves(kind, &mut triangles, &mut nodes);
        }
        let first_ground = triangles.len();
        let bounds = bounds(&triangles);
        if let Some(beyond) = ground {
            triangles.extend(ground_below(bounds, beyond));
            nodes.resize(triangles.len(), [NO_NODE; 3]);
        }
        let axes: Vec<[Vec3; 2]> = tree.nodes().iter().map(|n| [n.base(), n.position]).collect();
        let known = nodes[..first_ground].iter().flatten().all(|&n| (n as usize) < axes.len());
        assert!(known, "the surface is that of another tree");
        Self {
            bvh: build(&triangles),
            first_leaf,
            first_ground,
            axes,
            internodes: wood.internodes.clone(),
            tree: bounds,
            all: self::bounds(&triangles),
            triangles,
            nodes,
        }
    }

    /// How many triangles there are.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The lowest and highest coordinates of the tree, in metres.
    #[must_use]
    pub fn tree_bounds(&self) -> (Vec3, Vec3) {
        self.tree
    }

    /// The lowest and highest coordinates of the tree and the ground, in metres.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        self.all
    }

    /// What the ray from `from` along the unit vector `along` meets first; of several at the same
    /// distance, the first triangle.
    pub(crate) fn first_hit(&self, from: DVec3, along: DVec3) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        let ray = Ray::new(from.as_vec3a(), along.as_vec3a(), 0.0, f32::MAX);
        self.bvh.ray_traverse(ray, &mut RayHit::none(), |_, at| {
            let triangle = self.bvh.primitive_indices[at] as usize;
            let Some(meeting) = self.triangles[triangle].meeting(from, along) else {
                return f32::INFINITY;
            };
            let nearer = first.is_none_or(|first| {
                (meeting.distance, triangle) < (first.distance, first.triangle)
            });
            if nearer {
                let (distance, shares) = (meeting.distance, meeting.shares);
                first = Some(Hit { distance, triangle, shares });
            }
            // A little farther, so that rounding does not hide what is as near.
            meeting.distance as f32 * 1.00001 + MARGIN
        });
        first
    }

    /// The cosine between a ray and the normal of what it hits.
    pub(crate) fn cosine(&self, hit: &Hit, along: DVec3) -> f64 {
        self.triangles[hit.triangle].cosine(along)
    }

    pub(crate) fn class(&self, hit: &Hit) -> Class {
        match hit.triangle {
            t if t < self.first_leaf => Class::Wood,
            t if t < self.first_ground => Class::Leaf,
            _ => Class::Ground,
        }
    }

    /// What a hit lies on; `place` is where it is.
    pub(crate) fn label(&self, hit: &Hit, place: Vec3) -> Label {
        let class = self.class(hit);
        let node = self.nearest_node(hit, place);
        match self.internodes.get(node as usize) {
            Some(internode) => {
                Label { class, node, branch: internode.branch, order: internode.order }
            }
            None => Label { class, node: NO_NODE, branch: u32::MAX, order: u16::MAX },
        }
    }

    /// Of the nodes at the triangle's corners, the one whose internode is nearest.
    fn nearest_node(&self, hit: &Hit, place: Vec3) -> NodeId {
        let nodes = self.nodes[hit.triangle];
        if nodes[0] == nodes[1] && nodes[0] == nodes[2] {
            return nodes[0];
        }
        // Where internodes meet at a bend, the corner that is nearest decides.
        let [second, third] = hit.shares;
        let shares = [1.0 - second - third, second, third];
        let distance = |k: usize| {
            let [base, tip] = self.axes[nodes[k] as usize];
            (squared_distance(place, base, tip), -shares[k])
        };
        let nearer = |best: usize, k: usize| if distance(k) < distance(best) { k } else { best };
        nodes[(1..3).fold(0, nearer)]
    }
}

/// The squared distance of a place from the segment between two others.
fn squared_distance(place: Vec3, base: Vec3, tip: Vec3) -> f32 {
    let along = tip - base;
    let length = along.length_squared();
    let share =
        if length > 0.0 { ((place - base).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    place.distance_squared(base + along * share)
}

fn push_leaves(kind: &Foliage, triangles: &mut Vec<Triangle>, nodes: &mut Vec<[NodeId; 3]>) {
    let corners = kind.blade.indices.as_chunks::<3>().0;
    for leaf in &kind.leaves {
        let world = |i: u32| {
            leaf.position + leaf.rotation * (kind.blade.positions[i as usize] * leaf.scale)
        };
        triangles.extend(corners.iter().map(|t| Triangle::new(t.map(world))));
        nodes.resize(triangles.len(), [leaf.node; 3]);
    }
}

fn ground_below((low, high): (Vec3, Vec3), beyond: f32) -> [Triangle; 2] {
    let (low, high) = (low - Vec3::splat(beyond), high + Vec3::splat(beyond));
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let (a, c) = (corner(low.x, low.z), corner(high.x, high.z));
    let (b, d) = (corner(low.x, high.z), corner(high.x, low.z));
    [Triangle::new([a, b, c]), Triangle::new([a, c, d])]
}

/// The lowest and highest coordinates; zero where there are no triangles.
fn bounds(triangles: &[Triangle]) -> (Vec3, Vec3) {
    let all = triangles.iter().map(Triangle::bounds);
    all.reduce(|(a, b), (low, high)| (a.min(low), b.max(high))).unwrap_or_default()
}

fn build(triangles: &[Triangle]) -> Bvh2 {
    let boxes: Vec<Aabb> = triangles
        .iter()
        .map(|triangle| {
            let (low, high) = triangle.bounds();
            let farthest = low.abs().max(high.abs()).max_element();
            let margin = Vec3::splat(MARGIN_SHARE * farthest + MARGIN);
            Aabb::new((low - margin).into(), (high + margin).into())
        })
        .collect();
    let numbers = (0..boxes.len() as u32).collect();
    PlocBuilder::new().build(PlocSearchDistance::Low, &boxes, numbers, SortPrecision::U64, 0)
}
