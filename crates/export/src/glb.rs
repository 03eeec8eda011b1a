//! Binary glTF 2.0 (`.glb`): one node with one mesh of one primitive and one material.
//!
//! # Source
//!
//! glTF 2.0 specification, Khronos Group, §3.6 (binary data), §3.7 (geometry), §4 (container).

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use deeptree_graph::TreeInfo;
use deeptree_mesh::Mesh;
use gltf_json as json;
use json::accessor::{ComponentType, GenericComponentType, Type};
use json::buffer::Target;
use json::validation::{Checked, USize64};
use json::{Accessor, Index, Root};
use serde_json::value::RawValue;

use crate::numbers::{one_line, write_floats};

/// First word of a GLB file: "glTF".
const MAGIC: u32 = 0x4654_6C67;
/// Kind of the chunk with the description: "JSON".
const JSON_CHUNK: u32 = 0x4E4F_534A;
/// Kind of the chunk with the numbers: "BIN\0".
const BIN_CHUNK: u32 = 0x004E_4942;
/// Bytes before the first chunk.
const HEADER: u64 = 12;
/// Bytes before the contents of a chunk.
const CHUNK_HEADER: u64 = 8;

/// Linear colour of bark: a grey brown that reflects about a tenth of the light.
const BARK: [f32; 4] = [0.13, 0.095, 0.07, 1.0];

/// Why a GLB file was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlbError {
    /// The format counts its bytes with 32 bits.
    #[error(
        "the file would have {bytes} bytes and GLB ends at 4294967295; \
         take a coarser level of detail, or PLY"
    )]
    TooLarge {
        /// How many bytes it would have had.
        bytes: u64,
    },
    /// The output failed.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// Where the parts of the binary chunk lie, in bytes.
struct Layout {
    /// Lengths of positions, normals, texture coordinates and indices, in this order.
    parts: [u64; 4],
    /// Whether indices have 16 bits; 65535 is not a vertex then, it restarts strips.
    short: bool,
}

impl Layout {
    fn of(mesh: &Mesh) -> Self {
        let vertices = mesh.vertex_count() as u64;
        let short = vertices <= u64::from(u16::MAX);
        let index = if short { 2 } else { 4 };
        Self {
            parts: [12 * vertices, 12 * vertices, 8 * vertices, index * mesh.indices.len() as u64],
            short,
        }
    }

    fn len(&self) -> u64 {
        self.parts.iter().sum()
    }
}

/// Writes a mesh as binary glTF 2.0.
///
/// `asset.extras` holds the tree's `species`, `age`, `gravitropism` and `seed`; the seed as decimal
/// text, for JSON readers that keep numbers as doubles would round it. Indices have 16 bits where
/// that is enough. A mesh without triangles gives a scene whose node has no mesh.
///
/// # Errors
///
/// When the file would pass the 4 GiB that the format can count, or the output fails.
pub fn write(mesh: &Mesh, info: &TreeInfo, out: &mut impl Write) -> Result<(), GlbError> {
    let layout = Layout::of(mesh);
    let mut text =
        json::serialize::to_vec(&describe(mesh, info, &layout)).map_err(io::Error::from)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = layout.len().next_multiple_of(4);
    let chunks = if binary > 0 { 2 } else { 1 };
    let bytes = HEADER + chunks * CHUNK_HEADER + text.len() as u64 + binary;
    let total = u32::try_from(bytes).map_err(|_| GlbError::TooLarge { bytes })?;

    let mut out = BufWriter::with_capacity(1 << 16, out);
    write_words(&mut out, [MAGIC, 2, total])?;
    write_words(&mut out, [text.len() as u32, JSON_CHUNK])?;
    out.write_all(&text)?;
    if binary > 0 {
        write_words(&mut out, [binary as u32, BIN_CHUNK])?;
        write_numbers(&mut out, mesh, &layout)?;
    }
    Ok(out.flush()?)
}

fn write_words<const N: usize>(out: &mut impl Write, words: [u32; N]) -> io::Result<()> {
    out.write_all(words.map(u32::to_le_bytes).as_flattened())
}

/// The contents of the binary chunk, filled up to whole words.
fn write_numbers(out: &mut impl Write, mesh: &Mesh, layout: &Layout) -> io::Result<()> {
    write_floats(out, mesh.positions.iter().map(|p| p.to_array()))?;
    write_floats(out, mesh.normals.iter().map(|n| n.to_array()))?;
    write_floats(out, mesh.uvs.iter().copied())?;
    for &index in &mesh.indices {
        if layout.short {
            out.write_all(&(index as u16).to_le_bytes())?;
        } else {
            out.write_all(&index.to_le_bytes())?;
        }
    }
    let padding = layout.len().next_multiple_of(4) - layout.len();
    out.write_all(&[0; 3][..padding as usize])
}

/// The JSON description.
fn describe(mesh: &Mesh, info: &TreeInfo, layout: &Layout) -> Root {
    let mut root = Root { asset: asset(info), ..Root::default() };
    let name = name(info);
    let mesh = (!mesh.indices.is_empty()).then(|| push_mesh(&mut root, mesh, layout, &name));
    let node = root.push(json::Node { mesh, name: Some(name), ..json::Node::default() });
    let scene = json::Scene { nodes: vec![node], name: None, extensions: None, extras: None };
    root.scene = Some(root.push(scene));
    root
}

/// The tree's name: species and seed.
fn name(info: &TreeInfo) -> String {
    let species = one_line(&info.species);
    format!("{} {}", if species.is_empty() { "tree" } else { &species }, info.seed)
}

fn asset(info: &TreeInfo) -> json::Asset {
    let extras = serde_json::json!({
        "species": info.species,
        "age": info.age,
        "gravitropism": info.gravitropism,
        "seed": info.seed.to_string(),
    });
    json::Asset {
        generator: Some(format!("DeepTree {}", env!("CARGO_PKG_VERSION"))),
        extras: RawValue::from_string(extras.to_string()).ok(),
        ..json::Asset::default()
    }
}

/// Adds buffer, views, accessors, material and mesh.
fn push_mesh(root: &mut Root, mesh: &Mesh, layout: &Layout, name: &str) -> Index<json::Mesh> {
    let buffer = root.push(json::Buffer {
        byte_length: USize64(layout.len()),
        name: None,
        uri: None,
        extensions: None,
        extras: None,
    });
    let mut offset = 0;
    let [positions, normals, uvs, indices] = [0, 1, 2, 3].map(|part| {
        let target = if part == 3 { Target::ElementArrayBuffer } else { Target::ArrayBuffer };
        let length = layout.parts[part];
        offset += length;
        root.push(view(buffer, offset - length, length, target))
    });
    let vertices = mesh.vertex_count();
    let mut positions = accessor(positions, vertices, ComponentType::F32, Type::Vec3);
    if let Some((low, high)) = mesh.bounds() {
        positions.min = Some(serde_json::json!(low.to_array()));
        positions.max = Some(serde_json::json!(high.to_array()));
    }
    let normals = accessor(normals, vertices, ComponentType::F32, Type::Vec3);
    let uvs = accessor(uvs, vertices, ComponentType::F32, Type::Vec2);
    let kind = if layout.short { ComponentType::U16 } else { ComponentType::U32 };
    let indices = accessor(indices, mesh.indices.len(), kind, Type::Scalar);
    let attributes = BTreeMap::from([
        (Checked::Valid(json::mesh::Semantic::Positions), root.push(positions)),
        (Checked::Valid(json::mesh::Semantic::Normals), root.push(normals)),
        (Checked::Valid(json::mesh::Semantic::TexCoords(0)), root.push(uvs)),
    ]);
    let primitive = json::mesh::Primitive {
        attributes,
        indices: Some(root.push(indices)),
        material: Some(root.push(material())),
        mode: Checked::Valid(json::mesh::Mode::Triangles),
        targets: None,
        extensions: None,
        extras: None,
    };
    root.push(json::Mesh {
        name: Some(name.to_owned()),
        primitives: vec![primitive],
        weights: None,
        extensions: None,
        extras: None,
    })
}

fn view(
    buffer: Index<json::Buffer>,
    offset: u64,
    length: u64,
    target: Target,
) -> json::buffer::View {
    json::buffer::View {
        buffer,
        byte_length: USize64(length),
        byte_offset: Some(USize64(offset)),
        byte_stride: None,
        target: Some(Checked::Valid(target)),
        name: None,
        extensions: None,
        extras: None,
    }
}

fn accessor(
    view: Index<json::buffer::View>,
    count: usize,
    component: ComponentType,
    kind: Type,
) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64(count as u64),
        component_type: Checked::Valid(GenericComponentType(component)),
        type_: Checked::Valid(kind),
        min: None,
        max: None,
        normalized: false,
        sparse: None,
        name: None,
        extensions: None,
        extras: None,
    }
}

fn material() -> json::Material {
    json::Material {
        name: Some("wood".to_owned()),
        pbr_metallic_roughness: json::material::PbrMetallicRoughness {
            base_color_factor: json::material::PbrBaseColorFactor(BARK),
            metallic_factor: json::material::StrengthFactor(0.0),
            roughness_factor: json::material::StrengthFactor(0.9),
            ..Default::default()
        },
        ..Default::default()
    }
}
