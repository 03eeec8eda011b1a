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

/// Counts of what is where none can be, over all trees of these places, by side.
fn misplaced(places: &Value) -> [[u64; 2]; 4] {
    let mut counts = [[0; 2]; 4];
    for place in places.as_array().unwrap() {
        for (side, tree) in place.as_array().unwrap().iter().enumerate() {
            for (i, count) in counts[side].iter_mut().enumerate() {
                *count += tree["misplaced"][i].as_u64().unwrap();
            }
        }
    }
    counts
}

#[test]
fn among_obstacles_no_node_is_inside_one_and_no_edge_goes_through() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "environment", &[]);
    let places = &json["species"][0]["places"];
    assert_eq!(places.as_array().unwrap().len(), 2);
    assert_eq!(misplaced(places)[..3], [[0; 2]; 3], "teacher, control, learner");
    assert_eq!(json["cost"][0]["trees"], 2);
    // A row of teacher, control, learner and the learner that is not told; a mean would be of one.
    let csv = String::from_utf8(desk.read("report/environment.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 4 * 6);
    assert_eq!(page.matches("data:image/png;base64,iVBOR").count(), 2);
}

#[test]
fn in_forms_the_networks_stay_inside_where_the_open_field_does_not() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "forms", &[]);
    let forms = json["forms"].as_array().unwrap();
    assert_eq!(forms.len(), 3);
    for form in forms {
        let [first, second, told, untold] = misplaced(&form["trees"]["places"]);
        assert_eq!([first[0], second[0], told[0]], [0; 3], "{}", form["form"]);
        assert!(untold[0] > 0, "a maple has no need of the {}", form["form"]);
    }
    assert_eq!(page.matches("data:image/png;base64,iVBOR").count(), 3);
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
            let file = desk.read(&name);
            // An .obj with its materials beside it names them.
            let materials = [b"mtllib ", b"usemtl "];
            let lines = file.split_inclusive(|&byte| byte == b'\n');
            let named = lines.filter(|line| materials.iter().any(|name| line.starts_with(*name)));
            let named: usize = if format == "obj" { named.map(<[u8]>::len).sum() } else { 0 };
            bytes += file.len() - named;
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
fn wishes_are_measured_on_what_has_grown_and_what_is_beyond_is_refused() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "wishes", &[]);
    let controls = json["species"][0]["controls"].as_array().unwrap();
    assert_eq!(controls.len(), 4);
    let number = |value: &Value| value.as_f64().unwrap();
    for controlled in controls {
        let (low, high) = (number(&controlled["range"][0]), number(&controlled["range"][1]));
        let asked: Vec<f64> = controlled["settings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|s| number(&s["asked"]))
            .collect();
        assert!(!asked.is_empty() && asked.iter().all(|asked| (low..=high).contains(asked)));
        assert!(low > 0.0);
        for outside in controlled["outside"].as_array().unwrap() {
            let refusal = outside["refusal"].as_str().unwrap();
            assert!(refusal.contains("maple of"), "{refusal}");
            let forced = number(&outside["forced"]["asked"]);
            assert!((low..=high).contains(&forced), "{forced} of {low} to {high}");
        }
    }
    // The mean height is that of the trees that generate writes.
    let setting = &controls[0]["settings"][1];
    let asked = setting["asked"].as_f64().unwrap().to_string();
    let words = ["generate", "maple", "--height", &asked, "--seed", "1000000", "--count", "2"];
    desk.ok(&[&words[..], &["-o", "trees.csv"]].concat());
    let table = String::from_utf8(desk.read("trees.csv")).unwrap();
    let mut highest = [0.0f64; 2];
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let tree: usize = fields[0].parse().unwrap();
        highest[tree] = highest[tree].max(fields[4].parse().unwrap());
    }
    let mean = (highest[0] + highest[1]) / 2.0;
    assert!((number(&setting["came"]["mean"]) - mean).abs() < 1e-3, "{mean} {setting}");
    assert!(page.contains("no two species of a blend are in this run"));
    assert_eq!(page.matches("<svg").count(), 4);
}

#[test]
fn blends_are_measured_beside_their_parents() {
    let desk = Desk::new();
    let words = ["evaluate", "--species", "oak,willow", "--quick", "--trees", "2", "-o", "report"];
    desk.ok(&[&words[..], &["--chapters", "wishes"]].concat());
    let json: Value = serde_json::from_slice(&desk.read("report/wishes.json")).unwrap();
    let blends = json["blends"].as_array().unwrap();
    let names: Vec<&str> = blends.iter().map(|blend| blend["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["oak:0.7,willow:0.3", "oak:0.5,willow:0.5", "oak:0.3,willow:0.7"]);
    for blend in blends {
        // Angles to child 2, by which oak and willow differ most.
        let angle = |figures: &Value| figures[4]["mean"].as_f64().unwrap();
        let [oak, own, willow] =
            [&blend["of_parents"][0], &blend["own"], &blend["of_parents"][1]].map(angle);
        assert!(willow < own && own < oak, "{oak} {own} {willow}");
    }
}

#[test]
fn the_open_loop_judges_every_node_of_the_teachers_trees() {
    let desk = Desk::new();
    let (json, page) = run(&desk, "open-loop", &[]);
    let (own, paper) = (&json["species"][0]["model"], &json["species"][0]["paper"]);
    desk.ok(&["grow", "maple", "--seed", "1000000", "--count", "2", "-o", "trees.csv"]);
    let table = String::from_utf8(desk.read("trees.csv")).unwrap();
    let nodes = (table.lines().count() - 1) as f64;
    for said in [own, paper] {
        assert_eq!(said["trees"], 2);
        assert_eq!(said["children"]["count"].as_f64().unwrap(), nodes);
        assert_eq!(said["existence"]["excess"]["count"].as_f64().unwrap(), 3.0 * nodes);
        // Every node but the two roots is a child of one.
        assert_eq!(said["children"]["sum"].as_f64().unwrap(), nodes - 2.0);
    }
    // A length for each edge but the roots', by the model's tables; kind paper has no such law.
    let lengths = |said: &Value| said["laws"][10]["all"]["bias"]["count"].as_f64().unwrap();
    assert_eq!((lengths(own), lengths(paper)), (nodes - 2.0, 0.0));
    assert_eq!(page.matches("<svg").count(), 3);
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
