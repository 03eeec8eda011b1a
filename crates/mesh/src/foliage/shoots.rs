//! Where the leafy shoots of a tree stand.

use deeptree_graph::{
    BranchGraph, Draws, Lineage, Mat3, Node, NodeId, Purpose, Quat, Seed, Vec3, reaches,
};

use super::habit::Habit;
use crate::circle::square;
use crate::dressed::Leaf;
use crate::look::Look;
use crate::wood::limbs::goes_on;

/// Shoots are not shorter or longer than their species' by more than this share.
const SPREAD: f32 = 0.25;

/// The shoots of a tree by their kinds, node by node.
///
/// They stand on the internodes near the tips. What is drawn for a shoot is keyed by the lineage of
/// its node and its number there: neither other branches nor the density or the season moves it.
/// Coarser levels of detail have some of the shoots, which are larger.
pub(crate) fn shoots(tree: &BranchGraph, habit: &Habit, look: &Look) -> [Vec<Leaf>; KINDS] {
    let seed = Seed(tree.info.seed);
    let reaches = reaches(tree);
    let mut lineages: Vec<Lineage> = Vec::with_capacity(tree.len());
    let mut all = Vec::new();
    for (id, node) in tree.nodes().iter().enumerate() {
        let lineage =
            node.parent.map_or(Lineage::ROOT, |parent| lineages[parent as usize].child(node.slot));
        lineages.push(lineage);
        if reaches[id] < habit.depth && node.length.is_finite() && node.length > 0.0 {
            let draws = seed.draws(lineage, Purpose::Shoots);
            on_internode(tree, id as NodeId, habit, look, &draws, &mut all);
        }
    }
    thinned(all, look)
}

/// How many kinds of shoots a tree has.
pub(crate) const KINDS: usize = 2;

/// A shoot that was drawn.
struct Drawn {
    leaf: Leaf,
    kind: usize,
    /// It is left out where the share of shoots is not above this number in [0, 1).
    detail: f32,
}

/// The shoots of a level of detail and a density, scaled so that they have the area of all times
/// the density; at the finest level and density 1, all of them as they are.
fn thinned(mut all: Vec<Drawn>, look: &Look) -> [Vec<Leaf>; KINDS] {
    let squares = |all: &[Drawn]| -> f64 {
        all.iter().map(|drawn| f64::from(drawn.leaf.scale) * f64::from(drawn.leaf.scale)).sum()
    };
    let share = look.kept() * look.density;
    let wanted = squares(&all) * f64::from(look.density);
    all.retain(|drawn| drawn.detail < share);
    let left = squares(&all);
    let factor = if left > 0.0 { libm::sqrt(wanted / left) as f32 } else { 1.0 };
    let mut kinds = [const { Vec::new() }; KINDS];
    for Drawn { leaf, kind, .. } in all {
        kinds[kind].push(Leaf { scale: leaf.scale * factor, ..leaf });
    }
    kinds
}

/// The curve that the wood of an internode follows, as a cubic Hermite curve.
struct Course {
    ends: [Vec3; 2],
    tangents: [Vec3; 2],
    length: f32,
}

impl Course {
    /// The directions at its ends halve the bends there, as those of the wood's surface do.
    fn of(tree: &BranchGraph, id: NodeId) -> Self {
        let node = tree.node(id);
        let front = node.front();
        let goes_on = |node: &Node| goes_on(tree, node);
        let before = node.parent.map(|parent| tree.node(parent));
        let before =
            before.filter(|&parent| goes_on(parent) == Some(id)).map_or(front, Node::front);
        let after = goes_on(node).map_or(front, |child| tree.node(child).front());
        let halve = |a: Vec3| (a + front).try_normalize().unwrap_or(front);
        Self {
            ends: [node.base(), node.position],
            tangents: [halve(before), halve(after)],
            length: node.length,
        }
    }

    fn at(&self, t: f32) -> Vec3 {
        let (t2, u) = (t * t, 1.0 - t);
        let rise = t2 * (3.0 - 2.0 * t);
        let (from, to) = (self.length * t * u * u, self.length * t2 * u);
        self.ends[0] + (self.ends[1] - self.ends[0]) * rise + self.tangents[0] * from
            - self.tangents[1] * to
    }
}

/// Adds the shoots of one internode, and that at its end if it is a tip.
fn on_internode(
    tree: &BranchGraph,
    id: NodeId,
    habit: &Habit,
    look: &Look,
    draws: &Draws,
    all: &mut Vec<Drawn>,
) {
    let node = tree.node(id);
    let (front, up) = (node.front(), node.up());
    if !(front.is_normalized() && up.is_normalized() && node.position.is_finite()) {
        return;
    }
    let right = front.cross(up);
    let course = Course::of(tree, id);
    let mut own = draws.clone();
    let start = (own.uniform() * core::f64::consts::TAU) as f32;
    let patch = own.index(KINDS);
    // Whole nodes of the shoot's phyllotaxis; what is left over is drawn.
    let many = habit.phyllotaxis.at_a_node();
    let wanted = f64::from(habit.shoots * node.length) / f64::from(many);
    let whorls = (wanted + own.uniform()) as u32;
    for number in 0..whorls * many {
        let whorl = number / many;
        let mut draws = draws.clone().at(u64::from(number) + 1);
        let mut draw = || draws.uniform() as f32;
        let jitter = if many == 1 { 0.5 * (draw() - 0.5) } else { 0.0 };
        let t = (whorl as f32 + 0.5 + jitter) / whorls as f32;
        let angle = start + habit.phyllotaxis.angle(number);
        let (sin, cos) = libm::sincosf(angle);
        let out = right * cos + up * sin;
        let (sin, cos) = libm::sincosf(habit.angle * (0.8 + 0.4 * draw()));
        let along = front * cos + out * sin;
        let foot = course.at(t) + out * (0.6 * node.thickness.max(0.0));
        all.extend(shoot((id, patch), foot, along, out, habit, look, &mut draws));
    }
    if node.child_count() == 0 {
        let mut draws = draws.clone().at(0);
        let foot = node.position - front * 0.01;
        all.extend(shoot((id, patch), foot, front, up, habit, look, &mut draws));
    }
}

/// One shoot, unless it has lost its leaves in a season in which others have theirs: then it is not
/// looked at.
fn shoot(
    (node, patch): (NodeId, usize),
    foot: Vec3,
    along: Vec3,
    out: Vec3,
    habit: &Habit,
    look: &Look,
    draws: &mut Draws,
) -> Option<Drawn> {
    let mut draw = || draws.uniform() as f32;
    let (size, roll) = (draw(), draw() - 0.5);
    let sway = Vec3::new(draw() - 0.5, draw() - 0.5, draw() - 0.5);
    let (detail, fallen, dead, kind) = (draw(), draw(), draw(), draw());
    let alive = 1.0 - 0.75 * (1.0 - look.health);
    let hanging = habit.hanging(look.season);
    let bare = hanging > 0.0 && fallen >= hanging;
    if bare || dead >= alive {
        return None;
    }
    let along = (along + Vec3::Y * habit.light + sway * 0.35).try_normalize()?;
    // The upper side faces the sky, or for shoots that stand upright, what bears them.
    let sky = Vec3::Y - along * along.y;
    let up = (sky + out * -0.25).try_normalize().map_or(out, |up| up);
    let up = square(up, along);
    let right = along.cross(up);
    let (sin, cos) = libm::sincosf(roll * 1.2);
    let (up, right) = (up * cos + right * sin, right * cos - up * sin);
    let grown = habit.unfolded(look.season);
    let scale = habit.whole_length() * (1.0 + SPREAD * (2.0 * size - 1.0)) * grown;
    let rotation = Quat::from_mat3(&Mat3::from_cols(right, up, -along)).normalize();
    // Neighbours are mostly of one kind.
    let kind = if kind < 0.7 { patch } else { 1 - patch };
    Some(Drawn { leaf: Leaf { position: foot, rotation, scale, node }, kind, detail })
}
