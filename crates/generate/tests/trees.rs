//! What holds for every tree that the shipped model generates.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::shipped;
use deeptree_generate::{
    DEFAULT_BUDGET, GenerateError, Generated, Limits, Request, Wishes, generate, regenerate,
};
use deeptree_graph::codec::csv::CsvWriter;
use deeptree_graph::signature::tip_count;
use deeptree_graph::{Seed, TreeTraits, least_reach, reaches};
use deeptree_infer::{Model, Predictor, SimdPath, Workspace};
use sha2::{Digest, Sha256};

fn published() -> Model {
    Model::from_bytes(include_bytes!("../../../models/paper.safetensors")).unwrap()
}

fn request(species: &str, seed: u64) -> Request {
    Request::new(species, Seed(seed))
}

fn one(model: &Model, species: &str, seed: u64) -> Generated {
    generate(model, &request(species, seed), Limits::default(), &mut Workspace::default()).unwrap()
}

/// A hash of every bit of one tree of each species.
fn hash(model: &Model, limits: Limits, path: SimdPath) -> String {
    let mut work = Workspace::new(path);
    let mut table = CsvWriter::new(Vec::new()).unwrap();
    for (number, species) in (0..).zip(model.species()) {
        let grown = generate(model, &request(species, 42), limits, &mut work).unwrap();
        table.write(number, &grown.tree).unwrap();
    }
    Sha256::digest(table.finish().unwrap()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The bits of one tree of each species from the model that ships. When they change, every
/// `.dtree` file of that model means another tree: say so under "Results changed" in CHANGELOG.md,
/// and put the hash that the failure prints here.
const GOLDEN: &str = "5992b06df73ee78baf3c0d1472791cf763b784cbe7743fcbfba844ea42eb3bcf";

#[test]
fn every_batch_and_instruction_set_gives_the_golden_bits() {
    let model = shipped();
    for path in SimdPath::available() {
        assert_eq!(hash(&model, Limits::default(), path), GOLDEN, "on {path}");
    }
    for batch in [1, 7, 100_000] {
        let limits = Limits { batch, ..Limits::default() };
        assert_eq!(hash(&model, limits, SimdPath::detect()), GOLDEN, "in batches of {batch}");
    }
}

#[test]
fn the_published_kind_has_the_same_bits_on_every_path_too() {
    let model = published();
    let limits = |batch| Limits { budget: 2000, batch };
    let expected = hash(&model, limits(512), SimdPath::Scalar);
    for path in SimdPath::available() {
        assert_eq!(hash(&model, limits(512), path), expected, "on {path}");
    }
    assert_eq!(hash(&model, limits(1), SimdPath::detect()), expected);
}

#[test]
fn a_germ_grows_the_same_tree_again() {
    let model = shipped();
    let grown = one(&model, "willow", 5);
    let again =
        regenerate(&model, grown.germ, Limits::default(), &mut Workspace::default()).unwrap();
    assert_eq!(again, grown);
}

#[test]
fn trees_end_by_themselves_and_differ_from_seed_to_seed() {
    let model = shipped();
    for species in model.species() {
        let trees: Vec<Generated> = (0..6).map(|seed| one(&model, species, seed)).collect();
        assert!(trees.iter().all(|grown| !grown.hit_budget), "{species}");
        assert!(trees.iter().all(|grown| grown.tree.len() > 100), "{species}");
        let mut sizes: Vec<usize> = trees.iter().map(|grown| grown.tree.len()).collect();
        sizes.dedup();
        assert!(sizes.len() > 3, "{species}: {sizes:?}");
    }
}

#[test]
fn the_longest_path_of_a_tree_is_the_one_it_was_told() {
    let model = shipped();
    for (number, species) in model.species().iter().enumerate() {
        let mut kept = 0;
        for seed in 0..10 {
            let grown = one(&model, species, seed);
            let root = grown.germ.root;
            let tips = tip_count(root.signature.thickness, model.tip_radius(number));
            let plan = root.traits.reach().max(least_reach(tips));
            let reach = reaches(&grown.tree)[0];
            assert!(reach <= plan, "{species} {seed}: {reach} instead of {plan}");
            kept += u32::from(reach == plan);
        }
        // A child that would end below the ground takes its path with it.
        assert!(kept >= 9, "{species}: {kept} of 10");
    }
}

#[test]
fn no_node_lies_below_the_ground() {
    let model = shipped();
    for species in model.species() {
        for seed in 0..4 {
            let tree = one(&model, species, seed).tree;
            let lowest = tree.nodes().iter().map(|node| node.position.y).fold(1.0, f32::min);
            assert!(lowest > -1e-4, "{species} {seed}: {lowest}");
        }
    }
}

#[test]
fn tips_are_conserved_at_every_node() {
    let model = shipped();
    for (number, species) in model.species().iter().enumerate() {
        let grown = one(&model, species, 9);
        let tips = |thickness| tip_count(thickness, model.tip_radius(number));
        for node in grown.tree.nodes() {
            let above: u32 = node
                .children
                .iter()
                .flatten()
                .map(|&child| tips(grown.tree.node(child).thickness))
                .sum();
            let dropped = tips(node.thickness) - above;
            // A child that would end below the ground takes its tips with it.
            let near_ground = node.position.y < 1.1;
            assert!((dropped <= 3 || near_ground) && (above > 0 || dropped > 0));
        }
    }
}

#[test]
fn a_budget_cuts_a_tree_to_the_same_start_of_it_and_says_so() {
    let model = shipped();
    let whole = one(&model, "oak", 1).tree;
    for batch in [1, 512] {
        let limits = Limits { budget: 300, batch };
        let cut = generate(&model, &request("oak", 1), limits, &mut Workspace::default()).unwrap();
        assert!(cut.hit_budget);
        assert!((298..=300).contains(&cut.tree.len()));
        let positions = |tree: &deeptree_graph::BranchGraph| {
            tree.nodes().iter().map(|n| n.position.to_array()).collect::<Vec<_>>()
        };
        assert_eq!(positions(&cut.tree), positions(&whole)[..cut.tree.len()]);
    }
    assert_eq!(DEFAULT_BUDGET, 50_000);
}

#[test]
fn trees_come_as_high_as_they_are_asked_to() {
    let model = shipped();
    let mut work = Workspace::default();
    for (species, asked) in [("oak", 22.0), ("oak", 26.0), ("tulip", 40.0), ("maple", 23.0)] {
        let wishes = Wishes { height: Some(asked), ..Wishes::default() };
        let heights: Vec<f32> = (0..12)
            .map(|seed| Request { wishes, ..request(species, seed) })
            .map(|request| generate(&model, &request, Limits::default(), &mut work).unwrap())
            .map(|grown| TreeTraits::of(&grown.tree).height)
            .collect();
        let mean = heights.iter().sum::<f32>() / heights.len() as f32;
        assert!((mean / asked - 1.0).abs() < 0.05, "{species}: asked {asked} m, got {mean} m");
    }
}

#[test]
fn trees_that_are_asked_to_be_small_are_younger() {
    let model = shipped();
    let mut work = Workspace::default();
    for asked in [12.0, 15.0, 18.0] {
        let wishes = Wishes { height: Some(asked), ..Wishes::default() };
        let trees: Vec<Generated> = (0..12)
            .map(|seed| Request { wishes, ..request("oak", seed) })
            .map(|request| generate(&model, &request, Limits::default(), &mut work).unwrap())
            .collect();
        let height: f32 = trees.iter().map(|grown| TreeTraits::of(&grown.tree).height).sum();
        let mean = height / trees.len() as f32;
        assert!((mean / asked - 1.0).abs() < 0.05, "asked {asked} m, got {mean} m");
        assert!(trees.iter().all(|grown| grown.tree.info.age < 35));
    }
}

#[test]
fn a_damaged_germ_is_refused() {
    let model = shipped();
    let mut germ = one(&model, "oak", 0).germ;
    germ.root.signature.length = 1e30;
    let again = regenerate(&model, germ, Limits::default(), &mut Workspace::default());
    assert!(matches!(again, Err(GenerateError::Root { what: "length", .. })));
}

#[test]
fn what_the_model_never_saw_is_refused() {
    let model = shipped();
    let ask = |request| {
        generate(&model, &request, Limits::default(), &mut Workspace::default()).unwrap_err()
    };
    assert!(matches!(ask(request("elm", 0)), GenerateError::UnknownSpecies { .. }));
    let old = Request { age: Some(90), ..request("oak", 0) };
    assert!(matches!(ask(old), GenerateError::OutOfRange { what: "age", .. }));
    let nan = Request { gravitropism: Some(f32::NAN), ..request("oak", 0) };
    assert!(matches!(ask(nan), GenerateError::NotFinite { what: "gravitropism", .. }));
}
