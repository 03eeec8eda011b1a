//! Radii: from the points where there are enough of them, from the pipe model where not.

use deeptree_graph::{Vec2, Vec3};

use crate::circle::{self, Circle};
use crate::shape::straighten;
use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// What is known of radii before any is measured, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// Of the stem at its foot.
    pub(crate) stem: f32,
    /// Of the thinnest twigs.
    pub(crate) thinnest: f32,
    /// Wood thinner than this does not show as round.
    pub(crate) visible: f32,
}

/// Sets the radius of every joint, and moves joints of thick wood onto its axis.
///
/// Where the points along a stretch of a branch lie on a circle around it, the radius is that of the
/// circle; the median of neighbouring stretches keeps out what hangs beside it. Elsewhere the
/// cross-section is that of the last measured joint below, in the proportion of the metres of wood
/// that both carry. Nothing is thicker than what carries it.
///
/// # Source
///
/// Shinozaki et al. 1964, "A quantitative analysis of plant form: the pipe model theory", with the
/// length of the wood beyond for its pipes.
pub(crate) fn thicken(skeleton: &mut Skeleton, points: &[Vec3], known: &Known) {
    let branches = skeleton.branches();
    let mut expected = expected(skeleton, known, &vec![None; skeleton.joints.len()]);
    let mut measured = vec![None; skeleton.joints.len()];
    for _ in 0..2 {
        let owned = owned(skeleton, points);
        for branch in &branches {
            // Wood that was round a stretch ago is likely to be still, whatever it carries.
            let mut last = 0.0;
            let circles: Vec<Option<Found>> = (0..branch.len())
                .map(|at| {
                    let likely = expected[branch[at] as usize].max(0.8 * last);
                    let found = measure(skeleton, &owned, branch, at, likely, known);
                    last = found.map_or(0.0, |found| found.radius);
                    found
                })
                .collect();
            for (at, &joint) in branch.iter().enumerate() {
                let found = median(&circles[at.saturating_sub(2)..(at + 3).min(circles.len())]);
                measured[joint as usize] = found;
                if let (Some(found), Some(radius)) = (circles[at], found)
                    && joint != 0
                    && (found.radius / radius - 1.0).abs() < 0.35
                {
                    skeleton.joints[joint as usize].position = found.centre;
                }
            }
        }
        expected = self::expected(skeleton, known, &measured);
        for (joint, radius) in skeleton.joints.iter_mut().zip(&expected) {
            joint.radius = *radius;
        }
        // Circles jump a little from stretch to stretch; wood does not.
        let thick =
            |joint: &Joint| if joint.radius < known.visible { 0.0 } else { 2.0 * joint.radius };
        straighten(skeleton, thick);
    }
}

/// The points that each joint covers.
fn owned(skeleton: &Skeleton, points: &[Vec3]) -> Vec<Vec<Vec3>> {
    let mut owned = vec![Vec::new(); skeleton.joints.len()];
    for (&owner, &point) in skeleton.owner.iter().zip(points) {
        if owner != NONE {
            owned[owner as usize].push(point);
        }
    }
    owned
}

/// Radii by the pipe model from what is measured, from the foot outwards.
fn expected(skeleton: &Skeleton, known: &Known, measured: &[Option<f32>]) -> Vec<f32> {
    let beyond = skeleton.lengths_beyond();
    let mut radii: Vec<f32> = vec![measured[0].unwrap_or(known.stem); skeleton.joints.len()];
    for (i, joint) in skeleton.joints.iter().enumerate().skip(1) {
        let parent = joint.parent as usize;
        let share = (beyond[i] / beyond[parent].max(f32::MIN_POSITIVE)).min(1.0);
        let by_pipes = radii[parent] * libm::sqrtf(share);
        // A branch does not taper faster than this, nor swell.
        let radius =
            measured[i].map_or(by_pipes, |found| found.clamp(0.5 * by_pipes, radii[parent]));
        radii[i] = radius.clamp(known.thinnest, radii[parent].max(known.thinnest));
    }
    radii
}

/// A circle in space.
#[derive(Clone, Copy, Debug)]
struct Found {
    centre: Vec3,
    radius: f32,
}

/// The circle around a joint of a branch, by the points along a stretch of it.
fn measure(
    skeleton: &Skeleton,
    owned: &[Vec<Vec3>],
    branch: &[u32],
    at: usize,
    expected: f32,
    known: &Known,
) -> Option<Found> {
    if expected < known.visible {
        return None;
    }
    let place = |k: usize| skeleton.joints[branch[k] as usize].position;
    let reach = 1.5 * expected;
    let here = place(at);
    let near = |k: &usize| place(*k).distance(here) <= reach;
    let first = (0..at).rev().take_while(near).last().unwrap_or(at);
    let last = (at..branch.len()).take_while(near).last().unwrap_or(at);
    let (from, to) = (first.min(at.saturating_sub(1)), (last.max(at + 1)).min(branch.len() - 1));
    let axis = (place(to) - place(from)).try_normalize()?;
    let (u, v) = axis.any_orthonormal_pair();
    let flat: Vec<Vec2> = branch[first..=last]
        .iter()
        .flat_map(|&joint| &owned[joint as usize])
        .map(|&point| point - here)
        .filter(|from| from.dot(axis).abs() <= reach)
        .map(|from| Vec2::new(from.dot(u), from.dot(v)))
        .collect();
    let Circle { centre, radius, error, arc } = circle::fit(&flat)?;
    let is_round = arc >= 0.25 && error < 0.2 * radius && centre.length() < 1.2 * radius;
    let is_likely = (0.4..2.0).contains(&(radius / expected)) && radius >= known.visible;
    (flat.len() >= 8 && is_round && is_likely)
        .then(|| Found { centre: here + u * centre.x + v * centre.y, radius })
}

/// The median radius, if most of the stretches have one.
fn median(found: &[Option<Found>]) -> Option<f32> {
    let mut radii: Vec<f32> = found.iter().flatten().map(|found| found.radius).collect();
    radii.sort_unstable_by(f32::total_cmp);
    (2 * radii.len() > found.len()).then(|| radii[radii.len() / 2])
}
