//! The encoding of kind `paper`: Eq. 1 as published.

use super::{GROWTH_SPACE, TreeConditions, Writer};
use crate::graph::{ChildSignature, Node};

/// Length of an output signature u = (q, t, l) as the later regressors read it.
pub const CHILD_LEN: usize = 6;

/// Number of features for a model of `species` species.
#[must_use]
pub const fn len(species: usize) -> usize {
    15 + species
}

/// Where the three coordinates of the position stand, for the noise of the training recipe.
pub const POSITION: std::ops::Range<usize> = 0..3;

/// Encodes one node: p, t, d_r, d_s, q_p, l_p, o, m_p, a, v, s.
///
/// # Units
///
/// p, d_r and d_s over the growth space; t and l_p in metres; a per 64 cycles; s as a one-hot.
///
/// # Panics
///
/// When `out` is shorter than [`len`].
pub fn encode(node: &Node, tree: &TreeConditions, species: usize, out: &mut [f32]) {
    let mut w = Writer { out, at: 0 };
    w.put3(node.position / GROWTH_SPACE);
    w.put(node.thickness);
    w.put(node.root_distance / GROWTH_SPACE);
    w.put(node.branch_distance / GROWTH_SPACE);
    node.rotation.to_array().into_iter().for_each(|x| w.put(x));
    w.put(node.length);
    w.put(f32::from(node.order) / 8.0);
    w.put(f32::from(node.sibling_count) / 3.0);
    w.put(tree.age / 64.0);
    w.put(tree.gravitropism);
    w.one_hot(tree.species, species);
    debug_assert_eq!(w.at, len(species));
}

/// Encodes the output signature of an earlier sibling: q, t, l; zeros where there is none.
pub fn encode_child(child: Option<&ChildSignature>, out: &mut [f32]) {
    let out = &mut out[..CHILD_LEN];
    match child {
        Some(child) => {
            out[..4].copy_from_slice(&child.rotation.to_array());
            out[4] = child.thickness;
            out[5] = child.length;
        }
        None => out.fill(0.0),
    }
}
