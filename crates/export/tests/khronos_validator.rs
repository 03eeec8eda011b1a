//! GLB files pass the Khronos validator without an error or a warning.
//!
//! Runs where node and npm are installed; the validator is fetched once into the build folder.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use deeptree_export::glb;
use deeptree_graph::testing::random_tree;
use deeptree_mesh::{Mesh, WoodOptions, wood};

const PACKAGE: &str = "gltf-validator@2.0.0-dev.3.10";

/// The folder with the installed package; none, with a line about it, where that cannot be had.
fn validator() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gltf-validator");
    if folder.join("node_modules/gltf-validator/package.json").exists() {
        return Some(folder);
    }
    std::fs::create_dir_all(&folder).unwrap();
    let install = Command::new("npm")
        .args(["install", "--no-audit", "--no-fund", "--no-save", "--prefix"])
        .arg(&folder)
        .arg(PACKAGE)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    match install {
        Ok(status) if status.success() => Some(folder),
        Ok(_) => {
            eprintln!("skipped: npm could not install {PACKAGE}");
            None
        }
        Err(_) => {
            eprintln!("skipped: npm not found");
            None
        }
    }
}

/// Trees of all sizes: short and long indices, odd index counts, no mesh at all.
fn write_samples(folder: &Path) -> Vec<(PathBuf, Mesh)> {
    let samples = [(1, 1), (2, 7), (3, 60), (4, 400), (5, 20_000)];
    let mut meshes: Vec<_> = samples
        .into_iter()
        .map(|(seed, nodes)| {
            let tree = random_tree(seed, nodes);
            let mesh = wood(&tree, &WoodOptions::default());
            (tree.info, mesh)
        })
        .collect();
    assert!(meshes.iter().any(|(_, mesh)| mesh.vertex_count() > 65_535));
    meshes.push((random_tree(6, 1).info, Mesh::default()));
    let write = |(i, (info, mesh))| {
        let path = folder.join(format!("{i}.glb"));
        let mut bytes = Vec::new();
        let more = i % 2 == 0;
        let all = glb::Attributes { tangents: more, labels: more, wind: more };
        glb::write_with(&mesh, &info, all, &mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        (path, mesh)
    };
    meshes.into_iter().enumerate().map(write).collect()
}

#[test]
fn glb_files_pass_the_khronos_validator() {
    let Some(installed) = validator() else { return };
    let folder = tempfile::tempdir().unwrap();
    let samples = write_samples(folder.path());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/khronos_validator.js");
    let output = Command::new("node")
        .arg(script)
        .arg(installed)
        .args(samples.iter().map(|(path, _)| path))
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
    assert_eq!(rows.len(), samples.len());
    for (row, (_, mesh)) in rows.iter().zip(&samples) {
        assert_eq!(row["numErrors"], 0, "{row:#}");
        assert_eq!(row["numWarnings"], 0, "{row:#}");
        assert_eq!(row["totalVertexCount"], mesh.vertex_count());
        assert_eq!(row["totalTriangleCount"], mesh.triangle_count());
    }
}
