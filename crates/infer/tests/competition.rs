//! The network of competition as it is read from a model file.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::{draws, values};
use deeptree_graph::Vec2;
use deeptree_graph::signature::competition::{Contender, INDICES, OUTPUTS, REACH, encode, len};
use deeptree_infer::{
    Competition, ModelKind, Overflow, ReadWeightsError, Table, Weights, WeightsBuilder,
};

const SPECIES: [&str; 3] = ["beech", "oak", "willow"];
const HIDDEN: usize = 20;
const OWN: Contender = Contender { species: 1, age: 25.0, nodes: 3000.0, height: 21.0 };

/// Random weights, those of the last layer times `scale`.
fn builder(scale: f32) -> WeightsBuilder {
    let mut draws = draws(5);
    let mut builder = WeightsBuilder::new(ModelKind::Situated, SPECIES);
    let inputs = len(SPECIES.len());
    for (name, shape, scale) in [
        ("competition.0.weight", vec![inputs, HIDDEN], 0.4),
        ("competition.0.bias", vec![HIDDEN], 0.2),
        ("competition.1.weight", vec![HIDDEN, OUTPUTS], scale),
        ("competition.1.bias", vec![OUTPUTS], 0.2),
    ] {
        let values = values(&mut draws, shape.iter().product(), scale);
        builder.table(name, Table::new(shape, values).unwrap());
    }
    builder
}

fn weights(builder: &WeightsBuilder) -> Weights {
    Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap()
}

fn network(scale: f32) -> Competition {
    Competition::read(&weights(&builder(scale))).unwrap().unwrap()
}

fn others() -> Vec<(Vec2, Contender)> {
    let other = Contender { species: 0, nodes: 900.0, ..OWN };
    vec![(Vec2::new(4.0, 1.0), other), (Vec2::new(-3.0, 9.0), OWN)]
}

#[test]
fn nothing_near_changes_nothing_to_the_last_bit() {
    let network = network(0.4);
    for others in [vec![], vec![(Vec2::new(0.0, REACH), OWN)]] {
        let shift = network.shift(&OWN, &others).unwrap();
        assert_eq!(shift.map(f64::to_bits), [0; OUTPUTS]);
    }
    assert!(network.shift(&OWN, &others()).unwrap().iter().all(|&x| x != 0.0));
}

#[test]
fn the_shift_is_what_two_layers_say_with_the_others_less_what_they_say_without() {
    let file = weights(&builder(0.4));
    let dense = |row: &[f64], layer: usize| -> Vec<f64> {
        let table = |part: &str, shape: &[Option<usize>]| {
            file.table(&format!("competition.{layer}.{part}"), shape).unwrap().values().to_vec()
        };
        let (weight, bias) = (table("weight", &[None, None]), table("bias", &[None]));
        let sum = |o: usize| {
            let products = row.iter().enumerate();
            let products = products.map(|(i, x)| x * f64::from(weight[i * bias.len() + o]));
            f64::from(bias[o]) + products.sum::<f64>()
        };
        (0..bias.len()).map(sum).collect()
    };
    let say = |others: &[(Vec2, Contender)]| {
        let mut row = vec![0.0; len(SPECIES.len())];
        encode(SPECIES.len(), &OWN, others, &mut row);
        let row: Vec<f64> = row.into_iter().map(f64::from).collect();
        let hidden: Vec<f64> = dense(&row, 0).into_iter().map(|x| x.max(0.0)).collect();
        dense(&hidden, 1)
    };
    let (here, open) = (say(&others()), say(&[]));
    let shift = network(0.4).shift(&OWN, &others()).unwrap();
    for (i, shift) in shift.into_iter().enumerate() {
        assert!((shift - (here[i] - open[i])).abs() < 1e-4, "{i}: {shift}");
    }
    assert_eq!(network(0.4).weight_count(), (len(3) + 1) * HIDDEN + (HIDDEN + 1) * OUTPUTS);
}

#[test]
fn models_without_it_and_damaged_ones_are_told_apart() {
    let mut none = WeightsBuilder::new(ModelKind::Situated, SPECIES);
    none.table("competitions", Table::new(vec![1], vec![0.5]).unwrap());
    assert_eq!(Competition::read(&weights(&none)).unwrap(), None);
    let mut narrow = builder(0.4);
    let inputs = len(SPECIES.len()) - INDICES;
    let first = Table::new(vec![inputs, HIDDEN], vec![0.1; inputs * HIDDEN]).unwrap();
    narrow.table("competition.0.weight", first);
    let error = Competition::read(&weights(&narrow)).unwrap_err();
    assert!(matches!(error, ReadWeightsError::NetworkWidth { .. }), "{error}");
    assert_eq!(network(f32::MAX).shift(&OWN, &others()), Err(Overflow { row: 0 }));
}
