//! Indexed triangles, and the facts that can be read off them.

use std::ops::Range;

use deeptree_graph::Vec3;

/// A surface of triangles; counter-clockwise seen from outside.
///
/// # Units
///
/// Metres, y up. Texture coordinates count repeats of the texture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Outward unit normals, one a vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a vertex: u around the branch, v along it.
    pub uvs: Vec<[f32; 2]>,
    /// Three vertices a triangle.
    pub indices: Vec<u32>,
    /// The tubes the surface consists of; their ranges follow one another without gaps.
    pub tubes: Vec<Tube>,
}

/// The part of a [`Mesh`] that belongs to one branch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tube {
    /// Which branch, as an index into [`deeptree_graph::branches`].
    pub branch: u32,
    /// Gravelius order of the branch; the trunk has 0.
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
}
