//! Leaves as copies of one blade, by `EXT_mesh_gpu_instancing`.
//!
//! # Source
//!
//! The extension's specification, Khronos Group, version 1.

use deeptree_mesh::{Foliage, Leaf};
use gltf::Index;
use gltf::accessor::{ComponentType, Type};
use gltf_json as gltf;

use super::document::{Document, Out, require};
use super::json;
use crate::numbers::write_floats;

const EXTENSION: &str = "EXT_mesh_gpu_instancing";

impl<'a> Document<'a> {
    /// Adds a node with a mesh that stands wherever there is a leaf of this kind.
    pub(super) fn push_instances(
        &mut self,
        name: String,
        kind: &'a Foliage,
        mesh: Index<gltf::Mesh>,
    ) -> Index<gltf::Node> {
        let mut attributes = serde_json::Map::new();
        let mut add = |name: &str, accessor: Index<gltf::Accessor>| {
            attributes.insert(name.to_owned(), accessor.value().into());
        };
        add("TRANSLATION", self.per_leaf(kind, Type::Vec3, |leaf| leaf.position.to_array()));
        add("ROTATION", self.per_leaf(kind, Type::Vec4, |leaf| leaf.rotation.to_array()));
        add("SCALE", self.per_leaf(kind, Type::Vec3, |leaf| [leaf.scale; 3]));
        if self.options.attributes.labels {
            add("_NODE", self.per_leaf(kind, Type::Scalar, |leaf| [leaf.node as f32]));
        }
        require(&mut self.root, EXTENSION);
        let mut extensions = gltf::extensions::scene::Node::default();
        let value = serde_json::json!({ "attributes": attributes });
        extensions.others.insert(EXTENSION.to_owned(), value);
        self.root.push(gltf::Node {
            mesh: Some(mesh),
            name: Some(name),
            extensions: Some(extensions),
            ..gltf::Node::default()
        })
    }

    fn per_leaf<const N: usize>(
        &mut self,
        kind: &'a Foliage,
        shape: Type,
        of: fn(&Leaf) -> [f32; N],
    ) -> Index<gltf::Accessor> {
        let count = kind.leaves.len();
        let write = move |out: &mut Out<'_>| write_floats(out, kind.leaves.iter().map(of));
        let view = self.push_view(4 * (N * count) as u64, None, write);
        self.root.push(json::accessor(view, count, ComponentType::F32, shape))
    }
}
