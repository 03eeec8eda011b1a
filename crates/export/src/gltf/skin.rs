//! Growth as an animation: a skin whose joints travel and swell.
//!
//! Why a skin: morph targets hold every vertex once a target, and what unfolds from a seedling takes
//! dozens; a node with a scale for each branch would cut the surface, which is of one piece, and
//! scale what it bears along with it. Here each joint is two nodes: one that travels, which the next
//! ones stand on, and below it one that swells, which moves the surface. So positions are inherited
//! and sizes are not, all scales are the same in all directions, and nothing but translation and
//! scale is animated: what any player can do. Every key is at the begin or the end of a straight
//! change, so nothing is lost by interpolation.

use std::collections::BTreeMap;
use std::io::Write;

use gltf::accessor::{ComponentType, Type};
use gltf::animation::{Channel, Interpolation, Property, Sampler};
use gltf::buffer::Target;
use gltf::mesh::Semantic;
use gltf::validation::Checked;
use gltf::{Accessor, Animation, Index, Node, Skin};
use gltf_json as gltf;

use deeptree_graph::{TreeInfo, Vec3};

use super::document::{Document, Options, Out};
use super::{GltfError, json};
use crate::numbers::write_floats;
use crate::subject::Subject;
use crate::surface::Surface;
use crate::unfolding::{Joint, Unfolding};

impl<'a> Document<'a> {
    /// Describes a tree with an animation in which it unfolds from a seedling to its full shape.
    /// Without playing it, the full shape is seen. Leaves are surfaces of their own, whatever the
    /// options say of instances.
    ///
    /// # Errors
    ///
    /// As [`Document::new`].
    ///
    /// # Panics
    ///
    /// When it is written, if the unfolding was planned for another tree with fewer nodes.
    pub fn unfolding(
        subject: Subject<'a>,
        unfolding: &'a Unfolding,
        info: &TreeInfo,
        options: Options,
    ) -> Result<Self, GltfError> {
        let mut document = Self::empty(info, Options { instancing: false, ..options });
        let tree = document.push_tree(subject, json::name(info))?;
        let (skeleton, skin) = document.push_skeleton(unfolding);
        // Skinned nodes are roots, as nothing above could move them.
        let children = document.root.nodes[tree.value()].children.take().unwrap_or_default();
        let mut roots = vec![tree];
        roots.extend(children);
        let bare = document.root.nodes[tree.value()].mesh.is_none();
        if !bare {
            document.bind(tree, skin, subject.wood, unfolding);
        }
        for (&node, kind) in roots[1..].iter().zip(subject.leaves()) {
            document.bind(node, skin, kind, unfolding);
        }
        roots.push(skeleton);
        document.show(roots);
        Ok(document)
    }

    /// Lets the joints move the mesh of a node, which shows this surface.
    fn bind<S: Surface>(
        &mut self,
        node: Index<Node>,
        skin: Index<Skin>,
        surface: &'a S,
        unfolding: &'a Unfolding,
    ) {
        let count = surface.vertex_count();
        let mut add = |semantic: Semantic, pick: fn((u8, u8)) -> u8, normalized: bool| {
            let write = move |out: &mut Out<'_>| {
                for (place, node) in surface.anchors().zip(surface.nodes()) {
                    let [first, second] = unfolding.bind(node, place).map(pick);
                    out.write_all(&[first, second, 0, 0])?;
                }
                Ok(())
            };
            let view = self.push_view(4 * count as u64, Some(Target::ArrayBuffer), write);
            let accessor = json::accessor(view, count, ComponentType::U8, Type::Vec4);
            (Checked::Valid(semantic), self.root.push(Accessor { normalized, ..accessor }))
        };
        let joints = add(Semantic::Joints(0), |(joint, _)| joint, false);
        let weights = add(Semantic::Weights(0), |(_, weight)| weight, true);
        let node = &mut self.root.nodes[node.value()];
        node.skin = Some(skin);
        if let Some(mesh) = node.mesh {
            for primitive in &mut self.root.meshes[mesh.value()].primitives {
                primitive.attributes.extend([joints.clone(), weights.clone()]);
            }
        }
    }

    /// Adds the joints and their animation; returns the first joint's node, and the skin.
    fn push_skeleton(&mut self, unfolding: &Unfolding) -> (Index<Node>, Index<Skin>) {
        let joints = unfolding.joints();
        let travels: Vec<Index<Node>> =
            joints.iter().map(|joint| self.travel(joints, joint)).collect();
        let swells: Vec<Index<Node>> =
            joints.iter().map(|_| self.root.push(Node::default())).collect();
        let mut children: Vec<Vec<Index<Node>>> = swells.iter().map(|&swell| vec![swell]).collect();
        for (joint, &travel) in joints.iter().zip(&travels) {
            if let Some(below) = joint.parent {
                children[usize::from(below)].push(travel);
            }
        }
        for (travel, children) in travels.iter().zip(children) {
            self.root.nodes[travel.value()].children = Some(children);
        }
        self.root.nodes[travels[0].value()].name = Some("skeleton".to_owned());
        self.push_animation(unfolding, &travels, &swells);
        let inverse = self.push_inverse(joints);
        let skin = self.root.push(Skin {
            inverse_bind_matrices: Some(inverse),
            joints: swells,
            name: Some("skeleton".to_owned()),
            skeleton: Some(travels[0]),
            extensions: None,
            extras: None,
        });
        (travels[0], skin)
    }

    fn travel(&mut self, joints: &[Joint], joint: &Joint) -> Index<Node> {
        let translation = Some(offset(joints, joint).to_array());
        self.root.push(Node { translation, ..Node::default() })
    }

    /// The inverse bind matrices, column by column.
    fn push_inverse(&mut self, joints: &[Joint]) -> Index<Accessor> {
        let matrices: Vec<[f32; 16]> = joints
            .iter()
            .map(|joint| {
                let Vec3 { x, y, z } = -joint.position;
                [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, z, 1.]
            })
            .collect();
        let count = matrices.len();
        let write = move |out: &mut Out<'_>| write_floats(out, matrices.iter().copied());
        let view = self.push_view(64 * count as u64, None, write);
        self.root.push(json::accessor(view, count, ComponentType::F32, Type::Mat4))
    }

    fn push_animation(
        &mut self,
        unfolding: &Unfolding,
        travels: &[Index<Node>],
        swells: &[Index<Node>],
    ) {
        let mut animation = Animation {
            name: Some("growth".to_owned()),
            channels: Vec::new(),
            samplers: Vec::new(),
            extensions: None,
            extras: None,
        };
        let joints = unfolding.joints();
        let mut keys = Keys::default();
        for ((joint, &travel), &swell) in joints.iter().zip(travels).zip(swells) {
            if let Some(way) = unfolding.way(joint) {
                let whole = offset(joints, joint);
                keys.add(&mut animation, travel, Property::Translation, way, whole);
            }
            if let Some(swelling) = unfolding.swelling(joint) {
                keys.add(&mut animation, swell, Property::Scale, swelling, Vec3::ONE);
            }
        }
        keys.push(self, &mut animation);
        if !animation.channels.is_empty() {
            self.root.push(animation);
        }
    }
}

/// From its parent to a joint.
fn offset(joints: &[Joint], joint: &Joint) -> Vec3 {
    let parent = joint.parent.map(|parent| joints[usize::from(parent)].position);
    joint.position - parent.unwrap_or_default()
}

/// The keys of all channels: times and values that are the same are there once.
#[derive(Default)]
struct Keys {
    /// By their bits, the number of each pair.
    known_times: BTreeMap<[u32; 2], usize>,
    known_values: BTreeMap<[u32; 6], usize>,
    times: Vec<[f32; 2]>,
    values: Vec<[f32; 6]>,
    /// The numbers of the times and the values of each sampler.
    samplers: Vec<(usize, usize)>,
}

impl Keys {
    /// Adds a channel in which a property is `whole` times a share that rises.
    fn add(
        &mut self,
        animation: &mut Animation,
        node: Index<Node>,
        property: Property,
        rise: [(f32, f32); 2],
        whole: Vec3,
    ) {
        let [(begin, from), (end, to)] = rise;
        let [a, b] = [from, to].map(|share| whole * share);
        let (times, values) = ([begin, end], [a.x, a.y, a.z, b.x, b.y, b.z]);
        let time = *self.known_times.entry(times.map(f32::to_bits)).or_insert_with(|| {
            self.times.push(times);
            self.times.len() - 1
        });
        let value = *self.known_values.entry(values.map(f32::to_bits)).or_insert_with(|| {
            self.values.push(values);
            self.values.len() - 1
        });
        let at = self.samplers.iter().position(|&known| known == (time, value));
        let sampler = at.unwrap_or_else(|| {
            self.samplers.push((time, value));
            self.samplers.len() - 1
        });
        animation.channels.push(Channel {
            sampler: Index::new(sampler as u32),
            target: gltf::animation::Target {
                node,
                path: Checked::Valid(property),
                extensions: None,
                extras: None,
            },
            extensions: None,
            extras: None,
        });
    }

    /// Adds all keys to the document and the samplers to the animation.
    fn push(self, document: &mut Document<'_>, animation: &mut Animation) {
        let times = pairs(document, &self.times, Type::Scalar);
        for (index, [begin, end]) in times.iter().zip(&self.times) {
            let accessor = &mut document.root.accessors[index.value()];
            accessor.min = Some(serde_json::json!([begin]));
            accessor.max = Some(serde_json::json!([end]));
        }
        let values = pairs(document, &self.values, Type::Vec3);
        animation.samplers.extend(self.samplers.iter().map(|&(time, value)| Sampler {
            input: times[time],
            interpolation: Checked::Valid(Interpolation::Linear),
            output: values[value],
            extensions: None,
            extras: None,
        }));
    }
}

/// Adds accessors of two elements each, all in one view.
fn pairs<const N: usize>(
    document: &mut Document<'_>,
    rows: &[[f32; N]],
    kind: Type,
) -> Vec<Index<Accessor>> {
    if rows.is_empty() {
        return Vec::new();
    }
    let own = rows.to_vec();
    let write = move |out: &mut Out<'_>| write_floats(out, own.iter().copied());
    let view = document.push_view(4 * (N * rows.len()) as u64, None, write);
    let accessor = |i| {
        let mut accessor = json::accessor(view, 2, ComponentType::F32, kind);
        accessor.byte_offset = Some(gltf::validation::USize64(4 * (N * i) as u64));
        document.root.push(accessor)
    };
    (0..rows.len()).map(accessor).collect()
}
