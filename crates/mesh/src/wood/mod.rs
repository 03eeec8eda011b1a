//! The wood of a tree as one closed surface.
//!
//! A tree is cut into *limbs*, runs of nodes swept as one tube of rings. Where a limb has a
//! lateral, a patch of the tube's sides is left out, and what is left out is filled by the rim of
//! the lateral's *collar*: a ring of vertices on the limb's surface, from which the lateral's own
//! tube starts. Edges of the surface therefore always have two faces, whatever the geometry.

mod axis;
mod bark;
mod collar;
mod joint;
pub(crate) mod limbs;
mod ring;
mod section;
mod spread;
mod sweep;
mod zip;

pub(crate) use bark::{BARKED, GRAIN};

use deeptree_graph::BranchGraph;

use crate::mesh::Mesh;
use crate::options::WoodOptions;
use sweep::Sweep;

/// Meshes the wood of a tree as one closed surface: edge-manifold, of one piece, without holes.
///
/// - Each limb is a tube along a smooth curve through its nodes, with as many rings as its bends
///   take and as many sides as its radius takes; radii go linearly from node to node, and are at
///   least [`MIN_RADIUS`](crate::MIN_RADIUS).
/// - A lateral grows out of its parent's surface by a collar that is smooth to both. It leaves
///   where its axis comes out of the surface; where laterals would meet there, they share the
///   place. Nodes that lie within the parent's wood have no ring.
/// - Tips taper to a cone, thick ones end in a dome; the trunk's foot widens and is a flat disc.
/// - Cross-sections of thick wood of low order are fluted and a little flat.
/// - Vertices are doubled where the texture has its seam, on the side of each branch towards its
///   parent's foot, at the rim of each collar and at the foot: see [`Mesh::welded`].
/// - u goes around a limb a whole number of times, so that a texture that repeats has no seam; v
///   goes along it as fast, so that the texture keeps its shape. At the start of thick limbs its
///   side is about `texture_size`; it gets finer as the limb does, down to a quarter along it. With
///   `even_texels` u and v are distances in textures instead, and the seam can be seen.
///
/// # Panics
///
/// When `options` do not pass [`WoodOptions::validate`], or the mesh would have 2³² indices.
#[must_use]
pub fn wood(tree: &BranchGraph, options: &WoodOptions) -> Mesh {
    if let Err(error) = options.validate() {
        panic!("wood options: {error}");
    }
    let mut mesh = Sweep::new(tree, options).run();
    if options.bark > 0.0 {
        mesh.smooth();
    }
    mesh
}
