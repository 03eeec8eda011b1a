//! Smooth branches: joints go to the middle of what they cover, and zigzags out.

use deeptree_graph::Vec3;

use crate::skeleton::{Joint, Skeleton};
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

/// Takes bends out of branches: each joint goes to the mean of its branch, over so many metres to both
/// sides as `reach` says of it. Ends stay where they are.
pub(crate) fn straighten(skeleton: &mut Skeleton, reach: impl Fn(&Joint) -> f32) {
    for branch in skeleton.branches() {
        let parent = skeleton.joints[branch[0] as usize].parent;
        let start = (parent != NONE).then_some(parent);
        let place = |&i: &u32| skeleton.joints[i as usize].position;
        let line: Vec<Vec3> = start.iter().chain(&branch).map(place).collect();
        let mut along = vec![0.0; line.len()];
        for i in 1..line.len() {
            along[i] = along[i - 1] + line[i].distance(line[i - 1]);
        }
        let whole = along[line.len() - 1];
        for (&i, at) in branch.iter().zip(line.len() - branch.len()..) {
            let joint = &mut skeleton.joints[i as usize];
            // Symmetric, so that no end moves inwards.
            let reach = reach(joint).min(along[at]).min(whole - along[at]);
            joint.position = mean(&line, &along, at, reach);
        }
    }
}

/// The mean of a line over so many metres to both sides of one of its corners.
fn mean(line: &[Vec3], along: &[f32], at: usize, reach: f32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    let mut length = 0.0;
    let (low, high) = (along[at] - reach, along[at] + reach);
    let first = along.partition_point(|&s| s <= low).saturating_sub(1);
    for i in first..line.len() - 1 {
        let (from, to) = (along[i].max(low), along[i + 1].min(high));
        if along[i] >= high {
            break;
        }
        let step = along[i + 1] - along[i];
        if to > from && step > 0.0 {
            let middle = ((from + to) / 2.0 - along[i]) / step;
            sum += line[i].lerp(line[i + 1], middle) * (to - from);
            length += to - from;
        }
    }
    if length > 0.0 { sum / length } else { line[at] }
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
            needed(&line, tolerance, &mut kept);
            for (&i, kept) in run[1..run.len() - 1].iter().zip(&kept[1..]) {
                keep[i as usize] = *kept;
            }
        }
    }
    skeleton.keep(&keep);
}

/// Douglas and Peucker 1973: keeps of a line what it needs to stay within a tolerance.
fn needed(line: &[Vec3], tolerance: f32, keep: &mut [bool]) {
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
