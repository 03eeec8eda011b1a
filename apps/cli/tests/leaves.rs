//! Leaves and textures through the real command.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::Desk;
use serde_json::Value;

/// The description in a GLB file.
fn description(desk: &Desk, name: &str) -> Value {
    let bytes = desk.read(name);
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

fn count(description: &Value, what: &str) -> usize {
    description[what].as_array().map_or(0, Vec::len)
}

const SMALL: [&str; 6] = ["--age", "12", "--texture-size", "256", "--seed", "3"];

fn grow(desk: &Desk, species: &str, more: &[&str], out: &str) {
    let words = [&["grow", species, "-q", "-o", out], &SMALL[..], more].concat();
    desk.ok(&words);
}

#[test]
fn leaves_and_textures_come_where_they_are_asked_for() {
    let desk = Desk::new();
    desk.ok(&["grow", "oak", "--age", "12", "-q", "-o", "plain.glb"]);
    grow(&desk, "oak", &[], "bark.glb");
    grow(&desk, "oak", &["--leaves"], "summer.glb");
    grow(&desk, "oak", &["--season", "autumn"], "autumn.glb");
    grow(&desk, "oak", &["--season", "winter"], "winter.glb");
    grow(&desk, "pine", &["--season", "winter"], "pine.glb");
    let counts = |name: &str| {
        let description = description(&desk, name);
        (count(&description, "materials"), count(&description, "images"))
    };
    assert_eq!(counts("plain.glb"), (1, 0));
    // Colour, normal and roughness of each material.
    assert_eq!([counts("bark.glb"), counts("winter.glb")], [(1, 3), (2, 3)]);
    for name in ["summer.glb", "autumn.glb", "pine.glb"] {
        assert_eq!(counts(name), (2, 6), "{name}");
    }
    assert!(desk.read("summer.glb") != desk.read("autumn.glb"));
}

#[test]
fn an_impostor_is_the_last_level_of_detail() {
    let desk = Desk::new();
    grow(&desk, "oak", &["--lods", "--impostor=1"], "levels.glb");
    let levels = description(&desk, "levels.glb");
    let first = &levels["nodes"][levels["scenes"][0]["nodes"][0].as_u64().unwrap() as usize];
    let ids = first["extensions"]["MSFT_lod"]["ids"].as_array().unwrap();
    let coverage = first["extras"]["MSFT_screencoverage"].as_array().unwrap();
    assert_eq!((ids.len(), coverage.len()), (4, 5));
    assert!(coverage.is_sorted_by(|a, b| a.as_f64() > b.as_f64()));
    // A card of four corners, with a picture of colours and one of normals.
    let card = &levels["nodes"][ids[3].as_u64().unwrap() as usize];
    let card = &levels["nodes"][card["children"][0].as_u64().unwrap() as usize];
    let card = &levels["meshes"][card["mesh"].as_u64().unwrap() as usize]["primitives"][0];
    let position = card["attributes"]["POSITION"].as_u64().unwrap() as usize;
    assert_eq!(levels["accessors"][position]["count"], 4);
    // Beside the three of the bark.
    assert_eq!(count(&levels, "images"), 5);
}

#[test]
fn a_tree_of_a_batch_is_dressed_as_by_itself() {
    let desk = Desk::new();
    let words = ["--leaves", "--count", "3", "--threads", "2"];
    grow(&desk, "maple", &words, "maples");
    let alone = ["grow", "maple", "--age", "12", "--texture-size", "256", "--leaves"];
    desk.ok(&[&alone[..], &["--seed", "5", "-q", "-o", "alone.glb"]].concat());
    assert!(desk.read("maples/maple-5.glb") == desk.read("alone.glb"));
}

#[test]
fn a_tree_without_a_species_is_dressed_as_it_is_asked() {
    let desk = Desk::new();
    desk.ok(&["grow", "oak", "--age", "12", "-q", "-o", "tree.csv"]);
    desk.ok(&["convert", "tree.csv", "tree.glb", "--leaves=walnut", "--texture-size", "256", "-q"]);
    let names = description(&desk, "tree.glb")["materials"].to_string();
    assert!(names.contains("walnut bark") && names.contains("walnut leaves"), "{names}");
}
