//! The limbs that carry most of a tree: straightened before the twigs are traced from them.

use deeptree_graph::Vec3;

use crate::kdtree::KdTree;
use crate::skeleton::Skeleton;
use crate::ways::NONE;

/// Leaves of a skeleton only what carries at least a share of its metres.
pub(crate) fn limbs(skeleton: &mut Skeleton, share: f32) {
    let beyond = skeleton.lengths_beyond();
    let keep: Vec<bool> = beyond.iter().map(|b| *b >= share * beyond[0]).collect();
    // Parents carry no less than their children, so that what is kept hangs together.
    for (i, joint) in skeleton.joints.iter_mut().enumerate() {
        joint.radius = libm::sqrtf(beyond[i] / beyond[0].max(f32::MIN_POSITIVE));
    }
    skeleton.keep(&keep);
    skeleton.owner.fill(NONE);
}

/// Gives the points around limbs to the nearest joint, adding joints where edges are long.
pub(crate) fn claim(
    skeleton: &mut Skeleton,
    points: &[Vec3],
    index: &KdTree,
    stem: f32,
    cover: f32,
) {
    *skeleton = densified(skeleton, cover);
    let mut nearest = vec![f32::INFINITY; points.len()];
    let mut near = Vec::new();
    for (i, joint) in (0..).zip(&skeleton.joints) {
        let reach = cover + 1.5 * stem * joint.radius;
        index.within(joint.position, reach, &mut near);
        for &k in &near {
            let distance = points[k as usize].distance(joint.position);
            if distance < nearest[k as usize] {
                (nearest[k as usize], skeleton.owner[k as usize]) = (distance, i);
            }
        }
    }
    if skeleton.owner.iter().all(|&owner| owner == NONE)
        && let Some((k, _)) = index.nearest(skeleton.joints[0].position)
    {
        skeleton.owner[k as usize] = 0;
    }
}

/// The same skeleton with joints at most so far apart.
fn densified(skeleton: &Skeleton, step: f32) -> Skeleton {
    let mut dense = Skeleton::new(skeleton.joints[0].position, skeleton.owner.len());
    dense.joints[0].radius = skeleton.joints[0].radius;
    let mut number = vec![0; skeleton.joints.len()];
    for (i, joint) in skeleton.joints.iter().enumerate().skip(1) {
        let from = skeleton.joints[joint.parent as usize].position;
        let parts = libm::ceilf(from.distance(joint.position) / step).clamp(1.0, 1000.0) as u32;
        let mut parent = number[joint.parent as usize];
        for part in 1..=parts {
            let position = from.lerp(joint.position, part as f32 / parts as f32);
            dense.joints.push(crate::skeleton::Joint { position, parent, radius: joint.radius });
            parent = dense.joints.len() as u32 - 1;
        }
        number[i] = parent;
    }
    dense
}
