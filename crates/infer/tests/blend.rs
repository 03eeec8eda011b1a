//! Species between species, of networks with random weights.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::situated::{SPECIES, branchlets, weights, weights_of};
use common::{draws, values};
use deeptree_graph::Share;
use deeptree_graph::signature::situated;
use deeptree_infer::{Model, Predictor, Scratch, SimdPath, Weights};

fn share(species: u8, weight: u16) -> Share {
    Share { species, weight }
}

#[test]
fn a_blend_of_one_species_is_that_species_bit_for_bit() {
    let weights = weights();
    let whole = Model::from_weights(&weights).unwrap();
    for (number, name) in SPECIES.into_iter().enumerate() {
        let blended = weights.blend(&[share(number as u8, 9)]).unwrap();
        let alone = Model::from_weights(&blended).unwrap();
        assert_eq!(alone.species(), [format!("{name}:1")]);
        assert_eq!(alone.roots(0), whole.roots(number));
        assert!(alone.trend(0).is_some() && alone.trend(0) == whole.trend(number));
        assert_eq!(alone.hash(), whole.hash());
        let expected = branchlets(&whole, number);
        assert!(branchlets(&alone, 0) == expected, "{name}");
        assert!(expected.iter().any(|branchlet| branchlet.children.iter().any(Option::is_some)));
    }
}

#[test]
fn no_apical_shoot_is_aligned_between_species_that_align_it_otherwise() {
    // How far the logit of the aligned law is above the greatest of the components.
    let above = |weights: &Weights, shares: &[Share]| {
        let blend = weights.blend(shares).unwrap().mlp("rotation1").unwrap();
        let (inputs, mut scratch) = (values(&mut draws(6), blend.inputs(), 1.0), Scratch::new());
        let said = blend.forward(SimdPath::detect(), &inputs, &mut scratch);
        let components = &said[..situated::ROTATION_COMPONENTS];
        let greatest = components.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        said[situated::ROTATION_COMPONENTS] - greatest
    };
    let oaks_and_beeches = [share(0, 1), share(1, 1)];
    assert!(above(&weights(), &oaks_and_beeches) > -50.0);
    assert!(above(&weights_of(true), &[share(0, 1)]) > -50.0);
    assert!(above(&weights_of(true), &oaks_and_beeches) < -500.0);
}

#[test]
fn the_networks_of_a_blend_read_the_parts_of_its_species() {
    let weights = weights();
    let blended = weights.blend(&[share(0, 1), share(2, 3)]).unwrap();
    let mut draws = draws(5);
    for name in ["existence", "split", "reach", "size", "rotation3"] {
        let (whole, blend) = (weights.mlp(name).unwrap(), blended.mlp(name).unwrap());
        assert_eq!(blend.inputs(), whole.inputs() - 2);
        let rest = values(&mut draws, whole.inputs() - 3, 1.0);
        let parts = [&[0.25, 0.0, 0.75], &rest[..]].concat();
        let one = [&[1.0], &rest[..]].concat();
        let (mut a, mut b) = (Scratch::new(), Scratch::new());
        let path = SimdPath::detect();
        let pairs =
            whole.forward(path, &parts, &mut a).iter().zip(blend.forward(path, &one, &mut b));
        for (told, folded) in pairs {
            assert!((told - folded).abs() < 1e-4, "{name}: {told} {folded}");
        }
    }
}

#[test]
fn tables_and_roots_of_a_blend_have_the_weighted_mean() {
    let weights = weights();
    let blended = weights.blend(&[share(0, 1), share(2, 3)]).unwrap();
    let value = |weights: &Weights, name: &str, row: usize| {
        weights.table(name, &[None, None, None]).unwrap().row(row)[7]
    };
    for name in ["rotation_mean", "rotation_scale", "lengths"] {
        let expected = 0.25 * value(&weights, name, 0) + 0.75 * value(&weights, name, 2);
        assert!((value(&blended, name, 0) - expected).abs() < 1e-6, "{name}");
    }
    let model = Model::from_weights(&blended).unwrap();
    assert!((model.tip_radius(0) - 0.0175).abs() < 1e-7);
    assert_eq!(model.trend(0), None, "of several the roots alone say how a blend changes");
    let roots = model.roots(0);
    // Of thirty willows thrice as many as of thirty beeches.
    assert_eq!(roots.len(), 40);
    // Beeches of 12 m in the mean with a part of one in four, willows of 32 m with the rest.
    let own: Vec<_> = roots.iter().filter(|root| root.gravitropism == 0.1).collect();
    assert!(own.iter().all(|root| root.age == 36.0), "a quarter of 30 and three of 38");
    for own in [&own[..own.len() / 4], &own[own.len() / 4..]] {
        let mean = own.iter().map(|root| root.traits.height).sum::<f32>() / own.len() as f32;
        assert!((mean / 27.0 - 1.0).abs() < 0.1, "{mean}");
    }
    assert!(roots.iter().all(|root| (root.gravitropism + 0.3).abs() < 1e-6 || root.age == 36.0));
}
