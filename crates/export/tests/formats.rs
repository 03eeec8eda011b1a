//! What the formats' specifications ask for, read back byte by byte.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use deeptree_export::gltf::{Attributes, Document, Options};
use deeptree_export::{obj, ply};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{BranchGraph, TreeInfo, Vec3, branches};
use deeptree_mesh::{Mesh, WoodOptions, wood};

fn sample() -> (BranchGraph, Mesh) {
    let mut tree = random_tree(3, 40);
    tree.info.species = "silver\nfir ß".into();
    tree.info.seed = u64::MAX;
    let mesh = wood(&tree, &WoodOptions::default());
    assert!(mesh.triangle_count() > 0);
    (tree, mesh)
}

fn write_glb(mesh: &Mesh, info: &TreeInfo, options: Options) -> Vec<u8> {
    let mut bytes = Vec::new();
    Document::new(mesh.into(), info, options).unwrap().write_glb(&mut bytes).unwrap();
    bytes
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(bytes, at))
}

fn vec3_at(bytes: &[u8], at: usize) -> Vec3 {
    Vec3::new(f32_at(bytes, at), f32_at(bytes, at + 4), f32_at(bytes, at + 8))
}

/// The description and the binary chunk of a GLB file, whose container is checked on the way.
fn open_glb(bytes: &[u8]) -> (serde_json::Value, &[u8]) {
    assert_eq!(&bytes[..4], b"glTF");
    assert_eq!(u32_at(bytes, 4), 2);
    assert_eq!(u32_at(bytes, 8) as usize, bytes.len());
    let text = u32_at(bytes, 12) as usize;
    assert_eq!(&bytes[16..20], b"JSON");
    assert_eq!(text % 4, 0);
    let description = serde_json::from_slice(&bytes[20..20 + text]).unwrap();
    let rest = &bytes[20 + text..];
    if rest.is_empty() {
        return (description, rest);
    }
    assert_eq!(&rest[4..8], b"BIN\0");
    assert_eq!(u32_at(rest, 0) as usize, rest.len() - 8);
    assert_eq!(rest.len() % 4, 0);
    (description, &rest[8..])
}

#[test]
fn glb_holds_the_mesh_and_names_the_tree() {
    let (tree, mesh) = sample();
    let bytes = write_glb(&mesh, &tree.info, Options::default());
    let (json, binary) = open_glb(&bytes);

    assert_eq!(json["asset"]["version"], "2.0");
    let generator = json["asset"]["generator"].as_str().unwrap();
    assert!(generator.starts_with("DeepTree "), "{generator}");
    assert_eq!(json["asset"]["extras"]["species"], "silver\nfir ß");
    assert_eq!(json["asset"]["extras"]["seed"], "18446744073709551615");
    assert_eq!(json["asset"]["extras"]["age"], tree.info.age);
    assert_eq!(json["nodes"][0]["name"], "silver fir ß 18446744073709551615");
    assert_eq!(json["materials"][0]["name"], "wood");

    // Positions first, indices (short: few vertices) last.
    assert_eq!(json["accessors"][0]["count"], mesh.vertex_count());
    for (i, position) in mesh.positions.iter().enumerate() {
        assert_eq!(vec3_at(binary, 12 * i), *position);
    }
    let start = json["bufferViews"][3]["byteOffset"].as_u64().unwrap() as usize;
    for (i, index) in mesh.indices.iter().enumerate() {
        let at = start + 2 * i;
        assert_eq!(u32::from(u16::from_le_bytes([binary[at], binary[at + 1]])), *index);
    }
    let (low, high) = mesh.bounds().unwrap();
    for axis in 0..3 {
        let bound = |name: &str| json["accessors"][0][name][axis].as_f64().unwrap() as f32;
        assert_eq!((bound("min"), bound("max")), (low[axis], high[axis]));
    }
}

#[test]
fn glb_attributes_are_those_of_the_nodes() {
    let (tree, mesh) = sample();
    let attributes = Attributes { tangents: true, labels: true, wind: true };
    let bytes = write_glb(&mesh, &tree.info, Options { attributes, ..Options::default() });
    let (json, binary) = open_glb(&bytes);
    let offset = |name: &str| {
        let accessor = json["meshes"][0]["primitives"][0]["attributes"][name].as_u64().unwrap();
        let view = json["accessors"][accessor as usize]["bufferView"].as_u64().unwrap();
        assert_eq!(json["accessors"][accessor as usize]["count"], mesh.vertex_count());
        json["bufferViews"][view as usize]["byteOffset"].as_u64().unwrap() as usize
    };
    let [node, order, phase] = ["_NODE", "_ORDER", "_PHASE"].map(offset);
    let [stiffness, pivot, tangent] = ["_STIFFNESS", "_PIVOT", "TANGENT"].map(offset);
    let thickest = tree.root().thickness;
    for i in 0..mesh.vertex_count() {
        let own = tree.node(f32_at(binary, node + 4 * i) as u32);
        assert_eq!(f32_at(binary, order + 4 * i), f32::from(own.order));
        assert!((0.0..1.0).contains(&f32_at(binary, phase + 4 * i)));
        let share = (own.thickness / thickest).min(1.0);
        assert!((f32_at(binary, stiffness + 4 * i) - share).abs() < 1e-2);
        // The branch starts its length before the node's tip.
        let pivot = vec3_at(binary, pivot + 12 * i);
        assert!(pivot.distance(own.position) < own.branch_distance + 1e-3);
        let along = vec3_at(binary, tangent + 16 * i);
        assert!((along.length() - 1.0).abs() < 1e-4);
        assert!(along.dot(mesh.normals[i]).abs() < 1e-3);
    }
}

#[test]
fn glb_of_an_empty_mesh_has_no_binary_chunk() {
    let (tree, _) = sample();
    let bytes = write_glb(&Mesh::default(), &tree.info, Options::default());
    let (json, binary) = open_glb(&bytes);
    assert!(binary.is_empty());
    assert!(json.get("meshes").is_none());
}

#[test]
fn ply_rows_have_the_lengths_that_the_header_states() {
    let (tree, mesh) = sample();
    let mut bytes = Vec::new();
    ply::write(&mesh, &tree.info, &mut bytes).unwrap();
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let header = std::str::from_utf8(&bytes[..at]).unwrap();
    let body = &bytes[at..];

    let mut lines = header.lines();
    assert_eq!(lines.next(), Some("ply"));
    assert_eq!(lines.next(), Some("format binary_little_endian 1.0"));
    let count = |element: &str| -> usize {
        let start = format!("element {element} ");
        header.lines().find_map(|l| l.strip_prefix(&start)).unwrap().parse().unwrap()
    };
    let row: usize = header
        .lines()
        .filter_map(|l| l.strip_prefix("property ")?.split(' ').next())
        .map(|kind| match kind {
            "float" | "uint" => 4,
            "ushort" => 2,
            _ => 0,
        })
        .sum();
    let (vertices, faces) = (count("vertex"), count("face"));
    assert_eq!((vertices, faces), (mesh.vertex_count(), mesh.triangle_count()));
    assert_eq!(body.len(), vertices * row + faces * 13);

    // Branches are numbered as by `branches`, and orders are those of their nodes.
    let mut branch_of = vec![0; tree.len()];
    for (branch, path) in branches(&tree).iter().enumerate() {
        path.nodes.iter().for_each(|&id| branch_of[id as usize] = branch as u32);
    }
    for i in 0..vertices {
        let at = i * row;
        assert_eq!(vec3_at(body, at), mesh.positions[i]);
        assert_eq!(vec3_at(body, at + 12), mesh.normals[i]);
        let node = u32_at(body, at + 38);
        assert_eq!(node, mesh.nodes[i]);
        assert_eq!(u32_at(body, at + 32), branch_of[node as usize]);
        let order = u16::from_le_bytes([body[at + 36], body[at + 37]]);
        assert_eq!(order, tree.node(node).order);
    }
    for (i, &index) in mesh.indices.iter().enumerate() {
        let face = vertices * row + i / 3 * 13;
        assert_eq!(body[face], 3);
        assert_eq!(u32_at(body, face + 1 + i % 3 * 4), index);
    }
}

#[test]
fn obj_reads_back_to_the_same_bits() {
    let (tree, mesh) = sample();
    let mut bytes = Vec::new();
    obj::write(&mesh, &tree.info, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let rows = |key: &str| -> Vec<Vec<String>> {
        let rows = text.lines().filter_map(|l| l.strip_prefix(key)?.strip_prefix(' '));
        rows.map(|row| row.split(' ').map(str::to_owned).collect()).collect()
    };
    let floats = |key: &str| -> Vec<f32> {
        rows(key).iter().flatten().map(|x| x.parse().unwrap()).collect()
    };
    let flat = |v: &[Vec3]| v.iter().flat_map(|p| p.to_array()).collect::<Vec<f32>>();
    assert_eq!(floats("v"), flat(&mesh.positions));
    assert_eq!(floats("vn"), flat(&mesh.normals));
    assert_eq!(floats("vt"), mesh.uvs.as_flattened());
    let corners: Vec<String> = mesh.indices.iter().map(|i| format!("{0}/{0}/{0}", i + 1)).collect();
    assert_eq!(rows("f").concat(), corners);
    // The line break in the species does not end the comment.
    assert!(text.lines().any(|l| l == "# species silver fir ß"));
}
