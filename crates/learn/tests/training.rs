//! Trains on trees of a known law, and asks whether the networks have found it.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic, as tests do")]

#[allow(dead_code, reason = "other tests use more of it")]
mod synthetic;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use deeptree_graph::signature::inheritance::{self, Inheritance, REACH_LEN, share_bounds};
use deeptree_graph::signature::paper;
use deeptree_graph::signature::situated::{self, Branching, CLASSES};
use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{BranchGraph, NodeId, Quat, TreeTraits, Vec2, Vec3, plans, senses};
use deeptree_infer::{Mlp, ModelKind, ROOT_COLUMNS, Scratch, SimdPath, Weights};
use deeptree_learn::{
    Kind, NetworkOptions, Silent, TrainError, TrainEvent, TrainOptions, TrainProgress,
    TrainedModel, TrainingSet, retrain, train,
};

fn run(set: &TrainingSet, options: &TrainOptions) -> TrainedModel {
    let folder = tempfile::tempdir().unwrap();
    train(set, options, folder.path(), &Silent).unwrap()
}

fn weights(model: &TrainedModel) -> Weights {
    Weights::from_bytes(&model.weights).unwrap()
}

fn figure(model: &TrainedModel, network: &str, name: &str) -> f64 {
    model.report.networks[network].total.values[name]
}

/// Hidden layers of 8, for tests that do not look at what is learned.
fn tiny(kind: Kind) -> TrainOptions {
    let names = match kind {
        Kind::Situated => {
            ["existence", "split", "reach", "rotation1", "rotation2", "rotation3"].as_slice()
        }
        Kind::Paper => &["classifier", "regressor1", "regressor2", "regressor3"],
        Kind::Joint => &["joint"],
    };
    let own = NetworkOptions { hidden: Some(vec![8, 8]), ..NetworkOptions::default() };
    let networks = names.iter().map(|&name| (name.to_owned(), own.clone())).collect();
    TrainOptions {
        batch: 64,
        epochs: 4,
        steps_per_epoch: Some(13),
        warmup_steps: 5,
        networks,
        ..TrainOptions::new(kind)
    }
}

/// What the nodes of a synthetic tree share.
fn conditions(tree: &BranchGraph) -> TreeConditions {
    let species = usize::from(tree.info.species == "elm");
    let tip_radius = synthetic::TIP_RADIUS[species];
    TreeConditions::of(tree, species, tip_radius, None)
}

/// Mean predicted probabilities of existence, with the number of nodes: of an end at nodes with one
/// tip, by order; and of a fork at nodes with more.
#[derive(Default)]
struct Said {
    ends: BTreeMap<u16, (f64, u32)>,
    forks: (f64, u32),
}

impl Said {
    fn hear(&mut self, tree: &BranchGraph, existence: &Mlp) {
        let conditions = conditions(tree);
        let mut scratch = Scratch::new();
        let mut inputs = vec![0.0; situated::len(2)];
        let plans = plans(tree);
        let senses = senses(tree, conditions.tip_radius, &plans);
        for ((node, plan), sense) in tree.nodes().iter().zip(plans).zip(&senses) {
            let tips = tip_count(node.thickness, conditions.tip_radius);
            situated::encode(node, &conditions, plan, sense, 2, &mut inputs);
            let logits = existence.forward(SimdPath::detect(), &inputs, &mut scratch);
            let share = |wanted: fn(Branching) -> bool| {
                let odds = |branching: Branching| f64::from(logits[branching.class()]).exp();
                let fits = |branching: &Branching| plan.allows(*branching, tips);
                let all = (0..CLASSES).map(Branching::from_class).filter(fits);
                let some = all.clone().filter(|&branching| wanted(branching));
                some.map(odds).sum::<f64>() / all.map(odds).sum::<f64>()
            };
            let (sum, share) = if tips == 1 {
                let by_order = self.ends.entry(node.order.min(2)).or_default();
                (by_order, share(|branching| branching.children() == 0))
            } else {
                (&mut self.forks, share(|branching| branching.children() > 1))
            };
            *sum = (sum.0 + share, sum.1 + 1);
        }
    }
}

/// Probability that of two children the first is the heir, where each reaches at least k with
/// probability `on`^k and the farther one reaches `most`:
/// `P(X = m, Y ≤ m) / P(max(X, Y) = m) = p_m F_m / (F_m² − F_{m−1}²)`.
fn first_is_heir(on: f64, most: i32) -> f64 {
    let up_to = |k: i32| 1.0 - on.powi(k + 1);
    let (own, below) = (up_to(most), up_to(most - 1));
    (own - below) * own / (own * own - below * below)
}

/// Differences of the predicted from the true probability of an heir, at forks into two children of
/// one tip each whose chains have the same law: those of order 2 or more.
fn heir_errors(tree: &BranchGraph, network: &Mlp) -> Vec<f64> {
    let conditions = conditions(tree);
    let mut inputs = vec![0.0; situated::len(2) + REACH_LEN];
    let mut errors = Vec::new();
    let plans = plans(tree);
    let senses = senses(tree, conditions.tip_radius, &plans);
    for ((node, plan), sense) in tree.nodes().iter().zip(plans).zip(&senses) {
        let tips = tip_count(node.thickness, conditions.tip_radius);
        if tips != 2 || node.child_count() != 2 || node.order < 2 || plan.reach < 2 {
            continue;
        }
        let subset = if node.children[1].is_some() { 0b011 } else { 0b101 };
        let known = Inheritance {
            branching: Branching { subset, dropped: 0 },
            child_tips: node.children.map(|child| u32::from(child.is_some())),
            reach: plan.reach,
            slot: 0,
            earlier: [0; 3],
        };
        let (own, rest) = inputs.split_at_mut(situated::len(2));
        situated::encode(node, &conditions, plan, sense, 2, own);
        inheritance::encode(&known, rest);
        let logit = network.forward(SimdPath::detect(), &inputs, &mut Scratch::new())[0];
        let said = 1.0 / (1.0 + f64::from(-logit).exp());
        errors.push(said - first_is_heir(synthetic::GOES_ON[2], i32::from(plan.reach) - 1));
    }
    errors
}

#[test]
fn situated_networks_find_the_law_of_the_trees() {
    let set = synthetic::set(300);
    // Few nodes fork: without more epochs the warm-up would be all that those networks see.
    let long = NetworkOptions { epochs: Some(16), ..NetworkOptions::default() };
    let forking = ["rotation2", "rotation3", "split", "reach", "size"];
    let options = TrainOptions {
        epochs: 4,
        steps_per_epoch: None,
        networks: forking.map(|name| (name.to_owned(), long.clone())).into(),
        ..TrainOptions::new(Kind::Situated)
    };
    let model = run(&set, &options);
    let weights = weights(&model);
    assert_eq!((weights.kind(), weights.species()), (ModelKind::Situated, &set.species[..]));

    // Existence: over all reaches, ends and forks are as frequent as the law has them.
    let existence = weights.mlp("existence").unwrap();
    let mut said = Said::default();
    set.validation.iter().for_each(|tree| said.hear(tree, &existence));
    for (order, (sum, count)) in said.ends {
        let (mean, law) = (sum / f64::from(count), 1.0 - synthetic::GOES_ON[usize::from(order)]);
        assert!((mean - law).abs() < 0.04, "order {order}: {mean} instead of {law}, {count} nodes");
    }
    // As a table: the ends of the first species among all its nodes.
    let shares = weights.table("branchings", &[Some(set.species.len()), Some(CLASSES)]).unwrap();
    let own = set.train.iter().filter(|tree| tree.info.species == set.species[0]);
    let nodes: Vec<_> = own.flat_map(|tree| tree.nodes()).collect();
    let ends = nodes.iter().filter(|node| node.child_count() == 0).count();
    let told: f32 = shares.row(0)[..CLASSES / 8].iter().sum();
    assert!((f64::from(told) - ends as f64 / nodes.len() as f64).abs() < 1e-6, "{told}");
    assert!((shares.row(0).iter().sum::<f32>() - 1.0).abs() < 1e-5);
    let (mean, law) = (said.forks.0 / f64::from(said.forks.1), synthetic::FORKS);
    assert!((mean - law).abs() < 0.04, "forks: {mean} instead of {law}, {} nodes", said.forks.1);
    assert!(figure(&model, "existence", "children_excess").abs() < 0.02);
    for bin in &model.report.networks["existence"].total.reliability {
        let error = 4.0 * (0.25 / bin.count.max(1) as f64).sqrt();
        assert!((bin.predicted - bin.actual).abs() < 0.03 + error, "{bin:?}");
    }

    // Rotations: Gaussian about the slot's mean, so that in deviations the entropy of an apical swing is
    // that of two standard normal numbers. Of laterals, those whose bud's plane is upright do not sag.
    let entropy = 1.0 + std::f64::consts::TAU.ln();
    let nll = figure(&model, "rotation1", "nll");
    assert!((nll - entropy).abs() < 0.2, "{nll} instead of {entropy}");
    for slot in ["rotation2", "rotation3"] {
        let [said, is] =
            ["aligned_predicted", "aligned_actual"].map(|what| figure(&model, slot, what));
        assert!((said - is).abs() < 0.03 && (0.01..0.99).contains(&is), "{slot}: {said} {is}");
    }
    // As a table: the normal law of the angles of buds, at its quartiles and beyond.
    let buds = weights.table("buds", &[Some(2), Some(2), Some(65)]).unwrap();
    for (row, score) in (0..2).flat_map(|row| [(row, -2), (row, -1), (row, 1), (row, 2)]) {
        for law in buds.row(row).chunks_exact(65) {
            let value = law[usize::try_from(32 + 8 * score).unwrap()] / synthetic::SPREAD.x;
            assert!((value - score as f32).abs() < 0.2, "{value} instead of {score}");
        }
    }
    let table = |name| weights.table(name, &[Some(2), Some(3), Some(3)]).unwrap();
    let (mean, scale) = (table("rotation_mean"), table("rotation_scale"));
    for (species, slot) in (0..2).flat_map(|species| (0..3).map(move |slot| (species, slot))) {
        let law = synthetic::slot(species, slot);
        let (mean, scale) = (&mean.row(species)[3 * slot..], &scale.row(species)[3 * slot..]);
        let apart = Vec2::from_slice(mean).distance(law.mean);
        assert!(apart < 0.02, "species {species}, slot {slot}: {apart} rad");
        assert!(situated::wrapped(mean[2] - law.roll).abs() < 0.02, "{} {}", mean[2], law.roll);
        // That of a lateral's y is of its sag, which rounding carries far in planes that are nearly
        // upright, as those of straight trunks are.
        let ratio = Vec2::from_slice(scale) / synthetic::SPREAD;
        let off = (ratio - Vec2::ONE).abs();
        assert!(off.x < 0.1 && (slot > 0 || off.y < 0.1), "{ratio}");
        assert!((scale[2] - law.roll_scale).abs() < 0.1 * synthetic::ROLL_SPREAD, "{}", scale[2]);
    }

    // Split: uniform. The reach of the node tells a little of the shares, so that a network can do
    // better than the logarithm of the bins, but not by much.
    let uniform = mean_log_bins(&set.validation);
    let nll = figure(&model, "split", "nll");
    assert!((uniform - 0.25..uniform + 0.05).contains(&nll), "{nll} instead of {uniform}");

    // Reach: of two chains of one law, the first is the heir as often as can be worked out.
    let reach = weights.mlp("reach").unwrap();
    let errors: Vec<f64> =
        set.validation.iter().flat_map(|tree| heir_errors(tree, &reach)).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    assert!(errors.len() > 100 && mean.abs() < 0.05, "{mean}, {} forks", errors.len());
    let heirs = ["heir_predicted", "heir_actual"].map(|name| figure(&model, "reach", name));
    assert!((heirs[0] - heirs[1]).abs() < 0.03, "{heirs:?}");
}

/// Mean logarithm of the number of choices, over all decisions on tips that the reach leaves open.
fn mean_log_bins(trees: &[BranchGraph]) -> f64 {
    let mut logs = Vec::new();
    for tree in trees {
        let radius = conditions(tree).tip_radius;
        let plans = plans(tree);
        for (node, plan) in tree.nodes().iter().zip(plans) {
            let tips: Vec<u32> = node
                .children
                .iter()
                .flatten()
                .map(|&child| tip_count(tree.node(child).thickness, radius))
                .collect();
            for first in 0..tips.len().saturating_sub(1) {
                let left: u32 = tips[first..].iter().sum();
                let (least, most) = share_bounds(left, (tips.len() - first) as u32, plan.reach);
                if least < most {
                    logs.push(f64::from(most - least + 1).ln());
                }
            }
        }
    }
    logs.iter().sum::<f64>() / logs.len() as f64
}

#[test]
fn paper_networks_learn_the_means() {
    let set = synthetic::set(60);
    let options = TrainOptions {
        epochs: 4,
        steps_per_epoch: Some(150),
        learning_rate: 1e-3,
        ..TrainOptions::new(Kind::Paper)
    };
    let model = run(&set, &options);
    assert!(model.report.bytes <= 913_000);
    for slot in ["regressor1", "regressor2", "regressor3"] {
        // The spread of the rotations alone: 1 − cos of half the angle, E = (σx² + σy² + σ_roll²) / 8.
        let squares = synthetic::SPREAD.length_squared() + synthetic::ROLL_SPREAD.powi(2);
        let spread = f64::from(squares) / 8.0;
        let distance = figure(&model, slot, "cosine_distance");
        assert!(distance < 3.0 * spread, "{slot}: {distance}, spread {spread}");
        // Lengths are uniform in 0.5 … 1, variance 1/48; half of the error is the thickness's.
        assert!(figure(&model, slot, "mse") < 1.5 / 96.0);
    }
    assert!(figure(&model, "classifier", "accuracy") > 0.7);
}

#[test]
fn the_joint_network_learns_the_means_as_the_regressors_do() {
    let set = synthetic::set(60);
    let options = TrainOptions {
        epochs: 4,
        steps_per_epoch: Some(200),
        learning_rate: 1e-3,
        ..TrainOptions::new(Kind::Joint)
    };
    let model = run(&set, &options);
    assert_eq!(weights(&model).kind(), ModelKind::Joint);
    // As for the regressors: spread of the rotations, variance of the lengths.
    let spread = f64::from(synthetic::SPREAD.length_squared()) / 8.0;
    let distance = figure(&model, "joint", "cosine_distance");
    assert!(distance < 4.0 * spread, "{distance}, spread {spread}");
    assert!(figure(&model, "joint", "mse") < 2.0 / 96.0);
    assert!(figure(&model, "joint", "accuracy") > 0.7);
}

/// Share of the children of these trees that the file's classifier tells right.
fn accuracy(classifier: &Mlp, trees: &[BranchGraph]) -> f64 {
    let (mut right, mut all) = (0, 0);
    let (mut scratch, mut inputs) = (Scratch::new(), vec![0.0; paper::len(2)]);
    for tree in trees {
        for node in tree.nodes() {
            paper::encode(node, &conditions(tree), 2, &mut inputs);
            let logits = classifier.forward(SimdPath::detect(), &inputs, &mut scratch);
            let told = logits
                .iter()
                .zip(node.children)
                .filter(|(logit, c)| (**logit > 0.0) == c.is_some());
            (right, all) = (right + told.count(), all + 3);
        }
    }
    right as f64 / all as f64
}

#[test]
fn an_attribute_that_is_not_read_counts_neither_in_training_nor_in_the_file() {
    let set = synthetic::set(6);
    let mut options = TrainOptions { epochs: 2, steps_per_epoch: Some(100), ..tiny(Kind::Paper) };
    options.learning_rate = 1e-2;
    let plain = weights(&run(&set, &options)).mlp("classifier").unwrap();
    let reads = |networks: [(&str, &[&str]); 2]| {
        let mut options = options.clone();
        for (network, names) in networks {
            let own = options.networks.get_mut(network).unwrap();
            own.reads = Some(names.iter().map(|&name| name.to_owned()).collect());
        }
        run(&set, &options)
    };
    let model = reads([("classifier", &["p", "mp", "o"]), ("regressor2", &["t", "s"])]);
    let file = weights(&model);
    let classifier = file.mlp("classifier").unwrap();
    assert_ne!(classifier, plain);

    // The file, which is given all attributes, does as well as the training says.
    let (said, found) =
        (figure(&model, "classifier", "accuracy"), accuracy(&classifier, &set.validation));
    assert!((said - found).abs() < 1e-4, "{said} {found}");

    // Whatever stands in the place of an attribute, the bits are those of its absence.
    let read: [(&str, &[&str]); 2] =
        [("classifier", &["p", "mp", "o"]), ("regressor2", &["t", "s"])];
    let mut scratch = Scratch::new();
    for (network, names) in read {
        let mlp = file.mlp(network).unwrap();
        let row: Vec<f32> = (0..mlp.inputs()).map(|i| 0.3 + 0.1 * i as f32).collect();
        let mut bits = |row: &[f32]| -> Vec<u32> {
            let outputs = mlp.forward(SimdPath::detect(), row, &mut scratch);
            outputs.iter().map(|x| x.to_bits()).collect()
        };
        let before = bits(&row);
        for name in paper::ATTRIBUTES {
            let mut other = row.clone();
            for x in &mut other[paper::attribute(name, 2).unwrap()] {
                *x *= -7.5;
            }
            assert_eq!(bits(&other) != before, names.contains(&name), "{network}, {name}");
        }
    }
    // A network without a list reads all.
    assert_eq!(
        file.mlp("regressor1").unwrap(),
        weights(&run(&set, &options)).mlp("regressor1").unwrap()
    );
}

#[test]
fn an_unknown_attribute_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, network, name) in
        [(Kind::Paper, "classifier", "x"), (Kind::Situated, "existence", "p")]
    {
        let mut options = tiny(kind);
        options.networks.get_mut(network).unwrap().reads = Some(vec![name.to_owned()]);
        let error = train(&synthetic::set(2), &options, folder.path(), &Silent).unwrap_err();
        assert!(error.to_string().contains(&format!("`{name}`")), "{error}");
    }
}

/// Stops after an epoch.
struct StopAfter(AtomicU32, u32);

impl TrainProgress for StopAfter {
    fn event(&self, event: TrainEvent) {
        if let TrainEvent::Epoch { epoch, .. } = event {
            self.0.store(epoch, Ordering::Relaxed);
        }
    }

    fn keep_going(&self) -> bool {
        self.0.load(Ordering::Relaxed) < self.1
    }
}

/// Calls `train` until it is through, stopping it after each `epochs` epochs of a network.
fn in_pieces(set: &TrainingSet, options: &TrainOptions, folder: &Path) -> TrainedModel {
    for piece in 1.. {
        match train(set, options, folder, &StopAfter(AtomicU32::new(0), 2)) {
            Ok(model) => {
                assert!(piece > 1, "it was never stopped");
                return model;
            }
            Err(TrainError::Stopped { epoch, .. }) => assert!(epoch < options.epochs),
            Err(error) => panic!("{error}"),
        }
    }
    unreachable!()
}

#[test]
fn a_run_in_pieces_ends_with_the_same_bits() {
    let set = synthetic::set(6);
    for kind in [Kind::Situated, Kind::Paper, Kind::Joint] {
        let options = tiny(kind);
        let straight = run(&set, &options);
        let folder = tempfile::tempdir().unwrap();
        let pieces = in_pieces(&set, &options, folder.path());
        assert_eq!(straight.report.sha256, pieces.report.sha256, "{kind:?}");
        let alone = run(&set, &TrainOptions { workers: 1, ..options.clone() });
        assert_eq!(straight.report.sha256, alone.report.sha256, "{kind:?} with one worker");
        let other = run(&set, &TrainOptions { seed: 2, ..options });
        assert_ne!(straight.report.sha256, other.report.sha256, "{kind:?} with another seed");
    }
}

#[test]
fn a_network_trained_anew_is_the_one_that_training_all_gives() {
    let mut set = synthetic::set(4);
    let options = TrainOptions { epochs: 1, steps_per_epoch: Some(3), ..tiny(Kind::Situated) };
    let full = run(&set, &options);
    let again = |set: &TrainingSet, only: &str, options: &TrainOptions| {
        let folder = tempfile::tempdir().unwrap();
        let kept = (&weights(&full), &full.report);
        retrain(set, options, &[only.to_owned()], kept, folder.path(), &Silent)
    };
    let one = again(&set, "rotation1", &options).unwrap();
    assert_eq!(one.weights, full.weights);
    assert_eq!(one.report.sha256, full.report.sha256);
    let figures = |model: &TrainedModel| model.report.networks["rotation1"].total.clone();
    assert_eq!((one.report.networks.len(), figures(&one)), (8 - 1, figures(&full)));
    for network in ["outlook", "existence"] {
        let kept = |model: &TrainedModel| model.report.networks.get(network).cloned();
        assert_eq!(kept(&one), kept(&full));
    }
    let message = |found: Result<TrainedModel, TrainError>| found.unwrap_err().to_string();
    assert!(message(again(&set, "rotation9", &options)).contains("`rotation9`"));
    let other = TrainOptions { seed: 3, ..options.clone() };
    assert!(message(again(&set, "rotation1", &other)).contains("other options"));
    assert!(message(again(&set, "outlook", &options)).contains("scenes or volumes"));
    // Its own options may change; those of others may not.
    let mut other = options.clone();
    let own = other.networks.entry("rotation1".into()).or_default();
    own.hidden = Some(vec![8]);
    assert!(message(again(&set, "existence", &other)).contains("other options"));
    let smaller = again(&set, "rotation1", &other).unwrap();
    assert_eq!(smaller.report.options, other);
    assert!(smaller.report.weight_count < full.report.weight_count);
    other.networks.remove("rotation1");
    let plain = again(&set, "rotation1", &other).unwrap();
    assert_eq!(plain.report.options, other);
    set.data_hash = "other".into();
    let other = again(&set, "rotation1", &options).unwrap().report;
    let hash = |network: &str| other.networks[network].data_hash.clone();
    assert_eq!([hash("existence"), hash("rotation1")], [None, Some("other".into())]);
    assert_eq!(other.data_hash, full.report.data_hash);
}

#[test]
fn turns_are_told_as_the_kept_networks_read_them_or_all_anew() {
    let mut set = synthetic::set(4);
    let options = TrainOptions { epochs: 1, steps_per_epoch: Some(3), ..tiny(Kind::Situated) };
    let full = run(&set, &options);
    let again = |set: &TrainingSet, only: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        let only: Vec<String> = only.iter().map(|&name| name.to_owned()).collect();
        let kept = (&weights(&full), &full.report);
        retrain(set, &options, &only, kept, folder.path(), &Silent)
    };
    // Of half as many trees the rotations lie a little otherwise.
    set.train.truncate(set.train.len() / 2);
    set.train_surroundings.truncate(set.train.len());
    let turns = |model: &TrainedModel| {
        let model = weights(model);
        ["rolls", "rotation_mean", "rotation_scale"].map(|table| model.any_table(table).cloned())
    };
    let half = run(&set, &options);
    assert_ne!(turns(&half), turns(&full));
    let two = again(&set, &["rotation1", "rotation3"]).unwrap();
    assert_eq!(turns(&two), turns(&full));
    let all = again(&set, &["rotation1", "rotation2", "rotation3"]).unwrap();
    assert_eq!(turns(&all), turns(&half));
    let lengths = |model: &TrainedModel| weights(model).any_table("lengths").cloned();
    assert_eq!(lengths(&all), lengths(&full));
    // Trees with thicker tips are of another kind to all networks.
    for tree in &mut set.train {
        for id in 0..tree.len() as NodeId {
            tree.set_thickness(id, 2.0 * tree.node(id).thickness);
        }
    }
    let message = again(&set, &["rotation1"]).unwrap_err().to_string();
    assert!(message.contains("other radii"), "{message}");
}

#[test]
fn a_checkpoint_of_other_settings_or_data_is_refused() {
    let mut set = synthetic::set(2);
    let options = TrainOptions { epochs: 1, steps_per_epoch: Some(1), ..tiny(Kind::Paper) };
    let folder = tempfile::tempdir().unwrap();
    let again = |set: &TrainingSet, options: &TrainOptions| {
        train(set, options, folder.path(), &Silent).map(|model| model.report.sha256)
    };
    let first = again(&set, &options).unwrap();
    assert_eq!(again(&set, &TrainOptions { workers: 1, ..options.clone() }).unwrap(), first);
    let message =
        again(&set, &TrainOptions { batch: 7, ..options.clone() }).unwrap_err().to_string();
    assert!(message.contains("`options.batch` was 64, now 7"), "{message}");
    set.data_hash = "other".into();
    let message = again(&set, &options).unwrap_err().to_string();
    assert!(message.contains("`data_hash`"), "{message}");
}

#[test]
fn a_report_survives_toml() {
    let set = synthetic::set(2);
    let options = TrainOptions { epochs: 1, steps_per_epoch: Some(2), ..tiny(Kind::Situated) };
    let report = run(&set, &options).report;
    let text = report.to_toml().unwrap();
    assert_eq!(toml::from_str::<deeptree_learn::Report>(&text).unwrap(), report);
}

#[test]
fn roots_and_tip_radii_are_those_of_the_training_trees() {
    let set = synthetic::set(3);
    for kind in [Kind::Situated, Kind::Paper] {
        let options = TrainOptions { epochs: 1, steps_per_epoch: Some(1), ..tiny(kind) };
        let weights = weights(&run(&set, &options));
        let roots = weights.table("roots.elm", &[Some(3), Some(ROOT_COLUMNS)]).unwrap();
        let tree = &set.train[1];
        assert_eq!(tree.info.species, "elm");
        assert_eq!(&roots.row(0)[..4], &tree.root().rotation.to_array());
        let rest = [tree.root().thickness, 1.0, tree.info.age as f32, 0.0];
        assert_eq!(&roots.row(0)[4..8], &rest);
        assert_eq!(&roots.row(0)[8..], &TreeTraits::of(tree).to_array());
        assert_eq!(
            weights.table("tip_radius", &[Some(2)]).unwrap().values(),
            synthetic::TIP_RADIUS
        );
    }
}

#[test]
fn trees_that_break_the_pipe_model_are_named() {
    let mut set = synthetic::set(2);
    // A chain whose child is thicker than its parent.
    let mut tree = BranchGraph::new(set.train[0].info.clone(), Vec3::ZERO, signature(0.05));
    tree.grow(0, [Some(signature(0.07)), None, None]);
    set.train.push(tree);
    set.train_surroundings.push(None);
    let folder = tempfile::tempdir().unwrap();
    let error = train(&set, &tiny(Kind::Situated), folder.path(), &Silent).unwrap_err();
    assert!(matches!(error, TrainError::PipeModel { tree: 4, node: 0, .. }), "{error}");
}

fn signature(thickness: f32) -> deeptree_graph::ChildSignature {
    deeptree_graph::ChildSignature { rotation: Quat::IDENTITY, thickness, length: 1.0 }
}

#[test]
fn unknown_and_missing_species_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |set: &TrainingSet| {
        train(set, &tiny(Kind::Situated), folder.path(), &Silent).unwrap_err().to_string()
    };
    let mut set = synthetic::set(2);
    set.species.push("yew".into());
    assert!(fails(&set).contains("`yew`"));
    set.species = vec!["ash".into()];
    assert!(fails(&set).contains("`elm`"));
    set.train.clear();
    assert!(fails(&set).contains("no training trees"));
}
