//! Where the rings of a branch stand: its axis, cleaned of edges too short to carry two rings.

use deeptree_graph::{BranchGraph, NodeId, Path, Vec3};

use crate::options::WoodOptions;

/// Edges up to this length carry no surface of their own, in metres.
pub const MIN_EDGE: f32 = 1e-3;

/// Thinner wood is meshed with this radius, in metres.
pub const MIN_RADIUS: f32 = 5e-4;

/// Rings of one branch keep this distance, in radii: closer ones would cross at any bend.
const SPACING: f32 = 0.5;

/// A point of the axis and the radius there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Station {
    pub(crate) position: Vec3,
    pub(crate) radius: f32,
    /// The node whose internode ends here.
    pub(crate) node: NodeId,
}

/// Appends the stations of one branch: where its first edge starts, then its nodes.
///
/// Appends at least two, each more than [`MIN_EDGE`] from the one before, or none if the branch
/// has no extent.
pub(crate) fn push_branch(
    tree: &BranchGraph,
    branch: &Path,
    options: &WoodOptions,
    out: &mut Vec<Station>,
) {
    let start = out.len();
    out.push(base(tree, branch, options));
    let mut tip = out[start];
    for &id in &branch.nodes {
        let node = tree.node(id);
        tip = Station { position: node.position, radius: node.thickness.max(MIN_RADIUS), node: id };
        if apart(out[out.len() - 1], tip, SPACING * tip.radius) {
            out.push(tip);
        }
    }
    end_at(tip, start, out);
    if out.len() - start < 2 {
        out.truncate(start);
    }
}

/// The start of the first edge: for a lateral, on the axis of its parent and within its surface.
fn base(tree: &BranchGraph, branch: &Path, options: &WoodOptions) -> Station {
    let first = tree.node(branch.nodes[0]);
    let (position, radius) = match first.parent.map(|id| tree.node(id)) {
        Some(parent) => (parent.position, first.thickness.min(parent.thickness)),
        None => (first.base(), options.foot_flare * first.thickness),
    };
    Station { position, radius: radius.max(MIN_RADIUS), node: branch.nodes[0] }
}

/// Makes `tip` the last station, in place of one that stands too close before it.
fn end_at(tip: Station, start: usize, out: &mut Vec<Station>) {
    let last = out.len() - 1;
    if out[last].position == tip.position {
        return;
    }
    if last == start {
        if apart(out[start], tip, 0.0) {
            out.push(tip);
        }
    } else if apart(out[last - 1], tip, 0.0) {
        out[last] = tip;
    }
}

/// Whether two stations are further apart than `distance` and [`MIN_EDGE`]; false if one is not finite.
fn apart(a: Station, b: Station, distance: f32) -> bool {
    let squared = a.position.distance_squared(b.position);
    let least = distance.max(MIN_EDGE);
    squared > least * least && squared < f32::INFINITY
}
