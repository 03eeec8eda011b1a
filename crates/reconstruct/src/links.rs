//! Which wood a piece of wood across a gap grows from.
//!
//! Ways through a cloud cross a gap where it is narrowest. Branches leave theirs at a slant and keep
//! their direction, so that a piece hangs better from a place farther back, or from another branch.

use deeptree_graph::Vec3;

use crate::kdtree::KdTree;
use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// Edges are gaps from this length on, as a share of the cloud's longest side.
const GAP: f32 = 0.006;

/// A piece may hang across so many times the gap that it hangs across now, and across no more than
/// this share of the cloud's longest side.
const WIDER: f32 = 2.0;
const WIDEST: f32 = 0.08;

/// Directions are those of so much wood, as a share of the cloud's longest side.
const STRETCH: f32 = 0.02;

/// Hangs what stands across a gap from the joint that it grows from most likely: of those around, the
/// one from which the edge is the shortest, where an edge costs `length · (3 − cos α − cos β)` with its
/// angles α to the wood it leads to, as far as that shows, and β to the wood it comes from.
pub(crate) fn relink(skeleton: &mut Skeleton, side: f32) {
    let places: Vec<Vec3> = skeleton.joints.iter().map(|joint| joint.position).collect();
    let index = KdTree::new(&places);
    let heirs = skeleton.heirs();
    let mut tree = Links {
        parents: skeleton.joints.iter().map(|joint| joint.parent).collect(),
        places,
        stretch: STRETCH * side,
    };
    let mut near = Vec::new();
    for joint in 1..tree.places.len() as u32 {
        let own = tree.parents[joint as usize];
        let here = tree.places[joint as usize];
        let gap = here.distance(tree.places[own as usize]);
        if gap < GAP * side {
            continue;
        }
        let ahead = tree.towards(joint, |i| heirs[i as usize]);
        index.within(here, (WIDER * gap).min(WIDEST * side), &mut near);
        let mut best = (tree.cost(joint, ahead, own), own);
        for &other in near.iter().filter(|&&other| other != joint && other != own) {
            let cost = tree.cost(joint, ahead, other);
            if cost < best.0 && !tree.is_below(other, joint) {
                best = (cost, other);
            }
        }
        tree.parents[joint as usize] = best.1;
    }
    reparent(skeleton, &tree.parents);
}

/// A skeleton whose joints are hung elsewhere.
struct Links {
    places: Vec<Vec3>,
    parents: Vec<u32>,
    /// Metres that directions are taken over.
    stretch: f32,
}

impl Links {
    /// What it costs that a joint hangs from another, in metres.
    fn cost(&self, joint: u32, ahead: Option<Vec3>, from: u32) -> f32 {
        let edge = self.places[joint as usize] - self.places[from as usize];
        let Some(along) = edge.try_normalize() else { return 0.0 };
        let bend = ahead.map_or(0.0, |ahead| 1.0 - ahead.dot(along));
        // Towards the foot, so that it is against the way that wood grows.
        let back = self.towards(from, |i| self.parents[i as usize]);
        let slant = back.map_or(0.0, |back| 1.0 + back.dot(along));
        edge.length() * (1.0 + bend + slant)
    }

    /// The direction from a joint along a chain, over a stretch.
    fn towards(&self, from: u32, next: impl Fn(u32) -> u32) -> Option<Vec3> {
        let place = |i: u32| self.places[i as usize];
        let (mut at, mut way) = (from, 0.0);
        while next(at) != NONE && way < self.stretch {
            let to = next(at);
            way += place(at).distance(place(to));
            at = to;
        }
        (place(at) - place(from)).try_normalize()
    }

    /// Does a joint hang from another one, or is it that one?
    fn is_below(&self, joint: u32, other: u32) -> bool {
        let up = |&i: &u32| Some(self.parents[i as usize]).filter(|&parent| parent != NONE);
        std::iter::successors(Some(joint), up).any(|i| i == other)
    }
}

/// The same joints with other parents, again in an order that has parents before children.
fn reparent(skeleton: &mut Skeleton, parents: &[u32]) {
    let mut children = vec![Vec::new(); parents.len()];
    for (i, &parent) in (0u32..).zip(parents).skip(1) {
        children[parent as usize].push(i);
    }
    let mut order = vec![0u32];
    let mut at = 0;
    while at < order.len() {
        order.extend(&children[order[at] as usize]);
        at += 1;
    }
    let mut number = vec![NONE; parents.len()];
    (0..).zip(&order).for_each(|(new, &old)| number[old as usize] = new);
    let numbered = |old: u32| if old == NONE { NONE } else { number[old as usize] };
    let joint = |&old: &u32| {
        let parent = numbered(parents[old as usize]);
        Joint { parent, ..skeleton.joints[old as usize] }
    };
    skeleton.joints = order.iter().map(joint).collect();
    skeleton.owner.iter_mut().for_each(|owner| *owner = numbered(*owner));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stem of 10 m and a twig at 45° to it, of which the first half metre was not seen.
    fn twig(first: f32) -> Skeleton {
        let mut skeleton = Skeleton::new(Vec3::ZERO, 2);
        let mut push = |position, parent| {
            skeleton.joints.push(Joint { position, parent, radius: 0.0 });
            skeleton.joints.len() as u32 - 1
        };
        let stem: Vec<u32> = (1..=200).map(|i| push(Vec3::Y * (i as f32 * 0.05), i - 1)).collect();
        let mut at = stem[99 + (20.0 * first) as usize];
        for i in 0..30 {
            at = push(Vec3::new(1.0, 1.0, 0.0) * (first + i as f32 * 0.035) + Vec3::Y * 5.0, at);
        }
        skeleton.owner[1] = at;
        skeleton
    }

    #[test]
    fn a_twig_leaves_its_stem_at_the_slant_that_it_has() {
        // Beside its first seen point, at 5.5 m, the stem is nearest; the twig starts at 5 m.
        let mut skeleton = twig(0.5);
        let before = skeleton.clone();
        relink(&mut skeleton, 10.0);
        let (start, first) = skeleton
            .joints
            .iter()
            .filter(|joint| joint.position.x > 0.0)
            .map(|joint| (skeleton.joints[joint.parent as usize].position, joint.position))
            .find(|(start, _)| start.x == 0.0)
            .unwrap();
        assert!((4.9..5.3).contains(&start.y), "{start}");
        assert_eq!(first, Vec3::new(0.5, 5.5, 0.0));
        assert_eq!(skeleton.joints.len(), before.joints.len());
        for (i, joint) in (0..).zip(&skeleton.joints).skip(1) {
            assert!(joint.parent < i);
        }
        // Nothing but that first point hangs elsewhere.
        let hangs = |s: &Skeleton, place: Vec3| {
            let joint = s.joints.iter().find(|joint| joint.position == place).unwrap();
            s.joints[joint.parent as usize].position
        };
        for joint in &before.joints[1..] {
            let place = joint.position;
            assert_eq!(hangs(&before, place) != hangs(&skeleton, place), place == first, "{place}");
        }
        // What covers a point covers it still.
        let [old, new] = [&before, &skeleton].map(|s| s.joints[s.owner[1] as usize].position);
        assert_eq!((old, skeleton.owner[0]), (new, NONE));
    }

    #[test]
    fn wood_without_gaps_stays_as_it_is() {
        let mut skeleton = twig(0.0);
        skeleton.joints.truncate(201);
        skeleton.owner.fill(NONE);
        let before = skeleton.joints.clone();
        relink(&mut skeleton, 100.0);
        assert_eq!(skeleton.joints, before);
    }
}
