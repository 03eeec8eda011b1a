//! A model of kind `situated` with random weights.

use deeptree_graph::signature::inheritance::{REACH_LEN, REACH_OUTPUTS};
use deeptree_graph::signature::situated::{self, CLASSES, LENGTH_ORDERS};
use deeptree_graph::signature::size::SIZE_LEN;
use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{BranchGraph, Lineage, MAX_CHILDREN, Plan, Seed, Sense, TreeTraits};
use deeptree_infer::{
    Active, Branchlet, Model, ModelKind, Predictor, ROOT_COLUMNS, TREND_COLUMNS, Table, Weights,
    WeightsBuilder, Workspace, gain_name,
};

use super::{draws, values};

pub const SPECIES: [&str; 3] = ["beech", "oak", "willow"];

/// A model of kind `situated` with a hidden layer in each network, whose units have gains.
pub fn weights() -> Weights {
    weights_of(false)
}

/// The same, but for apical shoots of beeches that perhaps have no angle of their own.
pub fn weights_of(straight_beeches: bool) -> Weights {
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
        let gains =
            Table::new(vec![SPECIES.len(), 24], values(&mut draws, SPECIES.len() * 24, 1.0));
        builder.table(gain_name(name, 0), gains.unwrap());
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
    // Some branchings are seldom.
    let shares = (0..species * CLASSES).map(|i| if i % 5 == 3 { 0.0 } else { 0.03 });
    let shares = Table::new(vec![species, CLASSES], shares.collect());
    table("rotation_mean", &[species, MAX_CHILDREN, 3], 0.0);
    table("rotation_scale", &[species, MAX_CHILDREN, 3], 0.05);
    table("rolls", &[species, 65], 0.0);
    table("lengths", &[species, LENGTH_ORDERS, 65], 0.9);
    builder.table("branchings", shares.unwrap());
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

/// What is to grow below each node of [`tree`].
pub const PLAN: Plan = Plan { reach: 12, nodes: 300 };

/// A tree that no network has grown.
pub fn tree() -> BranchGraph {
    random_tree(4, 40)
}

/// What the nodes of [`tree`] branch into.
pub fn branchlets(model: &Model, species: usize) -> Vec<Branchlet> {
    let tree = tree();
    let tip_radius = model.tip_radius(species);
    let conditions = TreeConditions {
        age: 30.0,
        gravitropism: -0.1,
        species,
        tip_radius,
        root_tips: tip_count(tree.root().thickness, tip_radius),
        traits: TreeTraits::of(&tree),
        standing: Default::default(),
    };
    let (lineage, seed) = (Lineage::ROOT, Seed(3));
    let sense = Sense::default();
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
            plan: PLAN,
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
