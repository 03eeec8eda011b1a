//! What the network of competition learns.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

#[allow(dead_code, reason = "other tests use more of it")]
mod synthetic;

use deeptree_graph::signature::competition::{Contender, OUTPUTS};
use deeptree_graph::{Draws, Lineage, Purpose, Seed, Vec2};
use deeptree_infer::{Competition, Weights, WeightsBuilder};
use deeptree_learn::{
    Kind, Report, Rivalries, Rivalry, Silent, TrainError, TrainOptions, TrainedModel, retrain,
    train, train_competition, train_points,
};

fn options() -> TrainOptions {
    TrainOptions {
        epochs: 1,
        steps_per_epoch: Some(2),
        batch: 32,
        networks: Default::default(),
        workers: 2,
        ..TrainOptions::new(Kind::Situated)
    }
}

fn model() -> TrainedModel {
    let folder = tempfile::tempdir().unwrap();
    train(&synthetic::set(4), &options(), folder.path(), &Silent).unwrap()
}

/// A law that can be worked out: each other within 20 m takes a part of the tips and nodes that
/// falls with its distance, and nothing else.
fn rivalry(draws: &mut Draws) -> Rivalry {
    let own = Contender { species: draws.index(2), age: 30.0, nodes: 2000.0, height: 20.0 };
    let other = |draws: &mut Draws| {
        let mut x = || (30.0 * draws.uniform() - 15.0) as f32;
        (Vec2::new(x(), x()), own)
    };
    let others: Vec<_> = (0..1 + draws.index(6)).map(|_| other(draws)).collect();
    let near = |(at, _): &(Vec2, Contender)| (1.0 - f64::from(at.length()) / 20.0).max(0.0);
    let taken = -0.5 * libm::log1p(20.0 * others.iter().map(near).sum::<f64>());
    let mut shift = [0.0; OUTPUTS];
    (shift[0], shift[1]) = (1.5 * taken, taken);
    Rivalry { own, others, shift }
}

#[test]
fn a_law_of_competition_is_learned_and_every_other_network_is_kept() {
    let mut draws = Seed(3).draws(Lineage::ROOT, Purpose::Evaluation);
    let mut many = |count| (0..count).map(|_| rivalry(&mut draws)).collect::<Vec<_>>();
    let set = Rivalries { train: many(600), validation: many(200), data_hash: "a".into() };
    let model = model();
    let before = Weights::from_bytes(&model.weights).unwrap();
    let learn = || train_competition(&set, Seed(1), (&before, &model.report)).unwrap();
    let (bytes, report) = learn();
    let after = Weights::from_bytes(&bytes).unwrap();
    let mut both = WeightsBuilder::from_weights(&before);
    assert_eq!(both.network_of("competition", &after).to_bytes().unwrap(), bytes);
    assert_eq!(report.sha256.len(), 64);
    assert_eq!(report.bytes, bytes.len());
    assert_ne!(report.sha256, model.report.sha256);
    let figures = &report.networks["competition"];
    assert_eq!(figures.data_hash.as_deref(), Some("a"));
    for state in ["tips", "nodes"] {
        let r2 = figures.total.values[&format!("r2_{state}")];
        assert!(r2 > 0.97, "{state}: {r2}");
    }
    let network = Competition::read(&after).unwrap().unwrap();
    let own = set.validation[0].own;
    let near = network.shift(&own, &[(Vec2::new(2.0, 0.0), own)]).unwrap();
    let far = network.shift(&own, &[(Vec2::new(12.0, 0.0), own)]).unwrap();
    assert!(near[1] < far[1] && far[1] < 0.0, "{near:?} {far:?}");
    // ln(1 + 20 · 0.9) / 2
    assert!((near[1] + 1.472).abs() < 0.2, "{near:?}");
    assert_eq!(learn().0, bytes, "the same bits again");

    // Training a network of nodes anew keeps it, and those that hear of points.
    let (nodes, folder) = (synthetic::set(4), tempfile::tempdir().unwrap());
    let one = TrainOptions { epochs: 1, steps_per_epoch: Some(1), ..TrainOptions::points() };
    let (kept, scans) = ((&after, &report), synthetic::scans(&nodes));
    let (bytes, report) =
        train_points(&nodes, &scans, kept, &one, &folder.path().join("points"), &Silent).unwrap();
    let hears = Weights::from_bytes(&bytes).unwrap();
    assert!(hears.names().any(|name| name.starts_with("points.")));
    let (only, kept) = (["size".to_owned()], (&hears, &report));
    let again = retrain(&nodes, &options(), &only, kept, &folder.path().join("size"), &Silent);
    assert_eq!(again.unwrap().weights, bytes);
}

#[test]
fn without_trees_there_is_nothing_to_learn() {
    let model = model();
    let weights = Weights::from_bytes(&model.weights).unwrap();
    let set = Rivalries { train: vec![], validation: vec![], data_hash: String::new() };
    let error = train_competition(&set, Seed(1), (&weights, &model.report)).unwrap_err();
    assert!(matches!(error, TrainError::NoTrees { .. }));
}

#[test]
fn other_reports_and_species_that_the_model_has_not_are_refused() {
    let model = model();
    let weights = Weights::from_bytes(&model.weights).unwrap();
    let mut draws = Seed(3).draws(Lineage::ROOT, Purpose::Evaluation);
    let trees = vec![rivalry(&mut draws)];
    let mut set = Rivalries { train: trees.clone(), validation: trees, data_hash: String::new() };
    let other = Report { sha256: "0".repeat(64), ..model.report.clone() };
    let error = train_competition(&set, Seed(1), (&weights, &other)).unwrap_err();
    assert!(matches!(error, TrainError::OtherModel { .. }), "{error}");
    set.validation[0].own.species = 2;
    let error = train_competition(&set, Seed(1), (&weights, &model.report)).unwrap_err();
    assert!(matches!(error, TrainError::UnknownSpecies { part: "validation", .. }), "{error}");
}
