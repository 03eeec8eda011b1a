//! Wavefront OBJ (`.obj`): text that every modelling program reads.

use std::io::{self, BufWriter, Write};

use deeptree_graph::TreeInfo;
use deeptree_mesh::Mesh;

use crate::numbers::one_line;

/// Writes a mesh as Wavefront OBJ: `v`, `vt`, `vn` and triangles `f v/vt/vn`.
///
/// The comments at the top name the tree. Numbers have as many digits as it takes to read the same
/// floats again.
///
/// # Errors
///
/// When the output fails.
pub fn write(mesh: &Mesh, info: &TreeInfo, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let species = one_line(&info.species);
    writeln!(out, "# DeepTree {}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "# species {species}")?;
    writeln!(out, "# age {}", info.age)?;
    writeln!(out, "# gravitropism {}", info.gravitropism)?;
    writeln!(out, "# seed {}", info.seed)?;
    writeln!(out, "# metres, y up")?;
    writeln!(out, "o wood")?;
    for p in &mesh.positions {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for [u, v] in &mesh.uvs {
        writeln!(out, "vt {u} {v}")?;
    }
    for n in &mesh.normals {
        writeln!(out, "vn {} {} {}", n.x, n.y, n.z)?;
    }
    for corners in mesh.indices.as_chunks::<3>().0 {
        // Counted from 1.
        let [a, b, c] = corners.map(|i| u64::from(i) + 1);
        writeln!(out, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
    }
    out.flush()
}
