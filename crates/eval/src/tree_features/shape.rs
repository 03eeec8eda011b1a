//! Lengths, angles, twists and thicknesses as distributions, and how neighbours go together.

use std::f64::consts::PI;

use deeptree_graph::{BranchGraph, MAX_CHILDREN, Node, Vec3, branches, chains};

use super::recorder::Recorder;

/// Lengths of branches, unbranched runs and edges, in metres.
pub(super) fn distributions(tree: &BranchGraph, out: &mut Recorder) {
    let lengths = |paths: Vec<deeptree_graph::Path>| -> Vec<f64> {
        paths.iter().map(|path| f64::from(path.length(tree))).collect()
    };
    out.distribution("branch_length", lengths(branches(tree)));
    out.distribution("branching_distance", lengths(chains(tree)));
    out.distribution("edge_length", tree.nodes().iter().map(|n| f64::from(n.length)).collect());
    let edges = apical_pairs(tree).map(|(up, node)| (up.length.into(), node.length.into()));
    out.correlation("edge_length/correlation", &edges.collect::<Vec<_>>());
}

/// Angles below this are none, in radians.
const STRAIGHT: f64 = 1e-4;

/// Branching angles by slot, their headings around the parent, and the roll of apical frames.
pub(super) fn angles(tree: &BranchGraph, out: &mut Recorder) {
    for slot in 0..MAX_CHILDREN {
        let bends: Vec<(f64, f64)> =
            children(tree).filter(|node| usize::from(node.slot) == slot).map(bend).collect();
        // What goes straight on has no heading, but for what rounding makes of none.
        let bent = bends.iter().filter(|(angle, _)| *angle > STRAIGHT);
        let headings: Vec<f64> = bent.map(|(_, heading)| *heading).collect();
        let straight = bends.len() - headings.len();
        out.push(
            format!("angle_{}/straight", slot + 1),
            straight as f64 / bends.len().max(1) as f64,
        );
        out.distribution(&format!("angle_{}", slot + 1), bends.iter().map(|b| b.0).collect());
        out.circular(&format!("heading_{}", slot + 1), &headings);
    }
    let rolls: Vec<f64> = children(tree).filter(|node| node.slot == 0).map(roll).collect();
    out.distribution("roll", rolls.iter().map(|roll| roll.abs()).collect());
    out.circular("roll", &rolls);
    out.circular("heading_between_laterals", &between_laterals(tree));
    let bends = apical_pairs(tree).map(|(up, node)| (bend(up).0, bend(node).0));
    out.correlation("angle_1/correlation", &bends.collect::<Vec<_>>());
    let turns: Vec<f64> = apical_pairs(tree).map(|(up, node)| roll(node) - roll(up)).collect();
    out.circular("roll_change", &turns);
}

/// Thicknesses, tips and patterns of children where a node has any.
pub(super) fn forks(tree: &BranchGraph, out: &mut Recorder) {
    let at_forks = || children(tree).filter(|node| node.sibling_count > 1);
    let ratio = |node: &Node| {
        let up = parent(tree, node).map_or(0.0, |up| f64::from(up.thickness));
        if up > 0.0 { f64::from(node.thickness) / up } else { 0.0 }
    };
    let ratios = |lateral: bool| -> Vec<f64> {
        at_forks().filter(|node| (node.slot > 0) == lateral).map(ratio).collect()
    };
    out.distribution("thickness_ratio/apical", ratios(false));
    out.distribution("thickness_ratio/lateral", ratios(true));
    let runs = children(tree).filter(|node| node.sibling_count == 1).map(ratio);
    out.distribution("thickness_ratio/run", runs.collect());
    out.distribution("tips/largest_share", largest_shares(tree));
    patterns(tree, out);
}

/// Share of the nodes with each combination of taken slots: bit `s` of the number is slot `s`.
fn patterns(tree: &BranchGraph, out: &mut Recorder) {
    let mut shares = [0.0; 1 << MAX_CHILDREN];
    for node in tree.nodes() {
        let taken = node.children.iter().enumerate();
        let pattern: usize = taken.map(|(slot, child)| usize::from(child.is_some()) << slot).sum();
        shares[pattern] += 1.0 / tree.len() as f64;
    }
    for (pattern, share) in shares.into_iter().enumerate() {
        out.push(format!("children/{pattern:03b}"), share);
    }
}

/// At each fork, the share of the ends above it that its richest child carries.
fn largest_shares(tree: &BranchGraph) -> Vec<f64> {
    let mut tips = vec![0u32; tree.len()];
    let mut shares = Vec::new();
    // Children come after their parents, so backwards they are counted first.
    for (id, node) in tree.nodes().iter().enumerate().rev() {
        let above = node.children.iter().flatten().map(|&child| tips[child as usize]);
        let (sum, most) = (above.clone().sum::<u32>(), above.max().unwrap_or(0));
        tips[id] = sum.max(1);
        if node.child_count() > 1 {
            shares.push(f64::from(most) / f64::from(sum));
        }
    }
    shares
}

fn parent<'a>(tree: &'a BranchGraph, node: &Node) -> Option<&'a Node> {
    node.parent.map(|id| tree.node(id))
}

fn children(tree: &BranchGraph) -> impl Iterator<Item = &Node> {
    tree.nodes().iter().filter(|node| node.parent.is_some())
}

/// Apical children of apical children, each with its parent; the root is neither.
fn apical_pairs(tree: &BranchGraph) -> impl Iterator<Item = (&Node, &Node)> {
    children(tree).filter(|node| node.slot == 0).filter_map(|node| {
        let up = parent(tree, node)?;
        (up.slot == 0 && up.parent.is_some()).then_some((up, node))
    })
}

/// Angle from the parent's front, and the heading around it, in radians.
fn bend(node: &Node) -> (f64, f64) {
    let [x, y, z] = (node.rotation * Vec3::NEG_Z).to_array().map(f64::from);
    (x.hypot(y).atan2(-z), y.atan2(x))
}

/// The twist of the frame about its parent's front, in (−π, π].
///
/// `2 atan2(q_z, q_w)`: the turn about z of the decomposition of q into swing and twist.
fn roll(node: &Node) -> f64 {
    let (z, w) = (f64::from(node.rotation.z), f64::from(node.rotation.w));
    let twist = 2.0 * z.atan2(w);
    if twist > PI {
        twist - 2.0 * PI
    } else if twist <= -PI {
        twist + 2.0 * PI
    } else {
        twist
    }
}

/// The difference of the headings of two laterals of one node.
fn between_laterals(tree: &BranchGraph) -> Vec<f64> {
    let pair = |node: &Node| match node.children {
        [_, Some(a), Some(b)] => Some(bend(tree.node(b)).1 - bend(tree.node(a)).1),
        _ => None,
    };
    tree.nodes().iter().filter_map(pair).collect()
}
