//! Point clouds: scanned, told of, converted; and bad ones.

mod common;

use common::Desk;

const FAILED: i32 = 1;
const USAGE: i32 = 2;

/// A number after `"key":` in a line of JSON.
fn number(json: &str, key: &str) -> u64 {
    let after = json.split(&format!("\"{key}\":")).nth(1).unwrap_or_default();
    let digits: String = after.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().unwrap_or_default()
}

fn with_a_tree() -> Desk {
    let desk = Desk::new();
    desk.ok(&["grow", "oak", "--age", "7", "--seed", "3", "-o", "oak.tree"]);
    desk
}

#[test]
fn a_scan_goes_through_every_format_and_any_number_of_threads() {
    let desk = with_a_tree();
    let scan = ["scan", "oak.tree", "--points", "2000", "--seed", "5", "-o"];
    desk.ok(&[&scan[..], &["a.ply", "--threads", "1"]].concat());
    let said = desk.ok(&[&scan[..], &["b.ply", "--threads", "2", "--json"]].concat());
    assert_eq!(desk.read("a.ply"), desk.read("b.ply"));
    assert_eq!((number(&said, "points"), number(&said, "wood")), (2000, 2000));
    let mut before = "a.ply".to_owned();
    for format in ["xyz", "csv", "parquet", "laz", "las", "txt", "ply"] {
        let next = format!("again.{format}");
        desk.ok(&["convert", &before, &next]);
        let said = desk.ok(&["info", &next, "--json"]);
        assert_eq!((number(&said, "points"), number(&said, "wood")), (2000, 2000), "{format}");
        before = next;
    }
    // As text, bit for bit, before LAS rounds; the pipe takes it, too.
    desk.ok(&["convert", "again.parquet", "same.ply"]);
    assert_eq!(desk.read("same.ply"), desk.read("a.ply"));
    let text = desk.ok(&["convert", "a.ply", "-", "--format", "xyz", "--quiet"]);
    assert_eq!(text.as_bytes(), desk.read("again.xyz"));
}

#[test]
fn patterns_ground_and_leaves_can_be_asked_for() {
    let desk = with_a_tree();
    for pattern in ["terrestrial", "mobile", "airborne"] {
        let words = ["--ground", "--leaves", "--step", "0.3", "--json", "--points", "4000"];
        let scan = ["scan", "oak.tree", "--pattern", pattern, "-o", "a.las"];
        let said = desk.ok(&[&scan[..], &words[..]].concat());
        assert!(number(&said, "ground") > 0 && number(&said, "leaf") > 0, "{pattern}: {said}");
    }
}

#[test]
fn what_cannot_be_scanned_is_refused() {
    let desk = with_a_tree();
    let scan = |words: &[&str], part: &str| {
        desk.fails(&[&["scan", "oak.tree", "-o", "a.ply"], words].concat(), USAGE, part);
    };
    scan(&["--stations", "0"], "1 to 64 stations");
    scan(&["--step", "0"], "0.01° to 10°");
    scan(&["--step", "NaN"], "0.01° to 10°");
    scan(&["--noise", "-1"], "0 m to 1 m");
    scan(&["--divergence", "1e9"], "100 mrad");
    scan(&["--points", "0"], "--points");
    scan(&["--pattern", "orbital"], "orbital");
    desk.fails(&["scan", "oak.tree", "-o", "a.glb"], USAGE, "point clouds");
    desk.fails(&["scan", "oak.tree", "-o", "a"], USAGE, "extension");
    desk.fails(&["scan", "oak.tree", "-o", "-"], USAGE, "--format");
    desk.fails(&["scan", "none.tree", "-o", "a.ply"], FAILED, "none.tree");
}

#[test]
fn bad_clouds_are_told_in_one_line() {
    let desk = Desk::new();
    for (name, text, part) in [
        ("empty.xyz", "", "no points"),
        ("words.xyz", "to be or not to be\n", "no points"),
        ("two.xyz", "1 2\n3 4\n", "line 1"),
        ("commas.xyz", "1,5 2,5 3,5\n", "decimal"),
        ("bad.ply", "ply\nformat ascii 1.0\n", "cut off"),
        ("bad.las", "LASF", "cut off"),
        ("bad.laz", "LASF\0\0", "cut off"),
        ("no.ply", "ply\nformat ascii 1.0\nelement vertex 9\nend_header\n", "vertex"),
    ] {
        std::fs::write(desk.path(name), text).expect("the desk takes files");
        desk.fails(&["info", name], FAILED, part);
        desk.fails(&["convert", name, "out.xyz"], FAILED, part);
    }
    std::fs::write(desk.path("some.xyz"), "1 2 3\n1 2 3\nnan 1 2\n4 5\n6 7 8\n")
        .expect("as before");
    let output = desk.run(&["info", "some.xyz"]);
    let warned = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && warned.trim_end().lines().count() == 1, "{warned}");
    for part in ["1 without finite", "1 at the place", "line 4"] {
        assert!(warned.contains(part), "{warned}");
    }
}

#[test]
fn a_corpus_gets_its_scans_once() {
    let desk = Desk::new();
    let words =
        ["dataset", "--species", "oak", "--trees", "2", "--ages", "5..6", "--scans", "-o", "d"];
    let said = desk.ok(&[&words[..], &["--json"]].concat());
    assert_eq!(number(&said, "scan_tables_written"), 1);
    let said = desk.ok(&[&words[..], &["--json"]].concat());
    assert_eq!((number(&said, "scan_tables_written"), number(&said, "scan_tables_kept")), (0, 1));
    let said = desk.ok(&["info", "d/oak-000.scans.parquet", "--json"]);
    assert!(number(&said, "points") >= 16_000, "{said}");
}
