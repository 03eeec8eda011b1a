//! GLB files are shown by three.js: without an error, with their leaves and pictures, growing, and
//! from afar.
//!
//! Runs where Chromium, node and npm are; the packages are fetched once into the build folder.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use deeptree_export::gltf::{Document, Level, Options};
use deeptree_export::{Subject, Unfolding};
use deeptree_graph::Seed;
use deeptree_growth::{Parameters, Profile, Species, grow};
use deeptree_mesh::{Look, WoodOptions, dress, wood};
use deeptree_render::impostor;

const PACKAGES: [&str; 2] = ["three@0.187.0", "puppeteer-core@25.16.0"];

/// The folder with the packages, and the browser; none, with a line about it, where they cannot be
/// had.
fn browser() -> Option<(PathBuf, PathBuf)> {
    let found = std::env::var_os("PATH").and_then(|path| {
        let places = std::env::split_paths(&path);
        places.map(|place| place.join("chromium")).find(|browser| browser.is_file())
    });
    let Some(browser) = found else {
        eprintln!("skipped: chromium not found");
        return None;
    };
    Some((common::npm::install(&PACKAGES)?, browser))
}

/// What three.js makes of files, a row each; none where there is no browser.
fn show(documents: Vec<Document<'_>>) -> Option<Vec<serde_json::Value>> {
    let (packages, browser) = browser()?;
    let folder = tempfile::tempdir().unwrap();
    let write = |(i, document): (usize, Document<'_>)| {
        let path = folder.path().join(format!("{i}.glb"));
        let mut bytes = Vec::new();
        document.write_glb(&mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let paths: Vec<PathBuf> = documents.into_iter().enumerate().map(write).collect();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser.mjs");
    let pictures = std::env::var_os("DEEPTREE_PICTURES").unwrap_or_else(|| "-".into());
    let mut command = Command::new("node");
    command.arg(script).arg(packages).arg(browser).arg(pictures).args(&paths);
    let output = command.stderr(Stdio::inherit()).output().unwrap();
    assert!(output.status.success(), "the browser did not run to its end");
    let text = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows.len(), paths.len());
    assert!(rows.iter().all(|row| row["errors"] == serde_json::json!([])), "{rows:#?}");
    Some(rows)
}

/// Cards cover what the tree covers that they show, and stand where it stands.
#[test]
fn cards_stand_in_for_a_tree_in_three_js() {
    let parameters = Species::named("oak").unwrap().parameters(Profile::Reference).clone();
    let tree = grow("oak", &Parameters { age: 14.0, ..parameters }, Seed(1)).unwrap().tree;
    let look = Look { texture_size: 256, ..Look::default() };
    let dress =
        |lod| dress(&tree, wood(&tree, &WoodOptions::lod(lod)), &Look { lod, ..look.clone() });
    let [fine, coarse] = [0, 3].map(|lod| dress(lod).unwrap());
    let cards = impostor(&fine, 2, 256, 16, Seed(0)).unwrap();
    let cards = cards.into_dressed("oak", fine.wood.internodes.clone());
    let levels = [(&fine, 0.5), (&coarse, 0.05), (&cards, 0.002)]
        .map(|(level, coverage)| Level { subject: level.into(), coverage });
    let document = Document::with_levels(&levels, &tree.info, Options::default()).unwrap();
    let Some(rows) = show(vec![document]) else { return };
    let row = &rows[0];
    let seen = |frame: &serde_json::Value| {
        (frame["shown"].as_f64().unwrap(), frame["top"].as_f64().unwrap())
    };
    let (shown, top) = seen(&row["frames"][0]);
    let levels = row["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 2);
    assert!(seen(&levels[0]).0 > 0.5 * shown, "{row:#}");
    let (cards, height) = seen(&levels[1]);
    assert!((cards / shown - 1.0).abs() < 0.15 && (height - top).abs() <= 3.0, "{row:#}");
}

#[test]
fn three_js_shows_trees_without_complaint() {
    let (tree, dressed) = common::dressed(1, 300);
    let subject = Subject::from(&dressed);
    let unfolding = Unfolding::new(&tree, 6.0);
    let copies = Options { instancing: true, ..Options::default() };
    let documents = vec![
        Document::new(subject, &tree.info, Options::default()).unwrap(),
        Document::new(subject, &tree.info, copies).unwrap(),
        Document::unfolding(subject, &unfolding, &tree.info, Options::default()).unwrap(),
    ];
    let Some(rows) = show(documents) else { return };

    let leaves: usize = dressed.foliage.iter().map(|kind| 2 * kind.leaves.len()).sum();
    for row in &rows {
        assert_eq!(row["triangles"], dressed.wood.triangle_count() + leaves, "{row:#}");
        assert_eq!(row["maps"], 3 + 2 + 2, "{row:#}");
    }
    let shown = |row: usize, frame: usize| rows[row]["frames"][frame]["shown"].as_u64().unwrap();
    assert!(shown(0, 0) > 100, "{:#}", rows[0]);
    // Copies and surfaces of their own are the same picture, up to rounding.
    assert!(shown(0, 0).abs_diff(shown(1, 0)) * 50 < shown(0, 0), "{:#}", rows[1]);
    assert_eq!(rows[2]["animations"], 1);
    assert!(shown(2, 0) < shown(2, 1) && shown(2, 1) < shown(2, 2), "{:#}", rows[2]);
    assert_eq!(shown(2, 2), shown(0, 0));
}
