//! The skeleton on its way to a branch graph: joints with any number of children.

use deeptree_graph::Vec3;

use crate::ways::NONE;

/// A joint of a skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joint {
    pub(crate) position: Vec3,
    /// A joint that stands before this one; [`NONE`] at the root.
    pub(crate) parent: u32,
    /// In metres.
    pub(crate) radius: f32,
}

/// Joints, parents before children, the root first.
#[derive(Clone, Debug)]
pub(crate) struct Skeleton {
    pub(crate) joints: Vec<Joint>,
    /// For each point of the cloud the joint that covers it, or [`NONE`].
    pub(crate) owner: Vec<u32>,
}

impl Skeleton {
    /// Nothing but a root.
    pub(crate) fn new(root: Vec3, points: usize) -> Self {
        let root = Joint { position: root, parent: NONE, radius: 0.0 };
        Self { joints: vec![root], owner: vec![NONE; points] }
    }

    /// The children of each joint.
    pub(crate) fn children(&self) -> Vec<Vec<u32>> {
        let mut children = vec![Vec::new(); self.joints.len()];
        for (i, joint) in (0..).zip(&self.joints) {
            if joint.parent != NONE {
                children[joint.parent as usize].push(i);
            }
        }
        children
    }

    /// Metres of edges at and beyond each joint.
    pub(crate) fn lengths_beyond(&self) -> Vec<f32> {
        let mut beyond = vec![0.0; self.joints.len()];
        for i in (1..self.joints.len()).rev() {
            let Joint { position, parent, .. } = self.joints[i];
            beyond[i] += position.distance(self.joints[parent as usize].position);
            beyond[parent as usize] += beyond[i];
        }
        beyond
    }

    /// For each joint the child that carries the most, which its branch goes on with.
    pub(crate) fn heirs(&self) -> Vec<u32> {
        let beyond = self.lengths_beyond();
        let mut heirs = vec![NONE; self.joints.len()];
        for (i, joint) in (0u32..).zip(&self.joints).skip(1) {
            let heir = &mut heirs[joint.parent as usize];
            if *heir == NONE || beyond[i as usize] > beyond[*heir as usize] {
                *heir = i;
            }
        }
        heirs
    }

    /// The branches: each from where it leaves another one, along the children that carry the most.
    pub(crate) fn branches(&self) -> Vec<Vec<u32>> {
        let heirs = self.heirs();
        let starts = (0..self.joints.len() as u32).filter(|&i| {
            let parent = self.joints[i as usize].parent;
            parent == NONE || heirs[parent as usize] != i
        });
        let next = |&i: &u32| Some(heirs[i as usize]).filter(|&heir| heir != NONE);
        starts.map(|i| std::iter::successors(Some(i), next).collect()).collect()
    }

    /// Keeps the joints for which it holds; children of one that goes join its parent.
    pub(crate) fn keep(&mut self, keep: &[bool]) {
        let mut number = vec![0; self.joints.len()];
        let mut kept: Vec<Joint> = Vec::new();
        for (i, joint) in self.joints.iter().enumerate() {
            let parent = if i == 0 { NONE } else { number[joint.parent as usize] };
            if keep[i] || i == 0 {
                number[i] = kept.len() as u32;
                kept.push(Joint { parent, ..*joint });
            } else {
                number[i] = parent;
            }
        }
        self.joints = kept;
        for owner in self.owner.iter_mut().filter(|owner| **owner != NONE) {
            *owner = number[*owner as usize];
        }
    }
}
