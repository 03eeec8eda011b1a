//! Binary glTF 2.0 (`.glb`): one node with one mesh of one primitive and one material.
//!
//! # Source
//!
//! glTF 2.0 specification, Khronos Group, §3.6 (binary data), §3.7 (geometry), §4 (container).

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use deeptree_graph::TreeInfo;
use deeptree_mesh::{Internode, Mesh};
use gltf_json as json;
use json::accessor::{ComponentType, GenericComponentType, Type};
use json::buffer::Target;
use json::mesh::Semantic;
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

/// What is written of each vertex besides position, normal and texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attributes {
    /// `TANGENT`, for normal maps.
    pub tangents: bool,
    /// `_BRANCH`, `_ORDER` and `_NODE`: number of the Gravelius branch, its order, and number of
    /// the node in the branch graph; as floats, for vertices may not hold integers of 32 bits.
    pub labels: bool,
    /// `_PIVOT`, `_PHASE` and `_STIFFNESS`: where the branch swings about in the wind in metres,
    /// when as a share of a period, and its radius as a share of the trunk's.
    pub wind: bool,
}

/// One property of all vertices.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Position,
    Normal,
    TexCoord,
    Tangent,
    Branch,
    Order,
    Node,
    Pivot,
    Phase,
    Stiffness,
}

impl Part {
    /// The properties that are written.
    fn all(wanted: Attributes) -> Vec<Self> {
        let mut all = vec![Self::Position, Self::Normal, Self::TexCoord];
        if wanted.tangents {
            all.push(Self::Tangent);
        }
        if wanted.labels {
            all.extend([Self::Branch, Self::Order, Self::Node]);
        }
        if wanted.wind {
            all.extend([Self::Pivot, Self::Phase, Self::Stiffness]);
        }
        all
    }

    const fn kind(self) -> Type {
        match self {
            Self::Position | Self::Normal | Self::Pivot => Type::Vec3,
            Self::TexCoord => Type::Vec2,
            Self::Tangent => Type::Vec4,
            Self::Branch | Self::Order | Self::Node | Self::Phase | Self::Stiffness => Type::Scalar,
        }
    }

    /// Bytes a vertex.
    fn bytes(self) -> u64 {
        4 * self.kind().multiplicity() as u64
    }

    fn semantic(self) -> Semantic {
        let own = |name: &str| Semantic::Extras(name.to_owned());
        match self {
            Self::Position => Semantic::Positions,
            Self::Normal => Semantic::Normals,
            Self::TexCoord => Semantic::TexCoords(0),
            Self::Tangent => Semantic::Tangents,
            Self::Branch => own("BRANCH"),
            Self::Order => own("ORDER"),
            Self::Node => own("NODE"),
            Self::Pivot => own("PIVOT"),
            Self::Phase => own("PHASE"),
            Self::Stiffness => own("STIFFNESS"),
        }
    }

    fn write(self, mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
        let scalars = |out: &mut _, of: fn(&Internode) -> f32| {
            write_floats(out, (0..mesh.vertex_count()).map(|i| [of(mesh.internode(i))]))
        };
        match self {
            Self::Position => write_floats(out, mesh.positions.iter().map(|p| p.to_array())),
            Self::Normal => write_floats(out, mesh.normals.iter().map(|n| n.to_array())),
            // v runs downwards here.
            Self::TexCoord => write_floats(out, mesh.uvs.iter().map(|&[u, v]| [u, -v])),
            Self::Tangent => write_floats(out, mesh.tangents().into_iter()),
            Self::Branch => scalars(out, |internode| internode.branch as f32),
            Self::Order => scalars(out, |internode| f32::from(internode.order)),
            Self::Node => write_floats(out, mesh.nodes.iter().map(|&node| [node as f32])),
            Self::Pivot => {
                let pivot = |i| mesh.internode(i).pivot.to_array();
                write_floats(out, (0..mesh.vertex_count()).map(pivot))
            }
            Self::Phase => scalars(out, |internode| internode.phase),
            Self::Stiffness => scalars(out, |internode| internode.stiffness),
        }
    }
}

/// Where the parts of the binary chunk lie: the properties of the vertices, then the indices.
struct Layout {
    parts: Vec<Part>,
    /// Bytes of all indices.
    indices: u64,
    /// Whether indices have 16 bits; 65535 is not a vertex then, it restarts strips.
    short: bool,
}

impl Layout {
    fn of(mesh: &Mesh, wanted: Attributes) -> Self {
        let short = mesh.vertex_count() as u64 <= u64::from(u16::MAX);
        let index = if short { 2 } else { 4 };
        Self { parts: Part::all(wanted), indices: index * mesh.indices.len() as u64, short }
    }

    fn len(&self, mesh: &Mesh) -> u64 {
        let vertices = mesh.vertex_count() as u64;
        self.parts.iter().map(|part| part.bytes() * vertices).sum::<u64>() + self.indices
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
    write_with(mesh, info, Attributes::default(), out)
}

/// As [`write`], with more attributes.
///
/// # Errors
///
/// When the file would pass the 4 GiB that the format can count, or the output fails.
pub fn write_with(
    mesh: &Mesh,
    info: &TreeInfo,
    attributes: Attributes,
    out: &mut impl Write,
) -> Result<(), GlbError> {
    let layout = Layout::of(mesh, attributes);
    let mut text =
        json::serialize::to_vec(&describe(mesh, info, &layout)).map_err(io::Error::from)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = layout.len(mesh).next_multiple_of(4);
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
    for part in &layout.parts {
        part.write(mesh, out)?;
    }
    for &index in &mesh.indices {
        if layout.short {
            out.write_all(&(index as u16).to_le_bytes())?;
        } else {
            out.write_all(&index.to_le_bytes())?;
        }
    }
    let padding = layout.len(mesh).next_multiple_of(4) - layout.len(mesh);
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
        byte_length: USize64(layout.len(mesh)),
        name: None,
        uri: None,
        extensions: None,
        extras: None,
    });
    let vertices = mesh.vertex_count();
    let mut offset = 0;
    let mut attributes = BTreeMap::new();
    for part in &layout.parts {
        let length = part.bytes() * vertices as u64;
        let view = root.push(view(buffer, offset, length, Target::ArrayBuffer));
        offset += length;
        let mut accessor = accessor(view, vertices, ComponentType::F32, part.kind());
        if let (Part::Position, Some((low, high))) = (part, mesh.bounds()) {
            accessor.min = Some(serde_json::json!(low.to_array()));
            accessor.max = Some(serde_json::json!(high.to_array()));
        }
        attributes.insert(Checked::Valid(part.semantic()), root.push(accessor));
    }
    let indices = root.push(view(buffer, offset, layout.indices, Target::ElementArrayBuffer));
    let kind = if layout.short { ComponentType::U16 } else { ComponentType::U32 };
    let indices = accessor(indices, mesh.indices.len(), kind, Type::Scalar);
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
