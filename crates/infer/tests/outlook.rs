//! The network of environments as it is read from a model file.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::{draws, values};
use deeptree_graph::signature::outlook::{CHANNELS, CODE, KERNEL, MAPS, OUTPUTS, len};
use deeptree_graph::{Occupancy, Share, Voxel};
use deeptree_infer::{
    Expectation, ModelKind, Outlook, Overflow, ReadWeightsError, Table, Weights, WeightsBuilder,
};

const SPECIES: [&str; 3] = ["beech", "oak", "willow"];
const HIDDEN: usize = 48;

/// Random weights.
fn builder() -> WeightsBuilder {
    let mut draws = draws(3);
    let mut builder = WeightsBuilder::new(ModelKind::Situated, SPECIES);
    let mut table = |name: &str, shape: &[usize], scale: f32| {
        let values = values(&mut draws, shape.iter().product(), scale);
        builder.table(name, Table::new(shape.to_vec(), values).unwrap());
    };
    for (i, pair) in CHANNELS.windows(2).enumerate() {
        let scale = (6.0 / (KERNEL * pair[0]) as f32).sqrt();
        let name = format!("outlook.conv{}", i + 1);
        table(&format!("{name}.weight"), &[3, 3, 3, pair[0], pair[1]], scale);
        table(&format!("{name}.bias"), &[pair[1]], 0.2);
    }
    table("outlook.code.weight", &[MAPS, CODE], 0.2);
    table("outlook.code.bias", &[CODE], 0.2);
    table("outlook.0.weight", &[len(SPECIES.len()), HIDDEN], 0.4);
    table("outlook.0.bias", &[HIDDEN], 0.2);
    table("outlook.1.weight", &[HIDDEN, OUTPUTS], 0.3);
    table("outlook.1.bias", &[OUTPUTS], 0.2);
    for (name, first) in [("outlook.mean", 5.0), ("outlook.deviation", 0.5)] {
        let rows = (0..SPECIES.len() * 8).map(|i| first + 0.25 * i as f32).collect();
        builder.table(name, Table::new(vec![SPECIES.len(), 8], rows).unwrap());
    }
    // A blend takes roots and tip radii too.
    builder.table("tip_radius", Table::new(vec![3], vec![0.01; 3]).unwrap());
    for name in SPECIES {
        let root = [0.0, 0.0, 0.0, 1.0, 0.1, 1.0, 30.0, 0.0, 9.0, 4.0, 9.0, 5.0, 3.0, 8.0, 7.0];
        builder.table(format!("roots.{name}"), Table::new(vec![1, 15], root.to_vec()).unwrap());
    }
    builder
}

fn weights(builder: &WeightsBuilder) -> Weights {
    Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap()
}

fn network() -> Outlook {
    Outlook::read(&weights(&builder())).unwrap().unwrap()
}

/// Everything at x ≥ `from`, up to a height of 24 m.
fn wall(from: u8) -> Occupancy {
    let mut wall = Occupancy::EMPTY;
    for (x, y, z) in (0..32 * 32 * 32).map(|i| (i % 32, i / 32 % 32, i / 1024)) {
        if x >= i64::from(from) && y < 12 {
            wall.set(Voxel::at(x, y, z).unwrap());
        }
    }
    wall
}

fn near(a: &Expectation, b: &Expectation) -> bool {
    let states = a.state.iter().zip(&b.state).all(|(a, b)| (a - b).abs() < 1e-4 * a.abs().max(1.0));
    states && (a.offset - b.offset).length() < 1e-4
}

#[test]
fn a_model_without_its_tensors_has_no_outlook() {
    let mut builder = WeightsBuilder::new(ModelKind::Situated, SPECIES);
    builder.table("outlooks", Table::new(vec![1], vec![0.5]).unwrap());
    assert_eq!(Outlook::read(&weights(&builder)).unwrap(), None);
}

#[test]
fn it_has_the_weights_of_its_layers_and_at_most_ten_thousand_of_eight_species() {
    // 27 · 2 · 4 + 4, 27 · 4 · 8 + 8, 27 · 8 · 8 + 8, 512 · 8 + 8, 13 · 48 + 48, 48 · 10 + 10.
    assert_eq!(network().weight_count(), 220 + 872 + 1736 + 4104 + 672 + 490);
    assert!(220 + 872 + 1736 + 4104 + (len(8) + 1) * 48 + 490 <= 10_000);
}

/// The whole network in double precision, by its definition.
fn defined(weights: &Weights, grids: [&Occupancy; 2], species: usize) -> (Vec<f64>, [f64; 2]) {
    let table = |name: &str| -> Vec<f64> {
        let any = [None; 5];
        let of = |dims: usize| weights.table(name, &any[..dims]);
        let table = [1, 2, 5].into_iter().find_map(|dims| of(dims).ok()).unwrap();
        table.values().iter().map(|&x| f64::from(x)).collect()
    };
    let mut side = 32i64;
    let mut maps: Vec<f64> = (0..side * side * side)
        .flat_map(|i| {
            let voxel = Voxel::at(i % 32, i / 32 % 32, i / 1024).unwrap();
            grids.map(|grid| f64::from(u8::from(grid.holds(voxel))))
        })
        .collect();
    for (i, pair) in CHANNELS.windows(2).enumerate() {
        let (weight, bias) = (
            table(&format!("outlook.conv{}.weight", i + 1)),
            table(&format!("outlook.conv{}.bias", i + 1)),
        );
        let half = side / 2;
        let mut next = Vec::new();
        for place in 0..half * half * half {
            let [x, y, z] = [place % half, place / half % half, place / (half * half)];
            for o in 0..pair[1] {
                let mut sum = bias[o];
                for tap in 0..27i64 {
                    let at = [2 * x + tap % 3 - 1, 2 * y + tap / 3 % 3 - 1, 2 * z + tap / 9 - 1];
                    if at.iter().any(|c| !(0..side).contains(c)) {
                        continue;
                    }
                    let from = ((at[2] * side + at[1]) * side + at[0]) as usize * pair[0];
                    for c in 0..pair[0] {
                        sum += maps[from + c] * weight[(tap as usize * pair[0] + c) * pair[1] + o];
                    }
                }
                next.push(sum.max(0.0));
            }
        }
        (maps, side) = (next, half);
    }
    let dense = |inputs: &[f64], name: &str| -> Vec<f64> {
        let (weight, bias) = (table(&format!("{name}.weight")), table(&format!("{name}.bias")));
        let outputs = bias.len();
        let sum = |o: usize| {
            inputs.iter().enumerate().map(|(i, x)| x * weight[i * outputs + o]).sum::<f64>()
        };
        (0..outputs).map(|o| bias[o] + sum(o)).collect()
    };
    let code = dense(&maps, "outlook.code");
    let mut row = vec![0.0; 3];
    row[species] = 1.0;
    row.extend([20.0 / 50.0, 2.0 * -0.25]);
    row.extend(code);
    let hidden: Vec<f64> = dense(&row, "outlook.0").into_iter().map(|x| x.max(0.0)).collect();
    let said = dense(&hidden, "outlook.1");
    let (mean, deviation) = (table("outlook.mean"), table("outlook.deviation"));
    let state = |i: usize| mean[8 * species + i] + deviation[8 * species + i] * said[i];
    ((0..8).map(state).collect(), [4.0 * said[8], 4.0 * said[9]])
}

#[test]
fn it_says_what_its_definition_says() {
    let weights = weights(&builder());
    let network = Outlook::read(&weights).unwrap().unwrap();
    let (taken, shading) = (wall(19), wall(23));
    for grids in [[&taken, &shading], [&taken, &Occupancy::EMPTY], [&Occupancy::EMPTY; 2]] {
        let code = network.code(grids[0], grids[1]);
        for species in 0..SPECIES.len() {
            let ours = network.expect(&code, species, 20.0, -0.25).unwrap();
            let (state, offset) = defined(&weights, grids, species);
            for (a, b) in ours.state.iter().zip(&state) {
                assert!((a - b).abs() < 1e-3, "{a} {b}");
            }
            assert!((f64::from(ours.offset.x) - offset[0]).abs() < 1e-3);
            assert!((f64::from(ours.offset.y) - offset[1]).abs() < 1e-3);
        }
    }
}

#[test]
fn the_two_grids_are_told_apart_and_nothing_stays_nothing() {
    let network = network();
    let (empty, wall) = (Occupancy::EMPTY, wall(19));
    let codes = [
        network.code(&empty, &empty),
        network.code(&wall, &empty),
        network.code(&empty, &wall),
        network.code(&wall, &wall),
    ];
    for (i, one) in codes.iter().enumerate() {
        assert!(codes[..i].iter().all(|other| other != one));
    }
    let again = network.expect(&network.code(&empty, &empty), 1, 30.0, 0.1).unwrap();
    assert_eq!(again, network.expect(&codes[0], 1, 30.0, 0.1).unwrap());
}

#[test]
fn a_blend_of_one_expects_what_the_species_does() {
    let whole = weights(&builder());
    let network = Outlook::read(&whole).unwrap().unwrap();
    let code = network.code(&wall(19), &wall(19));
    for species in 0..SPECIES.len() {
        let blended = whole.blend(&[Share { species: species as u8, weight: 4 }]).unwrap();
        let alone = Outlook::read(&blended).unwrap().unwrap();
        assert_eq!(alone.code(&wall(19), &wall(19)), code);
        let (a, b) = (alone.expect(&code, 0, 20.0, 0.3), network.expect(&code, species, 20.0, 0.3));
        assert!(near(&a.unwrap(), &b.unwrap()));
    }
}

#[test]
fn tensors_that_do_not_fit_are_named() {
    let named = |name: &str, shape: &[usize], value: f32| {
        let mut builder = builder();
        let values = vec![value; shape.iter().product()];
        builder.table(name, Table::new(shape.to_vec(), values).unwrap());
        Outlook::read(&weights(&builder)).unwrap_err()
    };
    for (name, shape) in [
        ("outlook.conv1.weight", &[3, 3, 3, 4, 2][..]),
        ("outlook.conv1.weight", &[27, 2, 4]),
        ("outlook.conv3.weight", &[0, 3, 3, 8, 8]),
        ("outlook.conv2.bias", &[4]),
        ("outlook.code.weight", &[CODE, MAPS]),
        ("outlook.code.bias", &[0]),
        ("outlook.mean", &[3, 7]),
        ("outlook.deviation", &[8, 3]),
    ] {
        let error = named(name, shape, 0.5).to_string();
        assert!(error.contains(&format!("`{name}`")), "{error}");
    }
    let wide = named("outlook.0.weight", &[len(4), HIDDEN], 0.5);
    assert!(matches!(wide, ReadWeightsError::NetworkWidth { network, .. } if network == "outlook"));
    let flat = named("outlook.deviation", &[3, 8], 0.0);
    assert!(matches!(flat, ReadWeightsError::NotPositive { .. }));
    // One tensor makes a network that lacks the others.
    let mut builder = WeightsBuilder::new(ModelKind::Situated, SPECIES);
    builder.table("outlook.mean", Table::new(vec![3, 8], vec![1.0; 24]).unwrap());
    let error = Outlook::read(&weights(&builder)).unwrap_err();
    assert!(matches!(error, ReadWeightsError::MissingTensor { .. }), "{error}");
}

#[test]
fn numbers_that_overflow_are_an_error() {
    for (name, shape) in
        [("outlook.conv3.weight", &[3, 3, 3, 8, 8][..]), ("outlook.1.weight", &[HIDDEN, OUTPUTS])]
    {
        let mut builder = builder();
        let values = vec![f32::MAX; shape.iter().product()];
        builder.table(name, Table::new(shape.to_vec(), values).unwrap());
        let network = Outlook::read(&weights(&builder)).unwrap().unwrap();
        let code = network.code(&wall(4), &wall(4));
        assert_eq!(network.expect(&code, 0, 30.0, 0.1), Err(Overflow { row: 0 }), "{name}");
    }
}
