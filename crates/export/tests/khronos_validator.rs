//! GLB files pass the Khronos validator without an error or a warning.
//!
//! Runs where node and npm are installed; the validator is fetched once into the build folder.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use std::io::Cursor;

use deeptree_export::gltf::{Attributes, Document, Level, Options, Stand};
use deeptree_export::{Subject, Unfolding};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{TreeInfo, Vec3};
use deeptree_mesh::{Mesh, WoodOptions, wood};

const PACKAGE: &str = "gltf-validator@2.0.0-dev.3.10";

/// A file, and what is to be found in it.
struct Sample {
    path: PathBuf,
    vertices: usize,
    triangles: usize,
}

/// Files in a folder.
struct Samples {
    folder: tempfile::TempDir,
    all: Vec<Sample>,
}

impl Samples {
    fn path(&self) -> PathBuf {
        self.folder.path().join(format!("{}.glb", self.all.len()))
    }

    fn add(&mut self, document: Document<'_>, counts: (usize, usize)) {
        let path = self.path();
        let mut bytes = Vec::new();
        document.write_glb(&mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let (vertices, triangles) = counts;
        self.all.push(Sample { path, vertices, triangles });
    }
}

/// All vertices and triangles of a tree.
fn counts(subject: Subject<'_>) -> (usize, usize) {
    let leaves = subject.foliage.iter().map(|kind| {
        let (vertices, indices) = (kind.blade.positions.len(), kind.blade.indices.len());
        (kind.leaves.len() * vertices, kind.leaves.len() * indices / 3)
    });
    let wood = (subject.wood.vertex_count(), subject.wood.triangle_count());
    leaves.fold(wood, |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

/// Bare trees of all sizes: short and long indices, odd index counts, no mesh at all.
fn bare(samples: &mut Samples) {
    let sizes = [(1, 1), (2, 7), (3, 60), (4, 400), (5, 20_000)];
    let mut meshes: Vec<(TreeInfo, Mesh)> = sizes
        .into_iter()
        .map(|(seed, nodes)| {
            let tree = random_tree(seed, nodes);
            let mesh = wood(&tree, &WoodOptions::default());
            (tree.info, mesh)
        })
        .collect();
    assert!(meshes.iter().any(|(_, mesh)| mesh.vertex_count() > 65_535));
    meshes.push((random_tree(6, 1).info, Mesh::default()));
    for (i, (info, mesh)) in meshes.iter().enumerate() {
        let more = i % 2 == 0;
        let attributes = Attributes { tangents: more, labels: more, wind: more };
        let options = Options { attributes, ..Options::default() };
        let document = Document::new(mesh.into(), info, options).unwrap();
        samples.add(document, counts(mesh.into()));
    }
}

fn dressed(samples: &mut Samples) {
    for (i, nodes) in [1, 50, 3000].into_iter().enumerate() {
        let (tree, dressed) = common::dressed(i as u64, nodes);
        let more = i == 1;
        let attributes = Attributes { tangents: more, labels: more, wind: more };
        let options = Options { attributes, ..Options::default() };
        let document = Document::new((&dressed).into(), &tree.info, options).unwrap();
        samples.add(document, counts((&dressed).into()));
    }
}

/// The blade counts once, as the validator does not know the extension.
fn instanced(samples: &mut Samples) {
    let (tree, dressed) = common::dressed(7, 60);
    let attributes = Attributes { labels: true, ..Attributes::default() };
    let options = Options { attributes, instancing: true };
    let document = Document::new((&dressed).into(), &tree.info, options).unwrap();
    let blades = dressed.foliage.iter().map(|kind| kind.blade.positions.len()).sum::<usize>();
    let wood = counts((&dressed.wood).into());
    samples.add(document, (wood.0 + blades, wood.1 + blades / 2));
}

fn levels(samples: &mut Samples) {
    let (tree, fine) = common::dressed(8, 60);
    let coarse = wood(&tree, &WoodOptions::lod(3));
    let subjects = [Subject::from(&fine), Subject::from(&coarse)];
    let levels = subjects.map(|subject| Level { subject, coverage: 0.1 });
    let document = Document::with_levels(&levels, &tree.info, Options::default()).unwrap();
    let [a, b] = subjects.map(counts);
    samples.add(document, (a.0 + b.0, a.1 + b.1));
}

fn growing(samples: &mut Samples) {
    for nodes in [1, 60, 5000] {
        let (tree, dressed) = common::dressed(8, nodes);
        let unfolding = Unfolding::new(&tree, 8.0);
        let subject = Subject::from(&dressed);
        let document =
            Document::unfolding(subject, &unfolding, &tree.info, Options::default()).unwrap();
        samples.add(document, counts(subject));
    }
}

/// `.gltf` with files beside it, whose name has a blank.
fn beside(samples: &mut Samples) {
    let (tree, dressed) = common::dressed(9, 60);
    let document = Document::new((&dressed).into(), &tree.info, Options::default()).unwrap();
    let path = samples.folder.path().join("a tree.gltf");
    document.save(&path).unwrap();
    let (vertices, triangles) = counts((&dressed).into());
    samples.all.push(Sample { path, vertices, triangles });
}

/// Trees in one file, at one level of detail and at two; copies of blades count once.
fn stands(samples: &mut Samples) {
    for (two, instancing) in [(false, false), (true, false), (false, true)] {
        let options = Options { instancing, ..Options::default() };
        let mut stand = Stand::new(Cursor::new(Vec::new()), options);
        let mut counted = (0, 0);
        for seed in 0..3 {
            let (tree, fine) = common::dressed(seed, 60);
            let coarse = wood(&tree, &WoodOptions::lod(3));
            let subjects = [Subject::from(&fine), Subject::from(&coarse)];
            let levels = subjects.map(|subject| Level { subject, coverage: 0.1 });
            let levels = &levels[..if two { 2 } else { 1 }];
            stand.add(levels, &tree.info, Vec3::new(seed as f32, 0.0, -5.0)).unwrap();
            for level in levels {
                let (vertices, triangles) = counts(match instancing {
                    false => level.subject,
                    true => Subject { foliage: &[], ..level.subject },
                });
                let blades = if instancing { fine.foliage.len() } else { 0 };
                counted.0 += vertices + 4 * blades;
                counted.1 += triangles + 2 * blades;
            }
        }
        let path = samples.path();
        if two {
            stand.save_glb(&path).unwrap();
        } else {
            stand.write_glb(&mut std::fs::File::create(&path).unwrap()).unwrap();
        }
        let (vertices, triangles) = counted;
        samples.all.push(Sample { path, vertices, triangles });
    }
    let path = samples.folder.path().join("a stand.gltf");
    let mut stand = Stand::beside(&path, Options::default()).unwrap();
    let (tree, dressed) = common::dressed(3, 60);
    let level = Level { subject: (&dressed).into(), coverage: 0.1 };
    stand.add(&[level], &tree.info, Vec3::X).unwrap();
    stand.save(&path).unwrap();
    let (vertices, triangles) = counts((&dressed).into());
    samples.all.push(Sample { path, vertices, triangles });
    let nobody = Stand::new(Cursor::new(Vec::new()), Options::default());
    let path = samples.path();
    nobody.write_glb(&mut std::fs::File::create(&path).unwrap()).unwrap();
    samples.all.push(Sample { path, vertices: 0, triangles: 0 });
}

#[test]
fn glb_files_pass_the_khronos_validator() {
    let Some(installed) = common::npm::install(&[PACKAGE]) else { return };
    let mut samples = Samples { folder: tempfile::tempdir().unwrap(), all: Vec::new() };
    bare(&mut samples);
    dressed(&mut samples);
    instanced(&mut samples);
    levels(&mut samples);
    growing(&mut samples);
    beside(&mut samples);
    stands(&mut samples);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/khronos_validator.js");
    let output = Command::new("node")
        .arg(script)
        .arg(installed)
        .args(samples.all.iter().map(|sample| &sample.path))
        .stderr(Stdio::inherit())
        .output();
    let Ok(output) = output else {
        eprintln!("skipped: node not found");
        return;
    };
    assert!(output.status.success(), "the validator did not run to its end");
    let rows: Vec<serde_json::Value> = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(rows.len(), samples.all.len());
    for (row, sample) in rows.iter().zip(&samples.all) {
        assert_eq!(row["numErrors"], 0, "{row:#}");
        assert_eq!(row["numWarnings"], 0, "{row:#}");
        assert_eq!(row["totalVertexCount"], sample.vertices, "{row:#}");
        assert_eq!(row["totalTriangleCount"], sample.triangles, "{row:#}");
    }
}
