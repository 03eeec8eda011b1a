//! The vertices and triangles of wood and of leaves, one after another, as files want them.

use deeptree_graph::{NodeId, Vec3};
use deeptree_mesh::{Blade, Foliage, Leaf, Mesh};

/// Triangles that can be gone through without a copy of them in memory.
pub(crate) trait Surface {
    fn vertex_count(&self) -> usize;
    fn triangle_count(&self) -> usize;
    fn positions(&self) -> impl Iterator<Item = Vec3>;
    fn normals(&self) -> impl Iterator<Item = Vec3>;
    /// v upwards.
    fn uvs(&self) -> impl Iterator<Item = [f32; 2]>;
    /// As [`Mesh::tangents`].
    fn tangents(&self) -> impl Iterator<Item = [f32; 4]>;
    fn nodes(&self) -> impl Iterator<Item = NodeId>;
    fn triangles(&self) -> impl Iterator<Item = [u32; 3]>;

    /// Where each vertex is held by the tree: itself, or the foot of its leaf.
    fn anchors(&self) -> impl Iterator<Item = Vec3> {
        self.positions()
    }

    /// The lowest and the highest coordinates; none without vertices.
    fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let mut positions = self.positions();
        let first = positions.next()?;
        Some(positions.fold((first, first), |(low, high), p| (low.min(p), high.max(p))))
    }
}

impl Surface for Mesh {
    fn vertex_count(&self) -> usize {
        self.vertex_count()
    }

    fn triangle_count(&self) -> usize {
        self.triangle_count()
    }

    fn positions(&self) -> impl Iterator<Item = Vec3> {
        self.positions.iter().copied()
    }

    fn normals(&self) -> impl Iterator<Item = Vec3> {
        self.normals.iter().copied()
    }

    fn uvs(&self) -> impl Iterator<Item = [f32; 2]> {
        self.uvs.iter().copied()
    }

    fn tangents(&self) -> impl Iterator<Item = [f32; 4]> {
        self.tangents().into_iter()
    }

    fn nodes(&self) -> impl Iterator<Item = NodeId> {
        self.nodes.iter().copied()
    }

    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.indices.as_chunks::<3>().0.iter().copied()
    }
}

/// Each leaf as triangles of its own, leaf by leaf.
impl Surface for Foliage {
    fn vertex_count(&self) -> usize {
        self.leaves.len() * self.blade.positions.len()
    }

    fn triangle_count(&self) -> usize {
        self.leaves.len() * self.blade.indices.len() / 3
    }

    fn positions(&self) -> impl Iterator<Item = Vec3> {
        self.leaves.iter().flat_map(|leaf| self.blade.positions.iter().map(|&p| placed(leaf, p)))
    }

    fn normals(&self) -> impl Iterator<Item = Vec3> {
        self.leaves.iter().flat_map(|leaf| self.blade.normals.iter().map(|&n| turned(leaf, n)))
    }

    fn uvs(&self) -> impl Iterator<Item = [f32; 2]> {
        self.leaves.iter().flat_map(|_| self.blade.uvs.iter().copied())
    }

    fn tangents(&self) -> impl Iterator<Item = [f32; 4]> {
        let of_blade = self.blade.tangents().collect::<Vec<_>>();
        self.leaves.iter().flat_map(move |leaf| {
            let turn = |[x, y, z, sign]: [f32; 4]| {
                let t = turned(leaf, Vec3::new(x, y, z));
                [t.x, t.y, t.z, sign]
            };
            of_blade.iter().copied().map(turn).collect::<Vec<_>>()
        })
    }

    fn nodes(&self) -> impl Iterator<Item = NodeId> {
        self.leaves.iter().flat_map(|leaf| self.blade.positions.iter().map(|_| leaf.node))
    }

    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let size = self.blade.positions.len() as u32;
        let corners = self.blade.indices.as_chunks::<3>().0;
        (0..self.leaves.len() as u32)
            .flat_map(move |leaf| corners.iter().map(move |t| t.map(|i| i + leaf * size)))
    }

    fn anchors(&self) -> impl Iterator<Item = Vec3> {
        self.leaves.iter().flat_map(|leaf| self.blade.positions.iter().map(|_| leaf.position))
    }
}

/// The one blade, in its own frame.
impl Surface for Blade {
    fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    fn positions(&self) -> impl Iterator<Item = Vec3> {
        self.positions.iter().copied()
    }

    fn normals(&self) -> impl Iterator<Item = Vec3> {
        self.normals.iter().copied()
    }

    fn uvs(&self) -> impl Iterator<Item = [f32; 2]> {
        self.uvs.iter().copied()
    }

    fn tangents(&self) -> impl Iterator<Item = [f32; 4]> {
        let mesh = Mesh {
            positions: self.positions.clone(),
            normals: self.normals.clone(),
            uvs: self.uvs.clone(),
            indices: self.indices.clone(),
            ..Mesh::default()
        };
        mesh.tangents().into_iter()
    }

    /// It stands on none.
    fn nodes(&self) -> impl Iterator<Item = NodeId> {
        std::iter::repeat_n(0, self.positions.len())
    }

    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.indices.as_chunks::<3>().0.iter().copied()
    }
}

fn placed(leaf: &Leaf, p: Vec3) -> Vec3 {
    leaf.position + leaf.scale * (leaf.rotation * p)
}

/// A direction of the blade in the world; of length 1 again after rounding.
fn turned(leaf: &Leaf, direction: Vec3) -> Vec3 {
    (leaf.rotation * direction).normalize_or(Vec3::Y)
}
