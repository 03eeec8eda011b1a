//! Species between species, of networks with random weights.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::{draws, values};
use deeptree_graph::signature::inheritance::{REACH_LEN, REACH_OUTPUTS};
use deeptree_graph::signature::situated::{self, LENGTH_ORDERS};
use deeptree_graph::signature::size::SIZE_LEN;
use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{Lineage, MAX_CHILDREN, Plan, Seed, Sense, Share, TreeTraits};
use deeptree_infer::{
    Active, Branchlet, Model, ModelKind, Predictor, ROOT_COLUMNS, Scratch, SimdPath, TREND_COLUMNS,
    Table, Weights, WeightsBuilder, Workspace,
};

const SPECIES: [&str; 3] = ["beech", "oak", "willow"];

/// A model of kind `situated` with a hidden layer in each network.
fn weights() -> Weights {
    weights_of(false)
}

/// The same, but for apical shoots of beeches that perhaps have no angle of their own.
fn weights_of(straight_beeches: bool) -> Weights {
    let mut draws = draws(11);
    let mut builder = WeightsBuilder::new(ModelKind::Situated, SPECIES);
    let features = situated::len(SPECIES.len());
    let rotation = |slot| (features + situated::rotation_len(slot), situated::ROTATION_OUTPUTS);
    for (name, (inputs, outputs)) in [
        ("existence", (features, situated::CLASSES)),
        ("split", (features + situated::SPLIT_LEN, situated::SPLIT_OUTPUTS)),
        ("reach", (features + REACH_LEN, REACH_OUTPUTS)),
        ("size", (features + SIZE_LEN, situated::SPLIT_OUTPUTS)),
        ("rotation1", rotation(0)),
        ("rotation2", rotation(1)),
        ("rotation3", rotation(2)),
    ] {
        for (layer, (from, to)) in [(inputs, 24), (24, outputs)].into_iter().enumerate() {
            let weight = Table::new(vec![from, to], values(&mut draws, from * to, 0.3)).unwrap();
            let bias = Table::new(vec![to], values(&mut draws, to, 0.3)).unwrap();
            builder.layer(name, layer as u32, weight, bias);
        }
    }
    let mut table = |name: &str, shape: &[usize], least: f32| {
        let random = values(&mut draws, shape.iter().product(), 0.2);
        let mut above: Vec<f32> = random.into_iter().map(|x| least + x.abs()).collect();
        if straight_beeches && name == "rotation_mean" {
            above[..2].fill(0.0);
        }
        builder.table(name, Table::new(shape.to_vec(), above).unwrap());
    };
    let species = SPECIES.len();
    table("rotation_mean", &[species, MAX_CHILDREN, 3], 0.0);
    table("rotation_scale", &[species, MAX_CHILDREN, 3], 0.05);
    table("rolls", &[species, 65], 0.0);
    table("lengths", &[species, LENGTH_ORDERS, 65], 0.9);
    builder.table("tip_radius", Table::new(vec![species], vec![0.01, 0.01, 0.02]).unwrap());
    for (number, name) in SPECIES.into_iter().enumerate() {
        builder.table(format!("roots.{name}"), roots(number as f32));
        let trend = [30.0, 0.1].into_iter().chain([number as f32 + 1.0; TREND_COLUMNS - 2]);
        let trend = Table::new(vec![1, TREND_COLUMNS], trend.collect()).unwrap();
        builder.table(format!("trend.{name}"), trend);
    }
    Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap()
}

/// Twenty roots of one age, and ten of others; the sizes of a species are its number times ten, and
/// a little more from root to root.
fn roots(species: f32) -> Table {
    let row = |i: usize| {
        let size = 10.0 * (species + 1.0) + (i % 5) as f32;
        let (age, gravitropism) = if i < 20 { (30.0 + 4.0 * species, 0.1) } else { (20.0, -0.3) };
        let mut row = [size; ROOT_COLUMNS];
        row[..8].copy_from_slice(&[0.0, 0.0, 0.0, 1.0, 0.1 * size, 1.0, age, gravitropism]);
        row
    };
    Table::new(vec![30, ROOT_COLUMNS], (0..30).flat_map(row).collect()).unwrap()
}

fn share(species: u8, weight: u16) -> Share {
    Share { species, weight }
}

/// What the nodes of a random tree branch into.
fn branchlets(model: &Model, species: usize) -> Vec<Branchlet> {
    let tree = random_tree(4, 40);
    let tip_radius = model.tip_radius(species);
    let conditions = TreeConditions {
        age: 30.0,
        gravitropism: -0.1,
        species,
        tip_radius,
        root_tips: tip_count(tree.root().thickness, tip_radius),
        traits: TreeTraits::of(&tree),
    };
    let (lineage, seed) = (Lineage::ROOT, Seed(3));
    let sense = Sense::default();
    let plan = Plan { reach: 12, nodes: 300 };
    let active = |id| {
        let node = tree.node(id);
        let parent = node.parent.map(|id| tree.node(id));
        let (settled, room) = (None, None);
        Active {
            node,
            parent,
            lineage,
            seed,
            tree: conditions,
            plan,
            sense,
            settled,
            room,
            points: None,
        }
    };
    let frontier: Vec<Active<'_>> = (0..tree.len() as u32).map(active).collect();
    let mut branchlets = Vec::new();
    model.branchlets(&frontier, &mut Workspace::default(), &mut branchlets).unwrap();
    branchlets
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
