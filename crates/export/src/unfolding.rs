//! A tree that unfolds from a seedling: which joints move its surfaces, and when.
//!
//! A few nodes of the tree are joints: the foot, and the tips of the internodes that bear most. A
//! joint stands on its parent until the growth has come that far, travels along its internode, and
//! then stays, while what stands around it swells from nothing to its full size:
//!
//! `p(T) = x_j(T) + k_j(T) (p − x_j)`, with `k_j(T) = (T − τ_j) / (1 − τ_j)` from the time τ_j at
//! which the joint has arrived.
//!
//! Between two joints, the surface is blended by the share of the way: straight wood stays straight
//! and tapers towards the tip that is growing. What lies beyond the joints unfolds with the last one
//! below it. Every longest path below a node gets all the time that is left, so the whole crown
//! grows to the end:
//!
//! `τ_i = τ_p + (1 − τ_p) l_i / (l_i + reach_i + c)`, where reach is the length of the longest path
//! below, and c leaves the tips time to unfold.

use deeptree_graph::{BranchGraph, NodeId, Vec3};

/// The most joints: engines that keep them in a uniform block take as many.
const MAX_JOINTS: usize = 256;
/// The time that the last tips have to unfold, as a path length in shares of the longest path.
const LAST_FLUSH: f32 = 0.15;
/// The size of what has not begun to grow; nothing at all would have no normals.
const BUD: f32 = 1e-3;
/// The latest arrival: what arrives at the end could not swell.
const LATEST: f32 = 0.999;
/// The share of the growth that the seedling has behind it.
const SEEDLING: f32 = 0.02;

/// How a tree unfolds, for [`Document::unfolding`](crate::gltf::Document::unfolding).
#[derive(Clone, Debug)]
pub struct Unfolding {
    joints: Vec<Joint>,
    /// The joint at the tip of each node, or the last one below it.
    of_nodes: Vec<u8>,
    /// The nodes that have a joint of their own.
    own: Vec<bool>,
    seconds: f32,
}

/// A place of the tree that surfaces are moved by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joint {
    /// The joint before it; none of the foot.
    pub(crate) parent: Option<u8>,
    /// Where it stands at last.
    pub(crate) position: Vec3,
    /// When it leaves its parent, and when it has arrived; the growth goes from 0 to 1.
    pub(crate) start: f32,
    pub(crate) arrival: f32,
}

/// Two joints with the weight of each in 255ths, which add up to 255.
pub(crate) type Binding = [(u8, u8); 2];

impl Unfolding {
    /// Plans the growth of a tree in so many seconds.
    ///
    /// # Panics
    ///
    /// When `seconds` is not a number above 0.
    #[must_use]
    pub fn new(tree: &BranchGraph, seconds: f32) -> Self {
        assert!(seconds > 0.0 && seconds.is_finite(), "a growth of {seconds} seconds");
        let arrivals = arrivals(tree);
        let own = most_bearing(tree);
        let foot = Joint { parent: None, position: tree.root().base(), start: 0.0, arrival: 0.0 };
        let mut joints = vec![foot];
        let mut of_nodes: Vec<u8> = Vec::with_capacity(tree.len());
        for (i, node) in tree.nodes().iter().enumerate() {
            let below = node.parent.map_or(0, |parent| of_nodes[parent as usize]);
            if !own[i] {
                of_nodes.push(below);
                continue;
            }
            of_nodes.push(joints.len() as u8);
            joints.push(Joint {
                parent: Some(below),
                position: node.position,
                start: joints[usize::from(below)].arrival,
                arrival: arrivals[i],
            });
        }
        Self { joints, of_nodes, own, seconds }
    }

    pub(crate) fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// What moves a surface that belongs to a node and stands at `place`.
    pub(crate) fn bind(&self, node: NodeId, place: Vec3) -> Binding {
        let at = self.of_nodes[node as usize];
        let joint = &self.joints[usize::from(at)];
        let (Some(below), true) = (joint.parent, self.own[node as usize]) else {
            return [(at, u8::MAX), (0, 0)];
        };
        let from = self.joints[usize::from(below)].position;
        let along = joint.position - from;
        let share = (place - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
        // A share that is no number becomes 0.
        let weight = (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        match weight {
            0 => [(below, u8::MAX), (0, 0)],
            u8::MAX => [(at, u8::MAX), (0, 0)],
            _ => [(at, weight), (below, u8::MAX - weight)],
        }
    }

    /// The times in seconds and the shares of its way at which a joint moves; none where it stands
    /// in its place from the beginning.
    pub(crate) fn way(&self, joint: &Joint) -> Option<[(f32, f32); 2]> {
        self.between(joint.start, joint.arrival)
    }

    /// The times in seconds and the sizes between which a joint swells.
    pub(crate) fn swelling(&self, joint: &Joint) -> Option<[(f32, f32); 2]> {
        let [(begin, small), end] = self.between(joint.arrival, 1.0)?;
        Some([(begin, small.max(BUD)), end])
    }

    /// A rise from 0 to 1 between two times of growth, as far as it is yet to come.
    fn between(&self, start: f32, end: f32) -> Option<[(f32, f32); 2]> {
        let seconds = |time: f32| self.seconds * (time - SEEDLING) / (1.0 - SEEDLING);
        let from = start.max(SEEDLING);
        let (begin, finish) = (seconds(from), seconds(end));
        (finish > begin).then(|| [(begin, (from - start) / (end - start)), (finish, 1.0)])
    }
}

/// When the growth reaches the tip of each node.
fn arrivals(tree: &BranchGraph) -> Vec<f32> {
    let mut reaches = vec![0.0f32; tree.len()];
    for (i, node) in tree.nodes().iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            let reach = node.length + reaches[i];
            reaches[parent as usize] = reaches[parent as usize].max(reach);
        }
    }
    let flush = f64::from((LAST_FLUSH * (tree.root().length + reaches[0])).max(1e-3));
    // The time that is left at each tip.
    let mut left: Vec<f64> = Vec::with_capacity(tree.len());
    for (node, &reach) in tree.nodes().iter().zip(&reaches) {
        let before = node.parent.map_or(1.0, |parent| left[parent as usize]);
        let beyond = f64::from(reach) + flush;
        left.push(before * beyond / (f64::from(node.length) + beyond));
    }
    left.into_iter().map(|left| ((1.0 - left) as f32).min(LATEST)).collect()
}

/// Which nodes get a joint: those with the most nodes above them; with each all below it.
fn most_bearing(tree: &BranchGraph) -> Vec<bool> {
    let mut borne = vec![0u32; tree.len()];
    for (i, node) in tree.nodes().iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            borne[parent as usize] += 1 + borne[i];
        }
    }
    let mut order: Vec<usize> = (0..tree.len()).collect();
    // Stable: of equals the lower one first, which is the parent where they stand in line.
    order.sort_by_key(|&i| std::cmp::Reverse(borne[i]));
    let mut own = vec![false; tree.len()];
    order.iter().take(MAX_JOINTS - 1).for_each(|&i| own[i] = true);
    own
}

#[cfg(test)]
mod tests {
    use deeptree_graph::testing::random_tree;

    use super::*;

    fn place(unfolding: &Unfolding, joint: usize, time: f32) -> (Vec3, f32) {
        let mut at = Vec3::ZERO;
        let mut next = Some(joint as u8);
        while let Some(i) = next {
            let joint = &unfolding.joints[usize::from(i)];
            let from =
                joint.parent.map_or(Vec3::ZERO, |p| unfolding.joints[usize::from(p)].position);
            at += (joint.position - from) * share(unfolding.way(joint), time);
            next = joint.parent;
        }
        (at, share(unfolding.swelling(&unfolding.joints[joint]), time))
    }

    fn share(keys: Option<[(f32, f32); 2]>, time: f32) -> f32 {
        let Some([(a, low), (b, high)]) = keys else { return 1.0 };
        low + (high - low) * ((time - a) / (b - a)).clamp(0.0, 1.0)
    }

    #[test]
    fn at_the_end_everything_has_its_place_and_size() {
        for (seed, nodes) in [(1, 1), (2, 50), (3, 3000)] {
            let tree = random_tree(seed, nodes);
            let unfolding = Unfolding::new(&tree, 4.0);
            assert!(unfolding.joints.len() <= MAX_JOINTS);
            for (i, joint) in unfolding.joints.iter().enumerate() {
                let (at, size) = place(&unfolding, i, 4.0);
                assert!(at.distance(joint.position) < 1e-3 && size == 1.0, "{joint:?} {at} {size}");
            }
        }
    }

    #[test]
    fn growth_goes_from_the_foot_to_the_tips_and_is_never_taken_back() {
        let tree = random_tree(4, 2000);
        let unfolding = Unfolding::new(&tree, 10.0);
        for joint in &unfolding.joints {
            assert!(0.0 <= joint.start && joint.start <= joint.arrival && joint.arrival < 1.0);
            if let Some(below) = joint.parent {
                assert_eq!(joint.start, unfolding.joints[usize::from(below)].arrival);
            }
        }
        let (mut before, mut tallest) = (0.0, 0.0f32);
        for second in 0..=10 {
            let sizes = (0..unfolding.joints.len()).map(|i| place(&unfolding, i, second as f32));
            let (sum, top) = sizes.fold((0.0, 0.0f32), |(s, t), (at, k)| (s + k, t.max(at.y)));
            assert!(sum > before && top >= tallest, "at {second} s: {sum} {top}");
            (before, tallest) = (sum, top);
        }
    }

    #[test]
    fn what_stands_between_two_joints_belongs_to_both() {
        let tree = random_tree(5, 10);
        let unfolding = Unfolding::new(&tree, 1.0);
        let node = tree.node(1);
        let middle = node.base().lerp(node.position, 0.5);
        let [(above, more), (below, less)] = unfolding.bind(1, middle);
        assert_eq!(unfolding.joints[usize::from(above)].position, node.position);
        assert_eq!(Some(below), unfolding.joints[usize::from(above)].parent);
        assert!((127..=128).contains(&more) && more + less == 255, "{more} {less}");
        assert_eq!(unfolding.bind(1, node.position), [(above, 255), (0, 0)]);
    }
}
