//! Bad input: one line, an exit code that is not 0, no panic, no file left.

mod common;

use common::Desk;

const FAILED: i32 = 1;
const USAGE: i32 = 2;

#[test]
fn an_unknown_species_is_told_the_nearest_name() {
    let desk = Desk::new();
    for verb in ["generate", "grow"] {
        desk.fails(&[verb, "waeping", "-o", "a.glb"], USAGE, "there is no species 'waeping'");
        desk.fails(&[verb, "wilow", "-o", "a.glb"], USAGE, "did you mean willow?");
    }
    desk.fails(&["dataset", "--species", "oak,elm", "-o", "d"], USAGE, "'elm'");
    desk.fails(&["dataset", "--species", "oak,oak", "-o", "d"], USAGE, "named twice");
    desk.fails(&["evaluate", "--species", "mapel", "-o", "d"], USAGE, "did you mean maple?");
}

#[test]
fn numbers_that_cannot_be_are_refused() {
    let desk = Desk::new();
    for verb in ["generate", "grow"] {
        desk.fails(&[verb, "oak", "--count", "0", "-o", "a.csv"], USAGE, "--count");
        desk.fails(&[verb, "oak", "--seed", "-1", "-o", "a.glb"], USAGE, "--seed");
        desk.fails(&[verb, "oak", "--gravitropism", "NaN", "-o", "a.glb"], USAGE, "finite");
        desk.fails(&[verb, "oak", "--lod", "9", "-o", "a.glb"], USAGE, "--lod");
        desk.fails(&[verb, "oak", "--max-triangles", "0", "-o", "a.glb"], USAGE, "--max-triangles");
        desk.fails(&[verb, "oak", "--max-triangles", "7", "-o", "a.glb"], FAILED, "too few");
        desk.fails(&[verb, "oak", "--bark=2", "-o", "a.glb"], USAGE, "bark is 2");
        desk.fails(&[verb, "oak", "--attributes", "smell", "-o", "a.glb"], USAGE, "smell");
        for size in ["0", "255", "3000"] {
            let words = [verb, "oak", "--leaves", "--texture-size", size, "-o", "a.glb"];
            desk.fails(&words, USAGE, "from 256 to 2048 pixels");
        }
        desk.fails(&[verb, "oak", "--texture-size", "-1", "-o", "a.glb"], USAGE, "--texture-size");
        desk.fails(&[verb, "oak", "--season", "monsoon", "-o", "a.glb"], USAGE, "spring, summer");
        desk.fails(&[verb, "oak", "--leaves=fern", "-o", "a.glb"], USAGE, "leaves of 'fern'");
        desk.fails(&[verb, "oak", "--health", "1.5", "-o", "a.glb"], USAGE, "health is 1.5");
        desk.fails(&[verb, "oak", "--health", "NaN", "-o", "a.glb"], USAGE, "health is NaN");
        desk.fails(&[verb, "oak", "--leaf-density", "0", "-o", "a.glb"], USAGE, "density is 0");
    }
    desk.fails(&["grow", "oak", "--gravitropism", "7", "-o", "a.glb"], USAGE, "between -1 and 1");
    desk.fails(&["grow", "oak", "--age", "3.5", "-o", "a.glb"], USAGE, "whole number");
    desk.fails(&["generate", "oak", "--age", "3", "-o", "a.glb"], USAGE, "age");
    desk.fails(&["generate", "oak", "--height", "300", "-o", "a.glb"], USAGE, "of height");
    desk.fails(&["generate", "oak", "--height", "NaN", "-o", "a.glb"], USAGE, "finite");
    desk.fails(&["generate", "oak", "--budget", "0", "-o", "a.glb"], USAGE, "--budget");
    desk.fails(&["generate", "oak", "--simd", "mmx", "-o", "a.glb"], USAGE, "mmx");
}

#[test]
fn ranges_that_nothing_can_be_drawn_from_are_refused() {
    let desk = Desk::new();
    for (option, ranges, part) in [
        ("--ages", "20..10", "must not end below"),
        ("--ages", "10..20,15..30", "ascend"),
        ("--ages", "10..x", "`x` is no number"),
        ("--ages", "", "is no number"),
        ("--ages", "0..5", "between 1 and 100"),
        ("--ages", "5..101", "between 1 and 100"),
        ("--gravitropisms", "-0.4..NaN", "finite"),
        ("--gravitropisms", "-2..0", "between -1 and 1"),
    ] {
        desk.fails(&["dataset", option, ranges, "--trees", "1", "-o", "d"], USAGE, part);
    }
}

#[test]
fn blends_that_cannot_be_are_refused() {
    let desk = Desk::new();
    for (list, part) in [
        ("oak:0.7", "2 to 11 species"),
        ("oak,willow", "'oak' is no species with a weight"),
        ("oak:0.7,wilow:0.3", "did you mean willow?"),
        ("oak:0.7,willow:0", "above 0"),
        ("oak:0.7,willow:-1", "above 0"),
        ("oak:inf,willow:1", "finite"),
        ("oak:NaN,willow:1", "finite"),
        ("oak:x,willow:1", "finite"),
        ("oak:1,oak:2", "named twice"),
        ("oak:1,willow:1e-9", "too small to matter"),
        ("", "is no species with a weight"),
    ] {
        desk.fails(&["generate", "--blend", list, "-o", "a.csv"], USAGE, part);
    }
    let both = ["generate", "oak", "--blend", "oak:1,willow:1", "-o", "a.csv"];
    desk.fails(&both, USAGE, "cannot be used with");
    let paper = ["generate", "--blend", "oak:1,willow:1", "--model", "paper", "-o", "a.csv"];
    desk.fails(&paper, USAGE, "kind `paper`");
    desk.fails(&["generate", "-o", "a.csv"], USAGE, "not provided");
}

#[test]
fn outputs_that_cannot_be_are_refused() {
    let desk = Desk::new();
    desk.fails(&["generate", "oak", "-o", "tree.xyz123"], USAGE, ".xyz123");
    desk.fails(&["generate", "oak", "--count", "3", "-o", "a.glb"], USAGE, "name a folder");
    desk.fails(&["generate", "oak", "--format", "obj", "-o", "a.glb"], USAGE, "is no .obj file");
    desk.fails(&["generate", "oak", "-o", "missing/a.glb"], FAILED, "missing/a.glb");
    desk.fails(&["grow", "oak", "-o", "a.dtree"], USAGE, "only generate");
    desk.fails(&["generate", "oak"], USAGE, "--output");
    desk.fails(&["plant", "oak"], USAGE, "plant");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_and_a_folder_without_leave_are_told() {
    let desk = Desk::new();
    for format in ["glb", "csv", "parquet", "obj", "ply", "usdz", "tree", "dtree"] {
        let words = ["generate", "oak", "--format", format, "-o", "/dev/full"];
        desk.fails(&words, FAILED, "/dev/full");
    }
    desk.fails(&["generate", "oak", "-o", "/proc/a.glb"], FAILED, "/proc/a.glb");
    desk.fails(&["dataset", "--trees", "1", "-o", "/proc/corpus"], FAILED, "/proc/corpus");
}

#[test]
fn damaged_files_are_told_from_trees() {
    let desk = Desk::new();
    let noise: Vec<u8> =
        (0..5000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    for name in ["noise.tree", "noise.csv", "noise.parquet", "noise.dtree", "noise.safetensors"] {
        std::fs::write(desk.path(name), &noise).unwrap();
        desk.fails(&["info", name], FAILED, name);
    }
    desk.fails(&["convert", "noise.tree", "a.glb"], FAILED, "noise.tree");
    desk.fails(&["convert", "absent.csv", "a.glb"], FAILED, "absent.csv");
    desk.fails(&["convert", "noise.xyz", "a.glb"], USAGE, ".xyz");
    desk.fails(
        &["generate", "oak", "--model", "noise.safetensors", "-o", "a.glb"],
        FAILED,
        "noise",
    );
    desk.fails(&["generate", "oak", "--model", "absent", "-o", "a.glb"], FAILED, "absent");
}

#[test]
fn a_truncated_model_is_refused_at_any_length() {
    let desk = Desk::new();
    let model = include_bytes!("../../../models/situated.safetensors");
    for part in [0, 1, 7, 8, 100, 5_000, model.len() / 2, model.len() - 1] {
        std::fs::write(desk.path("cut.safetensors"), &model[..part]).unwrap();
        desk.fails(
            &["generate", "oak", "--model", "cut.safetensors", "-o", "a.glb"],
            FAILED,
            "cut",
        );
    }
}

#[test]
fn tables_that_are_no_trees_name_the_row() {
    let desk = Desk::new();
    let table = |rows: &str| format!("tree,id,parent,x,y,z,radius\n{rows}");
    for (rows, part) in [
        ("0,0,-1,0,1,0,0.1\n0,1,9,0,2,0,0.1\n", "row 2: its parent 9"),
        ("0,0,-1,0,1,0,0.1\n0,1,-1,0,2,0,0.1\n", "row 2: a second root"),
        ("0,0,-1,0,1,0,0.1\n0,1,0,0,NaN,0,0.1\n", "row 2: y is NaN"),
        ("0,0,-1,0,1,0,0.1\n0,1,2,0,2,0,0.1\n0,2,1,0,3,0,0.1\n", "row 2: it is its own ancestor"),
    ] {
        std::fs::write(desk.path("bad.csv"), table(rows)).unwrap();
        desk.fails(&["convert", "bad.csv", "a.glb"], FAILED, part);
    }
}
