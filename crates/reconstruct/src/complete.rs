//! What the scanner did not see: the networks grow branches of which no point tells.
//!
//! At every internode of the skeleton, branchlets are drawn again and again. Those that have the
//! children which the skeleton shows count for more. A child is grown where enough of the draws agree
//! that there is one, and on from there, as long as the chance of all that it stands on is high
//! enough: a guess that is as likely wrong as right makes no skeleton better.

use deeptree_graph::{Lineage, MAX_CHILDREN, Node, Plan, Quat, Vec3};
use deeptree_infer::{Branchlet, Overflow, Workspace};

use crate::forks::{View, lineage};
use crate::kdtree::KdTree;
use crate::prior::{Asked, DRAWS, Prior, ln_agreement};
use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// No node grows nearer to another branch than this, in internodes: what is that near is that branch.
const APART: f32 = 0.45;

/// Draws whose children end within this of one another mean the same child, in internodes.
const SAME: f32 = 0.3;

/// The least chance of what is grown. Less gives more branches of which more are wrong.
const CHANCE: f32 = 0.6;

/// A node of what is completed, in the growth space.
#[derive(Clone, Debug)]
struct Sprout {
    node: Node,
    plan: Plan,
    lineage: Lineage,
    /// The joint it stands for.
    joint: u32,
    /// It ends a branch, so that an apical child goes on with it.
    is_end: bool,
    /// Where its children go that the skeleton has.
    seen: Vec<Vec3>,
    /// How likely it is that there is this node.
    chance: f32,
    /// Which way its buds look does not show.
    has_no_roll: bool,
}

/// Where a completed tree may have branches, in the cloud's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
}

/// Asks the networks, at every internode of the skeleton, which children it has; where they agree on
/// one that goes to a place that no branch is near, it is added, and grows on level by level. Nothing
/// leaves the bounds of the cloud, and the tree gets no more wood than those of its shape that the
/// networks know.
///
/// Returns how many joints were added.
///
/// # Errors
///
/// When the model's numbers overflow.
pub(crate) fn complete(
    skeleton: &mut Skeleton,
    prior: &Prior<'_>,
    bounds: Bounds,
    work: &mut Workspace,
) -> Result<usize, Overflow> {
    let internode = prior.internode();
    let before = skeleton.joints.len();
    let wood = skeleton.lengths_beyond()[0] / internode;
    let mut missing = (prior.nodes() - wood).max(0.0) as usize;
    let mut level = sprouts(skeleton, prior);
    while !level.is_empty() && missing > 0 {
        let agreed = agreed(&level, prior, work)?;
        let places: Vec<Vec3> = skeleton.joints.iter().map(|joint| joint.position).collect();
        let index = KdTree::new(&places);
        let mut next: Vec<Sprout> = Vec::new();
        for (sprout, child) in agreed {
            let position = prior.in_cloud(child.node.position) + skeleton.joints[0].position;
            let near = |place: Vec3| place.distance(position) < APART * internode;
            let is_free = index.nearest(position).is_none_or(|(i, _)| !near(places[i as usize]))
                && next.iter().all(|other| !near(skeleton.joints[other.joint as usize].position));
            let is_within = position.cmpge(bounds.low).all() && position.cmple(bounds.high).all();
            if !is_free || !is_within || missing == 0 {
                continue;
            }
            missing -= 1;
            let parent = level[sprout].joint;
            let thickness = child.node.thickness * internode;
            let radius = thickness.min(skeleton.joints[parent as usize].radius);
            let joint = skeleton.joints.len() as u32;
            skeleton.joints.push(Joint { position, parent, radius });
            next.push(Sprout { joint, ..child });
        }
        level = next;
    }
    Ok(skeleton.joints.len() - before)
}

/// The joints of the skeleton where branches leave it and at every internode between, and its ends.
fn sprouts(skeleton: &Skeleton, prior: &Prior<'_>) -> Vec<Sprout> {
    let view = View::new(skeleton, prior.internode());
    let (heirs, forks) = (skeleton.heirs(), view.forks(skeleton));
    let mut children = vec![&[][..]; skeleton.joints.len()];
    forks.iter().for_each(|fork| children[fork.joint as usize] = &fork.children);
    let mut sprouts = Vec::new();
    for branch in skeleton.branches() {
        let mut way = 0.0;
        for &i in &branch {
            let Joint { position, parent, .. } = skeleton.joints[i as usize];
            if parent == NONE {
                continue;
            }
            way += position.distance(skeleton.joints[parent as usize].position);
            let heir = heirs[i as usize];
            let forks = children[i as usize];
            if way < prior.internode() && heir != NONE && forks.is_empty() {
                continue;
            }
            way = 0.0;
            let (node, plan) = prior.node(&view.situation(i));
            let ahead = Some(heir).filter(|&heir| heir != NONE && forks.is_empty());
            let seen = forks.iter().copied().chain(ahead).map(|child| view.towards(i, child));
            sprouts.push(Sprout {
                node,
                plan,
                lineage: lineage(i),
                joint: i,
                is_end: heir == NONE,
                seen: seen.collect(),
                chance: 1.0,
                has_no_roll: true,
            });
        }
    }
    sprouts
}

/// The children that the draws of each sprout agree on, by the number of the sprout.
fn agreed(
    level: &[Sprout],
    prior: &Prior<'_>,
    work: &mut Workspace,
) -> Result<Vec<(usize, Sprout)>, Overflow> {
    let mut all = Vec::new();
    // A few at a time, so that memory is bounded.
    for (first, few) in (0..).step_by(AT_ONCE).zip(level.chunks(AT_ONCE)) {
        let turned: Vec<Node> = few.iter().flat_map(turned).collect();
        let asked = |(i, node)| {
            let (sprout, draw): (&Sprout, _) = (&few[i / DRAWS], (i % DRAWS) as u8);
            Asked { node, plan: sprout.plan, lineage: sprout.lineage.child(draw) }
        };
        let asked: Vec<Asked<'_>> = turned.iter().enumerate().map(asked).collect();
        let drawn = prior.draw(&asked, work)?;
        let each = drawn.chunks_exact(DRAWS).zip(turned.chunks_exact(DRAWS));
        for (i, (sprout, (branchlets, nodes))) in few.iter().zip(each).enumerate() {
            let children = consensus(sprout, nodes, branchlets);
            all.extend(children.into_iter().map(|child| (first + i, child)));
        }
    }
    Ok(all)
}

/// Sprouts whose branchlets are drawn together.
const AT_ONCE: usize = 256;

/// A sprout as it is told at each draw.
fn turned(sprout: &Sprout) -> impl Iterator<Item = Node> + '_ {
    (0..DRAWS).map(|draw| {
        let roll = core::f32::consts::TAU * draw as f32 / DRAWS as f32;
        let roll = if sprout.has_no_roll { roll } else { 0.0 };
        let orientation = (sprout.node.orientation * Quat::from_rotation_z(roll)).normalize();
        Node { orientation, ..sprout.node.clone() }
    })
}

/// The children that enough of the branchlets have, the most likely first.
fn consensus(sprout: &Sprout, nodes: &[Node], branchlets: &[Branchlet]) -> Vec<Sprout> {
    let ln_weight = |(node, branchlet): (&Node, &Branchlet)| -> f32 {
        let fronts: Vec<Vec3> = fronts(node, branchlet).map(|(_, front)| front).collect();
        sprout.seen.iter().map(|&seen| ln_agreement(&fronts, seen)).sum()
    };
    let ln_weights: Vec<f32> = nodes.iter().zip(branchlets).map(ln_weight).collect();
    let most = ln_weights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let weights: Vec<f32> = ln_weights.iter().map(|ln| libm::expf(ln - most)).collect();
    let all: f32 = weights.iter().sum();
    let mut children: Vec<(usize, Sprout)> = Vec::new();
    for (draw, (node, branchlet)) in nodes.iter().zip(branchlets).enumerate() {
        children.extend(grown(sprout, node, branchlet).map(|child| (draw, child)));
    }
    let mut agreed: Vec<Sprout> = Vec::new();
    loop {
        let is_open = |child: &Sprout| agreed.iter().all(|other| !is_same(other, child));
        let mut best: Option<(f32, &Sprout)> = None;
        for (_, child) in children.iter().filter(|(_, child)| is_open(child)) {
            let mut has = [false; DRAWS];
            let same = children.iter().filter(|(_, other)| is_same(other, child));
            same.for_each(|&(draw, _)| has[draw] = true);
            let votes: f32 =
                weights.iter().zip(has).map(|(w, has)| if has { *w } else { 0.0 }).sum();
            if best.is_none_or(|(most, _)| votes > most) {
                best = Some((votes, child));
            }
        }
        let Some((votes, child)) = best else { return agreed };
        let chance = sprout.chance * votes / all;
        if chance < CHANCE || agreed.len() == MAX_CHILDREN {
            return agreed;
        }
        agreed.push(Sprout { chance, ..child.clone() });
    }
}

/// Do two children end at the same place?
fn is_same(a: &Sprout, b: &Sprout) -> bool {
    a.node.position.distance(b.node.position) < SAME
}

/// Slots and directions of the children of a branchlet.
fn fronts<'a>(
    node: &'a Node,
    branchlet: &'a Branchlet,
) -> impl Iterator<Item = (usize, Vec3)> + 'a {
    let front = |child: Quat| node.orientation * child * Vec3::NEG_Z;
    (0..MAX_CHILDREN)
        .filter_map(move |slot| Some((slot, front(branchlet.children[slot]?.rotation))))
}

/// The children that were drawn for a sprout; inside a branch the apical one is there already.
fn grown<'a>(
    sprout: &'a Sprout,
    up: &'a Node,
    branchlet: &'a Branchlet,
) -> impl Iterator<Item = Sprout> + 'a {
    let count = branchlet.children.iter().flatten().count() as u8;
    (0..MAX_CHILDREN).filter(|&slot| slot > 0 || sprout.is_end).filter_map(move |slot| {
        let child = branchlet.children[slot]?;
        let orientation = (up.orientation * child.rotation).normalize();
        let is_lateral = slot > 0;
        let distance = |from: f32, is_new: bool| if is_new { 0.0 } else { from } + child.length;
        let node = Node {
            slot: slot as u8,
            order: up.order.saturating_add(u16::from(is_lateral)),
            sibling_count: count,
            position: up.position + child.length * (orientation * Vec3::NEG_Z),
            thickness: child.thickness,
            root_distance: up.root_distance + child.length,
            branch_distance: distance(up.branch_distance, is_lateral),
            fork_distance: distance(up.fork_distance, count > 1),
            rotation: child.rotation,
            orientation,
            length: child.length,
            ..up.clone()
        };
        Some(Sprout {
            node,
            plan: branchlet.plans[slot],
            lineage: sprout.lineage.child(slot as u8),
            joint: NONE,
            is_end: true,
            seen: Vec::new(),
            chance: 0.0,
            has_no_roll: false,
        })
    })
}
