//! Trains networks to hear of points on trees of a known law, and asks what they make of them.
#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic, as tests do")]

#[allow(dead_code, reason = "other tests use more of it")]
mod synthetic;

use std::sync::OnceLock;

use deeptree_graph::signature::TreeConditions;
use deeptree_graph::{BranchGraph, CloudIndex, Lineage, NodeId, Quat, Seed, Vec3, plans, senses};
use deeptree_infer::{Active, Branchlet, Model, Predictor, SimdPath, Weights, Workspace};
use deeptree_learn::{
    Kind, NetworkOptions, Report, Scans, Silent, TrainError, TrainOptions, train, train_points,
};

use synthetic::{scan, scans};

/// A model that knows a little of the trees.
fn base() -> &'static (Weights, Report) {
    static BASE: OnceLock<(Weights, Report)> = OnceLock::new();
    BASE.get_or_init(|| {
        let names = ["existence", "split", "reach", "size", "rotation1", "rotation2", "rotation3"];
        let own = |name: &str| {
            let steps = if ["split", "reach", "size"].contains(&name) { 2 } else { 150 };
            NetworkOptions {
                hidden: Some(vec![16]),
                epochs: Some(1),
                steps_per_epoch: Some(steps),
                ..NetworkOptions::default()
            }
        };
        let networks = names.map(|name| (name.to_owned(), own(name))).into();
        let options = TrainOptions {
            batch: 128,
            warmup_steps: 20,
            networks,
            ..TrainOptions::new(Kind::Situated)
        };
        let folder = tempfile::tempdir().unwrap();
        let trained = train(&synthetic::set(40), &options, folder.path(), &Silent).unwrap();
        (Weights::from_bytes(&trained.weights).unwrap(), trained.report)
    })
}

fn borrowed((weights, report): &(Weights, Report)) -> (&Weights, &Report) {
    (weights, report)
}

fn options(epochs: u32, steps: u64) -> TrainOptions {
    TrainOptions {
        epochs,
        steps_per_epoch: Some(steps),
        warmup_steps: 20,
        ..TrainOptions::points()
    }
}

fn hearing() -> &'static (Vec<u8>, Report) {
    static TRAINED: OnceLock<(Vec<u8>, Report)> = OnceLock::new();
    TRAINED.get_or_init(|| {
        let (set, folder) = (synthetic::set(24), tempfile::tempdir().unwrap());
        train_points(&set, &scans(&set), borrowed(base()), &options(2, 100), folder.path(), &Silent)
            .unwrap()
    })
}

/// The branchlets of all nodes of a tree that stands in a cloud.
fn branchlets(
    model: &Model,
    tree: &BranchGraph,
    cloud: Option<&CloudIndex>,
    path: SimdPath,
    batch: usize,
) -> Vec<Branchlet> {
    let own = TreeConditions::of(tree, 0, model.tip_radius(0), model.kin(0));
    let conditions = TreeConditions { age: 30.0, ..own };
    let plans = plans(tree);
    let senses = senses(tree, conditions.tip_radius, &plans);
    let active = |id: usize| Active {
        node: &tree.nodes()[id],
        parent: None,
        lineage: Lineage::ROOT.child(id as u8),
        seed: Seed(3),
        tree: conditions,
        plan: plans[id],
        sense: senses[id],
        settled: None,
        room: None,
        points: cloud,
    };
    let frontier: Vec<Active<'_>> = (0..tree.len()).map(active).collect();
    let (mut all, mut some) = (Vec::new(), Vec::new());
    for batch in frontier.chunks(batch) {
        model.branchlets(batch, &mut Workspace::new(path), &mut some).unwrap();
        all.append(&mut some);
    }
    all
}

#[test]
fn points_make_trees_that_are_known_by_a_scan_likelier() {
    let said = &hearing().1.networks["points"].total.values;
    for law in ["existence", "rotation1"] {
        let (with, without) = (said[law], said[&format!("{law}_without")]);
        assert!(with < without - 0.02, "{law}: {with} with points, {without} without");
    }
}

#[test]
fn without_a_cloud_a_model_that_hears_says_what_it_said_before() {
    let (deaf, hears) =
        (Model::from_weights(&base().0).unwrap(), Model::from_bytes(&hearing().0).unwrap());
    assert!(hears.hears_points() && !deaf.hears_points());
    let own = hears.weight_count() - deaf.weight_count();
    assert!(4 * own <= 24_000, "{own} weights");
    let set = synthetic::set(2);
    let mut changed = 0;
    for tree in &set.validation {
        let of = |model, cloud| branchlets(model, tree, cloud, SimdPath::detect(), 512);
        assert_eq!(of(&deaf, None), of(&hears, None));
        let cloud = CloudIndex::new(&scan(tree).points);
        // A model that has not learned to hear is not disturbed.
        assert_eq!(of(&deaf, None), of(&deaf, Some(&cloud)));
        let pairs = of(&hears, None).into_iter().zip(of(&hears, Some(&cloud)));
        changed += pairs.filter(|(a, b)| a != b).count();
    }
    assert!(changed > 0);
}

#[test]
fn neither_batches_nor_instructions_nor_the_order_of_points_change_a_bit() {
    let model = Model::from_bytes(&hearing().0).unwrap();
    let tree = &synthetic::set(2).validation[0];
    let mut points = scan(tree).points;
    let cloud = CloudIndex::new(&points);
    points.reverse();
    let reversed = CloudIndex::new(&points);
    let expected = branchlets(&model, tree, Some(&cloud), SimdPath::detect(), 512);
    for path in SimdPath::available() {
        assert_eq!(branchlets(&model, tree, Some(&cloud), path, 7), expected);
    }
    assert_eq!(branchlets(&model, tree, Some(&reversed), SimdPath::detect(), 512), expected);
}

#[test]
fn a_tree_turned_about_the_vertical_with_its_cloud_has_the_same_children() {
    let model = Model::from_bytes(&hearing().0).unwrap();
    let tree = &synthetic::set(2).validation[0];
    let turn = Quat::from_rotation_y(1.0);
    let turned = {
        let mut info = tree.info.clone();
        info.seed += 1;
        let root = tree.root().as_child();
        let root = deeptree_graph::ChildSignature { rotation: turn * root.rotation, ..root };
        let mut turned = BranchGraph::new(info, Vec3::ZERO, root);
        for (id, node) in tree.nodes().iter().enumerate() {
            let child = |id: NodeId| tree.node(id).as_child();
            turned.grow(id as NodeId, node.children.map(|id| id.map(child)));
        }
        turned
    };
    let of = |tree: &BranchGraph| {
        let cloud = CloudIndex::new(&scan(tree).points);
        branchlets(&model, tree, Some(&cloud), SimdPath::detect(), 512)
    };
    let (mut same, mut all) = (0, 0);
    for (a, b) in of(tree).iter().zip(of(&turned)) {
        for (a, b) in a.children.iter().zip(b.children) {
            all += 1;
            same += usize::from(match (a, b) {
                (Some(a), Some(b)) => a.rotation.dot(b.rotation).abs() > 0.9999,
                (None, None) => true,
                _ => false,
            });
        }
    }
    // A draw next to a threshold may fall to the other side.
    assert!(same * 100 >= all * 98, "{same} of {all}");
}

#[test]
fn a_run_that_goes_on_from_a_checkpoint_ends_with_the_same_bits() {
    let (set, folder) = (synthetic::set(4), tempfile::tempdir().unwrap());
    let scans = scans(&set);
    let run = |folder: &std::path::Path, stop: bool| {
        let progress = Stop(stop);
        train_points(&set, &scans, borrowed(base()), &options(2, 3), folder, &progress)
    };
    assert!(matches!(run(folder.path(), true), Err(TrainError::Stopped { epoch: 1, .. })));
    let resumed = run(folder.path(), false).unwrap();
    let whole = run(tempfile::tempdir().unwrap().path(), false).unwrap();
    assert!(resumed.0 == whole.0);
}

/// Stops after the first epoch, or not at all.
struct Stop(bool);

impl deeptree_learn::TrainProgress for Stop {
    fn event(&self, _: deeptree_learn::TrainEvent) {}

    fn keep_going(&self) -> bool {
        !self.0
    }
}

#[test]
fn scans_that_are_not_of_the_trees_are_refused() {
    let (set, folder) = (synthetic::set(2), tempfile::tempdir().unwrap());
    let refused = |scans: &Scans| {
        train_points(&set, scans, borrowed(base()), &options(1, 1), folder.path(), &Silent)
            .map(drop)
            .unwrap_err()
            .to_string()
    };
    let mut few = scans(&set);
    few.train.pop();
    assert!(refused(&few).contains("one for each"), "{}", refused(&few));
    let mut other = scans(&set);
    other.validation[0].nodes[3] = 1_000_000;
    assert!(refused(&other).contains("validation tree 0"), "{}", refused(&other));
}

#[test]
fn reports_of_other_models_and_models_of_other_kinds_are_refused() {
    let (set, folder) = (synthetic::set(2), tempfile::tempdir().unwrap());
    let refused = |model: &Weights, report: &Report| {
        let (options, scans) = (options(1, 1), scans(&set));
        train_points(&set, &scans, (model, report), &options, folder.path(), &Silent)
            .map(drop)
            .unwrap_err()
            .to_string()
    };
    let (model, report) = base();
    let other = Report { sha256: "0".repeat(64), ..report.clone() };
    assert!(refused(model, &other).contains("tells of another model"));
    let tiny = TrainOptions {
        epochs: 1,
        steps_per_epoch: Some(1),
        networks: Default::default(),
        ..TrainOptions::new(Kind::Paper)
    };
    let paper = train(&set, &tiny, tempfile::tempdir().unwrap().path(), &Silent).unwrap();
    let weights = Weights::from_bytes(&paper.weights).unwrap();
    assert!(refused(&weights, &paper.report).contains("of another kind"));
}
