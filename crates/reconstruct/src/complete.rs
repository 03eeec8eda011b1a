//! What the scanner did not see: the networks grow on where the points end.

use deeptree_graph::{Lineage, MAX_CHILDREN, Node, Plan, Vec3};
use deeptree_infer::{Branchlet, Overflow, Workspace};

use crate::forks::{View, lineage};
use crate::kdtree::KdTree;
use crate::prior::{Asked, Prior};
use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// No node grows nearer to another branch than this, in internodes: what is that near is that branch.
const APART: f32 = 0.45;

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
}

/// Where a completed tree may have branches, in the cloud's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
}

/// Asks the networks, at every internode of the skeleton, which children it has; where one of them
/// goes to a place that no branch is near, it is added, and grows on level by level as the networks
/// say. Nothing leaves the bounds of the cloud, and the tree gets no more wood than those of its shape
/// that the networks know.
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
        let asked: Vec<Asked<'_>> = level
            .iter()
            .map(|s| Asked { node: &s.node, plan: s.plan, lineage: s.lineage })
            .collect();
        let drawn = prior.draw(&asked, work)?;
        let places: Vec<Vec3> = skeleton.joints.iter().map(|joint| joint.position).collect();
        let index = KdTree::new(&places);
        let mut next: Vec<Sprout> = Vec::new();
        for (sprout, branchlet) in level.iter().zip(&drawn) {
            for child in children(sprout, branchlet) {
                let position = prior.in_cloud(child.node.position) + skeleton.joints[0].position;
                let near = |place: Vec3| place.distance(position) < APART * internode;
                let is_free =
                    index.nearest(position).is_none_or(|(i, _)| !near(places[i as usize]))
                        && next
                            .iter()
                            .all(|other| !near(skeleton.joints[other.joint as usize].position));
                let is_within =
                    position.cmpge(bounds.low).all() && position.cmple(bounds.high).all();
                if !is_free || !is_within || missing == 0 {
                    continue;
                }
                missing -= 1;
                let radius = (child.node.thickness * internode)
                    .min(skeleton.joints[sprout.joint as usize].radius);
                let joint = skeleton.joints.len() as u32;
                skeleton.joints.push(Joint { position, parent: sprout.joint, radius });
                next.push(Sprout { joint, ..child });
            }
        }
        level = next;
    }
    Ok(skeleton.joints.len() - before)
}

/// The joints of the skeleton at every internode, and the ends of its branches.
fn sprouts(skeleton: &Skeleton, prior: &Prior<'_>) -> Vec<Sprout> {
    let view = View::new(skeleton, prior.internode());
    let heirs = skeleton.heirs();
    let mut sprouts = Vec::new();
    for branch in skeleton.branches() {
        let mut way = 0.0;
        for &i in &branch {
            let Joint { position, parent, .. } = skeleton.joints[i as usize];
            if parent == NONE {
                continue;
            }
            way += position.distance(skeleton.joints[parent as usize].position);
            let is_end = heirs[i as usize] == NONE;
            if way < prior.internode() && !is_end {
                continue;
            }
            way = 0.0;
            let (node, plan) = prior.node(&view.situation(i));
            let lineage = lineage(i);
            sprouts.push(Sprout { node, plan, lineage, joint: i, is_end });
        }
    }
    sprouts
}

/// The children that were drawn for a sprout; inside a branch the apical one is there already.
fn children<'a>(sprout: &'a Sprout, branchlet: &'a Branchlet) -> impl Iterator<Item = Sprout> + 'a {
    let count = branchlet.children.iter().flatten().count() as u8;
    let up = &sprout.node;
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
        let (plan, lineage) = (branchlet.plans[slot], sprout.lineage.child(slot as u8));
        Some(Sprout { node, plan, lineage, joint: NONE, is_end: true })
    })
}
