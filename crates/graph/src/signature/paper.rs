//! The encoding of kind `paper`: Eq. 1 as published.

use core::ops::Range;

use super::{GROWTH_SPACE, TreeConditions, Writer};
use crate::graph::{ChildSignature, MAX_CHILDREN, Node};

/// Length of an output signature u = (q, t, l) as the later regressors read it.
pub const CHILD_LEN: usize = 6;

/// Values of the joint network: the logits of the three children, then the output signature of each.
pub const JOINT_LEN: usize = MAX_CHILDREN * (1 + CHILD_LEN);

/// The attributes of Eq. 1 in the order of [`encode`], by their symbols without subscripts:
/// p, t, d_r, d_s, q_p, l_p, o, m_p, a, v, s.
pub const ATTRIBUTES: [&str; 11] = ["p", "t", "dr", "ds", "qp", "lp", "o", "mp", "a", "v", "s"];

/// Where the attribute of this symbol stands in [`encode`]; none for a name not in [`ATTRIBUTES`].
#[must_use]
pub fn attribute(symbol: &str, species: usize) -> Option<Range<usize>> {
    let widths = [3, 1, 1, 1, 4, 1, 1, 1, 1, 1, species];
    let index = ATTRIBUTES.iter().position(|known| *known == symbol)?;
    let start = widths[..index].iter().sum();
    Some(start..start + widths[index])
}

/// Number of features for a model of `species` species.
#[must_use]
pub const fn len(species: usize) -> usize {
    15 + species
}

/// Where the three coordinates of the position stand, for the noise of the training recipe.
pub const POSITION: Range<usize> = 0..3;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traits::TreeTraits;
    use crate::{BranchGraph, TreeInfo};
    use glam::{Quat, Vec3};

    const SPECIES: usize = 4;

    /// Every attribute moved by itself must change its own features and no others.
    #[test]
    fn each_attribute_stands_where_it_is_said_to() {
        let info = TreeInfo { species: "oak".into(), age: 9, gravitropism: 0.0, seed: 0 };
        let root = ChildSignature { rotation: Quat::IDENTITY, thickness: 0.2, length: 1.0 };
        let node = BranchGraph::new(info, Vec3::ZERO, root).root().clone();
        let tree = TreeConditions {
            age: 9.0,
            gravitropism: 0.0,
            species: 1,
            tip_radius: 0.01,
            root_tips: 9,
            traits: TreeTraits::from_array([1.0; TreeTraits::COUNT]),
            standing: Default::default(),
        };
        let features = |node: &Node, tree: &TreeConditions| {
            let mut out = vec![0.0; len(SPECIES)];
            encode(node, tree, SPECIES, &mut out);
            out
        };
        let before = features(&node, &tree);
        let mut end = 0;
        for symbol in ATTRIBUTES {
            let (mut node, mut tree) = (node.clone(), tree);
            match symbol {
                "p" => node.position += Vec3::ONE,
                "t" => node.thickness += 1.0,
                "dr" => node.root_distance += 1.0,
                "ds" => node.branch_distance += 1.0,
                "qp" => node.rotation = Quat::from_xyzw(0.5, 0.5, 0.5, 0.5),
                "lp" => node.length += 1.0,
                "o" => node.order += 1,
                "mp" => node.sibling_count += 1,
                "a" => tree.age += 1.0,
                "v" => tree.gravitropism += 0.1,
                "s" => tree.species = 2,
                other => panic!("{other}"),
            }
            let range = attribute(symbol, SPECIES).unwrap();
            assert_eq!(range.start, end, "{symbol}");
            end = range.end;
            let after = features(&node, &tree);
            let changed: Vec<usize> = (0..after.len()).filter(|&i| after[i] != before[i]).collect();
            assert!(changed.iter().all(|i| range.contains(i)), "{symbol}: {changed:?}");
            // The one-hot of the species has entries that are 0 in both.
            let expected = if symbol == "s" { 2 } else { range.len() };
            assert_eq!(changed.len(), expected, "{symbol}");
        }
        assert_eq!(end, len(SPECIES));
        assert_eq!(attribute("x", SPECIES), None);
    }
}
