//! What is scanned: triangles, where they are, and what they belong to.

use deeptree_cloud::Class;
use deeptree_graph::{BranchGraph, NodeId, Vec3};
use deeptree_mesh::{Foliage, Internode, Mesh};
use glam::DVec3;

use crate::cutout::Cutout;
use crate::hierarchy::Hierarchy;
use crate::triangle::{Seen, Triangle};

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
    /// Of each triangle of a leaf: texture coordinates, and which of `cutouts` they are of.
    outlines: Vec<([[f32; 2]; 3], u32)>,
    cutouts: Vec<Cutout>,
    hierarchy: Hierarchy,
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
        for kind in foliage.iter().filter(|kind| kind.woody) {
            push_leaves(kind, &mut triangles, &mut nodes);
        }
        let first_leaf = triangles.len();
        let (mut outlines, mut cutouts) = (Vec::new(), Vec::new());
        for kind in foliage.iter().filter(|kind| !kind.woody) {
            push_leaves(kind, &mut triangles, &mut nodes);
            push_outlines(kind, cutouts.len() as u32, &mut outlines);
            cutouts.push(Cutout::of(&kind.material));
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
            hierarchy: Hierarchy::new(triangles.iter().map(Triangle::bounds)),
            outlines,
            cutouts,
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

    /// What each of the rays from `from` along these unit vectors meets first; of several things at
    /// the same distance, the first triangle. The rays are those of one cone, the first in its
    /// middle, no other farther from it than `slope` a metre; what none meets within `depth` behind the
    /// nearest may be missing.
    pub(crate) fn first_hits<const N: usize>(
        &self,
        from: DVec3,
        along: &[DVec3; N],
        slope: f64,
        depth: f64,
    ) -> [Option<Hit>; N] {
        let mut first = [None; N];
        let mut nearest = f64::INFINITY;
        self.hierarchy.walk(from, along[0], slope, |triangle| {
            let seen = self.triangles[triangle].seen_from(from);
            for (first, along) in first.iter_mut().zip(along) {
                self.meet(triangle, &seen, *along, first);
                nearest = first.map_or(nearest, |hit: Hit| nearest.min(hit.distance));
            }
            nearest + depth
        });
        first
    }

    /// Replaces what a ray has met first by what it meets in a triangle, where that is nearer.
    fn meet(&self, triangle: usize, seen: &Seen, along: DVec3, first: &mut Option<Hit>) {
        let Some(meeting) = seen.meeting(along) else { return };
        let nearer = first
            .is_none_or(|first| (meeting.distance, triangle) < (first.distance, first.triangle));
        if nearer && self.is_there(triangle, meeting.shares) {
            let (distance, shares) = (meeting.distance, meeting.shares);
            *first = Some(Hit { distance, triangle, shares });
        }
    }

    /// Is the surface there at this place of a triangle? A picture of a leaf has holes around it.
    fn is_there(&self, triangle: usize, shares: [f64; 2]) -> bool {
        let leaf = triangle.wrapping_sub(self.first_leaf);
        self.outlines.get(leaf).is_none_or(|&(corners, number)| {
            self.cutouts.get(number as usize).is_none_or(|cutout| cutout.is_there(corners, shares))
        })
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

/// The texture coordinates of all copies of a leaf.
fn push_outlines(kind: &Foliage, cutout: u32, outlines: &mut Vec<([[f32; 2]; 3], u32)>) {
    let uv = |i: u32| kind.blade.uvs.get(i as usize).copied().unwrap_or_default();
    for _ in &kind.leaves {
        let corners = kind.blade.indices.as_chunks::<3>().0;
        outlines.extend(corners.iter().map(|t| (t.map(uv), cutout)));
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
