//! Chains with the special rule for the root, and what is measured of each.

use std::f32::consts::PI;

use deeptree_graph::{BranchGraph, NodeId, Vec3};

/// A run of nodes from one fork to the next.
///
/// Unlike those of [`deeptree_graph::chains`], a chain starts with the node it branches off, and
/// the walk does not stop at a root with several children: it goes on into the first.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    /// The fork, then the run; the first chain starts with the root.
    pub(super) nodes: Vec<NodeId>,
    /// Index of the chain it branches off.
    pub(super) parent: Option<usize>,
    /// Indices of the chains that branch off its end.
    pub(super) children: Vec<usize>,
    /// Forks between it and the root.
    pub(super) depth: u32,
    /// Whether its last node has no children. The first chain may be such an end and have child
    /// chains all the same: the other children of the root.
    pub(super) is_end: bool,
    /// What is measured of it.
    pub(super) measures: Measures,
}

/// A pair of consecutive nodes of a chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// In metres.
    pub(super) length: f32,
    /// Radius at the start, in metres.
    pub(super) start: f32,
    /// Radius at the end, in metres.
    pub(super) end: f32,
}

impl Segment {
    /// Volume of the cone frustum in cubic metres: `π h / 3 (r₁² + r₁ r₂ + r₂²)`.
    pub(super) fn volume(&self) -> f32 {
        let (r1, r2) = (self.start, self.end);
        PI * self.length / 3.0 * (r1 * r1 + r1 * r2 + r2 * r2)
    }
}

/// Lengths in metres, volumes in cubic metres, angles in radians.
#[derive(Clone, Debug)]
pub(super) struct Measures {
    /// The segments from the start on.
    pub(super) segments: Vec<Segment>,
    /// Sum of the segments' lengths.
    pub(super) length: f32,
    /// Sum of the distances of the nodes from the first node.
    pub(super) fan_length: f32,
    /// Sum of the segments' volumes.
    volume: f32,
    /// From the first node to the last.
    pub(super) span: Vec3,
    /// Direction of the first segment that has one.
    pub(super) first: Vec3,
    /// Direction of the last segment.
    pub(super) last: Vec3,
    /// Sum of the angles between consecutive segments. The first is compared with itself, which
    /// adds its rounding error.
    pub(super) angle_sum: f32,
    /// Smallest radius; `f32::MAX` of a chain without segments.
    pub(super) min_thickness: f32,
    /// Largest radius; `f32::MIN_POSITIVE` where there is none above it.
    pub(super) max_thickness: f32,
    /// Leaf chains above; 1 of a leaf chain.
    pub(super) leaves_above: f32,
    /// Length of the leaf chains above; inner chains add nothing of their own.
    pub(super) length_above: f32,
    /// Volume of the leaf chains above; inner chains add nothing of their own.
    pub(super) volume_above: f32,
}

/// Whether a number differs from zero by more than the float32 epsilon.
pub(super) fn is_above_epsilon(x: f32) -> bool {
    x.abs() > f32::EPSILON
}

/// `v / (|v| + ε)`: a little short of unit length, the more so the shorter v is; zero of zero.
pub(super) fn unit(v: Vec3) -> Vec3 {
    v / (v.length() + f32::EPSILON)
}

/// The angle between the directions of two vectors, in radians; π/2 where one is zero.
pub(super) fn angle(a: Vec3, b: Vec3) -> f32 {
    angle_of_units(unit(a), unit(b))
}

fn angle_of_units(a: Vec3, b: Vec3) -> f32 {
    a.dot(b).clamp(-1.0, 1.0).acos()
}

/// Cuts a tree into chains, the root's first; a parent comes before its children.
///
/// Children are numbered together, by slot, when their parent is finished; the last of them is
/// followed up first.
pub(super) fn cut(tree: &BranchGraph) -> Vec<Chain> {
    let mut chains = Vec::new();
    let mut open = vec![(0, None, 0)];
    chains.push(Chain::new(None, 0));
    while let Some((chain, fork, first)) = open.pop() {
        let nodes = run(tree, fork, first);
        let end = nodes[nodes.len() - 1];
        let mut starts: Vec<NodeId> = children(tree, end).collect();
        if first == 0 && end != 0 {
            starts.extend(children(tree, 0).skip(1));
        }
        for start in starts {
            let child = chains.len();
            open.push((child, Some(end), start));
            let depth = chains[chain].depth + 1;
            chains.push(Chain::new(Some(chain), depth));
            chains[chain].children.push(child);
        }
        chains[chain].is_end = children(tree, end).next().is_none();
        chains[chain].measures = Measures::of(tree, &nodes);
        chains[chain].nodes = nodes;
    }
    sum_above(&mut chains);
    chains
}

fn children(tree: &BranchGraph, node: NodeId) -> impl Iterator<Item = NodeId> {
    tree.node(node).children.into_iter().flatten()
}

/// The fork, `first`, and the nodes from there to the next fork or end.
fn run(tree: &BranchGraph, fork: Option<NodeId>, first: NodeId) -> Vec<NodeId> {
    let mut nodes: Vec<NodeId> = fork.into_iter().collect();
    let mut at = first;
    loop {
        nodes.push(at);
        match children(tree, at).next() {
            Some(next) if at == 0 || tree.node(at).child_count() == 1 => at = next,
            _ => return nodes,
        }
    }
}

/// Sums what the leaf chains above each chain have, from the leaves down.
fn sum_above(chains: &mut [Chain]) {
    for i in (0..chains.len()).rev() {
        let own = &chains[i].measures;
        let mut above = (1.0, own.length, own.volume);
        if !chains[i].children.is_empty() {
            above = (0.0, 0.0, 0.0);
            for child in chains[i].children.iter().map(|&child| &chains[child].measures) {
                above.0 += child.leaves_above;
                above.1 += child.length_above;
                above.2 += child.volume_above;
            }
        }
        let own = &mut chains[i].measures;
        (own.leaves_above, own.length_above, own.volume_above) = above;
    }
}

impl Chain {
    fn new(parent: Option<usize>, depth: u32) -> Self {
        let measures = Measures::default();
        Self { nodes: Vec::new(), parent, children: Vec::new(), depth, is_end: false, measures }
    }
}

impl Default for Measures {
    /// Those of a single node.
    fn default() -> Self {
        Self {
            segments: Vec::new(),
            length: 0.0,
            fan_length: 0.0,
            volume: 0.0,
            span: Vec3::ZERO,
            first: Vec3::ZERO,
            last: Vec3::ZERO,
            angle_sum: 0.0,
            min_thickness: f32::MAX,
            max_thickness: f32::MIN_POSITIVE,
            leaves_above: 0.0,
            length_above: 0.0,
            volume_above: 0.0,
        }
    }
}

impl Measures {
    /// Measures a run of nodes, but for what lies above it.
    fn of(tree: &BranchGraph, nodes: &[NodeId]) -> Self {
        let mut measures = Self::default();
        let points: Vec<Vec3> = nodes.iter().map(|&node| tree.node(node).position).collect();
        let radii: Vec<f32> = nodes.iter().map(|&node| radius(tree, node)).collect();
        if points.len() > 1 {
            measures.add_segments(&points, &radii);
            measures.add_directions(&points);
        }
        measures
    }

    fn add_segments(&mut self, points: &[Vec3], radii: &[f32]) {
        for i in 1..points.len() {
            let length = points[i - 1].distance(points[i]);
            let segment = Segment { length, start: radii[i - 1], end: radii[i] };
            self.length += length;
            self.volume += segment.volume();
            self.fan_length += points[0].distance(points[i]);
            self.segments.push(segment);
        }
        self.min_thickness = radii.iter().copied().fold(self.min_thickness, f32::min);
        self.max_thickness = radii.iter().copied().fold(self.max_thickness, f32::max);
    }

    fn add_directions(&mut self, points: &[Vec3]) {
        let directions: Vec<Vec3> = points.windows(2).map(|ends| unit(ends[1] - ends[0])).collect();
        self.span = points[points.len() - 1] - points[0];
        self.last = directions[directions.len() - 1];
        let has_direction = |d: &&Vec3| is_above_epsilon(d.length());
        self.first = directions.iter().find(has_direction).copied().unwrap_or(self.last);
        let mut before = directions[0];
        for &direction in &directions {
            self.angle_sum += angle_of_units(before, direction);
            before = direction;
        }
    }
}

/// A node's radius; 0 where it is not a number.
fn radius(tree: &BranchGraph, node: NodeId) -> f32 {
    let thickness = tree.node(node).thickness;
    if thickness.is_finite() { thickness } else { 0.0 }
}
