//! A tree as it is looked at: its wood, its leaves, and what both are made of.

use deeptree_graph::{NodeId, Quat, Vec3};

use crate::material::Material;
use crate::mesh::Mesh;

/// A tree with everything that is seen of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Dressed {
    /// The surface of trunk and branches.
    pub wood: Mesh,
    /// What it is made of.
    pub bark: Material,
    /// Leaves or needles, kind by kind; in winter the bare twigs of what has no leaves then.
    pub foliage: Vec<Foliage>,
}

/// All leaves of one shape and material, or all bare twigs.
#[derive(Clone, Debug, PartialEq)]
pub struct Foliage {
    /// The one leaf, or the one shoot with its leaves, that all are copies of.
    pub blade: Blade,
    /// Where the copies are.
    pub leaves: Vec<Leaf>,
    /// What they are made of.
    pub material: Material,
    /// Are they twigs without leaves? Their material is opaque.
    pub woody: bool,
}

/// The surface of a leaf, of a length of 1, in its own frame: the foot of the petiole at the
/// origin, the tip along −z, the upper side towards +y, as the frames of internodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blade {
    /// Vertices.
    pub positions: Vec<Vec3>,
    /// Unit normals of the upper side.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; v upwards from the foot to the tip.
    pub uvs: Vec<[f32; 2]>,
    /// Three vertices a triangle, counter-clockwise seen from above.
    pub indices: Vec<u32>,
}

/// One leaf: `p_world = position + scale · R(rotation) · p_blade`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// The foot of its petiole, in metres.
    pub position: Vec3,
    /// World from blade.
    pub rotation: Quat,
    /// Its length in metres.
    pub scale: f32,
    /// The node whose internode it stands on.
    pub node: NodeId,
}
