//! The branch graph G = {N, E} (§4.1 of the paper).

use glam::{Quat, Vec3};

/// The children a node can have: slot 0 is the apical child, slots 1 and 2 the lateral buds.
pub const MAX_CHILDREN: usize = 3;

/// Index of a node in [`BranchGraph::nodes`].
pub type NodeId = u32;

/// What all nodes of a tree share: age a, gravitropism v and species s of Eq. 1, and the seed.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeInfo {
    /// Species s, by name.
    pub species: String,
    /// Age a in growth cycles.
    pub age: u32,
    /// Gravitropism v: negative grows up, positive droops.
    pub gravitropism: f32,
    /// The seed the tree was drawn from (0 for a tree that was not drawn).
    pub seed: u64,
}

/// The output signature u = (q, t, l) of a child (§4.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChildSignature {
    /// q: orientation against the parent's frame, a unit quaternion.
    pub rotation: Quat,
    /// t: radius in metres.
    pub thickness: f32,
    /// l: length of the edge from the parent in metres.
    pub length: f32,
}

/// A node n with the attributes of Eq. 1 (without a, v, s, which [`TreeInfo`] holds for the whole
/// tree), its place in the graph, and what follows from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The parent; none at the root.
    pub parent: Option<NodeId>,
    /// Children by slot. Slots are independent: slot 2 may be taken while slot 1 is empty.
    pub children: [Option<NodeId>; MAX_CHILDREN],
    /// The slot of this node in its parent; 0 at the root.
    pub slot: u8,
    /// o: Gravelius order; the trunk has 0, a lateral one more than its parent (at most 65535).
    pub order: u16,
    /// m_p: how many children the parent has; 1 at the root.
    pub sibling_count: u8,
    /// p: the tip of the internode, in metres, y up.
    pub position: Vec3,
    /// t: radius in metres.
    pub thickness: f32,
    /// d_r: path length from the foot of the tree to the tip, in metres.
    pub root_distance: f32,
    /// d_s: path length from the start of the branch to the tip, in metres.
    pub branch_distance: f32,
    /// Path length from the last fork (an ancestor with two or more children) to the tip, in metres.
    pub fork_distance: f32,
    /// q_p: orientation against the parent's frame (the world's at the root).
    pub rotation: Quat,
    /// Orientation in the world: the product of the rotations from the root.
    pub orientation: Quat,
    /// l_p: length of the edge from the parent in metres.
    pub length: f32,
}

impl Node {
    /// d_front of Eq. 7: `R · [0, 0, −1]`, in the world.
    #[must_use]
    pub fn front(&self) -> Vec3 {
        self.orientation * Vec3::NEG_Z
    }

    /// d_up of Eq. 7: `R · [0, 1, 0]`, in the world.
    #[must_use]
    pub fn up(&self) -> Vec3 {
        self.orientation * Vec3::Y
    }

    /// Where the edge to this node starts: the parent's tip, or the foot of the tree.
    #[must_use]
    pub fn base(&self) -> Vec3 {
        self.position - self.length * self.front()
    }

    /// What [`BranchGraph::grow`] makes this node again of, below the same parent.
    #[must_use]
    pub const fn as_child(&self) -> ChildSignature {
        let Self { rotation, thickness, length, .. } = *self;
        ChildSignature { rotation, thickness, length }
    }

    /// How many children the node has.
    #[must_use]
    pub fn child_count(&self) -> u8 {
        self.children.iter().flatten().count() as u8
    }
}

/// A tree: nodes in level order (parents before children, siblings by slot), node 0 the root.
///
/// Grown branchlet by branchlet, so that all derived attributes are right by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchGraph {
    /// What all nodes share.
    pub info: TreeInfo,
    nodes: Vec<Node>,
}

impl BranchGraph {
    /// A tree of one node, whose edge starts at `foot`.
    ///
    /// The root's `rotation` is its orientation in the world.
    #[must_use]
    pub fn new(info: TreeInfo, foot: Vec3, root: ChildSignature) -> Self {
        let length = root.length;
        let tip = foot + length * (root.rotation * Vec3::NEG_Z);
        Self::with_root_tip(info, tip, root)
    }

    /// As [`Self::new`], given where the root's edge ends: a tip that was written to a file comes
    /// back as the same bits, which it would not by way of the foot.
    pub(crate) fn with_root_tip(info: TreeInfo, tip: Vec3, root: ChildSignature) -> Self {
        let node = Node {
            parent: None,
            children: [None; MAX_CHILDREN],
            slot: 0,
            order: 0,
            sibling_count: 1,
            position: tip,
            thickness: root.thickness,
            root_distance: root.length,
            branch_distance: root.length,
            fork_distance: root.length,
            rotation: root.rotation,
            orientation: root.rotation,
            length: root.length,
        };
        Self { info, nodes: vec![node] }
    }

    /// The root by itself: a tree that [`Self::grow`] makes this one again of.
    #[must_use]
    pub fn root_only(&self) -> Self {
        Self::with_root_tip(self.info.clone(), self.root().position, self.root().as_child())
    }

    /// The same tree with its foot moved by this many metres.
    #[must_use]
    pub fn moved(mut self, by: Vec3) -> Self {
        for node in &mut self.nodes {
            node.position += by;
        }
        self
    }

    /// Adds the branchlet of `parent`: up to three children at once.
    ///
    /// `p_child = p + l · R(q_parent · q) · [0, 0, −1]`
    ///
    /// # Panics
    ///
    /// When `parent` is not a node, or has children already.
    ///
    /// # Source
    ///
    /// DeepTree §4.3, Eq. 6 and 7, with R the rotation accumulated from the root (the paper leaves
    /// open whether R is local).
    pub fn grow(
        &mut self,
        parent: NodeId,
        children: [Option<ChildSignature>; MAX_CHILDREN],
    ) -> [Option<NodeId>; MAX_CHILDREN] {
        let up = self.nodes[parent as usize].clone();
        assert_eq!(up.child_count(), 0, "node {parent} has its children already");
        let sibling_count = children.iter().flatten().count() as u8;
        let mut ids = [None; MAX_CHILDREN];
        for (slot, child) in children.iter().enumerate() {
            let Some(child) = child else { continue };
            let orientation = (up.orientation * child.rotation).normalize();
            let lateral = slot > 0;
            ids[slot] = Some(self.nodes.len() as NodeId);
            self.nodes.push(Node {
                parent: Some(parent),
                children: [None; MAX_CHILDREN],
                slot: slot as u8,
                order: up.order.saturating_add(u16::from(lateral)),
                sibling_count,
                position: up.position + child.length * (orientation * Vec3::NEG_Z),
                thickness: child.thickness,
                root_distance: up.root_distance + child.length,
                branch_distance: if lateral { 0.0 } else { up.branch_distance } + child.length,
                fork_distance: if sibling_count > 1 { 0.0 } else { up.fork_distance }
                    + child.length,
                rotation: child.rotation,
                orientation,
                length: child.length,
            });
        }
        self.nodes[parent as usize].children = ids;
        ids
    }

    /// Makes a node as thick as this, in metres.
    ///
    /// # Panics
    ///
    /// When there is no such node.
    pub fn set_thickness(&mut self, id: NodeId, thickness: f32) {
        self.nodes[id as usize].thickness = thickness;
    }

    /// The nodes in level order.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The node `id`.
    #[must_use]
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id as usize]
    }

    /// The root.
    #[must_use]
    pub fn root(&self) -> &Node {
        &self.nodes[0]
    }

    /// How many nodes the tree has; never 0.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a tree always has its root")]
    pub fn len(&self) -> usize {
        self.nodes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info() -> TreeInfo {
        TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 }
    }

    fn bend(degrees: f32, length: f32) -> ChildSignature {
        ChildSignature {
            rotation: Quat::from_rotation_y(degrees.to_radians()),
            thickness: 0.01,
            length,
        }
    }

    #[test]
    fn four_right_angles_of_unit_edges_come_back_to_the_foot() {
        let mut tree = BranchGraph::new(info(), Vec3::ZERO, bend(0.0, 1.0));
        let mut tip = 0;
        for _ in 0..3 {
            tip = tree.grow(tip, [Some(bend(90.0, 1.0)), None, None])[0].unwrap();
        }
        assert!(tree.node(tip).position.length() < 1e-6);
        assert!((tree.node(tip).root_distance - 4.0).abs() < 1e-6);
    }

    #[test]
    fn laterals_raise_the_order_and_start_branch_and_fork_distances_anew() {
        let mut tree = BranchGraph::new(info(), Vec3::ZERO, bend(0.0, 2.0));
        let [apical, lateral, none] =
            tree.grow(0, [Some(bend(0.0, 1.0)), Some(bend(30.0, 0.5)), None]);
        assert_eq!(none, None);
        let (a, l) = (tree.node(apical.unwrap()), tree.node(lateral.unwrap()));
        assert_eq!((a.order, l.order), (0, 1));
        assert_eq!((a.branch_distance, l.branch_distance), (3.0, 0.5));
        assert_eq!((a.fork_distance, l.fork_distance), (1.0, 0.5));
        assert_eq!((a.sibling_count, l.sibling_count), (2, 2));
        let only = tree.grow(apical.unwrap(), [Some(bend(0.0, 1.0)), None, None])[0].unwrap();
        assert_eq!(tree.node(only).fork_distance, 2.0);
    }
}
