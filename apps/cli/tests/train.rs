//! Training through the real command.
#![cfg(feature = "train")]
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::Desk;
use deeptree_infer::Weights;

/// A corpus of five small trees of one species.
fn corpus() -> Desk {
    let desk = Desk::new();
    desk.ok(&["dataset", "--species", "walnut", "--trees", "5", "-o", "corpus"]);
    desk
}

fn train(desk: &Desk, kind: &str, model: &str) -> String {
    let words = ["train", "corpus", "--kind", kind, "--epochs", "1", "--samples", "4096"];
    desk.ok(&[&words[..], &["--seed", "5", "-o", model]].concat())
}

#[test]
fn every_kind_trains_into_models_that_generate() {
    let desk = corpus();
    for kind in ["situated", "paper", "joint"] {
        let model = format!("{kind}.safetensors");
        assert!(train(&desk, kind, &model).contains("weights"));
        assert!(desk.ok(&["info", &model]).contains(kind));
        let toml = String::from_utf8(desk.read(&format!("{kind}.toml"))).unwrap();
        assert!(toml.contains("data_hash") && toml.contains("sha256"));
        let words = ["generate", "walnut", "--model", &model, "--budget", "2000", "-o", "a.csv"];
        desk.ok(&words);
        desk.fails(&["generate", "oak", "--model", &model, "-o", "b.csv"], 2, "walnut");
    }
}

#[test]
fn a_training_that_is_run_again_gives_the_same_model() {
    let desk = corpus();
    train(&desk, "situated", "one.safetensors");
    train(&desk, "situated", "two.safetensors");
    assert!(desk.read("one.safetensors") == desk.read("two.safetensors"));
    // The checkpoints of the first are whole: it resumes and has nothing left to do.
    let before = desk.read("one.safetensors");
    train(&desk, "situated", "one.safetensors");
    assert!(desk.read("one.safetensors") == before);
}

#[test]
fn one_species_of_a_corpus_and_some_attributes_of_a_node_can_be_trained_on() {
    let desk = Desk::new();
    desk.ok(&["dataset", "--species", "walnut,tulip", "--trees", "5", "-o", "corpus"]);
    let words = ["train", "corpus", "--kind", "paper", "--epochs", "1", "--samples", "4096"];
    let train = |more: &[&'static str]| [&words[..], more].concat();
    desk.ok(&train(&[
        "--species",
        "walnut",
        "--classifier-attributes",
        "p,ds,mp",
        "--regressor-attributes",
        "t",
        "-o",
        "walnut.safetensors",
    ]));
    desk.ok(&[
        "generate",
        "walnut",
        "--model",
        "walnut.safetensors",
        "--budget",
        "500",
        "-o",
        "a.csv",
    ]);
    let words = ["generate", "tulip", "--model", "walnut.safetensors", "-o", "b.csv"];
    desk.fails(&words, 2, "walnut");
    let toml = String::from_utf8(desk.read("walnut.toml")).unwrap();
    assert!(toml.contains("reads = [\"p\", \"ds\", \"mp\"]"), "{toml}");

    let out = ["-o", "m.safetensors"];
    let bad =
        |more: &[&'static str], part: &str| desk.fails(&train(&[more, &out].concat()), 2, part);
    bad(&["--classifier-attributes", "p,dx"], "p, t, dr, ds, qp, lp, o, mp, a, v, s");
    bad(&["--regressor-attributes", ""], "--regressor-attributes");
    bad(&["--species", "wallnut"], "did you mean walnut?");
    let words = ["train", "corpus", "--kind", "joint", "--classifier-attributes", "p"];
    desk.fails(&[&words[..], &out].concat(), 2, "--kind paper");
}

#[test]
fn several_corpora_make_one_training_set() {
    let desk = corpus();
    let build = |words: &[&str]| desk.ok(&[&["dataset", "--trees", "5"], words].concat());
    build(&["--species", "walnut", "--ages", "10..20", "--seed", "100", "-o", "young"]);
    build(&["--species", "tulip", "-o", "tulips"]);
    let words = |model| {
        let short = ["--epochs", "1", "--samples", "4096", "--trees", "2", "-o", model];
        [&["train", "corpus", "young"][..], &short].concat()
    };
    desk.ok(&words("both.safetensors"));
    let info = |name: &str| -> serde_json::Value {
        serde_json::from_str(&desk.ok(&["info", name, "--json"])).unwrap()
    };
    // Two training trees of each corpus are there to start from, of the ages of both.
    assert_eq!(info("both.safetensors")["roots"], serde_json::json!([4]));
    let toml = String::from_utf8(desk.read("both.toml")).unwrap();
    for corpus in ["corpus", "young"] {
        assert!(toml.contains(info(corpus)["hash"].as_str().unwrap()), "{corpus}");
    }

    let alien = ["train", "corpus", "tulips", "-o", "m.safetensors"];
    desk.fails(&alien, 1, "tulips has the species tulip, which corpus has not");
    desk.fails(&["train", "corpus", "corpus", "-o", "m.safetensors"], 1, "the same trees");
}

#[test]
fn options_that_say_nothing_to_a_network_trained_by_itself_are_refused() {
    let desk = Desk::new();
    let refused = |network: &str, option: &str, value: &str| {
        let words = ["train", "absent", "--only", network, "--model", "m.safetensors"];
        let words = [&words[..], &[option, value, "-o", "n.safetensors"]].concat();
        desk.fails(&words, 2, &format!("{option} has no effect with --only {network}"));
    };
    let of_nodes = [
        ("--kind", "paper"),
        ("--species", "oak"),
        ("--classifier-attributes", "p"),
        ("--regressor-attributes", "t"),
        ("--workers", "1"),
    ];
    for (option, value) in of_nodes {
        refused("points", option, value);
        refused("competition", option, value);
        refused("trend", option, value);
    }
    for (option, value) in [("--epochs", "2"), ("--samples", "9"), ("--device", "wgpu")] {
        refused("trend", option, value);
    }
    for (option, value) in
        [("--epochs", "2"), ("--samples", "9"), ("--trees", "9"), ("--device", "wgpu")]
    {
        refused("competition", option, value);
    }
}

#[test]
fn networks_that_hear_points_train_from_the_command_line() {
    let desk = Desk::new();
    desk.ok(&["dataset", "--species", "walnut", "--trees", "5", "--scans", "-o", "corpus"]);
    train(&desk, "situated", "deaf.safetensors");
    let words = ["train", "corpus", "--only", "points", "--model", "deaf.safetensors"];
    let with = |more: &[&'static str]| [&words[..], more, &["-o", "hears.safetensors"]].concat();
    #[cfg(not(feature = "cuda"))]
    desk.fails(&with(&["--device", "cuda"]), 1, "cannot train on cuda");
    desk.ok(&with(&["--epochs", "1", "--samples", "64", "--trees", "2"]));
    let model = Weights::from_bytes(&desk.read("hears.safetensors")).unwrap();
    assert!(model.names().any(|name| name.starts_with("points.")));
    // Its file beside it tells of it, and of no other.
    std::fs::copy(desk.path("hears.toml"), desk.path("deaf.toml")).unwrap();
    desk.fails(&with(&[]), 1, "tells of another model");
}

#[test]
fn a_trend_is_fitted_from_the_command_line() {
    let desk = corpus();
    train(&desk, "situated", "plain.safetensors");
    let words = |data: &[&'static str], to: &'static str| {
        let model = ["--only", "trend", "--model", "plain.safetensors", "-o", to];
        [&["train"], data, &model].concat()
    };
    for to in ["a.safetensors", "b.safetensors"] {
        desk.ok(&words(&["corpus"], to));
    }
    assert_eq!(desk.read("a.safetensors"), desk.read("b.safetensors"));
    let told = desk.ok(&["info", "a.safetensors"]);
    assert!(told.contains("trends over age and gravitropism: 1"), "{told}");
    desk.ok(&["generate", "walnut", "--model", "a.safetensors", "-o", "walnut.csv"]);

    desk.fails(&words(&["corpus", "corpus"], "c.safetensors"), 1, "name it once");
    desk.ok(&["dataset", "--species", "oak", "--trees", "2", "-o", "oaks"]);
    desk.fails(&words(&["oaks"], "c.safetensors"), 1, "does not know the species oak");
    desk.ok(&["dataset", "--species", "walnut", "--scenes", "2", "-o", "scenes"]);
    desk.fails(&words(&["scenes"], "c.safetensors"), 1, "among obstacles");
    let both = ["train", "corpus", "--only", "trend,existence", "--model", "plain.safetensors"];
    desk.fails(&[&both[..], &["-o", "c.safetensors"]].concat(), 2, "trained by itself");
    assert!(!desk.path("c.safetensors").exists());
}

#[test]
fn what_cannot_be_trained_on_is_told() {
    let desk = corpus();
    desk.fails(&["train", "absent", "-o", "m.safetensors"], 1, "absent is no corpus");
    desk.fails(&["train", "corpus", "-o", "m.bin"], 2, "m.bin");
    let shard = std::fs::read_dir(desk.path("corpus"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| path.extension().is_some_and(|e| e == "parquet"))
        .unwrap();
    std::fs::write(&shard, b"PAR1 and then nothing").unwrap();
    desk.fails(&["train", "corpus", "-o", "m.safetensors"], 1, ".parquet");
}
