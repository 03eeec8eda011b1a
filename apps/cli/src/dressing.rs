//! Trees as they are looked at in pictures.

use anyhow::Result;
use deeptree_graph::BranchGraph;
use deeptree_mesh::{Dressed, Look, WoodOptions, wood};

use crate::look;

/// The surface of a tree, its leaves if it has any, and what they are made of.
pub(crate) fn dressed(tree: &BranchGraph, look: &Look) -> Result<Dressed> {
    Ok(look::dressed(tree, wood(tree, &WoodOptions::lod(look.lod)), look)?)
}
