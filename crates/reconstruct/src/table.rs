//! Trees as tables of cylinders (quantitative structure models).

use std::io::{self, Write};

use deeptree_graph::{BranchGraph, Vec3, branches};

/// Writes a tree as cylinders, one a row, comma separated, with a head.
///
/// `place` gives the coordinates of a point of the tree, and `turn` those of a direction, in the frame
/// of the table; edges without length have no cylinder. Columns, after TreeQSM's: radius and length
/// in metres; where the cylinder starts; the unit direction of its axis; parent and extension (the
/// cylinder that continues the branch) as numbers of rows counted from 1, 0 for none; branch and
/// position in it counted from 1; branch order, 0 for the trunk.
///
/// # Errors
///
/// When the output cannot be written.
///
/// # Source
///
/// Raumonen et al. 2013, "Fast automatic precision tree models from terrestrial laser scanner data".
pub fn write_cylinders(
    tree: &BranchGraph,
    place: impl Fn(Vec3) -> [f64; 3],
    turn: impl Fn(Vec3) -> Vec3,
    out: &mut impl Write,
) -> io::Result<()> {
    writeln!(
        out,
        "radius,length,start_x,start_y,start_z,axis_x,axis_y,axis_z,parent,extension,branch,\
         branch_order,position_in_branch"
    )?;
    let mut branch_of = vec![(0, 0); tree.len()];
    for (branch, path) in (1..).zip(branches(tree)) {
        let solid = path.nodes.iter().filter(|&&id| tree.node(id).length > 0.0);
        for (position, &id) in (1..).zip(solid) {
            branch_of[id as usize] = (branch, position);
        }
    }
    let mut row = vec![0u32; tree.len()];
    let mut rows = 0;
    for (id, node) in tree.nodes().iter().enumerate() {
        if node.length > 0.0 {
            rows += 1;
            row[id] = rows;
        }
    }
    for (id, node) in tree.nodes().iter().enumerate().filter(|(_, node)| node.length > 0.0) {
        let [x, y, z] = place(node.base());
        let axis = turn(node.front());
        let parent = node.parent.map_or(0, |parent| row[parent as usize]);
        let extension = node.children[0].map_or(0, |child| row[child as usize]);
        let (branch, position) = branch_of[id];
        writeln!(
            out,
            "{:.5},{:.5},{x:.4},{y:.4},{z:.4},{:.5},{:.5},{:.5},{parent},{extension},{branch},{},{position}",
            node.thickness, node.length, axis.x, axis.y, axis.z, node.order
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{ChildSignature, Quat, TreeInfo};

    #[test]
    fn a_fork_is_three_cylinders_that_name_each_other() {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let rotation = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let edge = |rotation, length| ChildSignature { rotation, thickness: 0.25, length };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(rotation, 0.0));
        tree.grow(0, [Some(edge(Quat::IDENTITY, 2.0)), None, None]);
        let aside = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2);
        tree.grow(1, [Some(edge(Quat::IDENTITY, 1.0)), Some(edge(aside, 0.5)), None]);
        let mut out = Vec::new();
        let place = |p: Vec3| [f64::from(p.x) + 5_000_000.125, f64::from(p.y), f64::from(p.z)];
        write_cylinders(&tree, place, |v| v, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(rows.len(), 3);
        assert!(rows[0].starts_with("0.25000,2.00000,5000000.1250,0.0000,0.0000,"), "{}", rows[0]);
        assert!(rows[0].ends_with(",0,2,1,0,1"), "{}", rows[0]);
        assert!(rows[1].ends_with(",1,0,1,0,2"), "{}", rows[1]);
        assert!(rows[2].ends_with(",1,0,2,1,1"), "{}", rows[2]);
    }
}
