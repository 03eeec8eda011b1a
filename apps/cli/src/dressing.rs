//! Trees as they are looked at.

use deeptree_graph::BranchGraph;
use deeptree_mesh::{Dressed, WoodOptions, wood};
use deeptree_render::plain_bark;

/// The surface of a tree, and what it is made of.
pub(crate) fn dressed(tree: &BranchGraph, lod: u8) -> Dressed {
    let wood = wood(tree, &WoodOptions::lod(lod));
    Dressed { wood, bark: plain_bark(), foliage: Vec::new() }
}
