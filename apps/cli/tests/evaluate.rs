//! The report, from the command to its files.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::Desk;
use serde_json::{Value, json};

/// The chapters that compare the two models' trees.
const CHAPTERS: &str = "table,perceptual,two-sample,memorisation";

/// Every chapter at toy size.
fn report(desk: &Desk, folder: &str) -> String {
    let words = ["evaluate", "--quick", "--species", "tulip", "--trees", "4"];
    desk.ok(&[&words[..], &["--chapters", CHAPTERS, "-o", folder]].concat());
    text(desk, &format!("{folder}/report.html"))
}

fn text(desk: &Desk, name: &str) -> String {
    String::from_utf8(desk.read(name)).unwrap()
}

fn figures(desk: &Desk, name: &str) -> Value {
    serde_json::from_slice(&desk.read(name)).unwrap()
}

#[test]
fn a_report_has_its_chapters_and_their_figures_and_a_second_run_goes_on_from_the_parts() {
    let desk = Desk::new();
    let page = report(&desk, "report");
    for chapter in CHAPTERS.split(',') {
        assert!(page.contains(&format!("<section id=\"{chapter}\">")), "{chapter}");
        assert!(page.contains(&format!("<a href=\"#{chapter}\">")), "{chapter}");
        let csv = text(&desk, &format!("report/{chapter}.csv"));
        let columns = csv.lines().next().unwrap().split(',').count();
        assert!(csv.lines().count() > 1, "{chapter}");
        assert!(csv.lines().all(|line| line.split(',').count() == columns), "{chapter}");
        figures(&desk, &format!("report/{chapter}.json"));
    }
    assert!(page.contains("<svg"), "charts are inside");

    // Ten quantities of the learner, of the teacher's second sample, and of kind paper.
    let criteria = figures(&desk, "report/criteria.json");
    for set in ["DT", "P2", "paper"] {
        assert_eq!(criteria[set].as_array().unwrap().len(), 10, "{set}");
    }
    // The mean of nodes by hand, from the trees' own parts.
    let nodes = |set: &str| -> f64 {
        let part = figures(&desk, &format!("report/parts/trees-tulip-{set}.json"));
        let trees = part["value"]["set"]["trees"].as_array().unwrap().clone();
        assert_eq!(trees.len(), 4, "{set}");
        trees.iter().map(|tree| tree["nodes"].as_f64().unwrap() / 4.0).sum()
    };
    let found = criteria["DT"].as_array().unwrap().iter().find(|one| one["quantity"] == "nodes");
    let relative = found.unwrap()["mean"]["relative"].as_f64().unwrap();
    assert!((relative - (nodes("DT") / nodes("P") - 1.0)).abs() < 1e-9);
    let tests = figures(&desk, "report/two-sample.json");
    for set in ["P2", "DT", "other", "paper"] {
        let area = tests["tulip"][set]["auc"]["value"].as_f64().unwrap();
        assert!((0.0..=1.0).contains(&area), "{set}");
    }
    assert_eq!(tests["tulip"]["other_species"], "walnut");

    // The parts are what a second run goes on from: it gives the same page, and what stands in
    // a part is what the page says.
    assert!(page == report(&desk, "report"));
    let ends = "report/parts/ends-tulip.json";
    let mut part = figures(&desk, ends);
    assert_eq!(part["value"], json!({ "trees": 4, "hit_budget": 0 }));
    assert!(page.contains("8 of 8 trees of the learner ended by themselves"));
    part["value"]["hit_budget"] = 3.into();
    std::fs::write(desk.path(ends), part.to_string()).unwrap();
    assert!(report(&desk, "report").contains("5 of 8 trees of the learner ended by themselves"));
    // Parts of other options are made anew.
    part["of"]["quick"] = false.into();
    std::fs::write(desk.path(ends), part.to_string()).unwrap();
    assert!(page == report(&desk, "report"));
}

#[test]
fn one_side_alone_has_a_table_and_says_what_is_not_measured() {
    let desk = Desk::new();
    for (side, rows) in [("p", 2), ("dt", 2)] {
        let words = ["evaluate", "--quick", "--species", "walnut", "--trees", "3", "-o", side];
        desk.ok(&[&words[..], &["--side", side, "--chapters", CHAPTERS]].concat());
        let table = figures(&desk, &format!("{side}/table.json"));
        assert_eq!(table["rows"].as_array().unwrap().len(), rows, "{side}");
        let page = text(&desk, &format!("{side}/report.html"));
        assert_eq!(page.matches("Not measured: only one side").count(), 3, "{side}");
    }
}

#[test]
fn an_unknown_chapter_is_refused_with_the_names_of_those_there_are() {
    let desk = Desk::new();
    let words = ["evaluate", "--chapters", "table,tables", "-o", "report"];
    desk.fails(&words, 2, "no chapter 'tables'; there are table, perceptual, two-sample");
}
