//! The text of a stage: the tree, its wood and its leaves.

use std::io::{self, BufWriter, Write};

use deeptree_graph::{TreeInfo, Vec3};
use deeptree_mesh::{Foliage, Leaf, Material};

use super::materials;
use super::text::{array, identifier, quoted, tuple};
use crate::subject::Subject;
use crate::surface::Surface;

/// What follows an array with a value for each vertex.
const PER_VERTEX: &str = " (\n            interpolation = \"vertex\"\n        )";

/// Writes the text; `file` says where the picture of a name is.
pub(super) fn write(
    subject: Subject<'_>,
    info: &TreeInfo,
    file: &dyn Fn(&str) -> String,
    out: &mut impl Write,
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let species = if info.species.is_empty() { "tree" } else { &info.species };
    let tree = identifier(&format!("{species} {}", info.seed));
    write_head(info, &tree, &mut out)?;
    writeln!(out, "def Xform \"{tree}\" (\n    kind = \"component\"\n)\n{{")?;
    if !subject.wood.indices.is_empty() {
        let Material { name, double_sided: both, .. } = subject.bark;
        let looks = Looks { tree: &tree, material: name, both: *both };
        write_mesh("wood", subject.wood, &looks, &mut out)?;
    }
    for (name, kind) in subject.named_leaves() {
        write_leaves(&identifier(&name), kind, &tree, &mut out)?;
    }
    materials::write(subject, &tree, file, &mut out)?;
    writeln!(out, "}}")?;
    out.flush()
}

fn write_head(info: &TreeInfo, tree: &str, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "#usda 1.0\n(")?;
    writeln!(out, "    customLayerData = {{")?;
    writeln!(out, "        string creator = \"DeepTree {}\"", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "        string species = {}", quoted(&info.species))?;
    writeln!(out, "        int age = {}", info.age)?;
    writeln!(out, "        float gravitropism = {}", info.gravitropism)?;
    writeln!(out, "        uint64 seed = {}", info.seed)?;
    writeln!(out, "    }}")?;
    writeln!(out, "    defaultPrim = \"{tree}\"")?;
    writeln!(out, "    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n")
}

/// What a mesh looks like.
struct Looks<'a> {
    tree: &'a str,
    material: &'a str,
    /// Is it seen from both sides?
    both: bool,
}

fn write_mesh(
    name: &str,
    surface: &impl Surface,
    looks: &Looks<'_>,
    out: &mut impl Write,
) -> io::Result<()> {
    let Looks { tree, material, both } = looks;
    writeln!(out, "    def Mesh \"{name}\" (")?;
    writeln!(out, "        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {{")?;
    write_extent(surface.bounds(), out)?;
    array("int[] faceVertexCounts", surface.triangles().map(|_| 3), "", out)?;
    array("int[] faceVertexIndices", surface.triangles().flatten(), "", out)?;
    writeln!(out, "        rel material:binding = </{tree}/materials/{}>", identifier(material))?;
    array("normal3f[] normals", surface.normals().map(tuple), PER_VERTEX, out)?;
    array("point3f[] points", surface.positions().map(tuple), "", out)?;
    let uvs = surface.uvs().map(|[u, v]| format!("({u}, {v})"));
    array("texCoord2f[] primvars:st", uvs, PER_VERTEX, out)?;
    writeln!(out, "        uniform bool doubleSided = {}", u8::from(*both))?;
    writeln!(out, "        uniform token subdivisionScheme = \"none\"\n    }}\n")
}

fn write_extent(bounds: Option<(Vec3, Vec3)>, out: &mut impl Write) -> io::Result<()> {
    match bounds {
        Some((low, high)) => array("float3[] extent", [low, high].into_iter().map(tuple), "", out),
        None => Ok(()),
    }
}

/// Leaves as copies of their blade.
fn write_leaves(name: &str, kind: &Foliage, tree: &str, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "    def PointInstancer \"{name}\"\n    {{")?;
    write_extent(kind.bounds(), out)?;
    let leaves = || kind.leaves.iter();
    let quaternion = |leaf: &Leaf| {
        let q = leaf.rotation;
        format!("({}, {}, {}, {})", q.w, q.x, q.y, q.z)
    };
    array("quath[] orientations", leaves().map(quaternion), "", out)?;
    array("point3f[] positions", leaves().map(|leaf| tuple(leaf.position)), "", out)?;
    array("int[] protoIndices", leaves().map(|_| 0), "", out)?;
    writeln!(out, "        rel prototypes = </{tree}/{name}/blade>")?;
    array("float3[] scales", leaves().map(|leaf| tuple(Vec3::splat(leaf.scale))), "", out)?;
    writeln!(out)?;
    let both = kind.material.double_sided;
    let looks = Looks { tree, material: &kind.material.name, both };
    write_mesh("blade", &kind.blade, &looks, out)?;
    writeln!(out, "    }}\n")
}
