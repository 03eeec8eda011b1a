//! Stanford PLY (`.ply`), binary: with the branch, the order and the node at each vertex.

use std::io::{self, BufWriter, Write};

use deeptree_graph::TreeInfo;
use deeptree_mesh::Mesh;

use crate::numbers::{one_line, write_floats};

/// Writes a mesh as little-endian binary PLY.
///
/// Vertices: `x y z`, `nx ny nz`, `s t` (texture coordinates), `branch` (number of the Gravelius
/// branch), `order` and `node` (of the branch graph). Faces: `vertex_indices`. The comments name the tree.
///
/// # Errors
///
/// When the output fails.
pub fn write(mesh: &Mesh, info: &TreeInfo, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    write_header(mesh, info, &mut out)?;
    for i in 0..mesh.vertex_count() {
        let vectors = [mesh.positions[i].to_array(), mesh.normals[i].to_array()];
        write_floats(&mut out, vectors.into_iter())?;
        write_floats(&mut out, [mesh.uvs[i]].into_iter())?;
        let internode = mesh.internode(i);
        out.write_all(&internode.branch.to_le_bytes())?;
        out.write_all(&internode.order.to_le_bytes())?;
        out.write_all(&mesh.nodes[i].to_le_bytes())?;
    }
    for corners in mesh.indices.as_chunks::<3>().0 {
        out.write_all(&[3])?;
        out.write_all(corners.map(u32::to_le_bytes).as_flattened())?;
    }
    out.flush()
}

fn write_header(mesh: &Mesh, info: &TreeInfo, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment DeepTree {}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "comment species {}", one_line(&info.species))?;
    writeln!(out, "comment age {}", info.age)?;
    writeln!(out, "comment gravitropism {}", info.gravitropism)?;
    writeln!(out, "comment seed {}", info.seed)?;
    writeln!(out, "comment metres, y up")?;
    writeln!(out, "element vertex {}", mesh.vertex_count())?;
    for name in ["x", "y", "z", "nx", "ny", "nz", "s", "t"] {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "property uint branch\nproperty ushort order\nproperty uint node")?;
    writeln!(out, "element face {}", mesh.triangle_count())?;
    writeln!(out, "property list uchar uint vertex_indices")?;
    writeln!(out, "end_header")
}
