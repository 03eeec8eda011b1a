//! Trains on trees that answer their environment by a known rule, and asks whether it was found.
#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic, as tests do")]

#[allow(dead_code, reason = "other tests use more of it")]
mod synthetic;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};

use deeptree_graph::signature::outlook::crown_offset;
use deeptree_graph::{
    BranchGraph, ChildSignature, Draws, Lineage, NodeId, Occupancy, Purpose, Quat, Seed, TreeInfo,
    TreeTraits, Vec2, Vec3,
};
use deeptree_infer::{Model, Outlook, Predictor, Weights};
use deeptree_learn::{
    Kind, NetworkOptions, Silent, Surroundings, TrainError, TrainEvent, TrainOptions,
    TrainProgress, TrainedModel, TrainingSet, train,
};
use deeptree_scene::{BoxShape, Cuboid, Environment, Scene};

/// Number of the species that answers its environment.
const YEW: usize = 2;

/// Where the height stands in a state.
const HEIGHT: usize = 6;

/// Height in the open field, and what a thousand taken voxels take of it, in metres.
const OPEN: f32 = 16.0;
const LOST: f32 = 8.0;

/// How far a thousand voxels in one direction push the crown, in metres.
const PUSH: f32 = 4.0;

/// Internodes of the trunk; one more leans over.
const TRUNK: usize = 4;

/// A box of 4 to 10 voxels a side, somewhere beside the tree.
fn scene(draws: &mut Draws) -> Surroundings {
    let size = [(); 3].map(|()| 4 + draws.index(7) as i64);
    let (angle, far) = (std::f64::consts::TAU * draws.uniform(), 8.0 + 4.0 * draws.uniform());
    let middle = [16.0 + far * angle.cos(), 4.0 + 4.0 * draws.uniform(), 16.0 + far * angle.sin()];
    let low = [0, 1, 2].map(|axis| (middle[axis] as i64 - size[axis] / 2).max(0));
    // In metres, and a bit less than the voxels.
    let corner = |at: [i64; 3], inset: f32| {
        Occupancy::LOW + Vec3::from_array(at.map(|x| Occupancy::VOXEL * x as f32 + inset))
    };
    let (min, max) = (corner(low, 0.1), corner([0, 1, 2].map(|i| low[i] + size[i]), -0.1));
    let cuboid = Cuboid::new(BoxShape::Aligned { min, max }).unwrap();
    let scene = Scene::new(vec![cuboid], Vec::new()).unwrap();
    Surroundings::of(Environment { scene, volume: None }).unwrap()
}

/// The rule: height, and offset of the crown. Turned with the scene it says the same.
fn answer(taken: &Occupancy) -> (f32, Vec2) {
    let height = OPEN - LOST * taken.count() as f32 / 1000.0;
    let pushes = taken.iter().map(|voxel| {
        let at = voxel.centre();
        Vec2::new(at.x, at.z).normalize()
    });
    (height, -PUSH / 1000.0 * pushes.sum::<Vec2>())
}

/// A trunk and one internode that leans over: the crown's offset is a fifth of its length.
fn yew(seed: u64, taken: &Occupancy) -> BranchGraph {
    let (height, offset) = answer(taken);
    let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::Priors);
    let info = TreeInfo {
        species: "yew".into(),
        age: 20 + draws.index(3) as u32,
        gravitropism: 0.0,
        seed,
    };
    let edge = |rotation, length| ChildSignature { rotation, thickness: 0.01, length };
    let up = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::Y);
    // Of itself a tree varies by a tenth of a metre.
    let height = height + 0.1 * draws.normal() as f32;
    let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(up, height / TRUNK as f32));
    for node in 0..TRUNK - 1 {
        tree.grow(node as NodeId, [Some(edge(Quat::IDENTITY, height / TRUNK as f32)), None, None]);
    }
    let lean = offset * (TRUNK + 1) as f32;
    let aim = Vec3::new(lean.x, 0.0, lean.y);
    let length = aim.length().max(0.01);
    let front = up.inverse() * (aim + Vec3::Y * 1e-4).normalize();
    let over = edge(Quat::from_rotation_arc(Vec3::NEG_Z, front), length);
    tree.grow(TRUNK as NodeId - 1, [Some(over), None, None]);
    tree
}

/// Yews in environments and as many of the open field, beside other trees.
fn set(yews: u64) -> TrainingSet {
    let mut set = synthetic::set(4);
    set.species.push("yew".into());
    let add = |trees: &mut Vec<BranchGraph>, around: &mut Vec<_>, from: u64, count: u64| {
        for seed in from..from + count {
            let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::Evaluation);
            let surroundings = scene(&mut draws);
            trees.push(yew(seed, surroundings.taken()));
            around.push(Some(surroundings));
            trees.push(yew(seed + (1 << 40), &Occupancy::EMPTY));
            around.push(None);
        }
    };
    add(&mut set.train, &mut set.train_surroundings, 0, yews);
    add(&mut set.validation, &mut set.validation_surroundings, 1 << 32, yews.div_ceil(4));
    set
}

/// So little for all networks but `outlook` that they take no time.
fn options(epochs: u32, steps: u64) -> TrainOptions {
    let brief = NetworkOptions {
        hidden: Some(vec![8]),
        epochs: Some(1),
        steps_per_epoch: Some(2),
        ..NetworkOptions::default()
    };
    let names = ["existence", "split", "reach", "size", "rotation1", "rotation2", "rotation3"];
    let mut networks: BTreeMap<_, _> = names.map(|name| (name.to_owned(), brief.clone())).into();
    let own = NetworkOptions {
        epochs: Some(epochs),
        steps_per_epoch: Some(steps),
        ..NetworkOptions::default()
    };
    networks.insert("outlook".into(), own);
    let warmup_steps = (steps / 4).min(50);
    TrainOptions { batch: 64, warmup_steps, networks, ..TrainOptions::new(Kind::Situated) }
}

fn run(set: &TrainingSet, options: &TrainOptions) -> TrainedModel {
    let folder = tempfile::tempdir().unwrap();
    train(set, options, folder.path(), &Silent).unwrap()
}

fn outlook(model: &TrainedModel) -> Outlook {
    Model::from_bytes(&model.weights).unwrap().outlook().unwrap().clone()
}

#[test]
fn the_rule_by_which_trees_answer_their_environment_is_found() {
    let set = set(600);
    let model = run(&set, &options(2, 400));
    let figures = &model.report.networks["outlook"].total.values;
    for (name, least) in [("height", 0.9), ("offset_x", 0.8), ("offset_z", 0.8)] {
        let r2 = figures[&format!("r2_{name}")];
        assert!(r2 > least, "{name}: R² {r2}");
    }
    // Never varied, never spoken of.
    assert!(!figures.contains_key("r2_nodes"));

    // What is written says so too, in metres, of scenes that no tree of the set has seen.
    let network = outlook(&model);
    let empty = network.code(&Occupancy::EMPTY, &Occupancy::EMPTY);
    let open = network.expect(&empty, YEW, 21.0, 0.0).unwrap();
    assert!((open.state[HEIGHT] - f64::from(OPEN)).abs() < 0.5, "{open:?}");
    assert!(open.offset.length() < 0.2, "{open:?}");
    let (mut errors, mut losses) = ([0.0, 0.0], [0.0, 0.0]);
    for seed in 0..100 {
        let scene = scene(&mut Seed(seed).draws(Lineage::ROOT, Purpose::Existence));
        let said =
            network.expect(&network.code(scene.taken(), scene.shading()), YEW, 21.0, 0.0).unwrap();
        let (height, offset) = answer(scene.taken());
        let square = |x: f64| x * x;
        errors[0] += square(said.state[HEIGHT] - open.state[HEIGHT] + f64::from(OPEN - height));
        errors[1] += f64::from((said.offset - open.offset - offset).length_squared());
        losses[0] += square(f64::from(OPEN - height));
        losses[1] += f64::from(offset.length_squared());
    }
    // Of what a model that knows no environments would miss, a tenth is left.
    assert!(errors[0] < 0.1 * losses[0], "height: {} of {}", errors[0], losses[0]);
    assert!(errors[1] < 0.2 * losses[1], "offset: {} of {}", errors[1], losses[1]);
}

#[test]
fn what_is_written_says_what_the_training_says() {
    let set = set(40);
    let model = run(&set, &options(1, 20));
    let (network, weights) = (outlook(&model), Weights::from_bytes(&model.weights).unwrap());
    let deviation = weights.table("outlook.deviation", &[Some(3), Some(8)]).unwrap().row(YEW);
    let (mut squares, mut offsets, mut count) = (0.0, 0.0, 0.0);
    for (tree, around) in set.validation.iter().zip(&set.validation_surroundings) {
        let Some(around) = around else { continue };
        let code = network.code(around.taken(), around.shading());
        let said = network.expect(&code, YEW, tree.info.age as f32, 0.0).unwrap();
        let error = said.state[HEIGHT] - f64::from(TreeTraits::of(tree).height);
        squares += (error / f64::from(deviation[HEIGHT])).powi(2);
        offsets += f64::from((said.offset - crown_offset(tree)).x / 4.0).powi(2);
        count += 1.0;
    }
    let figures = &model.report.networks["outlook"].total.values;
    for (name, ours) in [("mse_height", squares / count), ("mse_offset_x", offsets / count)] {
        let theirs = figures[name];
        assert!((ours / theirs - 1.0).abs() < 1e-3, "{name}: {ours} {theirs}");
    }
    assert_eq!(model.report.networks["outlook"].weight_count, network.weight_count());
}

/// Stops after each epoch of a network.
struct Impatient(AtomicU32);

impl TrainProgress for Impatient {
    fn event(&self, event: TrainEvent) {
        if let TrainEvent::Epoch { network: "outlook", .. } = event {
            self.0.store(1, Ordering::Relaxed);
        }
    }

    fn keep_going(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

#[test]
fn a_run_in_pieces_ends_with_the_same_bits() {
    let (set, options) = (set(6), options(3, 2));
    let straight = run(&set, &options);
    let folder = tempfile::tempdir().unwrap();
    let mut stops = 0;
    let pieces = loop {
        match train(&set, &options, folder.path(), &Impatient(AtomicU32::new(0))) {
            Ok(model) => break model,
            Err(TrainError::Stopped { .. }) => stops += 1,
            Err(error) => panic!("{error}"),
        }
    };
    assert_eq!(stops, 2);
    assert_eq!(straight.report.sha256, pieces.report.sha256);
    let alone = run(&set, &TrainOptions { workers: 1, ..options.clone() });
    assert_eq!(straight.report.sha256, alone.report.sha256);
}

#[test]
fn without_environments_there_is_no_outlook() {
    let mut set = set(6);
    let is_open = |around: &Option<Surroundings>| around.is_none();
    let keep: Vec<bool> = set.train_surroundings.iter().map(is_open).collect();
    let mut kept = keep.iter();
    set.train.retain(|_| *kept.next().unwrap());
    set.train_surroundings.retain(is_open);
    let model = run(&set, &options(1, 2));
    assert!(!model.report.networks.contains_key("outlook"));
    assert!(Model::from_bytes(&model.weights).unwrap().outlook().is_none());
}

#[test]
fn roots_are_those_of_the_open_field() {
    let set = set(6);
    let model = run(&set, &options(1, 1));
    let model = Model::from_bytes(&model.weights).unwrap();
    let roots = model.roots(YEW);
    assert_eq!(roots.len(), 6);
    assert!(roots.iter().all(|root| (root.traits.height - OPEN).abs() < 1.0));
}

#[test]
fn sets_that_do_not_fit_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |set: &TrainingSet| {
        train(set, &options(1, 1), folder.path(), &Silent).unwrap_err().to_string()
    };
    let mut short = set(2);
    short.train_surroundings.pop();
    assert!(fails(&short).contains("surroundings of 11"), "{}", fails(&short));
    let mut inside = set(2);
    let scene = inside.train_surroundings.iter().flatten().next().cloned();
    inside.train_surroundings.fill(scene);
    assert!(fails(&inside).contains("`ash`"), "{}", fails(&inside));
}
