//! Stanford PLY (`.ply`), binary: with the branch, the order and the node at each vertex.

use std::io::{self, BufWriter, Write};

use deeptree_graph::TreeInfo;
use deeptree_mesh::Internode;

use crate::numbers::{one_line, write_floats};
use crate::subject::Subject;
use crate::surface::Surface;

/// Writes a tree as little-endian binary PLY, the wood first and then leaf by leaf.
///
/// Vertices: `x y z`, `nx ny nz`, `s t` (texture coordinates), `branch` (number of the Gravelius
/// branch), `order` and `node` (of the branch graph; of a leaf, those of the internode it stands
/// on) and, for trees with leaves, `part` (0 for wood, 1 for the first kind of leaf and so on).
/// Faces: `vertex_indices`. The comments name the tree. There are no materials in the format.
///
/// # Errors
///
/// When the output fails.
pub fn write<'a>(
    subject: impl Into<Subject<'a>>,
    info: &TreeInfo,
    out: &mut impl Write,
) -> io::Result<()> {
    let subject = subject.into();
    let mut out = BufWriter::with_capacity(1 << 16, out);
    write_header(subject, info, &mut out)?;
    let dressed = subject.leaves().next().is_some();
    let internodes = &subject.wood.internodes;
    write_vertices(subject.wood, internodes, dressed.then_some(0), &mut out)?;
    for (part, kind) in (1..).zip(subject.leaves()) {
        write_vertices(kind, internodes, Some(part), &mut out)?;
    }
    write_faces(subject.wood, 0, &mut out)?;
    let mut first = subject.wood.vertex_count() as u32;
    for kind in subject.leaves() {
        write_faces(kind, first, &mut out)?;
        first += kind.vertex_count() as u32;
    }
    out.flush()
}

fn write_vertices(
    surface: &impl Surface,
    internodes: &[Internode],
    part: Option<u8>,
    out: &mut impl Write,
) -> io::Result<()> {
    let places = surface.positions().zip(surface.normals());
    for (((position, normal), uv), node) in places.zip(surface.uvs()).zip(surface.nodes()) {
        write_floats(out, [position.to_array(), normal.to_array()].into_iter())?;
        write_floats(out, [uv].into_iter())?;
        let internode = &internodes[node as usize];
        out.write_all(&internode.branch.to_le_bytes())?;
        out.write_all(&internode.order.to_le_bytes())?;
        out.write_all(&node.to_le_bytes())?;
        if let Some(part) = part {
            out.write_all(&[part])?;
        }
    }
    Ok(())
}

/// Faces whose vertices are counted from `first` on.
fn write_faces(surface: &impl Surface, first: u32, out: &mut impl Write) -> io::Result<()> {
    for corners in surface.triangles() {
        out.write_all(&[3])?;
        out.write_all(corners.map(|i| (i + first).to_le_bytes()).as_flattened())?;
    }
    Ok(())
}

fn write_header(subject: Subject<'_>, info: &TreeInfo, out: &mut impl Write) -> io::Result<()> {
    let count = |of_wood: usize, of_leaves: fn(&_) -> usize| {
        of_wood + subject.leaves().map(of_leaves).sum::<usize>()
    };
    let vertices = count(subject.wood.vertex_count(), Surface::vertex_count);
    let triangles = count(subject.wood.triangle_count(), Surface::triangle_count);
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment DeepTree {}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "comment species {}", one_line(&info.species))?;
    writeln!(out, "comment age {}", info.age)?;
    writeln!(out, "comment gravitropism {}", info.gravitropism)?;
    writeln!(out, "comment seed {}", info.seed)?;
    writeln!(out, "comment metres, y up")?;
    writeln!(out, "element vertex {vertices}")?;
    for name in ["x", "y", "z", "nx", "ny", "nz", "s", "t"] {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "property uint branch\nproperty ushort order\nproperty uint node")?;
    if subject.leaves().next().is_some() {
        writeln!(out, "property uchar part")?;
    }
    writeln!(out, "element face {triangles}")?;
    writeln!(out, "property list uchar uint vertex_indices")?;
    writeln!(out, "end_header")
}
