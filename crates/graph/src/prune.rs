//! Pruning: what is cut off a tree, and the wounds that are left.

use glam::Vec3;

use crate::graph::{BranchGraph, MAX_CHILDREN, Node, NodeId};
use crate::plan::{Plan, plans};

/// What to cut off. A node that is cut takes with it all that it bears.
///
/// Lengths and coordinates are in metres, y up.
#[derive(Clone, Debug, PartialEq)]
pub enum Cut {
    /// Nodes beyond a plane: those with `normal · p > offset`.
    Plane {
        /// Points to the side that is cut off; of any length above 0.
        normal: Vec3,
        /// `normal · p` of the points of the plane.
        offset: f32,
    },
    /// Nodes whose edge enters a box along the axes.
    Box {
        /// The corner of the least coordinates.
        min: Vec3,
        /// The corner of the greatest coordinates.
        max: Vec3,
    },
    /// Nodes whose edge enters a ball.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Its radius.
        radius: f32,
    },
    /// Nodes above a height: those with `y > height`.
    Above(f32),
    /// Nodes of a Gravelius order above this.
    Order(u16),
    /// Nodes whose way from the foot is longer than this fraction of the tree's longest one.
    Path(f32),
    /// These nodes.
    Nodes(Vec<NodeId>),
}

/// Why a tree cannot be pruned so.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PruneError {
    #[error("{what} is {value}; it must be a finite number")]
    NotFinite { what: &'static str, value: f32 },
    #[error("the normal of the plane is 0; it must point to the side that is cut off")]
    NoNormal,
    #[error(
        "the box ends at {axis} = {max}, before it begins at {min}; give its least corner first"
    )]
    InvertedBox { axis: char, min: f32, max: f32 },
    #[error("the radius of the sphere is {radius}; it must not be negative")]
    NegativeRadius { radius: f32 },
    #[error("the fraction of the longest path is {fraction}; it must be between 0 and 1")]
    NoFraction { fraction: f32 },
    #[error("the tree has no node {node}; its nodes are 0 to {last}")]
    NoSuchNode { node: NodeId, last: usize },
    #[error("nothing is left: the root is cut off, and with it the whole tree; cut less")]
    NothingLeft,
}

/// Where something was cut off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wound {
    /// The node that bore it, in the pruned tree.
    pub node: NodeId,
    /// The slot that is empty now.
    pub slot: u8,
    /// Radius of what was cut off, in metres: by the pipe model its square says how many tips were
    /// lost.
    pub thickness: f32,
    /// Nodes on the longest path below the child that was cut off.
    pub reach: u16,
    /// Nodes that were cut off, that child included.
    pub nodes: u32,
}

/// A tree without what was cut off.
#[derive(Clone, Debug, PartialEq)]
pub struct Pruned {
    /// What is left, in level order.
    pub tree: BranchGraph,
    /// For each node of the tree before, its number in [`Self::tree`]; none where it was cut off.
    pub kept: Vec<Option<NodeId>>,
    /// Where something was cut off, by node and slot.
    pub wounds: Vec<Wound>,
}

/// Cuts off what any of the cuts says. All of them look at the tree as it is given.
///
/// What is kept has the same bits as before, except for what a node knows of its siblings (their
/// number, and the way from the last fork), which is that of the tree that is left.
///
/// # Errors
///
/// When a cut is not of numbers that make sense, or the root is cut off.
pub fn prune(tree: &BranchGraph, cuts: &[Cut]) -> Result<Pruned, PruneError> {
    cuts.iter().try_for_each(|cut| cut.check(tree))?;
    let is_cut = cut_nodes(tree, cuts);
    if is_cut[0] {
        return Err(PruneError::NothingLeft);
    }
    let plans = plans(tree);
    let mut left = tree.root_only();
    let mut kept = vec![None; tree.len()];
    kept[0] = Some(0);
    let mut wounds = Vec::new();
    // The node that each node of what is left was before.
    let mut before = vec![0];
    let mut next = 0;
    while next < before.len() {
        let node = next as NodeId;
        let former = tree.node(before[next]).children;
        let standing = former.map(|child| child.filter(|&child| !is_cut[child as usize]));
        let ids = left.grow(node, standing.map(|child| Some(tree.node(child?).as_child())));
        for slot in 0..MAX_CHILDREN {
            let Some(child) = former[slot] else { continue };
            if let Some(id) = ids[slot] {
                kept[child as usize] = Some(id);
                before.push(child);
            } else {
                let thickness = tree.node(child).thickness;
                let Plan { reach, nodes: below } = plans[child as usize];
                let nodes = 1 + below;
                wounds.push(Wound { node, slot: slot as u8, thickness, reach, nodes });
            }
        }
        next += 1;
    }
    Ok(Pruned { tree: left, kept, wounds })
}

/// For each node, whether it or one that bears it is cut.
fn cut_nodes(tree: &BranchGraph, cuts: &[Cut]) -> Vec<bool> {
    let longest = tree.nodes().iter().map(|node| node.root_distance).fold(0.0, f32::max);
    let mut is_cut = vec![false; tree.len()];
    for cut in cuts {
        if let Cut::Nodes(ids) = cut {
            ids.iter().for_each(|&id| is_cut[id as usize] = true);
        }
    }
    // Children stand after their parents.
    for (id, node) in tree.nodes().iter().enumerate() {
        is_cut[id] |= node.parent.is_some_and(|parent| is_cut[parent as usize])
            || cuts.iter().any(|cut| cut.takes(node, longest));
    }
    is_cut
}

impl Cut {
    /// Does the place of a node say that it is cut?
    fn takes(&self, node: &Node, longest: f32) -> bool {
        let tip = node.position;
        match self {
            Self::Plane { normal, offset } => normal.dot(tip) > *offset,
            Self::Box { min, max } => enters_box(node.base(), tip, *min, *max),
            Self::Sphere { center, radius } => distance(node.base(), tip, *center) <= *radius,
            Self::Above(height) => tip.y > *height,
            Self::Order(order) => node.order > *order,
            Self::Path(fraction) => node.root_distance > fraction * longest,
            Self::Nodes(_) => false,
        }
    }

    fn check(&self, tree: &BranchGraph) -> Result<(), PruneError> {
        let finite = |what, values: &[f32]| match values.iter().find(|value| !value.is_finite()) {
            Some(&value) => Err(PruneError::NotFinite { what, value }),
            None => Ok(()),
        };
        match self {
            Self::Plane { normal, offset } => {
                finite("a number of the plane", &normal.to_array())?;
                finite("a number of the plane", &[*offset])?;
                if *normal == Vec3::ZERO {
                    return Err(PruneError::NoNormal);
                }
            }
            Self::Box { min, max } => {
                finite("a coordinate of the box", &min.to_array())?;
                finite("a coordinate of the box", &max.to_array())?;
                for (i, axis) in ['x', 'y', 'z'].into_iter().enumerate() {
                    if min[i] > max[i] {
                        return Err(PruneError::InvertedBox { axis, min: min[i], max: max[i] });
                    }
                }
            }
            Self::Sphere { center, radius } => {
                finite("a number of the sphere", &center.to_array())?;
                finite("a number of the sphere", &[*radius])?;
                if *radius < 0.0 {
                    return Err(PruneError::NegativeRadius { radius: *radius });
                }
            }
            Self::Above(height) => finite("the height", &[*height])?,
            Self::Order(_) => {}
            Self::Path(fraction) => {
                if !(0.0..=1.0).contains(fraction) {
                    return Err(PruneError::NoFraction { fraction: *fraction });
                }
            }
            Self::Nodes(ids) => {
                if let Some(&node) = ids.iter().find(|&&id| id as usize >= tree.len()) {
                    return Err(PruneError::NoSuchNode { node, last: tree.len() - 1 });
                }
            }
        }
        Ok(())
    }
}

/// Does the segment from `a` to `b` have a point in the box?
fn enters_box(a: Vec3, b: Vec3, min: Vec3, max: Vec3) -> bool {
    // The part of the segment, from 0 to 1, that lies between each pair of faces.
    let (mut from, mut to) = (0.0f32, 1.0f32);
    for i in 0..3 {
        let (start, step) = (a[i], b[i] - a[i]);
        if step == 0.0 {
            if start < min[i] || start > max[i] {
                return false;
            }
            continue;
        }
        let (low, high) = ((min[i] - start) / step, (max[i] - start) / step);
        from = from.max(low.min(high));
        to = to.min(low.max(high));
    }
    // Rounding must not let an end in the box escape.
    let inside = |p: Vec3| p.cmpge(min).all() && p.cmple(max).all();
    from <= to || inside(a) || inside(b)
}

/// Distance of a point from the segment from `a` to `b`.
fn distance(a: Vec3, b: Vec3, point: Vec3) -> f32 {
    let step = b - a;
    let along = (point - a).dot(step);
    let square = step.length_squared();
    let nearest = if along <= 0.0 || square == 0.0 {
        a
    } else if along >= square {
        b
    } else {
        a + step * (along / square)
    };
    nearest.distance(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::csv::{self, CsvWriter};
    use crate::reach::reaches;
    use crate::testing::random_tree;
    use crate::{ChildSignature, Quat, TreeInfo};
    use proptest::prelude::*;

    /// A trunk of `height` edges of a metre straight up, whose every node has a lateral of a metre
    /// to +x in slot 1.
    fn comb(height: usize) -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let edge = |rotation, thickness| ChildSignature { rotation, thickness, length: 1.0 };
        let quarter = core::f32::consts::FRAC_PI_2;
        let up = edge(Quat::from_rotation_x(quarter), 0.2);
        let mut tree = BranchGraph::new(info, Vec3::ZERO, up);
        let mut tip = 0;
        for _ in 1..height {
            let apical = Some(edge(Quat::IDENTITY, 0.1));
            let lateral = Some(edge(Quat::from_rotation_y(-quarter), 0.05));
            tip = tree.grow(tip, [apical, lateral, None])[0].unwrap();
        }
        tree
    }

    fn bits(node: &Node) -> Vec<u32> {
        let mut numbers = node.position.to_array().to_vec();
        numbers.extend([node.thickness, node.length, node.root_distance, node.branch_distance]);
        numbers.extend(node.rotation.to_array());
        numbers.extend(node.orientation.to_array());
        let mut bits: Vec<u32> = numbers.into_iter().map(f32::to_bits).collect();
        bits.extend([u32::from(node.order), u32::from(node.slot)]);
        bits
    }

    /// The cuts that look at the place of a node only, so that what one leaves it leaves again.
    fn cut() -> impl Strategy<Value = Cut> {
        let point = || prop::array::uniform3(-3.0f32..3.0).prop_map(Vec3::from);
        prop_oneof![
            (point(), -2.0f32..3.0).prop_map(|(normal, offset)| Cut::Plane { normal, offset }),
            (point(), point())
                .prop_map(|(a, b)| Cut::Box { min: a.min(b) + 0.4, max: a.max(b) + 0.4 }),
            (point(), 0.0f32..2.0).prop_map(|(center, radius)| Cut::Sphere { center, radius }),
            (-1.0f32..4.0).prop_map(Cut::Above),
            (0u16..5).prop_map(Cut::Order),
        ]
    }

    /// A random tree about the origin.
    fn tree() -> impl Strategy<Value = BranchGraph> {
        any::<u64>().prop_map(|seed| {
            let tree = random_tree(seed, 150);
            let foot = Vec3::new(0.1, 0.2, 0.3);
            let mut rows: Vec<crate::Row> = tree.rows().collect();
            let shift = foot - rows[0].position;
            rows.iter_mut().for_each(|row| row.position += shift);
            BranchGraph::from_rows(tree.info, &rows).unwrap()
        })
    }

    proptest! {
        #[test]
        fn what_is_kept_has_the_same_bits(tree in tree(), cuts in prop::collection::vec(cut(), 1..3)) {
            let Ok(pruned) = prune(&tree, &cuts) else { return Ok(()) };
            prop_assert_eq!(pruned.kept.iter().flatten().count(), pruned.tree.len());
            for (old, new) in pruned.kept.iter().enumerate() {
                let Some(new) = new else { continue };
                prop_assert_eq!(bits(&tree.nodes()[old]), bits(pruned.tree.node(*new)));
            }
        }

        #[test]
        fn what_is_left_is_a_tree_of_its_own(tree in tree(), cut in cut()) {
            // As a table it reads back as itself: what a node knows of its siblings is right.
            let Ok(pruned) = prune(&tree, &[cut]) else { return Ok(()) };
            let mut table = CsvWriter::new(Vec::new()).unwrap();
            table.write(0, &pruned.tree).unwrap();
            let back = csv::read(&table.finish().unwrap(), &tree.info).unwrap();
            prop_assert_eq!(&back[0].1, &pruned.tree);
        }

        #[test]
        fn nothing_that_a_cut_takes_is_left(tree in tree(), cut in cut()) {
            let Ok(pruned) = prune(&tree, std::slice::from_ref(&cut)) else { return Ok(()) };
            for node in pruned.tree.nodes() {
                // Points along the edge; nearer to the border than rounding either is right.
                let points = (0..=10).map(|i| node.position.lerp(node.base(), i as f32 / 10.0));
                for p in points {
                    let taken = match &cut {
                        Cut::Plane { normal, offset } => {
                            p == node.position && normal.dot(p) > offset + 1e-4
                        }
                        Cut::Box { min, max } => {
                            (p - *min).min_element() > 1e-4 && (*max - p).min_element() > 1e-4
                        }
                        Cut::Sphere { center, radius } => p.distance(*center) < radius - 1e-4,
                        Cut::Above(height) => p == node.position && p.y > *height,
                        Cut::Order(order) => node.order > *order,
                        Cut::Path(_) | Cut::Nodes(_) => false,
                    };
                    prop_assert!(!taken, "{cut:?} left {p}");
                }
            }
        }

        #[test]
        fn nothing_is_cut_without_a_reason(tree in tree(), cut in cut()) {
            // Each wound is of a child that the cut takes itself.
            let Ok(pruned) = prune(&tree, std::slice::from_ref(&cut)) else { return Ok(()) };
            let mut lost = 0;
            for (old, node) in tree.nodes().iter().enumerate().skip(1) {
                let parent = node.parent.unwrap() as usize;
                if pruned.kept[old].is_none() && pruned.kept[parent].is_some() {
                    lost += 1;
                    let far = match &cut {
                        Cut::Plane { normal, offset } => normal.dot(node.position) <= *offset,
                        Cut::Box { min, max } => {
                            let (a, b) = (node.position, node.base());
                            (a.max(b) - *min).min_element() < -1e-4
                                || (*max - a.min(b)).min_element() < -1e-4
                        }
                        Cut::Sphere { center, radius } => {
                            let way = node.base().distance(*center);
                            way - node.length > radius + 1e-4
                        }
                        Cut::Above(height) => node.position.y <= *height,
                        Cut::Order(order) => node.order <= *order,
                        Cut::Path(_) | Cut::Nodes(_) => true,
                    };
                    prop_assert!(!far, "{cut:?} took {}", node.position);
                }
            }
            prop_assert_eq!(lost, pruned.wounds.len());
            let cut: u32 = pruned.wounds.iter().map(|wound| wound.nodes).sum();
            prop_assert_eq!(pruned.tree.len() + cut as usize, tree.len());
        }

        #[test]
        fn cuts_commute_and_one_after_the_other_are_both_at_once(
            tree in tree(), a in cut(), b in cut(),
        ) {
            let both = prune(&tree, &[a.clone(), b.clone()]);
            prop_assert_eq!(&both, &prune(&tree, &[b.clone(), a.clone()]));
            let one_by_one = |first: &Cut, second: &Cut| {
                prune(&prune(&tree, std::slice::from_ref(first))?.tree, std::slice::from_ref(second))
            };
            let both = both.map(|pruned| pruned.tree);
            prop_assert_eq!(&both, &one_by_one(&a, &b).map(|pruned| pruned.tree));
            prop_assert_eq!(&both, &one_by_one(&b, &a).map(|pruned| pruned.tree));
        }

        #[test]
        fn pruning_twice_is_pruning_once(tree in tree(), cut in cut()) {
            let Ok(once) = prune(&tree, std::slice::from_ref(&cut)) else { return Ok(()) };
            let twice = prune(&once.tree, &[cut]).unwrap();
            prop_assert_eq!(&twice.tree, &once.tree);
            prop_assert!(twice.wounds.is_empty());
        }

        #[test]
        fn cutting_a_node_takes_all_it_bears_and_no_more(seed in any::<u64>(), at in any::<u32>()) {
            let tree = random_tree(seed, 150);
            prop_assume!(tree.len() > 1);
            let node = 1 + at % (tree.len() as u32 - 1);
            let pruned = prune(&tree, &[Cut::Nodes(vec![node])]).unwrap();
            for (id, kept) in (0..).zip(&pruned.kept) {
                let mut ancestors = std::iter::successors(Some(id), |&id| tree.node(id).parent);
                prop_assert_eq!(kept.is_none(), ancestors.any(|ancestor| ancestor == node));
            }
            let lost = tree.node(node);
            let wound = Wound {
                node: pruned.kept[lost.parent.unwrap() as usize].unwrap(),
                slot: lost.slot,
                thickness: lost.thickness,
                reach: reaches(&tree)[node as usize],
                nodes: pruned.kept.iter().filter(|kept| kept.is_none()).count() as u32,
            };
            prop_assert_eq!(pruned.wounds, [wound]);
        }
    }

    #[test]
    fn cuts_of_a_comb_are_those_worked_out_by_hand() {
        let tree = comb(6);
        assert_eq!(tree.len(), 11);
        let left = |cut| {
            let pruned = prune(&tree, &[cut]).unwrap();
            (pruned.tree.len(), pruned.wounds.len())
        };
        // Trunk nodes at heights 1 to 6; the laterals at 1 to 5, their tips at x = 1.
        assert_eq!(left(Cut::Above(3.5)), (6, 1), "three of the trunk, each with its lateral");
        assert_eq!(left(Cut::Order(0)), (6, 5));
        assert_eq!(left(Cut::Plane { normal: Vec3::X * 2.0, offset: 1.0 }), (6, 5));
        assert_eq!(left(Cut::Path(0.5)), (5, 2), "up to 3 m: tips at 2 m have laterals of 3 m");
        assert_eq!(left(Cut::Path(1.0)), (11, 0));
        // The middle of one lateral, between its ends.
        let at = Vec3::new(0.5, 2.0, 0.0);
        assert_eq!(left(Cut::Sphere { center: at, radius: 0.1 }), (10, 1));
        assert_eq!(left(Cut::Box { min: at - 0.1, max: at + 0.1 }), (10, 1));
        // A ball on the trunk between the second node and the third: two are left, with laterals.
        let on = Vec3::new(0.0, 2.5, 0.0);
        assert_eq!(left(Cut::Sphere { center: on, radius: 0.1 }), (4, 1));
        assert_eq!(left(Cut::Nodes(vec![2, 4])), (9, 2));
        // The lateral above the cut was 0.05 thick and bore nothing.
        let lateral = prune(&tree, &[Cut::Nodes(vec![2])]).unwrap().wounds;
        assert_eq!(lateral, [Wound { node: 0, slot: 1, thickness: 0.05, reach: 0, nodes: 1 }]);
    }

    #[test]
    fn a_child_whose_siblings_are_cut_is_an_only_child() {
        let pruned = prune(&comb(4), &[Cut::Order(0)]).unwrap();
        assert!(pruned.tree.nodes().iter().all(|node| node.sibling_count == 1));
        let forks: Vec<f32> = pruned.tree.nodes().iter().map(|node| node.fork_distance).collect();
        assert_eq!(forks, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn cuts_that_make_no_sense_are_refused() {
        let tree = comb(3);
        let fails = |cut| prune(&tree, &[cut]).unwrap_err();
        let no = f32::NAN;
        assert_eq!(fails(Cut::Above(-1.0)), PruneError::NothingLeft);
        assert_eq!(fails(Cut::Nodes(vec![0])), PruneError::NothingLeft);
        assert_eq!(fails(Cut::Nodes(vec![5])), PruneError::NoSuchNode { node: 5, last: 4 });
        assert!(matches!(fails(Cut::Above(no)), PruneError::NotFinite { what: "the height", .. }));
        assert!(matches!(fails(Cut::Path(no)), PruneError::NoFraction { .. }));
        assert_eq!(fails(Cut::Path(1.5)), PruneError::NoFraction { fraction: 1.5 });
        assert_eq!(fails(Cut::Plane { normal: Vec3::ZERO, offset: 1.0 }), PruneError::NoNormal);
        let infinite = Vec3::new(0.0, f32::INFINITY, 0.0);
        for cut in [
            Cut::Plane { normal: infinite, offset: 0.0 },
            Cut::Plane { normal: Vec3::Y, offset: no },
            Cut::Box { min: Vec3::ZERO, max: infinite },
            Cut::Sphere { center: infinite, radius: 1.0 },
            Cut::Sphere { center: Vec3::ZERO, radius: no },
        ] {
            assert!(matches!(fails(cut), PruneError::NotFinite { .. }));
        }
        let inverted = Cut::Box { min: Vec3::ONE, max: Vec3::new(2.0, 0.0, 2.0) };
        assert_eq!(fails(inverted), PruneError::InvertedBox { axis: 'y', min: 1.0, max: 0.0 });
        let negative = Cut::Sphere { center: Vec3::Y, radius: -1.0 };
        assert_eq!(fails(negative), PruneError::NegativeRadius { radius: -1.0 });
    }
}
