//! Trees that stand together in one file are each what they are by themselves, at their places.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};

use deeptree_export::gltf::{Document, GltfError, Level, Options, Stand};
use deeptree_graph::{BranchGraph, Vec3};
use deeptree_mesh::Dressed;

fn trees() -> Vec<(BranchGraph, Dressed, Vec3)> {
    let place = |seed: u64| Vec3::new(4.0 * seed as f32, 0.5, -7.0);
    let tree = |seed| {
        let (tree, dressed) = common::dressed(seed, 40);
        (tree, dressed, place(seed))
    };
    (0..3).map(tree).collect()
}

fn stand<S: Read + Write + Seek>(mut stand: Stand<S>) -> Stand<S> {
    for (tree, dressed, at) in trees() {
        let level = Level { subject: (&dressed).into(), coverage: 0.5 };
        stand.add(&[level], &tree.info, at).unwrap();
    }
    stand
}

/// Positions of all vertices below a node, in the order of the file.
fn positions(node: &gltf::Node<'_>, blob: &[u8]) -> Vec<[f32; 3]> {
    let own = node.mesh().into_iter().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>());
    let mut all: Vec<[f32; 3]> = own
        .flat_map(|primitive| {
            primitive.reader(|_| Some(blob)).read_positions().unwrap().collect::<Vec<_>>()
        })
        .collect();
    for child in node.children() {
        all.extend(positions(&child, blob));
    }
    all
}

#[test]
fn each_tree_is_at_its_place_what_it_is_by_itself_and_materials_are_shared() {
    let mut bytes = Vec::new();
    stand(Stand::new(Cursor::new(Vec::new()), Options::default())).write_glb(&mut bytes).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = file.blob.as_deref().unwrap();
    let nodes: Vec<_> = file.default_scene().unwrap().nodes().collect();
    assert_eq!(nodes.len(), 3);
    for (number, (node, (tree, dressed, at))) in nodes.iter().zip(trees()).enumerate() {
        assert_eq!(node.transform().decomposed().0, at.to_array());
        assert!(node.name().unwrap().starts_with(&format!("{number} ")));
        assert!(node.name().unwrap().ends_with(&tree.info.seed.to_string()));
        let extras: serde_json::Value =
            serde_json::from_str(node.extras().as_ref().unwrap().get()).unwrap();
        assert_eq!(extras["number"], number);
        assert_eq!(extras["seed"], tree.info.seed.to_string());
        let mut alone = Vec::new();
        let document = Document::new((&dressed).into(), &tree.info, Options::default()).unwrap();
        document.write_glb(&mut alone).unwrap();
        let alone = gltf::Gltf::from_slice(&alone).unwrap();
        let own = alone.default_scene().unwrap().nodes().next().unwrap();
        assert_eq!(positions(node, blob), positions(&own, alone.blob.as_deref().unwrap()));
        assert_eq!((file.materials().len(), file.images().len()), (3, 7));
        assert_eq!(file.images().len(), alone.images().len());
    }
}

#[test]
fn a_stand_in_a_file_is_that_in_memory_and_leaves_nothing_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stand.glb");
    stand(Stand::beside(&path, Options::default()).unwrap()).save_glb(&path).unwrap();
    let mut bytes = Vec::new();
    stand(Stand::new(Cursor::new(Vec::new()), Options::default())).write_glb(&mut bytes).unwrap();
    assert!(std::fs::read(&path).unwrap() == bytes);
    drop(stand(Stand::beside(&path, Options::default()).unwrap()));
    let left: Vec<_> = folder.path().read_dir().unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["stand.glb"]);
    assert!(Stand::beside(&folder.path().join("none/stand.glb"), Options::default()).is_err());
}

/// A disk that is full after so many bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Read for Full {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        Ok(0)
    }
}

impl Seek for Full {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

#[test]
fn what_goes_wrong_on_the_way_is_told() {
    let (tree, mut dressed) = common::dressed(1, 40);
    let mut stand = Stand::new(Full(10_000), Options::default());
    let level = Level { subject: (&dressed).into(), coverage: 0.5 };
    let result = stand.add(&[level], &tree.info, Vec3::ZERO);
    assert!(matches!(result, Err(GltfError::Io(_))));
    let mut stand = Stand::new(Cursor::new(Vec::new()), Options::default());
    std::sync::Arc::make_mut(dressed.bark.color_image.as_mut().unwrap()).pixels.pop();
    let level = Level { subject: (&dressed).into(), coverage: 0.5 };
    let result = stand.add(&[level], &tree.info, Vec3::ZERO);
    assert!(matches!(result, Err(GltfError::Image { .. })));
}
