//! Size of the tree, and where in the crown its nodes are.

use deeptree_graph::{BranchGraph, Node, branches};

use super::recorder::{Recorder, mean};

/// Bins of the height and of the radius.
const BINS: usize = 10;
/// Headings over half a turn in which the crown's width is taken.
const HEADINGS: u32 = 16;

/// A node's tip seen from the foot of the tree, in metres.
#[derive(Clone, Copy)]
struct Place {
    x: f64,
    z: f64,
    height: f64,
    radius: f64,
}

fn place(tree: &BranchGraph, node: &Node) -> Place {
    let at = node.position - tree.root().base();
    let [x, height, z] = at.to_array().map(f64::from);
    Place { x, z, height, radius: x.hypot(z) }
}

fn places(tree: &BranchGraph) -> Vec<Place> {
    tree.nodes().iter().map(|node| place(tree, node)).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// Counts, extents, trunk and paths.
pub(super) fn size(tree: &BranchGraph, out: &mut Recorder) {
    let places = places(tree);
    let ends: Vec<f64> = tree
        .nodes()
        .iter()
        .filter(|node| node.child_count() == 0)
        .map(|node| f64::from(node.root_distance))
        .collect();
    let branches = branches(tree);
    let height = largest(places.iter().map(|place| place.height));
    out.push("nodes", tree.len() as f64);
    out.push("branches", branches.len() as f64);
    out.push("ends", ends.len() as f64);
    out.push("nodes_by_end", tree.len() as f64 / ends.len() as f64);
    out.push("order/max", largest(tree.nodes().iter().map(|node| f64::from(node.order))));
    out.push("height", height);
    out.push("crown/base", crown_base(tree, height));
    widths(&places, out);
    trunk(tree, &branches[0].nodes, height, out);
    out.distribution("path", ends.clone());
    out.push("path/max", largest(ends.into_iter()));
}

/// Height of the lowest fork by the height of the tree; 1 without a fork.
fn crown_base(tree: &BranchGraph, height: f64) -> f64 {
    let forks = tree.nodes().iter().filter(|node| node.child_count() > 1);
    let lowest = forks.map(|node| place(tree, node).height).fold(height, f64::min);
    lowest / height
}

/// Radius and widths: extents along [`HEADINGS`] horizontal directions.
fn widths(places: &[Place], out: &mut Recorder) {
    let width = |heading: u32| {
        let angle = f64::from(heading) / f64::from(HEADINGS) * std::f64::consts::PI;
        let (sin, cos) = angle.sin_cos();
        // From the foot, which is part of the tree: both ends start at 0.
        let (low, high) = places
            .iter()
            .map(|place| place.x * cos + place.z * sin)
            .fold((0.0f64, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    let widths: Vec<f64> = (0..HEADINGS).map(width).collect();
    let widest = largest(widths.iter().copied());
    out.push("crown/radius", largest(places.iter().map(|place| place.radius)));
    out.push("crown/width", mean(&widths));
    out.push("crown/roundness", widths.iter().copied().fold(widest, f64::min) / widest);
}

/// The branch of order 0: length, radius at the foot, share of the height, lean, straightness.
fn trunk(tree: &BranchGraph, nodes: &[u32], height: f64, out: &mut Recorder) {
    let tip = tree.node(nodes[nodes.len() - 1]);
    let at = place(tree, tip);
    let length = f64::from(tip.root_distance);
    out.push("trunk/nodes", nodes.len() as f64);
    out.push("trunk/length", length);
    out.push("trunk/thickness", f64::from(tree.root().thickness));
    out.push("trunk/height_share", at.height / height);
    out.push("trunk/lean", at.radius / length);
    out.push("trunk/straightness", at.radius.hypot(at.height) / length);
}

/// How far the crown is off its axis, and how unevenly its nodes surround it.
pub(super) fn lean(tree: &BranchGraph, out: &mut Recorder) {
    let all = places(tree);
    let ends: Vec<Place> = tree
        .nodes()
        .iter()
        .filter(|node| node.child_count() == 0)
        .map(|node| place(tree, node))
        .collect();
    for (name, places) in [("nodes", all), ("ends", ends)] {
        // |Σ r| / Σ |r|: 0 for a balanced crown, 1 for a flag.
        let by_radius = |place: &Place| place.radius;
        out.push(format!("lean/{name}"), resultant(&places, 1.0, by_radius));
        out.push(format!("azimuth/{name}/1"), resultant(&places, 1.0, |_| 1.0));
        out.push(format!("azimuth/{name}/2"), resultant(&places, 2.0, |_| 1.0));
    }
}

/// `|Σ w e^(i k φ)| / Σ w` over the nodes off the axis.
fn resultant(places: &[Place], k: f64, weight: impl Fn(&Place) -> f64) -> f64 {
    let (mut x, mut z, mut total) = (0.0, 0.0, 0.0);
    for place in places.iter().filter(|place| place.radius > 1e-6) {
        let (sin, cos) = (k * place.z.atan2(place.x)).sin_cos();
        let w = weight(place);
        (x, z, total) = (x + w * cos, z + w * sin, total + w);
    }
    if total > 0.0 { x.hypot(z) / total } else { 0.0 }
}

/// Shares of the nodes by height and by radius, in tenths of the largest.
pub(super) fn histograms(tree: &BranchGraph, out: &mut Recorder) {
    let places = places(tree);
    let heights: Vec<f64> = places.iter().map(|place| place.height).collect();
    let radii: Vec<f64> = places.iter().map(|place| place.radius).collect();
    for (name, values) in [("at_height", heights), ("at_radius", radii)] {
        let most = largest(values.iter().copied());
        let mut shares = [0.0; BINS];
        for value in &values {
            // Nodes below the foot count as at it; 0 / 0 of a stump too.
            let bin = (value / most * BINS as f64).max(0.0) as usize;
            shares[bin.min(BINS - 1)] += 1.0 / values.len() as f64;
        }
        let relative: Vec<f64> = values.iter().map(|value| value / most).collect();
        out.distribution(name, if most > 0.0 { relative } else { Vec::new() });
        for (bin, share) in shares.into_iter().enumerate() {
            out.push(format!("{name}/bin{bin}"), share);
        }
    }
}
