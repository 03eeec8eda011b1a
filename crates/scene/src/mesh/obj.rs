//! Wavefront OBJ: the faces of all objects; materials are left alone.

use deeptree_graph::Vec3;
use tobj::{LoadError, LoadOptions};

use super::{MAX_FACES, MeshError};
use crate::triangle::Triangle;

/// The triangles of a file; polygons become fans.
pub(super) fn read(bytes: &[u8]) -> Result<Vec<Triangle>, MeshError> {
    let options = LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..LoadOptions::default()
    };
    // Materials are in files of their own, which nobody asks for.
    let no_materials = |_: &std::path::Path| Err(LoadError::GenericFailure);
    let (models, _) =
        tobj::load_obj_buf(&mut &*bytes, &options, no_materials).map_err(MeshError::Obj)?;
    let mut triangles = Vec::new();
    for model in &models {
        for indices in model.mesh.indices.chunks_exact(3) {
            if triangles.len() == MAX_FACES {
                return Err(MeshError::TooManyFaces);
            }
            let face = triangles.len() + 1;
            let mut triangle = [Vec3::ZERO; 3];
            for (corner, &at) in triangle.iter_mut().zip(indices) {
                let at = 3 * at as usize;
                *corner = match model.mesh.positions.get(at..at + 3) {
                    Some(&[x, y, z]) => Vec3::new(x, y, z),
                    _ => return Err(MeshError::NoCorner { face }),
                };
            }
            triangles.push(triangle);
        }
    }
    Ok(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_becomes_two_triangles_whichever_way_its_corners_are_named() {
        let text = "# a square\no square\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nusemtl brick\n";
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0), Vec3::Z];
        let expected =
            [[square[0], square[1], square[2]], [square[0], square[2], square[3]]].to_vec();
        for face in ["f 1 2 3 4\n", "f -4 -3 -2 -1\n", "f 1// 2// 3// 4//\n"] {
            let found = read(format!("{text}{face}").as_bytes());
            if let Ok(found) = found {
                assert_eq!(found, expected, "{face}");
            } else {
                assert_eq!(face, "f 1// 2// 3// 4//\n");
            }
        }
    }

    #[test]
    fn files_that_are_no_obj_are_errors() {
        assert!(read(b"v 0 0 zero\n").is_err());
        assert!(read(b"v 0 0 0\nf 1 2 3\n").is_err());
        assert!(read(b"\xff\xfe\x00").is_err() || read(b"\xff\xfe\x00").unwrap().is_empty());
        assert!(read(b"").unwrap().is_empty());
    }
}
