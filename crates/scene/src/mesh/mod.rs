//! Triangle meshes: what of them is solid, and reading them from files.

mod glb;
mod obj;

use std::collections::BTreeMap;

use deeptree_graph::Vec3;
use glam::DVec3;

use crate::boxes::{FARTHEST, is_within_reach};
use crate::index::Index;
use crate::triangle::{self, Triangle};

/// The most faces a mesh may have.
pub const MAX_FACES: usize = 1_000_000;

/// What is wrong with a mesh.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MeshError {
    #[error("meshes are read from .obj and .glb files")]
    Format,
    #[error("this is no OBJ file ({0})")]
    Obj(tobj::LoadError),
    #[error("this is no GLB file ({0})")]
    Glb(String),
    #[error("it has more than {MAX_FACES} faces; reduce it first")]
    TooManyFaces,
    #[error("it has no faces")]
    NoFaces,
    #[error("face {face} names a corner that is not there")]
    NoCorner { face: usize },
    #[error("face {face} has a corner that is no number, or farther off than {FARTHEST} m")]
    Number { face: usize },
}

/// Triangles in metres, y up.
///
/// A piece whose faces close it, all the same way round, is solid: points can lie inside. Any other
/// piece is a sheet, which hides the sky and stops branches, but has no inside. Two corners are the
/// same when their coordinates are.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    triangles: Vec<Triangle>,
    /// Does the triangle belong to a solid piece?
    solid: Vec<bool>,
    /// Edges of sheets that have not one face on each side.
    open_edges: usize,
    bounds: [Vec3; 2],
    index: Index,
}

impl PartialEq for TriangleMesh {
    /// The rest follows from the triangles.
    fn eq(&self, other: &Self) -> bool {
        self.triangles == other.triangles
    }
}

impl TriangleMesh {
    /// The mesh of these triangles; those without area are left out.
    ///
    /// # Errors
    ///
    /// When there are none or too many, or a corner is no place.
    pub fn new(triangles: Vec<[Vec3; 3]>) -> Result<Self, MeshError> {
        if triangles.len() > MAX_FACES {
            return Err(MeshError::TooManyFaces);
        }
        let is_wrong =
            |triangle: &Triangle| !triangle.iter().all(|&corner| is_within_reach(corner));
        if let Some(face) = triangles.iter().position(is_wrong) {
            return Err(MeshError::Number { face: face + 1 });
        }
        // −0 is 0: corners are compared by their bits.
        let mut triangles: Vec<Triangle> =
            triangles.into_iter().map(|t| t.map(|corner| corner + Vec3::ZERO)).collect();
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        if triangles.is_empty() {
            return Err(MeshError::NoFaces);
        }
        let (solid, open_edges) = pieces(&triangles);
        let bounds = triangles.iter().flatten().fold(
            [Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY)],
            |[low, high], &corner| [low.min(corner), high.max(corner)],
        );
        let index =
            Index::new(triangles.iter().map(|[a, b, c]| [a.min(*b).min(*c), a.max(*b).max(*c)]));
        Ok(Self { triangles, solid, open_edges, bounds, index })
    }

    /// Reads the bytes of a file; its name says which format.
    ///
    /// # Errors
    ///
    /// When the name ends otherwise than in `.obj` or `.glb`, or the file holds no mesh.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, MeshError> {
        let lower = name.to_lowercase();
        let triangles = if lower.ends_with(".obj") {
            obj::read(bytes)?
        } else if lower.ends_with(".glb") {
            glb::read(bytes)?
        } else {
            return Err(MeshError::Format);
        };
        Self::new(triangles)
    }

    /// The triangles.
    #[must_use]
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }

    /// Which triangles belong to solid pieces.
    #[must_use]
    pub fn solid(&self) -> &[bool] {
        &self.solid
    }

    /// How many edges keep sheets from being solid; 0 when all of the mesh is.
    #[must_use]
    pub fn open_edges(&self) -> usize {
        self.open_edges
    }

    /// The lowest and the highest corner, in metres.
    #[must_use]
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// The same mesh, moved.
    ///
    /// # Errors
    ///
    /// When it is moved out of reach.
    pub fn moved(&self, by: Vec3) -> Result<Self, MeshError> {
        Self::new(self.triangles.iter().map(|t| t.map(|corner| corner + by)).collect())
    }

    /// Does a point lie inside a solid piece?
    ///
    /// How often the surface winds around the point, by the crossings of a ray: a room within a
    /// solid piece, whose faces look inwards, is outside, and where two pieces overlap is inside.
    #[must_use]
    pub fn contains(&self, point: Vec3) -> bool {
        let [low, high] = self.bounds;
        if !(point.cmpge(low).all() && point.cmple(high).all()) {
            return false;
        }
        // No edge of a drawn house runs this way.
        const ALONG: Vec3 = Vec3::new(0.436_917_4, 0.812_345_6, 0.386_217_9);
        let mut winding = 0;
        self.index.any_along(point, ALONG, f32::INFINITY, |i| {
            if self.solid[i] {
                let meeting =
                    triangle::meeting(&self.triangles[i], point.as_dvec3(), ALONG.as_dvec3());
                if let Some((_, from_front)) = meeting.filter(|&(at, _)| at >= 0.0) {
                    winding += if from_front { 1 } else { -1 };
                }
            }
            false
        });
        winding != 0
    }

    /// Does the ray `from + s · along` meet a triangle at some s in \[0, `most`\]?
    pub(crate) fn meets(&self, from: Vec3, along: Vec3, most: f64) -> bool {
        let (start, direction) = (from.as_dvec3(), along.as_dvec3());
        self.index.any_along(from, along, most as f32, |i| {
            triangle::meeting(&self.triangles[i], start, direction)
                .is_some_and(|(at, _)| (0.0..=most).contains(&at))
        })
    }

    /// Does a triangle reach into the box of this centre and these half sides?
    pub(crate) fn reaches(&self, centre: DVec3, half: DVec3) -> bool {
        let (low, high) = ((centre - half).as_vec3(), (centre + half).as_vec3());
        self.index.any_within(low, high, |i| {
            if self.solid[i] {
                triangle::reaches_into(&self.triangles[i], centre, half)
            } else {
                triangle::meets(&self.triangles[i], centre, half)
            }
        })
    }
}

/// Which triangles belong to solid pieces, and how many edges are open.
fn pieces(triangles: &[Triangle]) -> (Vec<bool>, usize) {
    let mut numbers = BTreeMap::new();
    let corners: Vec<[usize; 3]> = triangles
        .iter()
        .map(|triangle| {
            triangle.map(|corner| {
                let next = numbers.len();
                *numbers.entry(corner.to_array().map(f32::to_bits)).or_insert(next)
            })
        })
        .collect();
    // Pieces: corners that triangles connect, each leading to a lower one or to itself.
    let mut lower: Vec<usize> = (0..numbers.len()).collect();
    let find = |lower: &mut Vec<usize>, mut at: usize| {
        while lower[at] != at {
            lower[at] = lower[lower[at]];
            at = lower[at];
        }
        at
    };
    // How often an edge runs up minus how often down, by the numbers of its ends.
    let mut edges: BTreeMap<[usize; 2], i32> = BTreeMap::new();
    for &[a, b, c] in &corners {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([from.min(to), from.max(to)]).or_default() +=
                if from < to { 1 } else { -1 };
            let (one, other) = (find(&mut lower, from), find(&mut lower, to));
            lower[one.max(other)] = one.min(other);
        }
    }
    let mut open = vec![false; numbers.len()];
    let mut open_edges = 0;
    for (&[from, _], &count) in &edges {
        if count != 0 {
            open_edges += 1;
            open[find(&mut lower, from)] = true;
        }
    }
    let solid = corners.iter().map(|&[a, ..]| !open[find(&mut lower, a)]).collect();
    (solid, open_edges)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The faces of a box, looking outwards.
    pub(crate) fn faces(low: Vec3, high: Vec3) -> Vec<Triangle> {
        let corner = |i: usize| {
            let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        // Anticlockwise from outside; bit 0 is x, bit 1 y, bit 2 z.
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
            .into_iter()
            .flat_map(|[a, b, c, d]| {
                let [a, b, c, d] = [a, b, c, d].map(corner);
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    pub(crate) fn inwards(mut triangles: Vec<Triangle>) -> Vec<Triangle> {
        for triangle in &mut triangles {
            triangle.swap(1, 2);
        }
        triangles
    }

    #[test]
    fn the_faces_of_a_box_make_a_solid_piece_and_without_one_a_sheet() {
        let faces = faces(Vec3::ZERO, Vec3::splat(2.0));
        let whole = TriangleMesh::new(faces.clone()).unwrap();
        assert_eq!(whole.open_edges(), 0);
        assert!(whole.solid().iter().all(|&solid| solid));
        assert!(whole.contains(Vec3::ONE) && !whole.contains(Vec3::new(1.0, 3.0, 1.0)));
        // A triangle has three edges.
        let broken = TriangleMesh::new(faces[1..].to_vec()).unwrap();
        assert_eq!(broken.open_edges(), 3);
        assert!(!broken.contains(Vec3::ONE));
        assert!(broken.meets(Vec3::new(1.0, 5.0, 0.5), Vec3::NEG_Y, 10.0));
    }

    #[test]
    fn a_room_is_outside_and_where_pieces_overlap_is_inside() {
        let mut hollow = faces(Vec3::splat(-4.0), Vec3::splat(4.0));
        hollow.extend(inwards(faces(Vec3::splat(-3.0), Vec3::splat(3.0))));
        let hollow = TriangleMesh::new(hollow).unwrap();
        assert!(!hollow.contains(Vec3::ZERO) && hollow.contains(Vec3::new(3.5, 0.0, 0.0)));

        let mut two = faces(Vec3::splat(-4.0), Vec3::splat(1.0));
        two.extend(faces(Vec3::splat(-1.0), Vec3::splat(4.0)));
        let two = TriangleMesh::new(two).unwrap();
        assert!(two.contains(Vec3::ZERO) && two.contains(Vec3::splat(-3.0)));
        assert!(!two.contains(Vec3::new(-3.0, 3.0, 0.0)));
    }

    #[test]
    fn a_piece_that_is_inside_out_is_solid_still() {
        let mesh = TriangleMesh::new(inwards(faces(Vec3::ZERO, Vec3::ONE))).unwrap();
        assert!(mesh.contains(Vec3::splat(0.5)) && !mesh.contains(Vec3::splat(1.5)));
    }

    #[test]
    fn meshes_that_cannot_be_are_told_why() {
        assert!(matches!(TriangleMesh::new(Vec::new()), Err(MeshError::NoFaces)));
        let flat = vec![[Vec3::ZERO, Vec3::ZERO, Vec3::X]];
        assert!(matches!(TriangleMesh::new(flat), Err(MeshError::NoFaces)));
        let wrong = vec![[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::ZERO, Vec3::X, Vec3::NAN]];
        assert!(matches!(TriangleMesh::new(wrong), Err(MeshError::Number { face: 2 })));
        let many = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]; MAX_FACES + 1];
        assert!(matches!(TriangleMesh::new(many), Err(MeshError::TooManyFaces)));
        assert!(matches!(TriangleMesh::from_bytes("house.stl", b""), Err(MeshError::Format)));
    }
}
