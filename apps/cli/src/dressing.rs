//! Trees as they are looked at in pictures.

use anyhow::Result;
use deeptree_graph::{BranchGraph, Vec3};
use deeptree_mesh::{Dressed, Look, WoodOptions, wood};
use deeptree_render::Standing;
use rayon::prelude::*;

use crate::look;

/// The surface of a tree, its leaves if it has any, and what they are made of.
pub(crate) fn dressed(tree: &BranchGraph, look: &Look) -> Result<Dressed> {
    Ok(look::dressed(tree, wood(tree, &WoodOptions::lod(look.lod)), look)?)
}

/// The surfaces of trees that stand together, with where each of them stands.
pub(crate) fn all_dressed(
    trees: &[(&BranchGraph, Vec3)],
    look: &Look,
) -> Result<Vec<(Dressed, Vec3)>> {
    trees.par_iter().map(|&(tree, at)| Ok((dressed(tree, look)?, at))).collect()
}

/// The same, borrowed.
pub(crate) fn standing(trees: &[(Dressed, Vec3)]) -> Vec<Standing<'_>> {
    trees.iter().map(|(tree, at)| Standing { tree, at: *at }).collect()
}
