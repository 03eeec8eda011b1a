//! USD files are what usd-core, the reference implementation, calls sound; packages are aligned.
//!
//! usd-core runs where there is a Python with pip: it is fetched once into the build folder, unless
//! `DEEPTREE_PYTHON` names a Python that has it.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use deeptree_export::usd::{UsdError, save, write_usdz};
use deeptree_graph::testing::random_tree;
use deeptree_mesh::{Mesh, WoodOptions, wood};

const PACKAGE: &str = "usd-core==26.11";

/// A Python with usd-core; none, with a line about it, where that cannot be had.
fn python() -> Option<PathBuf> {
    let has = |python: &Path| {
        let mut import = Command::new(python);
        import.args(["-c", "import pxr.Usd"]).stderr(Stdio::null());
        import.status().is_ok_and(|status| status.success())
    };
    if let Some(python) = std::env::var_os("DEEPTREE_PYTHON").map(PathBuf::from)
        && has(&python)
    {
        return Some(python);
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("usd-core");
    let python = folder.join("bin/python");
    if has(&python) {
        return Some(python);
    }
    let run = |program: &Path, arguments: &[&str]| {
        let mut command = Command::new(program);
        command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    let made = run(Path::new("python3"), &["-m", "venv", folder.to_str()?])
        && run(&python, &["-m", "pip", "install", PACKAGE]);
    if !made {
        eprintln!("skipped: no Python could install {PACKAGE}");
    }
    made.then_some(python)
}

fn rows(files: &[PathBuf]) -> Option<Vec<serde_json::Value>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/usd_check.py");
    let output = Command::new(python()?).arg(script).args(files).output().unwrap();
    let (out, err) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "usd-core did not run to its end: {err}");
    assert!(!err.contains("rror"), "usd-core complains: {err}");
    Some(out.lines().map(|line| serde_json::from_str(line).unwrap()).collect())
}

fn package(subject: &deeptree_mesh::Dressed, info: &deeptree_graph::TreeInfo) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    write_usdz(subject, info, &mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn stages_and_packages_are_sound_to_usd_core() {
    let folder = tempfile::tempdir().unwrap();
    let (tree, dressed) = common::dressed(1, 80);
    let paths = ["a tree.usda", "tree.usdz", "bare.usda", "empty.usda"];
    let paths = paths.map(|name| folder.path().join(name));
    save(&dressed, &tree.info, &paths[0]).unwrap();
    std::fs::write(&paths[1], package(&dressed, &tree.info)).unwrap();
    let bare = random_tree(2, 30);
    save(&wood(&bare, &WoodOptions::default()), &bare.info, &paths[2]).unwrap();
    save(&Mesh::default(), &bare.info, &paths[3]).unwrap();
    let Some(rows) = rows(&paths) else { return };

    for row in &rows {
        assert_eq!(row["problems"], serde_json::json!([]), "{row:#}");
        assert_eq!((&row["up"], &row["meters_per_unit"]), (&"Y".into(), &1.0.into()), "{row:#}");
        assert_eq!(row["valid"], true, "{row:#}");
        for scheme in row["subdivision"].as_array().unwrap() {
            assert_eq!(scheme, "none");
        }
    }
    let (low, high) = dressed.wood.bounds().unwrap();
    for row in &rows[..2] {
        assert_eq!(row["seed"], tree.info.seed.to_string());
        assert_eq!(row["vertices"], serde_json::json!([dressed.wood.vertex_count(), 4, 4, 4]));
        assert_eq!(row["triangles"], serde_json::json!([dressed.wood.triangle_count(), 2, 2, 2]));
        let leaves: Vec<usize> = dressed.foliage.iter().map(|kind| kind.leaves.len()).collect();
        assert_eq!(row["leaves"], serde_json::json!(leaves));
        let materials = row["materials"].as_array().unwrap();
        assert_eq!(materials[0]["name"], "test_bark");
        assert_eq!(materials[1]["name"], "test_leaf");
        assert_eq!(materials[3]["name"], "test_leaf");
        let resolved = |m: &serde_json::Value, of: &str| m[of]["resolved"] == true;
        assert!(["color", "normal", "roughness"].iter().all(|of| resolved(&materials[0], of)));
        assert!(["color", "normal", "opacity"].iter().all(|of| resolved(&materials[1], of)));
        // Leaves reach beyond the wood, never short of it.
        for axis in 0..3 {
            assert!(row["low"][axis].as_f64().unwrap() as f32 <= low[axis] + 1e-5);
            assert!(row["high"][axis].as_f64().unwrap() as f32 >= high[axis] - 1e-5);
        }
    }
    assert_eq!(rows[3]["vertices"], serde_json::json!([]));
}

#[test]
fn packages_are_stored_aligned_and_the_same_every_time() {
    let (tree, dressed) = common::dressed(3, 40);
    let bytes = package(&dressed, &tree.info);
    assert_eq!(bytes, package(&dressed, &tree.info));
    let mut archive = zip::ZipArchive::new(Cursor::new(&bytes)).unwrap();
    assert!(archive.file_names().next().unwrap().unwrap().ends_with(".usda"));
    assert_eq!(archive.len(), 1 + 3 + 2 + 2);
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).unwrap();
        assert_eq!(file.compression(), zip::CompressionMethod::Stored);
        let start = file.data_start().unwrap() as usize;
        assert_eq!(start % 64, 0, "{:?} begins at {start}", file.name());
        let mut contents = Vec::new();
        file.read_to_end(&mut contents).unwrap();
        assert_eq!(contents, bytes[start..start + contents.len()]);
    }
}

#[test]
fn a_picture_of_the_wrong_size_is_refused_by_its_material() {
    let (tree, mut dressed) = common::dressed(4, 10);
    Arc::make_mut(dressed.bark.normal_image.as_mut().unwrap()).height = 3;
    let error = write_usdz(&dressed, &tree.info, &mut Cursor::new(Vec::new())).unwrap_err();
    assert!(matches!(&error, UsdError::Image { material, .. } if material == "test bark"));
}
