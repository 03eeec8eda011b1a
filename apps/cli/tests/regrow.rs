//! Trees that are pruned and grow again, from file to file.
#![allow(clippy::unwrap_used, reason = "a test that cannot read its files has failed")]

mod common;

use std::collections::HashSet;

use common::Desk;
use serde_json::Value;

const USAGE: i32 = 2;

/// What the rows of a table say of their nodes: all but the numbers of the tree, the node and its
/// parent.
fn nodes(desk: &Desk, name: &str) -> HashSet<String> {
    let table = String::from_utf8(desk.read(name)).unwrap();
    let node = |row: &str| row.splitn(4, ',').nth(3).unwrap().to_owned();
    table.lines().skip(1).map(node).collect()
}

fn figures(desk: &Desk, words: &[&str]) -> Value {
    serde_json::from_str(&desk.ok(&[words, &["--json"]].concat())).unwrap()
}

fn count(figures: &Value, key: &str) -> usize {
    figures[key].as_u64().unwrap() as usize
}

#[test]
fn what_is_kept_stands_in_the_table_as_it_stood() {
    let desk = Desk::new();
    desk.ok(&["generate", "oak", "--seed", "7", "-o", "oak.parquet"]);
    desk.ok(&["convert", "oak.parquet", "oak.csv"]);
    std::fs::write(desk.path("ids.txt"), "7\n31, 32\t40\n").unwrap();
    let before = nodes(&desk, "oak.csv");
    for cut in [
        &["--keep-below", "9"][..],
        &["--keep-order", "1"],
        &["--keep-path", "0.5"],
        &["--cut-box", "-2,4,-2,6,30,6"],
        &["--cut-sphere", "0,9,1,4"],
        &["--cut-plane=-1,0,0.5,2"],
        &["--cut-nodes", "ids.txt"],
        &["--keep-below", "15", "--keep-below", "14", "--cut-sphere", "0,9,1,2"],
    ] {
        let words =
            ["regrow", "oak.parquet", "--seed", "3", "--pruned", "left.csv", "-o", "new.csv"];
        let figures = figures(&desk, &[&words[..], cut].concat());
        let (left, after) = (nodes(&desk, "left.csv"), nodes(&desk, "new.csv"));
        assert!(left.is_subset(&before) && left.is_subset(&after), "{cut:?}");
        assert_eq!(count(&figures, "kept"), left.len());
        assert_eq!(count(&figures, "cut"), before.len() - left.len());
        assert_eq!(count(&figures, "regrown"), after.len() - left.len());
        assert!(left.len() < before.len() && left.len() < after.len(), "{cut:?}");
        assert!(count(&figures, "wounds") > 0);
        assert_eq!(figures["hit_budget"], Value::Array(Vec::new()));
        assert_eq!(figures["seed"], 3);
    }
}

#[test]
fn every_format_that_is_read_gives_the_same_tree() {
    let desk = Desk::new();
    desk.ok(&["generate", "maple", "--seed", "2", "-o", "maple.dtree"]);
    desk.ok(&["generate", "maple", "--seed", "2", "-o", "maple.parquet"]);
    desk.ok(&["generate", "maple", "--seed", "2", "-o", "maple.csv"]);
    let regrow = |input: &str, extra: &[&str]| {
        let words = ["regrow", input, "--keep-below", "8", "--seed", "5", "-o", "new.csv"];
        desk.ok(&[&words[..], extra].concat());
        desk.read("new.csv")
    };
    let expected = regrow("maple.parquet", &[]);
    assert!(expected == regrow("maple.dtree", &[]));
    // A table of comma-separated values names no species; age and gravitropism are the maple's own.
    assert!(expected == regrow("maple.csv", &["--species", "maple"]));
    assert!(expected == regrow("maple.parquet", &["--batch", "1", "--simd", "scalar"]));
    let unnamed = ["regrow", "maple.csv", "--keep-below", "8", "-o", "a.csv"];
    desk.fails(&unnamed, USAGE, "say which it is with --species");
    assert!(expected != regrow("maple.parquet", &["--gravitropism", "0.2"]));
    for format in ["glb", "obj", "ply", "tree", "parquet"] {
        let name = format!("new.{format}");
        desk.ok(&["regrow", "maple.dtree", "--keep-order", "1", "-o", &name]);
        assert!(desk.read(&name).len() > 1000, "{name}");
    }
    desk.ok(&["regrow", "new.parquet", "--keep-order", "2", "--seed", "9", "-o", "again.parquet"]);
}

#[test]
fn all_trees_of_a_table_are_regrown_each_by_its_own_seed() {
    let desk = Desk::new();
    desk.ok(&["generate", "pine", "--count", "3", "-o", "pines.parquet"]);
    let words = ["regrow", "pines.parquet", "--keep-below", "9", "--seed", "40"];
    let figures = figures(&desk, &[&words[..], &["-o", "new.csv"]].concat());
    assert_eq!(count(&figures, "trees"), 3);
    desk.ok(&["convert", "new.csv", "--tree", "2", "third.csv"]);
    let third = ["regrow", "pines.parquet", "--tree", "2", "--keep-below", "9", "--seed", "42"];
    desk.ok(&[&third[..], &["-o", "alone.csv"]].concat());
    assert_eq!(nodes(&desk, "alone.csv"), nodes(&desk, "third.csv"));
    desk.fails(&[&words[..], &["-o", "new.glb"]].concat(), USAGE, "say which with --tree");
    let one_pruned = ["--pruned", "left.glb", "-o", "other.csv"];
    desk.fails(&[&words[..], &one_pruned].concat(), USAGE, "say which with --tree");
    desk.ok(&[&words[..], &["--format", "tree", "-o", "folder"]].concat());
    assert!(desk.path("folder/pine-42.tree").exists());
}

#[test]
fn a_tree_of_a_blend_is_regrown_as_one() {
    let desk = Desk::new();
    desk.ok(&["generate", "--blend", "oak:0.7,willow:0.3", "--seed", "1", "-o", "blend.parquet"]);
    let words = ["regrow", "blend.parquet", "--keep-below", "9", "-o", "new.parquet"];
    assert_eq!(figures(&desk, &words)["species"], "oak:0.7,willow:0.3");
}

#[test]
fn trees_of_the_growth_model_and_of_the_published_recipe_are_regrown_too() {
    let desk = Desk::new();
    desk.ok(&["grow", "walnut", "--seed", "4", "-o", "walnut.parquet"]);
    desk.ok(&["regrow", "walnut.parquet", "--keep-path", "0.6", "-o", "new.parquet"]);
    let paper = ["--model", "paper", "--budget", "3000"];
    let make = ["generate", "walnut", "-o", "paper.parquet"];
    desk.ok(&[&make[..], &paper].concat());
    let words = ["regrow", "paper.parquet", "--keep-path", "0.6", "-o", "new.parquet"];
    desk.ok(&[&words[..], &paper].concat());
}

#[test]
fn cuts_that_cannot_be_are_refused() {
    let desk = Desk::new();
    desk.ok(&["generate", "oak", "-o", "oak.parquet"]);
    std::fs::write(desk.path("ids.txt"), "1 x").unwrap();
    for (cut, part) in [
        (&[][..], "not provided"),
        (&["--keep-below", "-1"], "nothing is left"),
        (&["--keep-below", "NaN"], "finite"),
        (&["--keep-path", "1.5"], "between 0 and 1"),
        (&["--keep-order", "-1"], "--keep-order"),
        (&["--cut-box", "0,0,0,1,1"], "6 numbers"),
        (&["--cut-box", "0,5,0,1,4,1"], "least corner first"),
        (&["--cut-sphere", "0,5,0,-1"], "must not be negative"),
        (&["--cut-plane", "0,0,0,1"], "the normal of the plane is 0"),
    ] {
        let words = ["regrow", "oak.parquet", "-o", "a.csv"];
        desk.fails(&[&words[..], cut].concat(), USAGE, part);
    }
    let cut = ["--keep-below", "9"];
    let fails = |words: &[&str], code, part| desk.fails(&[words, &cut].concat(), code, part);
    fails(&["regrow", "oak.parquet", "-o", "a.dtree"], USAGE, "only generate");
    fails(&["regrow", "oak.parquet", "--species", "oka", "-o", "a.csv"], USAGE, "did you mean oak");
    fails(&["regrow", "oak.parquet", "--age", "90", "-o", "a.csv"], USAGE, "of age");
    fails(&["regrow", "oak.parquet", "--pruned", "p", "-o", "a.csv"], USAGE, "extension");
    fails(&["regrow", "absent.parquet", "-o", "a.csv"], 1, "absent.parquet");
    let nodes = ["regrow", "oak.parquet", "--cut-nodes", "ids.txt", "-o", "a.csv"];
    desk.fails(&nodes, 1, "`x` is no node number");
    std::fs::write(desk.path("ids.txt"), "1000000").unwrap();
    desk.fails(&nodes, USAGE, "no node 1000000");
}

#[test]
fn a_hit_budget_is_reported() {
    let desk = Desk::new();
    desk.ok(&["generate", "oak", "-o", "oak.parquet"]);
    let words = ["regrow", "oak.parquet", "--keep-below", "9", "--seed", "6", "--budget", "50"];
    let figures = figures(&desk, &[&words[..], &["-o", "a.csv"]].concat());
    assert_eq!(figures["hit_budget"], serde_json::json!([6]));
    assert_eq!(figures["regrown"], 0);
    assert!(figures["kept"].as_u64() > Some(50));
}
