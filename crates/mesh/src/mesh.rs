//! Indexed triangles, and the facts that can be read off them.

use std::ops::Range;

use deeptree_graph::{NodeId, Vec3};

use crate::internode::Internode;

/// A surface of triangles; counter-clockwise seen from outside.
///
/// # Units
///
/// Metres, y up. Texture coordinates count repeats of the texture, v upwards as in OBJ.
///
/// # Seams
///
/// A vertex that needs two texture coordinates or two normals stands there twice, at the same
/// place: the mesh is what a renderer draws. [`Mesh::seams`] says which vertices are such copies,
/// and [`Mesh::welded`] gives the triangles without them: that is the surface which is closed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Outward unit normals, one a vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a vertex: u around the branch, v along it.
    pub uvs: Vec<[f32; 2]>,
    /// The internode that each vertex belongs to, as its node in the branch graph.
    pub nodes: Vec<NodeId>,
    /// Three vertices a triangle.
    pub indices: Vec<u32>,
    /// Copies of vertices at the same place: the copy, and the vertex it stands beside, which is
    /// no copy itself.
    pub seams: Vec<[u32; 2]>,
    /// The tubes the surface consists of; their ranges follow one another without gaps.
    pub tubes: Vec<Tube>,
    /// What vertices inherit from their internode, one for each node of the branch graph.
    pub internodes: Vec<Internode>,
}

/// The part of a [`Mesh`] that was swept along one run of nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tube {
    /// Which branch it starts with, as an index into [`deeptree_graph::branches`].
    pub branch: u32,
    /// Gravelius order of that branch; the trunk has 0.
    pub order: u16,
    /// Its vertices.
    pub vertices: Range<u32>,
    /// Its entries of [`Mesh::indices`].
    pub indices: Range<u32>,
}

impl Mesh {
    /// How many vertices there are, seams counted twice.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// How many triangles there are.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// The three corners of each triangle.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> + '_ {
        self.indices.as_chunks::<3>().0.iter().map(|t| t.map(|i| self.positions[i as usize]))
    }

    /// The triangles with each copy of a vertex replaced by the vertex it stands beside.
    #[must_use]
    pub fn welded(&self) -> Vec<u32> {
        let mut one: Vec<u32> = (0..self.positions.len() as u32).collect();
        for &[copy, original] in &self.seams {
            one[copy as usize] = original;
        }
        self.indices.iter().map(|&i| one[i as usize]).collect()
    }

    /// The internode of a vertex.
    #[must_use]
    pub fn internode(&self, vertex: usize) -> &Internode {
        &self.internodes[self.nodes[vertex] as usize]
    }

    /// The lowest and the highest coordinates, or none for a mesh without vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.positions.first()?;
        let widen = |(low, high): (Vec3, Vec3), &p: &Vec3| (low.min(p), high.max(p));
        Some(self.positions.iter().fold((first, first), widen))
    }

    /// The enclosed volume in cubic metres; where tubes overlap, each counts.
    ///
    /// `V = Σ a · (b × c) / 6` over the triangles (divergence theorem).
    #[must_use]
    pub fn volume(&self) -> f64 {
        // About the first vertex, so that a tree far from the origin keeps its digits.
        let origin = self.positions.first().copied().unwrap_or_default();
        let six = self.triangles().map(|corners| {
            let [a, b, c] = corners.map(|p| (p - origin).to_array().map(f64::from));
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        });
        six.sum::<f64>() / 6.0
    }

    /// The area in square metres; what lies inside other tubes counts too.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.triangles().map(|[a, b, c]| f64::from((b - a).cross(c - a).length()) / 2.0).sum()
    }

    /// Sets the normals to the mean of the faces around each vertex, weighted by area; vertices that
    /// stand beside others with a normal of their own, as at the foot, keep it.
    pub(crate) fn smooth(&mut self) {
        let mut sums = vec![Vec3::ZERO; self.vertex_count()];
        for (t, welded) in
            self.indices.as_chunks::<3>().0.iter().zip(self.welded().as_chunks::<3>().0)
        {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            let face = (b - a).cross(c - a);
            for (&i, &one) in t.iter().zip(welded) {
                // A copy with another normal is an edge.
                let smooth = self.normals[i as usize].dot(self.normals[one as usize]) > 0.5;
                if smooth {
                    sums[one as usize] += face;
                }
            }
        }
        let mut one: Vec<u32> = (0..self.vertex_count() as u32).collect();
        for &[copy, original] in &self.seams {
            let smooth = self.normals[copy as usize].dot(self.normals[original as usize]) > 0.5;
            one[copy as usize] = if smooth { original } else { copy };
        }
        for (normal, one) in self.normals.iter_mut().zip(one) {
            *normal = sums[one as usize].try_normalize().unwrap_or(*normal);
        }
    }

    /// Tangents for normal maps, one a vertex: the direction in which u grows, square to the
    /// normal, and the sign of the bitangent: `bitangent = sign · normal × tangent`, the direction
    /// in which v grows (upwards in the picture).
    ///
    /// Summed over the triangles around each vertex, weighted by area; where a vertex has no
    /// direction of u, any direction square to the normal.
    #[must_use]
    pub fn tangents(&self) -> Vec<[f32; 4]> {
        let mut along_u = vec![Vec3::ZERO; self.vertex_count()];
        let mut sign = vec![0.0f32; self.vertex_count()];
        for t in self.indices.as_chunks::<3>().0 {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            let [p, q, r] = t.map(|i| self.uvs[i as usize]);
            let (b, c) = (b - a, c - a);
            let (u1, v1, u2, v2) = (q[0] - p[0], q[1] - p[1], r[0] - p[0], r[1] - p[1]);
            // Twice the area in the texture: its sign says whether the triangle lies mirrored.
            let turn = u1 * v2 - u2 * v1;
            let side = if turn < 0.0 { -1.0 } else { 1.0 };
            let direction = (b * v2 - c * v1) * side;
            for &i in t {
                along_u[i as usize] += direction;
                sign[i as usize] += turn;
            }
        }
        let one = |((tangent, normal), sign): ((&Vec3, &Vec3), &f32)| {
            let flat = *tangent - *normal * normal.dot(*tangent);
            let t = flat.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
            [t.x, t.y, t.z, if *sign < 0.0 { -1.0 } else { 1.0 }]
        };
        along_u.iter().zip(&self.normals).zip(&sign).map(one).collect()
    }
}
