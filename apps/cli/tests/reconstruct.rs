//! `deeptree reconstruct` through the real command.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::Desk;
use serde_json::Value;

/// A leaning stem with a branch, seen from one side, in coordinates of a land survey; z up.
fn survey(desk: &Desk) {
    let mut text = String::new();
    for i in 0..4000 {
        let (sin, cos) = (f64::from(i % 20) * 0.15).sin_cos();
        let height = f64::from(i / 20) * 0.02;
        let (x, y) = (448_262.0 + 0.1 * cos + 0.1 * height, 5_411_932.0 + 0.1 * sin);
        text += &format!("{x:.4} {y:.4} {:.4}\n", 170.0 + height);
    }
    for i in 0..300 {
        let along = f64::from(i) * 0.005;
        text +=
            &format!("{:.4} {:.4} {:.4}\n", 448_262.3 + along, 5_411_932.0, 172.0 + 0.5 * along);
    }
    std::fs::write(desk.path("cloud.xyz"), text).unwrap();
}

#[test]
fn a_scanned_tree_is_reconstructed_and_says_how_well() {
    let desk = Desk::new();
    desk.ok(&["generate", "pine", "--seed", "4", "-o", "pine.tree"]);
    desk.ok(&["scan", "pine.tree", "--points", "9000", "-o", "pine.ply"]);
    let said = desk.ok(&["reconstruct", "pine.ply", "--frame", "tree", "-o", "made.csv", "--json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    let number = |key: &str| said[key].as_f64().unwrap();
    assert!(number("f_1_percent") > 0.8, "{said}");
    assert!(number("dbh_m") > 0.05 && number("wood_volume_m3") > 0.0);
    let by_order: f64 =
        said["length_by_order_m"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).sum();
    assert!((by_order / number("skeleton_length_m") - 1.0).abs() < 1e-6);
    let truth: Value = serde_json::from_str(&desk.ok(&["info", "pine.tree", "--json"])).unwrap();
    let height = truth["trees"][0]["height_m"].as_f64().or(truth["height_m"].as_f64());
    if let Some(height) = height {
        // From below a crown its top does not show.
        let share = number("height_m") / height;
        assert!((0.7..1.02).contains(&share), "{said} {truth}");
    }
    // The tree is one that other verbs read.
    desk.ok(&["convert", "made.csv", "made.glb"]);
    let geometry = ["reconstruct", "pine.ply", "--frame", "tree", "--no-prior", "-o", "plain.csv"];
    desk.ok(&geometry);
    desk.ok(&["reconstruct", "pine.ply", "--complete", "--species", "pine", "-o", "whole.obj"]);
}

#[test]
fn tables_keep_the_coordinates_of_a_land_survey() {
    let desk = Desk::new();
    survey(&desk);
    let words =
        ["reconstruct", "cloud.xyz", "-o", "tree.csv", "--qsm", "qsm.csv", "--labels", "l.xyz"];
    let said = desk.ok(&[&words[..], &["--json"]].concat());
    let said: Value = serde_json::from_str(&said).unwrap();
    let offset: Vec<f64> =
        said["offset_m"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!(offset[1] > 5_000_000.0, "{said}");
    // The table has whole coordinates, z up; the stem starts at 170 m.
    let table = String::from_utf8(desk.read("qsm.csv")).unwrap();
    let row: Vec<f64> =
        table.lines().nth(1).unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    assert!((row[0] - 0.1).abs() < 0.02, "{row:?}");
    let foot = [448_262.0, 5_411_932.0, 170.0];
    assert!((0..3).all(|k| (row[2 + k] - foot[k]).abs() < 0.05), "{row:?}");
    assert!(row[7] > 0.95, "the axis points upwards: {row:?}");
    // The tree's file has them relative to the offset.
    let tree = String::from_utf8(desk.read("tree.csv")).unwrap();
    let head: Vec<&str> = tree.lines().next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|h| *h == name).unwrap();
    let first: Vec<&str> = tree.lines().nth(1).unwrap().split(',').collect();
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let at: f64 = first[column(name)].parse().unwrap();
        assert!((at + offset[k] - foot[k]).abs() < 0.05, "{name}: {at} {offset:?}");
    }
    // Each point has a branch, an order and a node.
    let labels = String::from_utf8(desk.read("l.xyz")).unwrap();
    assert!(labels.lines().count() >= 4300);
    let root = ["--root", "448262,5411932,170"];
    desk.ok(&[&["reconstruct", "cloud.xyz", "-o", "again.obj"], &root[..]].concat());
}

#[test]
fn what_cannot_be_done_is_said_in_one_line() {
    let desk = Desk::new();
    survey(&desk);
    std::fs::write(desk.path("one.xyz"), "1 2 3\n1 2 3\n").unwrap();
    std::fs::write(desk.path("text.xyz"), "no points here\n").unwrap();
    let fails = |words: &[&str], code, part: &str| {
        desk.fails(&[&["reconstruct"], words, &["-q"]].concat(), code, part);
    };
    fails(&["one.xyz", "-o", "t.glb"], 1, "at one place");
    fails(&["text.xyz", "-o", "t.glb"], 1, "text.xyz");
    fails(&["none.xyz", "-o", "t.glb"], 1, "none.xyz");
    fails(&["cloud.xyz", "-o", "t.dtree"], 2, "dtree");
    fails(&["cloud.xyz", "-o", "t.glb", "--root", "0,0,0"], 1, "from the nearest point");
    fails(&["cloud.xyz", "-o", "t.glb", "--root", "0,0"], 2, "3 numbers");
    fails(&["cloud.xyz", "-o", "t.glb", "--species", "ash"], 2, "ash");
    fails(&["cloud.xyz", "-o", "t.glb", "--cover=-1"], 2, "above 0");
    fails(&["cloud.xyz", "-o", "t.glb", "--labels", "l.jpg"], 2, "jpg");
    fails(&["cloud.xyz", "-o", "t.glb", "--no-prior", "--complete"], 2, "complete");
}
