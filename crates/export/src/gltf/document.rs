//! The description of a tree, and where its numbers come from.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use deeptree_graph::TreeInfo;
use deeptree_mesh::{Foliage, Internode, Material};
use gltf::accessor::{ComponentType, Type};
use gltf::buffer::{Target, View};
use gltf::validation::Checked;
use gltf::{Accessor, Index, Root};
use gltf_json as gltf;

use super::GltfError;
use super::json;
use super::materials::{Materials, Wrap};
use super::parts::{Attributes, Part};
use crate::subject::Subject;
use crate::surface::Surface;

/// How a tree is described.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// More attributes of vertices.
    pub attributes: Attributes,
    /// One blade and the places of its leaves in place of a surface for each leaf, by
    /// `EXT_mesh_gpu_instancing`: files are much smaller, and programs must know the extension.
    pub instancing: bool,
}

/// What numbers are written through.
pub(super) type Out<'w> = BufWriter<&'w mut dyn Write>;

type Writer<'a> = dyn Fn(&mut Out<'_>) -> io::Result<()> + 'a;

/// A part of the buffer, filled up to whole words.
pub(super) struct Block<'a> {
    bytes: u64,
    write: Box<Writer<'a>>,
}

/// A tree as glTF describes it, ready to be written.
pub struct Document<'a> {
    pub(super) root: Root,
    pub(super) materials: Materials,
    pub(super) options: Options,
    pub(super) blocks: Vec<Block<'a>>,
    /// Bytes of all blocks, with what fills them up.
    pub(super) bytes: u64,
}

impl<'a> Document<'a> {
    /// Describes a tree: a node with the wood, and below it a node with each kind of leaf.
    ///
    /// `asset.extras` holds the tree's `species`, `age`, `gravitropism` and `seed`; the seed as
    /// decimal text, for JSON readers that keep numbers as doubles would round it. Indices have 16
    /// bits where that is enough. Wood without triangles gives a node without a mesh.
    ///
    /// # Errors
    ///
    /// When a picture of a material is not sound.
    pub fn new(subject: Subject<'a>, info: &TreeInfo, options: Options) -> Result<Self, GltfError> {
        let mut document = Self::empty(info, options);
        let node = document.push_tree(subject, json::name(info))?;
        document.show(vec![node]);
        Ok(document)
    }

    /// A description of nothing yet.
    pub(super) fn empty(info: &TreeInfo, options: Options) -> Self {
        let root = Root { asset: json::asset(&json::extras(info, None)), ..Root::default() };
        Self { root, materials: Materials::default(), options, blocks: Vec::new(), bytes: 0 }
    }

    /// Makes these nodes what is seen.
    pub(super) fn show(&mut self, nodes: Vec<Index<gltf::Node>>) {
        let scene = gltf::Scene { nodes, name: None, extensions: None, extras: None };
        self.root.scene = Some(self.root.push(scene));
    }

    pub(super) fn push_tree(
        &mut self,
        subject: Subject<'a>,
        name: String,
    ) -> Result<Index<gltf::Node>, GltfError> {
        let mut node = gltf::Node { name: Some(name.clone()), ..gltf::Node::default() };
        let wood = subject.wood;
        if !wood.indices.is_empty() {
            let material = self.material(subject.bark, Wrap::Repeat)?;
            let wanted = self.wanted(subject.bark.normal_image.is_some());
            let primitive = self.push_surface(wood, &wood.internodes, material, wanted);
            node.mesh = Some(self.push_mesh(primitive, name));
        }
        // Children before the node: it names them.
        let leaves = subject
            .named_leaves()
            .into_iter()
            .map(|(name, kind)| self.push_leaves(name, kind, &wood.internodes))
            .collect::<Result<Vec<_>, _>>()?;
        node.children = (!leaves.is_empty()).then_some(leaves);
        Ok(self.root.push(node))
    }

    fn push_leaves(
        &mut self,
        name: String,
        kind: &'a Foliage,
        internodes: &'a [Internode],
    ) -> Result<Index<gltf::Node>, GltfError> {
        let material = self.material(&kind.material, Wrap::Clamp)?;
        let tangents = kind.material.normal_image.is_some();
        if self.options.instancing {
            let wanted = Attributes { tangents, ..Attributes::default() };
            let primitive = self.push_surface(&kind.blade, &[], material, wanted);
            let mesh = self.push_mesh(primitive, name.clone());
            return Ok(self.push_instances(name, kind, mesh));
        }
        let wanted = self.wanted(tangents);
        let primitive = self.push_surface(kind, internodes, material, wanted);
        let mesh = Some(self.push_mesh(primitive, name.clone()));
        Ok(self.root.push(gltf::Node { mesh, name: Some(name), ..gltf::Node::default() }))
    }

    /// The attributes that are asked for, and tangents where a material needs them.
    fn wanted(&self, tangents: bool) -> Attributes {
        let wanted = self.options.attributes;
        Attributes { tangents: wanted.tangents || tangents, ..wanted }
    }

    fn material(
        &mut self,
        material: &Material,
        wrap: Wrap,
    ) -> Result<Index<gltf::Material>, GltfError> {
        self.materials
            .index(&mut self.root, material, wrap)
            .map_err(|source| GltfError::Image { material: material.name.clone(), source })
    }

    fn push_mesh(&mut self, primitive: gltf::mesh::Primitive, name: String) -> Index<gltf::Mesh> {
        self.root.push(gltf::Mesh {
            name: Some(name),
            primitives: vec![primitive],
            weights: None,
            extensions: None,
            extras: None,
        })
    }

    /// Adds the vertices and triangles of a surface.
    fn push_surface<S: Surface>(
        &mut self,
        surface: &'a S,
        internodes: &'a [Internode],
        material: Index<gltf::Material>,
        wanted: Attributes,
    ) -> gltf::mesh::Primitive {
        let vertices = surface.vertex_count();
        let mut attributes = BTreeMap::new();
        for part in Part::all(wanted) {
            let bytes = part.bytes() * vertices as u64;
            let write = move |out: &mut Out<'_>| part.write(surface, internodes, out);
            let view = self.push_view(bytes, Some(Target::ArrayBuffer), write);
            let mut accessor = json::accessor(view, vertices, ComponentType::F32, part.kind());
            if let (Part::Position, Some((low, high))) = (part, surface.bounds()) {
                accessor.min = Some(serde_json::json!(low.to_array()));
                accessor.max = Some(serde_json::json!(high.to_array()));
            }
            attributes.insert(Checked::Valid(part.semantic()), self.root.push(accessor));
        }
        gltf::mesh::Primitive {
            attributes,
            indices: Some(self.push_indices(surface)),
            material: Some(material),
            mode: Checked::Valid(gltf::mesh::Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        }
    }

    fn push_indices(&mut self, surface: &'a impl Surface) -> Index<Accessor> {
        // 65535 is not a vertex in 16 bits, it restarts strips.
        let short = surface.vertex_count() as u64 <= u64::from(u16::MAX);
        let (kind, size) = if short { (ComponentType::U16, 2) } else { (ComponentType::U32, 4) };
        let count = 3 * surface.triangle_count();
        let write = move |out: &mut Out<'_>| {
            for corners in surface.triangles() {
                if short {
                    out.write_all(corners.map(|i| (i as u16).to_le_bytes()).as_flattened())?;
                } else {
                    out.write_all(corners.map(u32::to_le_bytes).as_flattened())?;
                }
            }
            Ok(())
        };
        let view = self.push_view(size * count as u64, Some(Target::ElementArrayBuffer), write);
        self.root.push(json::accessor(view, count, kind, Type::Scalar))
    }

    /// Adds a part of the buffer, whose numbers `write` writes.
    pub(super) fn push_view(
        &mut self,
        bytes: u64,
        target: Option<Target>,
        write: impl Fn(&mut Out<'_>) -> io::Result<()> + 'a,
    ) -> Index<View> {
        let view = self.root.push(json::view(self.bytes, bytes, target));
        self.bytes += bytes.next_multiple_of(4);
        self.blocks.push(Block { bytes, write: Box::new(write) });
        view
    }

    /// The contents of the buffer.
    pub(super) fn write_blocks(&self, out: &mut Out<'_>) -> io::Result<()> {
        for block in &self.blocks {
            (block.write)(out)?;
            let padding = block.bytes.next_multiple_of(4) - block.bytes;
            out.write_all(&[0; 3][..padding as usize])?;
        }
        Ok(())
    }
}

/// Says that the description uses an extension.
pub(super) fn note(root: &mut Root, extension: &str) {
    if !root.extensions_used.iter().any(|known| known == extension) {
        root.extensions_used.push(extension.to_owned());
    }
}

/// Says that the description means nothing without an extension.
pub(super) fn require(root: &mut Root, extension: &str) {
    note(root, extension);
    if !root.extensions_required.iter().any(|known| known == extension) {
        root.extensions_required.push(extension.to_owned());
    }
}
