//! Binary glTF: the triangles of the default scene, with the transforms of its nodes.

use std::collections::BTreeSet;

use deeptree_graph::Vec3;
use glam::Mat4;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};

use super::{MAX_FACES, MeshError};
use crate::triangle::Triangle;

/// Bytes of a file's header, by which its length begins.
const HEADER: u32 = 12;

/// The triangles of a file. glTF is in metres with y up, as we are.
pub(super) fn read(bytes: &[u8]) -> Result<Vec<Triangle>, MeshError> {
    if !bytes.starts_with(b"glTF") {
        return Err(wrong("it does not begin with glTF"));
    }
    let failed = |error: gltf::Error| wrong(&one_line(&error.to_string()));
    // The reader subtracts the header's size from what the header says.
    if let Some(&[a, b, c, d]) = bytes.get(8..12)
        && u32::from_le_bytes([a, b, c, d]) < HEADER
    {
        return Err(wrong("its header says that it ends within itself"));
    }
    let file = Gltf::from_slice_without_validation(bytes).map_err(failed)?;
    let description = file.document.into_json();
    // The validation looks positions up before it has made sure that they are there.
    let primitives = description.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let mut attributes = primitives.flat_map(|primitive| primitive.attributes.values());
    if attributes.any(|index| index.value() >= description.accessors.len()) {
        return Err(wrong("a mesh names numbers that are not there"));
    }
    let document = Document::from_json(description).map_err(failed)?;
    let blob = file.blob.as_deref().unwrap_or_default();
    let mut open: Vec<(Node<'_>, Mat4)> =
        roots(&document).into_iter().map(|node| (node, Mat4::IDENTITY)).collect();
    let (mut triangles, mut seen) = (Vec::new(), BTreeSet::new());
    while let Some((node, above)) = open.pop() {
        // A file whose nodes go round in circles would never end.
        if !seen.insert(node.index()) {
            return Err(wrong("a node has two parents"));
        }
        let transform = above * Mat4::from_cols_array_2d(&node.transform().matrix());
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            add(&primitive, transform, blob, &mut triangles)?;
        }
        open.extend(node.children().map(|child| (child, transform)));
    }
    Ok(triangles)
}

fn wrong(what: &str) -> MeshError {
    MeshError::Glb(what.to_owned())
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The nodes that the default scene starts with, or, without scenes, those without a parent.
fn roots(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let children: BTreeSet<usize> = document
        .nodes()
        .flat_map(|node| node.children().map(|c| c.index()).collect::<Vec<_>>())
        .collect();
    document.nodes().filter(|node| !children.contains(&node.index())).collect()
}

/// Adds the triangles of a primitive; points and lines have none.
fn add(
    primitive: &Primitive<'_>,
    transform: Mat4,
    blob: &[u8],
    triangles: &mut Vec<Triangle>,
) -> Result<(), MeshError> {
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
    if (positions.data_type(), positions.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        return Err(wrong("positions are stored otherwise than as three floats"));
    }
    let positions: Vec<Vec3> = items::<12>(&positions, blob)?
        .map(|item| {
            let float = |at: usize| {
                f32::from_le_bytes([item[at], item[at + 1], item[at + 2], item[at + 3]])
            };
            transform.transform_point3(Vec3::new(float(0), float(4), float(8)))
        })
        .collect();
    let indices: Vec<usize> = match primitive.indices() {
        None => (0..positions.len()).collect(),
        Some(indices) => self::indices(&indices, blob)?,
    };
    let faces = match mode {
        Mode::Triangles => indices.len() / 3,
        _ => indices.len().saturating_sub(2),
    };
    if triangles.len() + faces > MAX_FACES {
        return Err(MeshError::TooManyFaces);
    }
    for face in 0..faces {
        let corners = match mode {
            Mode::Triangles => [3 * face, 3 * face + 1, 3 * face + 2],
            // Every other triangle of a strip runs the other way round.
            Mode::TriangleStrip => [face, face + 1 + face % 2, face + 2 - face % 2],
            _ => [0, face + 1, face + 2],
        };
        let mut triangle = [Vec3::ZERO; 3];
        for (corner, at) in triangle.iter_mut().zip(corners) {
            *corner = *indices
                .get(at)
                .and_then(|&index| positions.get(index))
                .ok_or(MeshError::NoCorner { face: triangles.len() + 1 })?;
        }
        triangles.push(triangle);
    }
    Ok(())
}

fn indices(accessor: &Accessor<'_>, blob: &[u8]) -> Result<Vec<usize>, MeshError> {
    if accessor.dimensions() != Dimensions::Scalar {
        return Err(wrong("indices are stored otherwise than as single numbers"));
    }
    Ok(match accessor.data_type() {
        DataType::U8 => items::<1>(accessor, blob)?.map(|[a]| usize::from(a)).collect(),
        DataType::U16 => {
            items::<2>(accessor, blob)?.map(|item| usize::from(u16::from_le_bytes(item))).collect()
        }
        DataType::U32 => {
            items::<4>(accessor, blob)?.map(|item| u32::from_le_bytes(item) as usize).collect()
        }
        _ => return Err(wrong("indices are stored otherwise than as whole numbers from 0 on")),
    })
}

/// The items of an accessor, of `SIZE` bytes each, if all of them are within the file.
fn items<'a, const SIZE: usize>(
    accessor: &Accessor<'_>,
    blob: &'a [u8],
) -> Result<impl Iterator<Item = [u8; SIZE]> + use<'a, SIZE>, MeshError> {
    if accessor.sparse().is_some() {
        return Err(wrong("it has sparse numbers, which are not read; export it without them"));
    }
    let view = accessor.view().ok_or_else(|| wrong("an accessor has no numbers"))?;
    if !matches!(view.buffer().source(), Source::Bin) {
        return Err(wrong("its numbers are in another file; export it as one .glb"));
    }
    let (stride, count) = (view.stride().unwrap_or(SIZE), accessor.count());
    if stride < SIZE {
        return Err(wrong("items of a buffer overlap"));
    }
    let missing = || wrong("numbers are missing; the file is cut off or damaged");
    let bytes = view
        .offset()
        .checked_add(view.length())
        .and_then(|end| blob.get(view.offset()..end))
        .and_then(|bytes| bytes.get(accessor.offset()..))
        .ok_or_else(missing)?;
    let last = count.saturating_sub(1).checked_mul(stride).and_then(|last| last.checked_add(SIZE));
    if count > 0 && last.is_none_or(|last| last > bytes.len()) {
        return Err(missing());
    }
    Ok((0..count).map(move |i| std::array::from_fn(|at| bytes[i * stride + at])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A GLB file of this description and these numbers.
    fn glb(json: &str, numbers: &[u8]) -> Vec<u8> {
        let mut json = json.as_bytes().to_vec();
        json.resize(json.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + json.len() + 8 + numbers.len();
        let word = |value: usize| (value as u32).to_le_bytes();
        let mut file = b"glTF".to_vec();
        file.extend([word(2), word(total), word(json.len())].concat());
        file.extend(b"JSON");
        file.extend(json);
        file.extend(word(numbers.len()));
        file.extend(b"BIN\0");
        file.extend(numbers);
        file
    }

    /// Four corners of a square, and five indices of two bytes, the last one wrong.
    fn numbers() -> Vec<u8> {
        let corners = [[0.0f32, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]];
        let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend([0u16, 1, 2, 3, 9, 0].iter().flat_map(|i| i.to_le_bytes()));
        bytes
    }

    fn file(mode: u8, indices: u8, node: &str) -> Vec<u8> {
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{node}],
            "meshes":[{{"primitives":[{{"mode":{mode},"attributes":{{"POSITION":0}},"indices":1}}]}}],
            "accessors":[
              {{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
                "min":[0,0,0],"max":[1,0,1]}},
              {{"bufferView":1,"componentType":5123,"count":{indices},"type":"SCALAR"}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}},
                           {{"buffer":0,"byteOffset":48,"byteLength":12}}],
            "buffers":[{{"byteLength":60}}]}}"#
        );
        glb(&json, &numbers())
    }

    #[test]
    fn a_strip_is_two_triangles_that_look_the_same_way() {
        let found = read(&file(5, 4, r#"{"mesh":0}"#)).unwrap();
        assert_eq!(
            found,
            [[Vec3::ZERO, Vec3::Z, Vec3::X], [Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X],]
        );
        let up = |[a, b, c]: Triangle| (b - a).cross(c - a);
        assert!(found.into_iter().all(|triangle| up(triangle) == Vec3::Y));
    }

    #[test]
    fn nodes_move_scale_and_nest() {
        let nodes = r#"{"children":[1],"translation":[10,0,0]},{"mesh":0,"scale":[2,2,2]}"#;
        let found = read(&file(4, 3, nodes)).unwrap();
        assert_eq!(
            found,
            [[Vec3::new(10.0, 0.0, 0.0), Vec3::new(10.0, 0.0, 2.0), Vec3::new(12.0, 0.0, 0.0),]]
        );
    }

    #[test]
    fn what_is_not_in_the_file_is_an_error() {
        assert!(matches!(read(&file(5, 5, r#"{"mesh":0}"#)), Err(MeshError::NoCorner { face: 3 })));
        assert!(matches!(read(&file(5, 7, r#"{"mesh":0}"#)), Err(MeshError::Glb(_))));
        assert!(matches!(read(&file(5, 4, r#"{"children":[0]}"#)), Err(MeshError::Glb(_))));
        let whole = file(4, 3, r#"{"mesh":0}"#);
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length} bytes");
        }
    }
}
