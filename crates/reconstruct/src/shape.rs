//! Smooth branches: joints go to the middle of what they cover, and zigzags out.

use deeptree_graph::Vec3;

use crate::skeleton::Skeleton;
use crate::ways::NONE;

/// Moves joints towards the mean of the points they cover and of the joints beside them, and leaves
/// out those that a straight edge does without.
pub(crate) fn shape(skeleton: &mut Skeleton, points: &[Vec3], cover: f32) {
    centre(skeleton, points, cover);
    for _ in 0..2 {
        smooth(skeleton, cover);
    }
    simplify(skeleton, 0.2 * cover);
}

fn centre(skeleton: &mut Skeleton, points: &[Vec3], most: f32) {
    let mut sums = vec![(Vec3::ZERO, 0.0f32); skeleton.joints.len()];
    for (&owner, &point) in skeleton.owner.iter().zip(points) {
        if owner != NONE {
            let (sum, count) = &mut sums[owner as usize];
            *sum += point - skeleton.joints[owner as usize].position;
            *count += 1.0;
        }
    }
    for (joint, (sum, count)) in skeleton.joints.iter_mut().zip(sums).skip(1) {
        let by = sum / (count + 1.0);
        joint.position += by.clamp_length_max(0.5 * most);
    }
}

/// Half of the way to the middle between a joint's parent and the child that goes on.
fn smooth(skeleton: &mut Skeleton, most: f32) {
    let heirs = skeleton.heirs();
    let before: Vec<Vec3> = skeleton.joints.iter().map(|joint| joint.position).collect();
    for (i, joint) in skeleton.joints.iter_mut().enumerate().skip(1) {
        if heirs[i] != NONE {
            let middle = (before[joint.parent as usize] + before[heirs[i] as usize]) / 2.0;
            joint.position += ((middle - joint.position) / 2.0).clamp_length_max(0.5 * most);
        }
    }
}

/// Leaves out joints of one child that lie within a tolerance of the edge that would replace them.
fn simplify(skeleton: &mut Skeleton, tolerance: f32) {
    let children = skeleton.children();
    let mut keep = vec![true; skeleton.joints.len()];
    let is_through = |i: u32| i != 0 && children[i as usize].len() == 1;
    for start in 0..skeleton.joints.len() as u32 {
        if is_through(start) {
            continue;
        }
        for &first in &children[start as usize] {
            let mut run = vec![start, first];
            while is_through(run[run.len() - 1]) {
                run.push(children[run[run.len() - 1] as usize][0]);
            }
            let line: Vec<Vec3> =
                run.iter().map(|&i| skeleton.joints[i as usize].position).collect();
            let mut kept = vec![false; run.len()];
            straighten(&line, tolerance, &mut kept);
            for (&i, kept) in run[1..run.len() - 1].iter().zip(&kept[1..]) {
                keep[i as usize] = *kept;
            }
        }
    }
    skeleton.keep(&keep);
}

/// Douglas and Peucker 1973: keeps of a line what it needs to stay within a tolerance.
fn straighten(line: &[Vec3], tolerance: f32, keep: &mut [bool]) {
    let mut stack = vec![(0, line.len() - 1)];
    while let Some((from, to)) = stack.pop() {
        (keep[from], keep[to]) = (true, true);
        let (a, along) = (line[from], line[to] - line[from]);
        let mut farthest = (tolerance, 0);
        for (i, &p) in line.iter().enumerate().take(to).skip(from + 1) {
            let squared = along.length_squared();
            let share =
                if squared > 0.0 { ((p - a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
            let distance = p.distance(a + along * share);
            if distance > farthest.0 {
                farthest = (distance, i);
            }
        }
        if farthest.1 > 0 {
            stack.push((from, farthest.1));
            stack.push((farthest.1, to));
        }
    }
}
