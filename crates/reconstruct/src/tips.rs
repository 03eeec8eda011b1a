//! Where points end, wood seldom does: the networks say which twigs grow on.
//!
//! The last point of a twig lies somewhere on its last internode. A twig that the networks expect where
//! it is goes on by a part of an internode, but by no more than the mean way between two of its own
//! points: what reached farther would have been met again. That is what the empty space beyond a twig
//! tells, without knowing where the scanner stood.

use deeptree_graph::Vec3;
use deeptree_infer::{Overflow, Workspace};

use crate::forks::View;
use crate::prior::{Prior, Situation};
use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// Shorter twigs, in internodes, do not show where they lead.
const LONG: f32 = 0.4;

/// A twig goes on by this part of an internode at most: farther on, half of the wood or more is wrong.
const ON: f32 = 0.3;

/// The logarithm of how many children a steradian the networks must expect where a twig is.
const EXPECTED: f32 = -1.5;

/// The end of a twig.
struct End {
    joint: u32,
    /// The joint an internode below it.
    base: u32,
    /// Unit direction from there.
    front: Vec3,
    /// Metres since the last fork, of the last internode or a step more, and the points along them.
    way: f32,
    points: u32,
}

impl End {
    /// How far it goes on, in metres.
    fn step(&self, internode: f32) -> f32 {
        (ON * internode).min(self.way / self.points.max(1) as f32)
    }
}

/// Grows the ends of twigs on, but for what would hang lower than the points do; returns how many
/// joints were added.
///
/// # Errors
///
/// When the model's numbers overflow.
pub(crate) fn grow_on(
    skeleton: &mut Skeleton,
    prior: &Prior<'_>,
    lowest: f32,
    work: &mut Workspace,
) -> Result<usize, Overflow> {
    let internode = prior.internode();
    let ends = ends(skeleton, internode);
    let view = View::new(skeleton, internode);
    let situations: Vec<Situation> = ends.iter().map(|end| view.situation(end.base)).collect();
    let expected = prior.expect(&situations, work)?;
    let before = skeleton.joints.len();
    for (end, expected) in ends.iter().zip(&expected) {
        if expected.ln_density(end.front) > EXPECTED {
            let Joint { position, radius, .. } = skeleton.joints[end.joint as usize];
            let position = position + end.step(internode) * end.front;
            if position.y >= lowest {
                skeleton.joints.push(Joint { position, parent: end.joint, radius });
            }
        }
    }
    Ok(skeleton.joints.len() - before)
}

/// The ends of twigs that are long enough.
fn ends(skeleton: &Skeleton, internode: f32) -> Vec<End> {
    let children = skeleton.children();
    let mut points = vec![0; skeleton.joints.len()];
    let owners = skeleton.owner.iter().filter(|&&owner| owner != NONE);
    owners.for_each(|&owner| points[owner as usize] += 1);
    let place = |i: u32| skeleton.joints[i as usize].position;
    let end = |joint: u32| {
        let mut end = End { joint, base: joint, front: Vec3::ZERO, way: 0.0, points: 0 };
        let (mut whole, mut is_forked) = (0.0, false);
        while skeleton.joints[end.base as usize].parent != NONE && whole < internode {
            let up = skeleton.joints[end.base as usize].parent;
            let step = place(end.base).distance(place(up));
            whole += step;
            if !is_forked {
                end.way += step;
                end.points += points[end.base as usize];
            }
            end.base = up;
            is_forked |= children[up as usize].len() > 1;
        }
        end.front = (place(joint) - place(end.base)).try_normalize()?;
        (end.way >= LONG * internode).then_some(end)
    };
    let is_end = |i: &u32| children[*i as usize].is_empty();
    (1..skeleton.joints.len() as u32).filter(is_end).filter_map(end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twig_goes_on_no_farther_than_its_points_lie_apart() {
        let end = |way, points| End { joint: 1, base: 0, front: Vec3::X, way, points }.step(0.5);
        assert_eq!([end(1.0, 0), end(1.0, 1), end(1.0, 10)], [0.15, 0.15, 0.1]);
    }

    #[test]
    fn ends_are_told_by_what_is_behind_them() {
        // A stem of 4 m with a twig of 1 m at 3 m, and a stub of 0.2 m at 2 m.
        let mut skeleton = Skeleton::new(Vec3::ZERO, 7);
        let mut push = |position, parent| {
            skeleton.joints.push(Joint { position, parent, radius: 0.0 });
            skeleton.joints.len() as u32 - 1
        };
        let stem: Vec<u32> = (1..=4).map(|i| push(Vec3::Y * i as f32, i - 1)).collect();
        let middle = push(Vec3::new(0.5, 3.0, 0.0), stem[2]);
        let twig = push(Vec3::new(1.0, 3.0, 0.0), middle);
        push(Vec3::new(0.2, 2.0, 0.0), stem[1]);
        skeleton.owner = vec![0, stem[2], middle, twig, twig, twig, NONE];
        let ends = ends(&skeleton, 1.0);
        let found: Vec<_> =
            ends.iter().map(|e| (e.joint, e.base, e.front, e.way, e.points)).collect();
        assert_eq!(found, [(stem[3], stem[2], Vec3::Y, 1.0, 0), (twig, stem[2], Vec3::X, 1.0, 4)]);
    }
}
