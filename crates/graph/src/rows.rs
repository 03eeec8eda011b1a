//! From the rows of a skeleton table to a valid tree: where bad input is told apart from a tree.

use std::collections::HashMap;

use glam::{Quat, Vec3};

use crate::graph::{BranchGraph, ChildSignature, MAX_CHILDREN, NodeId, TreeInfo};

/// How far a given position may lie from the one that parent, rotation and length imply, in metres.
///
/// Tables written elsewhere round their digits; a millimetre is below anything visible.
const POSITION_TOLERANCE: f32 = 1e-3;

/// How far from 1 the length of a given quaternion may be.
const UNIT_TOLERANCE: f32 = 1e-3;

/// One row of a skeleton table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The node's number; any order, any gaps, each once.
    pub id: i64,
    /// The parent's number; −1 at the root.
    pub parent: i64,
    /// Child slot; by order of the rows where it is not given.
    pub slot: Option<u8>,
    /// Tip of the internode in metres, y up.
    pub position: Vec3,
    /// Radius in metres.
    pub radius: f32,
    /// Rotation and length against the parent; from the positions where they are not given.
    pub edge: Option<(Quat, f32)>,
}

/// Why rows are not a tree. `row` counts the rows from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum GraphError {
    #[error("the table has no rows; a tree has at least its root")]
    Empty,
    #[error("row {row}: id {id} was given to row {first} already; every node needs its own")]
    DuplicateId { row: usize, id: i64, first: usize },
    #[error("no row has parent -1; one must, the root")]
    NoRoot,
    #[error("row {row}: a second root (the first is row {first}); one tree has one root")]
    SecondRoot { row: usize, first: usize },
    #[error("row {row}: its parent {parent} is no row of this tree")]
    Orphan { row: usize, parent: i64 },
    #[error("row {row}: it is its own ancestor; following the parents must end at the root")]
    Cycle { row: usize },
    #[error("row {row}: {field} is {value}; it must be a finite number")]
    NotFinite { row: usize, field: &'static str, value: f32 },
    #[error("row {row}: {field} is {value}; it must not be negative")]
    Negative { row: usize, field: &'static str, value: f32 },
    #[error("row {row}: the rotation has length {norm}; it must be a unit quaternion")]
    NotUnit { row: usize, norm: f32 },
    #[error("row {row}: a fourth child of node {parent}; a node has at most 3")]
    FourthChild { row: usize, parent: i64 },
    #[error("row {row}: slot {slot} is not 0 (apical), 1 or 2 (lateral)")]
    NoSuchSlot { row: usize, slot: u8 },
    #[error("row {row}: slot {slot} of node {parent} is taken already")]
    SlotTaken { row: usize, slot: u8, parent: i64 },
    #[error(
        "row {row}: its position is {distance} m from where parent, rotation and length put it; \
         correct them or leave the rotation and length columns out"
    )]
    PositionMismatch { row: usize, distance: f32 },
}

impl BranchGraph {
    /// Builds the tree of a table's rows.
    ///
    /// Nodes are renumbered into level order. Where `edge` is missing, the frame of a node is its
    /// parent's, turned by the smallest rotation that brings its front onto the edge.
    ///
    /// # Errors
    ///
    /// When the rows are not one tree of finite numbers with at most three children a node.
    pub fn from_rows(info: TreeInfo, rows: &[Row]) -> Result<Self, GraphError> {
        let (root, children) = link(rows)?;
        rows.iter().enumerate().try_for_each(|(i, row)| check_numbers(i + 1, row))?;

        // The root's edge starts where it says, or straight below it on the ground.
        let at = &rows[root];
        let (rotation, length) = at.edge.unwrap_or_else(|| {
            (Quat::from_rotation_x(core::f32::consts::FRAC_PI_2), at.position.y.max(0.0))
        });
        let edge = ChildSignature { rotation, thickness: at.radius, length };
        let mut tree = Self::with_root_tip(info, at.position, edge);

        let mut row_of = vec![root];
        let mut next = 0;
        while next < row_of.len() {
            let branchlet = children[row_of[next]];
            let signatures =
                branchlet.map(|child| child.map(|row| child_signature(&tree, next, &rows[row])));
            let ids = tree.grow(next as NodeId, signatures);
            for (row, id) in branchlet.into_iter().zip(ids) {
                if let (Some(row), Some(id)) = (row, id) {
                    check_position(row + 1, &rows[row], tree.node(id).position)?;
                    row_of.push(row);
                }
            }
            next += 1;
        }
        if row_of.len() < rows.len() {
            return Err(GraphError::Cycle { row: first_unreached(rows.len(), &row_of) });
        }
        Ok(tree)
    }

    /// The rows that [`Self::from_rows`] makes the same tree of.
    pub fn rows(&self) -> impl Iterator<Item = Row> + '_ {
        self.nodes().iter().enumerate().map(|(id, node)| Row {
            id: id as i64,
            parent: node.parent.map_or(-1, i64::from),
            slot: Some(node.slot),
            position: node.position,
            radius: node.thickness,
            edge: Some((node.rotation, node.length)),
        })
    }
}

/// The root's row and, for each row, the rows of its children by slot.
#[expect(clippy::type_complexity, reason = "two plain tables")]
fn link(rows: &[Row]) -> Result<(usize, Vec<[Option<usize>; MAX_CHILDREN]>), GraphError> {
    let mut row_of = HashMap::with_capacity(rows.len());
    for (i, row) in rows.iter().enumerate() {
        if let Some(first) = row_of.insert(row.id, i) {
            return Err(GraphError::DuplicateId { row: i + 1, id: row.id, first: first + 1 });
        }
    }
    let mut root = None;
    let mut children = vec![[None; MAX_CHILDREN]; rows.len()];
    for (i, row) in rows.iter().enumerate() {
        if row.parent == -1 {
            if let Some(first) = root.replace(i) {
                return Err(GraphError::SecondRoot { row: i + 1, first: first + 1 });
            }
            continue;
        }
        let Some(&parent) = row_of.get(&row.parent) else {
            return Err(GraphError::Orphan { row: i + 1, parent: row.parent });
        };
        let siblings: &mut [Option<usize>; MAX_CHILDREN] = &mut children[parent];
        let slot = match row.slot {
            Some(slot) if usize::from(slot) >= MAX_CHILDREN => {
                return Err(GraphError::NoSuchSlot { row: i + 1, slot });
            }
            _ if siblings.iter().all(Option::is_some) => {
                return Err(GraphError::FourthChild { row: i + 1, parent: row.parent });
            }
            Some(slot) if siblings[usize::from(slot)].is_some() => {
                return Err(GraphError::SlotTaken { row: i + 1, slot, parent: row.parent });
            }
            Some(slot) => usize::from(slot),
            None => siblings.iter().position(Option::is_none).unwrap_or(0),
        };
        siblings[slot] = Some(i);
    }
    match root {
        Some(root) => Ok((root, children)),
        None if rows.is_empty() => Err(GraphError::Empty),
        None => Err(GraphError::NoRoot),
    }
}

fn check_numbers(row_number: usize, row: &Row) -> Result<(), GraphError> {
    let (rotation, length) = row.edge.unwrap_or((Quat::IDENTITY, 0.0));
    let fields = [
        ("x", row.position.x),
        ("y", row.position.y),
        ("z", row.position.z),
        ("radius", row.radius),
        ("length", length),
        ("qx", rotation.x),
        ("qy", rotation.y),
        ("qz", rotation.z),
        ("qw", rotation.w),
    ];
    for (field, value) in fields {
        if !value.is_finite() {
            return Err(GraphError::NotFinite { row: row_number, field, value });
        }
    }
    for (field, value) in [("radius", row.radius), ("length", length)] {
        if value < 0.0 {
            return Err(GraphError::Negative { row: row_number, field, value });
        }
    }
    let norm = rotation.length();
    if (norm - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(GraphError::NotUnit { row: row_number, norm })
    }
}

fn check_position(row_number: usize, row: &Row, position: Vec3) -> Result<(), GraphError> {
    let distance = row.position.distance(position);
    // Coordinates far from the origin carry fewer digits than a millimetre.
    let tolerance = POSITION_TOLERANCE + 1e-5 * row.position.abs().max_element();
    if distance <= tolerance {
        Ok(())
    } else {
        Err(GraphError::PositionMismatch { row: row_number, distance })
    }
}

fn child_signature(tree: &BranchGraph, parent: usize, row: &Row) -> ChildSignature {
    let (rotation, length) = row.edge.unwrap_or_else(|| {
        let parent = &tree.nodes()[parent];
        let edge = row.position - parent.position;
        let length = edge.length();
        let rotation = match edge.try_normalize() {
            Some(front) => {
                Quat::from_rotation_arc(Vec3::NEG_Z, parent.orientation.inverse() * front)
            }
            None => Quat::IDENTITY,
        };
        (rotation.normalize(), length)
    });
    ChildSignature { rotation, thickness: row.radius, length }
}

fn first_unreached(rows: usize, reached: &[usize]) -> usize {
    let mut seen = vec![false; rows];
    for &row in reached {
        seen[row] = true;
    }
    seen.iter().position(|seen| !seen).map_or(0, |row| row + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(id: i64, parent: i64, y: f32) -> Row {
        Row { id, parent, slot: None, position: Vec3::new(0.0, y, 0.0), radius: 0.1, edge: None }
    }

    fn read(rows: &[Row]) -> Result<BranchGraph, GraphError> {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        BranchGraph::from_rows(info, rows)
    }

    #[test]
    fn each_way_of_not_being_a_tree_names_its_row() {
        let base = [row(0, -1, 1.0), row(1, 0, 2.0)];
        let with = |extra: &[Row]| read(&[&base[..], extra].concat()).unwrap_err();
        assert_eq!(read(&[]).unwrap_err(), GraphError::Empty);
        assert_eq!(read(&[row(0, 1, 0.0), row(1, 0, 0.0)]).unwrap_err(), GraphError::NoRoot);
        assert_eq!(with(&[row(1, 0, 3.0)]), GraphError::DuplicateId { row: 3, id: 1, first: 2 });
        assert_eq!(with(&[row(2, -1, 3.0)]), GraphError::SecondRoot { row: 3, first: 1 });
        assert_eq!(with(&[row(2, 7, 3.0)]), GraphError::Orphan { row: 3, parent: 7 });
        assert_eq!(with(&[row(2, 3, 3.0), row(3, 2, 3.0)]), GraphError::Cycle { row: 3 });
        assert_eq!(with(&[row(2, 2, 3.0)]), GraphError::Cycle { row: 3 });
        assert!(matches!(
            with(&[row(2, 1, f32::NAN)]),
            GraphError::NotFinite { row: 3, field: "y", .. }
        ));
        assert!(matches!(
            with(&[Row { radius: -1.0, ..row(2, 1, 3.0) }]),
            GraphError::Negative { row: 3, field: "radius", .. }
        ));
        let more = [row(2, 0, 2.0), row(3, 0, 2.0), row(4, 0, 2.0)];
        assert_eq!(with(&more), GraphError::FourthChild { row: 5, parent: 0 });
        let slotted = |id, slot| Row { slot: Some(slot), ..row(id, 0, 2.0) };
        assert_eq!(with(&[slotted(2, 3)]), GraphError::NoSuchSlot { row: 3, slot: 3 });
        assert_eq!(with(&[slotted(2, 0)]), GraphError::SlotTaken { row: 3, slot: 0, parent: 0 });
        let far = Row { edge: Some((Quat::IDENTITY, 5.0)), ..row(2, 1, 3.0) };
        assert!(matches!(with(&[far]), GraphError::PositionMismatch { row: 3, .. }));
        let long = Row { edge: Some((Quat::from_xyzw(0.0, 0.0, 0.0, 2.0), 1.0)), ..row(2, 1, 3.0) };
        assert!(matches!(with(&[long]), GraphError::NotUnit { row: 3, .. }));
    }

    #[test]
    fn rows_in_any_order_give_the_tree_in_level_order() {
        let tree = read(&[row(9, 4, 3.0), row(4, 2, 2.0), row(2, -1, 1.0)]).unwrap();
        let heights: Vec<f32> = tree.nodes().iter().map(|n| n.position.y).collect();
        assert!(heights.iter().zip([1.0, 2.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!((tree.nodes()[2].root_distance - 3.0).abs() < 1e-6);
        assert!(tree.nodes()[2].front().distance(Vec3::Y) < 1e-6);
    }
}
