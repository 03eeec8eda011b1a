//! A species between species.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_generate::{Generated, Limits, Request, generate, germ};
use deeptree_graph::{Seed, Share, TreeTraits};
use deeptree_infer::{BlendError, Model, Predictor, Weights, Workspace};

fn weights() -> Weights {
    Weights::from_bytes(include_bytes!("../../../models/situated.safetensors")).unwrap()
}

/// The shares of species by their names.
fn shares(weights: &Weights, parts: &[(&str, u16)]) -> Vec<Share> {
    let number = |name| weights.species().iter().position(|known| known == name).unwrap() as u8;
    parts.iter().map(|&(name, weight)| Share { species: number(name), weight }).collect()
}

fn blend(parts: &[(&str, u16)]) -> Model {
    let weights = weights();
    Model::from_weights(&weights.blend(&shares(&weights, parts)).unwrap()).unwrap()
}

fn one(model: &Model, species: &str, seed: u64) -> Generated {
    let request = Request::new(species, Seed(seed));
    generate(model, &request, Limits::default(), &mut Workspace::default()).unwrap()
}

#[test]
fn a_blend_of_one_species_is_that_species_bit_for_bit() {
    let whole = Model::from_weights(&weights()).unwrap();
    for name in ["oak", "willow", "beech"] {
        let alone = blend(&[(name, 3)]);
        assert_eq!(alone.hash(), whole.hash());
        for seed in 0..3 {
            let (a, b) = (one(&whole, name, seed), one(&alone, &format!("{name}:1"), seed));
            assert!(a.tree.nodes() == b.tree.nodes(), "{name} {seed}");
            assert_eq!(a.germ.root, b.germ.root, "{name} {seed}");
        }
    }
}

#[test]
fn trees_of_a_blend_end_and_carry_its_name() {
    let model = blend(&[("oak", 70), ("willow", 30)]);
    for seed in 0..8 {
        let grown = one(&model, "oak:0.7,willow:0.3", seed);
        assert!(!grown.hit_budget && grown.tree.len() > 100, "{seed}");
        assert_eq!(grown.tree.info.species, "oak:0.7,willow:0.3");
    }
}

#[test]
fn what_trees_of_a_blend_are_drawn_as_has_the_weighted_mean() {
    let whole = Model::from_weights(&weights()).unwrap();
    let mixed = blend(&[("oak", 70), ("willow", 30)]);
    let mean = |model: &Model, species: &str| -> [f64; TreeTraits::COUNT] {
        let n = 4000;
        let mut sums = [0.0; TreeTraits::COUNT];
        for seed in 0..n {
            let root = germ(model, &Request::new(species, Seed(seed))).unwrap().root;
            for (sum, x) in sums.iter_mut().zip(root.traits.to_array()) {
                *sum += f64::from(x) / n as f64;
            }
        }
        sums
    };
    let (oak, willow) = (mean(&whole, "oak"), mean(&whole, "willow"));
    let between = mean(&mixed, "oak:0.7,willow:0.3");
    for i in 0..TreeTraits::COUNT {
        let expected = 0.7 * oak[i] + 0.3 * willow[i];
        // 4000 draws of deviations up to a third of the mean, thrice.
        assert!((between[i] / expected - 1.0).abs() < 0.03, "{i}: {} {expected}", between[i]);
    }
}

#[test]
fn shares_that_are_none_are_refused() {
    let weights = weights();
    let share = |species, weight| Share { species, weight };
    let error = |shares: &[Share]| weights.blend(shares).unwrap_err();
    assert!(matches!(error(&[]), BlendError::Empty));
    assert!(matches!(error(&[share(0, 1), share(99, 1)]), BlendError::UnknownSpecies { .. }));
    assert!(matches!(error(&[share(0, 1), share(0, 1)]), BlendError::Twice { .. }));
    assert!(matches!(error(&[share(0, 1), share(1, 0)]), BlendError::NoWeight { .. }));
    let paper = include_bytes!("../../../models/paper.safetensors");
    let paper = Weights::from_bytes(paper).unwrap().blend(&[share(0, 1)]).unwrap_err();
    assert!(matches!(paper, BlendError::Kind { .. }));
}
