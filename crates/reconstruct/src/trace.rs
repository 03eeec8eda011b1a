//! Branches are traced along the ways through the cloud until each point is covered.

use deeptree_graph::Vec3;

use crate::kdtree::KdTree;
use crate::skeleton::{Joint, Skeleton};
use crate::ways::{NONE, Ways};

/// How far branches reach and what they may cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tracing<'a> {
    pub(crate) points: &'a [Vec3],
    pub(crate) index: &'a KdTree,
    pub(crate) ways: &'a Ways,
    /// Radius of the wood that each point may lie on, in metres.
    pub(crate) radius: &'a [f32],
    /// Points this near to a branch are covered by it, in metres.
    pub(crate) cover: f32,
    /// Metres of branch across gaps that one more covered point is worth.
    pub(crate) worth: f32,
    /// The widest gap that any branch crosses, in metres.
    pub(crate) widest: f32,
}

/// Adds to a skeleton what it does not cover: from the point whose way is the longest, the way is followed until it
/// meets what stands already; all points near it are covered; and so on from the longest way that
/// is left.
///
/// Wood is covered as far around as it may be thick, and a way that enters it ends at its axis, so
/// that branches do not run down beside the stem. A branch that crosses gaps which are longer than
/// the points beyond them are worth is left out, and so is one across a gap that is too wide for any:
/// what stands there is another tree.
///
/// # Source
///
/// Sato et al. 2000, "TEASAR: tree-structure extraction algorithm for accurate and robust
/// skeletons", on a graph of points.
pub(crate) fn trace(tracing: &Tracing<'_>, skeleton: &mut Skeleton) {
    let ways = tracing.ways;
    let mut tips: Vec<u32> = ways.order.clone();
    tips.sort_by(|&a, &b| {
        let [x, y] = [a, b].map(|i| ways.length[i as usize]);
        y.total_cmp(&x).then(a.cmp(&b))
    });
    let (mut way, mut covered) = (Vec::new(), Vec::new());
    for tip in tips {
        if skeleton.owner[tip as usize] != NONE {
            continue;
        }
        way.clear();
        let mut at = tip;
        while at != NONE && skeleton.owner[at as usize] == NONE {
            way.push(at);
            at = ways.next[at as usize];
        }
        way.reverse();
        let start = if at == NONE { 0 } else { skeleton.owner[at as usize] };
        let joints = tracing.joints(&way, skeleton.joints[start as usize].position);
        tracing.cover(&joints, &skeleton.owner, &mut covered);
        let gaps = tracing.gaps(&joints, skeleton.joints[start as usize].position);
        if gaps.widest <= tracing.widest && gaps.sum <= tracing.worth * covered.len() as f32 {
            let first = skeleton.joints.len() as u32;
            for (i, position) in (0..).zip(joints) {
                let parent = if i == 0 { start } else { first + i - 1 };
                skeleton.joints.push(Joint { position, parent, radius: 0.0 });
            }
            covered.iter().for_each(|&(point, joint)| {
                skeleton.owner[point as usize] = first + joint;
            });
        }
    }
}

impl Tracing<'_> {
    /// Is the wood at a point thick enough that its axis is not where the point is?
    fn is_thick(&self, point: u32) -> bool {
        self.radius[point as usize] > self.cover
    }

    /// The joints along a way: thin wood goes through its points, thick wood through the middle of
    /// the points around.
    fn joints(&self, way: &[u32], start: Vec3) -> Vec<Vec3> {
        let mut joints: Vec<Vec3> = Vec::new();
        let mut near = Vec::new();
        for (i, &point) in way.iter().enumerate() {
            let mut position = self.points[point as usize];
            let radius = self.radius[point as usize];
            if self.is_thick(point) {
                self.index.within(position, 2.0 * radius, &mut near);
                let alike = |k: &&u32| {
                    let apart = self.ways.length[**k as usize] - self.ways.length[point as usize];
                    apart.abs() <= radius
                };
                let level: Vec<Vec3> =
                    near.iter().filter(alike).map(|&k| self.points[k as usize]).collect();
                position = level.iter().sum::<Vec3>() / level.len().max(1) as f32;
            }
            let last = joints.last().copied().unwrap_or(start);
            let step = if self.is_thick(point) { 0.7 * radius } else { 0.3 * self.cover };
            if position.distance(last) > step || i + 1 == way.len() {
                joints.push(position);
            }
        }
        joints
    }

    /// The points near the joints that nothing covers yet, each with the joint nearest to it.
    fn cover(&self, joints: &[Vec3], owner: &[u32], covered: &mut Vec<(u32, u32)>) {
        let (mut near, mut found) = (Vec::new(), Vec::new());
        for (joint, &position) in (0..).zip(joints) {
            let thickness = self.index.nearest(position).map_or(0.0, |(i, _)| {
                let radius = self.radius[i as usize];
                if radius > self.cover { 2.0 * radius } else { 0.0 }
            });
            self.index.within(position, self.cover + thickness, &mut near);
            let free = near.iter().filter(|&&k| owner[k as usize] == NONE);
            found.extend(free.map(|&k| {
                (k, self.points[k as usize].distance_squared(position).to_bits(), joint)
            }));
        }
        found.sort_unstable();
        found.dedup_by_key(|&mut (point, ..)| point);
        covered.clear();
        covered.extend(found.into_iter().map(|(point, _, joint)| (point, joint)));
    }

    /// What of a way's edges is farther from its points than what is covered.
    fn gaps(&self, joints: &[Vec3], start: Vec3) -> Gaps {
        let (mut from, mut gaps) = (start, Gaps { sum: 0.0, widest: 0.0 });
        for &to in joints {
            let gap = (from.distance(to) - 2.0 * self.cover).max(0.0);
            gaps = Gaps { sum: gaps.sum + gap, widest: gaps.widest.max(gap) };
            from = to;
        }
        gaps
    }
}

/// Gaps that a way crosses, in metres.
struct Gaps {
    sum: f32,
    widest: f32,
}
