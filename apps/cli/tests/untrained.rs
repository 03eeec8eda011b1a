//! Chapters that train, in a build that cannot.
#![cfg(not(feature = "train"))]

mod common;

use common::Desk;

#[test]
fn chapters_that_train_say_which_build_they_need() {
    let desk = Desk::new();
    desk.ok(&["evaluate", "--quick", "--chapters", "ablation,joint", "-o", "report"]);
    let page = String::from_utf8(desk.read("report/report.html")).unwrap();
    for chapter in ["ablation", "joint"] {
        let command = format!("--features train -- evaluate --chapters {chapter} -o report");
        assert!(page.contains(&command), "{page}");
    }
}
