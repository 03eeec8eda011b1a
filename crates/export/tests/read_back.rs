//! What other readers find in the files: the `gltf` and `tobj` crates.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::fs;
use std::path::Path;
use std::sync::Arc;

use deeptree_export::gltf::{Attributes, Document, GltfError, Options};
use deeptree_export::{Unfolding, obj, ply, usd};
use deeptree_graph::{TreeInfo, Vec3};
use deeptree_mesh::{Dressed, Image};

fn glb(dressed: &Dressed, info: &TreeInfo, options: Options) -> Vec<u8> {
    let mut bytes = Vec::new();
    Document::new(dressed.into(), info, options).unwrap().write_glb(&mut bytes).unwrap();
    bytes
}

fn decode(bytes: &[u8]) -> Image {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let channels = info.color_type.samples() as u8;
    Image { width: info.width, height: info.height, channels, pixels }
}

fn primitive<'a>(node: &gltf::Node<'a>) -> gltf::Primitive<'a> {
    node.mesh().unwrap().primitives().next().unwrap()
}

/// The places of all corners of a kind's triangles, worked out here.
fn corners(kind: &deeptree_mesh::Foliage) -> Vec<Vec3> {
    let place = |leaf: &deeptree_mesh::Leaf, i: u32| {
        leaf.position + leaf.rotation * (kind.blade.positions[i as usize] * leaf.scale)
    };
    let all =
        kind.leaves.iter().flat_map(|leaf| kind.blade.indices.iter().map(move |&i| (leaf, i)));
    all.map(|(leaf, i)| place(leaf, i)).collect()
}

fn assert_same_places(found: &[Vec3], expected: &[Vec3]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!(a.distance(*b) < 1e-5, "{a} is not {b}");
    }
}

#[test]
fn glb_has_materials_leaves_and_pictures_to_the_pixel() {
    let (tree, dressed) = common::dressed(1, 60);
    let bytes = glb(&dressed, &tree.info, Options::default());
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = blob.unwrap();
    let root = document.default_scene().unwrap().nodes().next().unwrap();
    assert_eq!(root.children().len(), dressed.foliage.len());

    let points = |primitive: &gltf::Primitive<'_>| -> Vec<Vec3> {
        let reader = primitive.reader(|_| Some(&blob));
        let all: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
        let indices = reader.read_indices().unwrap().into_u32();
        indices.map(|i| Vec3::from(all[i as usize])).collect()
    };
    let wood: Vec<Vec3> = dressed.wood.triangles().flatten().collect();
    assert_eq!(points(&primitive(&root)), wood);
    for (node, kind) in root.children().zip(&dressed.foliage) {
        let leaves = primitive(&node);
        assert_same_places(&points(&leaves), &corners(kind));
        let material = leaves.material();
        assert_eq!(material.name(), Some(&*kind.material.name));
        assert_eq!(material.alpha_mode(), gltf::material::AlphaMode::Mask);
        assert_eq!(material.alpha_cutoff(), Some(1.0 / 3.0));
        assert!(material.double_sided());
        let extras: serde_json::Value =
            serde_json::from_str(material.extras().as_ref().unwrap().get()).unwrap();
        assert_eq!(extras["translucency"].as_f64().unwrap() as f32, 0.3);
        // The tip of a blade, at v = 1, is at the upper edge of the picture.
        let uvs = leaves.reader(|_| Some(&blob)).read_tex_coords(0).unwrap().into_f32();
        assert_eq!(
            uvs.take(4).collect::<Vec<_>>(),
            [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]
        );
    }

    assert_eq!((document.materials().len(), document.images().len()), (3, 3 + 2 + 2));
    let picture = |texture: gltf::Texture<'_>| match texture.source().source() {
        gltf::image::Source::View { view, mime_type } => {
            assert_eq!(mime_type, "image/png");
            decode(&blob[view.offset()..view.offset() + view.length()])
        }
        gltf::image::Source::Uri { .. } => panic!("the picture is not in the file"),
    };
    let bark = primitive(&root).material();
    let pbr = bark.pbr_metallic_roughness();
    assert_eq!((pbr.base_color_factor(), pbr.metallic_factor()), (dressed.bark.color, 0.0));
    let color = picture(pbr.base_color_texture().unwrap().texture());
    assert_eq!(Some(&color), dressed.bark.color_image.as_deref());
    let normal = picture(bark.normal_texture().unwrap().texture());
    assert_eq!(Some(&normal), dressed.bark.normal_image.as_deref());
    let rough = picture(pbr.metallic_roughness_texture().unwrap().texture());
    let green: Vec<u8> = rough.pixels.as_chunks::<3>().0.iter().map(|p| p[1]).collect();
    assert_eq!(green, dressed.bark.roughness_image.unwrap().pixels);
}

#[test]
fn instances_stand_where_the_leaves_stand() {
    let (tree, dressed) = common::dressed(2, 60);
    let options = Options { instancing: true, ..Options::default() };
    let bytes = glb(&dressed, &tree.info, options);
    assert!(bytes.len() < glb(&dressed, &tree.info, Options::default()).len());
    // The crate refuses files whose required extensions it does not know.
    let root: serde_json::Value = {
        let text = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice(&bytes[20..20 + text]).unwrap()
    };
    assert_eq!(root["extensionsRequired"], serde_json::json!(["EXT_mesh_gpu_instancing"]));
    let node = &root["nodes"][0];
    let instances = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    let floats = |name: &str, n: usize| -> Vec<Vec<f32>> {
        let accessor = &root["accessors"][instances[name].as_u64().unwrap() as usize];
        let view = &root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let text = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let start = 28 + text + view["byteOffset"].as_u64().unwrap() as usize;
        let length = view["byteLength"].as_u64().unwrap() as usize;
        let words = bytes[start..start + length].as_chunks::<4>().0;
        let floats: Vec<f32> = words.iter().map(|w| f32::from_le_bytes(*w)).collect();
        floats.chunks(n).map(<[f32]>::to_vec).collect()
    };
    let (places, turns, sizes) =
        (floats("TRANSLATION", 3), floats("ROTATION", 4), floats("SCALE", 3));
    let leaves = &dressed.foliage[0].leaves;
    assert_eq!(places.len(), leaves.len());
    for (i, leaf) in leaves.iter().enumerate() {
        assert_eq!(places[i], leaf.position.to_array());
        assert_eq!(turns[i], leaf.rotation.to_array());
        assert_eq!(sizes[i], [leaf.scale; 3]);
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entry = |entry: Result<fs::DirEntry, _>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<String> = fs::read_dir(folder).unwrap().map(entry).collect();
    names.sort();
    names
}

#[test]
fn gltf_stands_with_its_files_and_reads_as_the_binary_one_does() {
    let folder = tempfile::tempdir().unwrap();
    let (tree, dressed) = common::dressed(3, 60);
    let path = folder.path().join("my tree.gltf");
    Document::new((&dressed).into(), &tree.info, Options::default()).unwrap().save(&path).unwrap();
    assert_eq!(
        names(folder.path()),
        [
            "my tree.bin",
            "my tree.gltf",
            "my tree_other_leaf_color.png",
            "my tree_other_leaf_normal.png",
            "my tree_test_bark_color.png",
            "my tree_test_bark_normal.png",
            "my tree_test_bark_roughness.png",
            "my tree_test_leaf_color.png",
            "my tree_test_leaf_normal.png",
        ]
    );
    let png = fs::read(folder.path().join("my tree_test_leaf_color.png")).unwrap();
    assert_eq!(Some(&decode(&png)), dressed.foliage[0].material.color_image.as_deref());
    // The numbers are those of the binary file, up to its pictures.
    let numbers = fs::read(folder.path().join("my tree.bin")).unwrap();
    let binary = glb(&dressed, &tree.info, Options::default());
    let text = u32::from_le_bytes(binary[12..16].try_into().unwrap()) as usize;
    assert_eq!(binary[28 + text..28 + text + numbers.len()], numbers);
}

#[test]
fn files_that_fail_leave_no_description_behind() {
    let folder = tempfile::tempdir().unwrap();
    let (tree, dressed) = common::dressed(3, 10);
    let nowhere = folder.path().join("missing/tree.gltf");
    let document = Document::new((&dressed).into(), &tree.info, Options::default()).unwrap();
    assert!(matches!(document.save(&nowhere), Err(GltfError::File(_))));
    obj::save(&dressed, &tree.info, &folder.path().join("missing/tree.obj")).unwrap_err();
    // A folder stands where the numbers should go.
    fs::create_dir(folder.path().join("tree.bin")).unwrap();
    fs::create_dir(folder.path().join("tree.mtl")).unwrap();
    let document = Document::new((&dressed).into(), &tree.info, Options::default()).unwrap();
    document.save(&folder.path().join("tree.gltf")).unwrap_err();
    obj::save(&dressed, &tree.info, &folder.path().join("tree.obj")).unwrap_err();
    let left = names(folder.path());
    assert!(
        left.iter().all(|name| !name.ends_with(".gltf") && !name.ends_with(".obj")),
        "{left:?}"
    );
    assert!(left.iter().all(|name| !name.ends_with(".part")), "{left:?}");
}

#[test]
fn a_picture_of_the_wrong_size_is_refused_by_its_material() {
    let (tree, mut dressed) = common::dressed(4, 10);
    let picture = dressed.foliage[0].material.color_image.as_mut().unwrap();
    Arc::make_mut(picture).pixels.pop();
    let result = Document::new((&dressed).into(), &tree.info, Options::default());
    let Err(GltfError::Image { material, source }) = result else { panic!("it was taken") };
    assert_eq!(material, "test leaf");
    assert!(source.to_string().contains("8 × 16 pixels and 4 channels has 511 bytes"), "{source}");
}

#[test]
fn obj_names_the_materials_that_its_library_has() {
    let folder = tempfile::tempdir().unwrap();
    let (tree, dressed) = common::dressed(5, 60);
    let path = folder.path().join("tree.obj");
    obj::save(&dressed, &tree.info, &path).unwrap();
    let (models, materials) = tobj::load_obj(&path, &tobj::LoadOptions::default()).unwrap();
    let materials = materials.unwrap();
    assert_eq!(
        models.iter().map(|m| &*m.name).collect::<Vec<_>>(),
        ["wood", "test_leaf", "other_leaf", "test_leaf_2"]
    );
    assert_eq!(materials.len(), 3);
    let material = |model: &tobj::Model| &materials[model.mesh.material_id.unwrap()];
    assert_eq!(material(&models[0]).name, "test_bark");
    assert_eq!(material(&models[0]).diffuse, Some([0.9, 0.8, 0.7]));
    let color = material(&models[0]).diffuse_texture.as_ref().unwrap();
    assert_eq!(
        Some(&decode(&fs::read(folder.path().join(color)).unwrap())),
        dressed.bark.color_image.as_deref()
    );
    let leaf = material(&models[1]);
    assert_eq!(leaf.dissolve_texture, leaf.diffuse_texture);
    for (model, kind) in models[1..].iter().zip(&dressed.foliage) {
        let place = |&i: &u32| Vec3::from_slice(&model.mesh.positions[3 * i as usize..][..3]);
        let found: Vec<Vec3> = model.mesh.indices.iter().map(place).collect();
        assert_same_places(&found, &corners(kind));
    }
    assert_eq!(models[0].mesh.indices.len(), dressed.wood.indices.len());
}

#[test]
fn ply_says_which_part_and_node_a_leaf_belongs_to() {
    let (tree, dressed) = common::dressed(6, 40);
    let mut bytes = Vec::new();
    ply::write(&dressed, &tree.info, &mut bytes).unwrap();
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let header = std::str::from_utf8(&bytes[..at]).unwrap();
    assert!(header.contains("property uchar part\n"), "{header}");
    let rows = bytes[at..].as_chunks::<43>().0;
    let first = dressed.wood.vertex_count();
    let number = |row: &[u8; 43]| u32::from_le_bytes(row[38..42].try_into().unwrap());
    assert!(rows[..first].iter().all(|row| row[42] == 0));
    for (i, leaf) in dressed.foliage[0].leaves.iter().enumerate() {
        for row in &rows[first + 4 * i..first + 4 * i + 4] {
            assert_eq!((row[42], number(row)), (1, leaf.node));
        }
    }
}

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Pictures are left out: another version of the encoder may pack them in another way.
#[test]
fn files_have_the_same_bytes_on_every_machine() {
    let folder = tempfile::tempdir().unwrap();
    let (tree, mut dressed) = common::dressed(7, 40);
    let Dressed { bark, foliage, .. } = &mut dressed;
    for material in foliage.iter_mut().map(|kind| &mut kind.material).chain([bark]) {
        material.color_image = None;
        material.normal_image = None;
        material.roughness_image = None;
    }
    let attributes = Attributes { tangents: true, labels: true, wind: true };
    let real = glb(&dressed, &tree.info, Options { attributes, instancing: false });
    let copies = glb(&dressed, &tree.info, Options { instancing: true, ..Options::default() });
    let unfolding = Unfolding::new(&tree, 5.0);
    let mut growing = Vec::new();
    Document::unfolding((&dressed).into(), &unfolding, &tree.info, Options::default())
        .unwrap()
        .write_glb(&mut growing)
        .unwrap();
    let mut text = Vec::new();
    obj::write(&dressed, &tree.info, &mut text).unwrap();
    let path = folder.path().join("tree.usda");
    usd::save(&dressed, &tree.info, &path).unwrap();
    let stage = fs::read(path).unwrap();
    let hashes = [&real, &copies, &growing, &text, &stage].map(|bytes| hash(bytes));
    // Changed on purpose? Then the printed hashes are the new ones; say so in the changelog.
    assert_eq!(hashes, GOLDEN, "{hashes:#x?}");
}

const GOLDEN: [u64; 5] = [
    0x73a7_6511_9ef3_3806,
    0x8328_4a59_8575_409f,
    0xa82b_267f_9fa4_49c6,
    0xa2d9_e7cb_420e_d697,
    0x9058_4a21_8a0a_ebfe,
];
