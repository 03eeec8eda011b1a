//! Chapters of the report at toy size.
#![allow(clippy::unwrap_used, reason = "a test that cannot read its report has failed")]

mod common;

use common::Desk;
use serde_json::Value;

const QUICK: [&str; 8] =
    ["evaluate", "--species", "maple", "--quick", "--trees", "2", "-o", "report"];

fn run(desk: &Desk, chapter: &str, extra: &[&str]) -> (Value, String) {
    desk.ok(&[&QUICK[..], &["--chapters", chapter], extra].concat());
    let json = desk.read(&format!("report/{chapter}.json"));
    let csv = String::from_utf8(desk.read(&format!("report/{chapter}.csv"))).unwrap();
    assert!(csv.lines().count() > 1, "{csv}");
    let page = String::from_utf8(desk.read("report/report.html")).unwrap();
    assert!(page.contains(&format!("<section id=\"{chapter}\">")));
    (serde_json::from_slice(&json).unwrap(), page)
}

#[test]
fn diversity_draws_its_sheets_and_measures_both_sides() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "diversity", &[]);
    let row = &json["rows"][0];
    assert!(row["p"]["mean"].as_f64().unwrap() > 0.0);
    assert!(row["dt"]["mean"].as_f64().unwrap() > 0.0);
    assert_eq!(page.matches("data:image/png;base64,iVBOR").count(), 3);
}

#[test]
fn regrowth_changes_no_kept_node_and_draws_its_charts() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "regrowth", &[]);
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 5);
    for row in rows {
        assert_eq!(row["changed"], 0);
        let kept = row["kept"]["mean"].as_f64().unwrap();
        assert!(kept > 0.0 && kept < 1.0, "{kept}");
        // Before, after, and what they differ by.
        for number in row["numbers"].as_array().unwrap() {
            let mean = |i: usize| number[i]["mean"].as_f64().unwrap();
            assert!((mean(1) - mean(0) - mean(2)).abs() < 1e-6 * mean(0));
        }
    }
    assert_eq!(json["again"][0]["rounds"].as_array().unwrap().len(), 3);
    assert_eq!(page.matches("<svg").count(), 4);
    assert_eq!(page.matches("data:image/png;base64,iVBOR").count(), 1);
}

#[test]
fn sizes_are_those_of_the_files_that_generate_writes() {
    let desk = Desk::new();
    let (json, _) = run(&desk, "compression", &["--seed", "5"]);
    let row = &json["rows"][0];
    for format in ["tree", "csv", "parquet", "glb", "obj"] {
        let mut bytes = 0;
        for seed in ["5", "6"] {
            let name = format!("{seed}.{format}");
            desk.ok(&["generate", "maple", "--seed", seed, "-o", &name]);
            bytes += desk.read(&name).len();
        }
        assert_eq!(row[format]["mean"].as_f64().unwrap(), bytes as f64 / 2.0, "{format}");
    }
    desk.ok(&["generate", "maple", "-o", "seed.dtree"]);
    assert_eq!(json["seed_bytes"], desk.read("seed.dtree").len());
    let model = std::fs::metadata(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../models/situated.safetensors"
    ));
    assert_eq!(json["network_bytes"], model.unwrap().len());
}

#[test]
fn priors_measure_what_the_model_has_seen_and_say_what_it_refuses() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "priors", &[]);
    let settings = json["settings"].as_array().unwrap();
    // The growth model's trees get larger with age, and droop with gravitropism.
    let mean = |axis: &str, i: usize| -> Vec<f64> {
        let own = settings.iter().filter(|setting| setting["axis"] == axis);
        own.map(|setting| setting["p"]["numbers"][i]["mean"].as_f64().unwrap()).collect()
    };
    assert!(mean("Age", 0).is_sorted_by(|a, b| a < b), "nodes");
    assert!(mean("Age", 1).is_sorted_by(|a, b| a < b), "height");
    assert!(mean("Gravitropism", 3).is_sorted_by(|a, b| a > b), "rise");
    // Each setting either has generated trees or the range that the model has seen.
    for setting in settings {
        let value = setting["value"].as_f64().unwrap();
        if let Some(range) = setting["dt"].get("NotSeen") {
            let end = |key: &str| range[key].as_f64().unwrap();
            assert!(value < end("low") || value > end("high") || range["what"] != "age");
        } else {
            assert!(setting["dt"]["Grown"]["trees"]["numbers"][0]["mean"].as_f64().unwrap() > 1.0);
        }
    }
    assert_eq!(page.matches("<svg").count(), 8);
    assert_eq!(page.matches("data:image/png;base64,iVBOR").count(), 2);
    // A second run takes the parts of the first.
    let part = "report/parts/priors-age-maple.json";
    let text = String::from_utf8(desk.read(part)).unwrap();
    std::fs::write(desk.path(part), text.replace("\"cut\":0", "\"cut\":7")).unwrap();
    let (json, page) = run(&desk, "priors", &[]);
    assert_eq!(json["settings"][0]["p"]["cut"], 7);
    assert!(page.contains("trees of the growth model were cut short"));
    // Those of another build it makes anew.
    let text = String::from_utf8(desk.read(part)).unwrap();
    let (_, rest) = text.split_once("[\"program hash\",\"").unwrap();
    let (program, _) = rest.split_once('"').unwrap();
    assert!(program.len() == 32 && text.contains("\"cut\":7"));
    std::fs::write(desk.path(part), text.replace(program, &"0".repeat(32))).unwrap();
    let (json, _) = run(&desk, "priors", &[]);
    assert_eq!(json["settings"][0]["p"]["cut"], 0);
}

#[test]
fn runtimes_are_of_all_methods_and_the_script_has_the_same_networks() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "runtime", &[]);
    let row = &json["rows"][0];
    let methods: Vec<&str> = row["timings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|timing| {
            assert!(timing["seconds"].as_f64().unwrap() > 0.0);
            assert!(timing["nodes"].as_u64().unwrap() > 1 && timing["trees"] == 2);
            timing["method"].as_str().unwrap()
        })
        .collect();
    assert_eq!(methods[..3], ["growth model", "networks", "kind paper"]);
    match row["apart"].as_f64() {
        Some(apart) => {
            assert!(apart < 1e-5, "{apart}");
            assert_eq!(methods[3..], ["kind paper, PyTorch"]);
        }
        None => {
            println!("skipped the PyTorch version: no Python with torch, see --python");
            assert!(page.contains("no Python with torch was found"));
        }
    }
    desk.fails(
        &["evaluate", "--chapters", "runtime", "--python", "/no/python", "-o", "report"],
        1,
        "has no torch to import",
    );
}
