//! Trees of a known law that keep the pipe model, for tests and for timing.

use deeptree_graph::signature::situated::{Slot, Turn};
use deeptree_graph::signature::thickness_of;
use deeptree_graph::{
    BranchGraph, ChildSignature, Draws, Lineage, Node, NodeId, Purpose, Quat, Seed, TreeInfo, Vec2,
    Vec3,
};
use deeptree_learn::{Scan, Scans, TrainingSet};

/// Radius of a twig that bears one tip, in metres, by species.
pub(crate) const TIP_RADIUS: [f32; 2] = [0.01, 0.004];

/// Probability that a node with one tip goes on with an apical child, by order (deeper: the last).
pub(crate) const GOES_ON: [f64; 3] = [0.8, 0.55, 0.3];

/// Probability that a node with two tips or more forks; otherwise one child bears all tips, in
/// slot 0. A fork takes slots 0 and 1, 0 and 2, or all, equally often; the last with three tips or
/// more.
pub(crate) const FORKS: f64 = 0.6;

/// v of all trees: none, so that the mean swing of a slot is that of its law.
const GRAVITROPISM: f32 = 0.0;

/// Deviations of a child's swing from its slot's mean, in radians.
pub(crate) const SPREAD: Vec2 = Vec2::new(0.10, 0.05);

/// Deviation of an apical child's roll, in radians.
pub(crate) const ROLL_SPREAD: f32 = 0.15;

/// How rotations lie in a slot.
pub(crate) fn slot(species: usize, slot: usize) -> Slot {
    Slot {
        mean: Vec2::new(0.5 + 0.3 * species as f32, 0.2),
        roll: 2.1 * slot as f32,
        scale: SPREAD,
        roll_scale: if slot == 0 { ROLL_SPREAD } else { 0.0 },
    }
}

/// Two species, `trees` training trees each and a quarter as many to judge by, that start with
/// 20 to 60 tips. Shares at a fork are uniform; no tip is dropped but at the ends.
pub(crate) fn set(trees: u64) -> TrainingSet {
    let grow = |from: u64, count: u64| {
        (0..2 * count).map(|k| tree(Seed(from + k), (k % 2) as usize)).collect()
    };
    let (train, validation): (Vec<_>, Vec<_>) = (grow(0, trees), grow(1 << 32, trees.div_ceil(4)));
    TrainingSet {
        species: vec!["ash".into(), "elm".into()],
        train_surroundings: vec![None; train.len()],
        validation_surroundings: vec![None; validation.len()],
        train,
        validation,
        data_hash: "synthetic".into(),
    }
}

/// What a scanner sees of a tree: four points of each internode but those of every fifth node.
pub(crate) fn scan(tree: &BranchGraph) -> Scan {
    let mut scan = Scan::default();
    for (id, node) in tree.nodes().iter().enumerate() {
        if id % 5 != 4 {
            for part in [0.2, 0.45, 0.7, 0.95] {
                scan.points.push(node.base().lerp(node.position, part));
                scan.nodes.push(id as NodeId);
            }
        }
    }
    scan
}

/// The scans of the trees of a set.
pub(crate) fn scans(set: &TrainingSet) -> Scans {
    let all = |trees: &[BranchGraph]| trees.iter().map(scan).collect();
    Scans { train: all(&set.train), validation: all(&set.validation) }
}

fn tree(seed: Seed, species: usize) -> BranchGraph {
    let mut draws = seed.draws(Lineage::ROOT, Purpose::Existence);
    let tips = 20 + draws.index(41) as u32;
    let info = TreeInfo {
        species: ["ash", "elm"][species].into(),
        age: 30 + draws.index(10) as u32,
        gravitropism: GRAVITROPISM,
        seed: seed.0,
    };
    let root = ChildSignature {
        rotation: Quat::from_rotation_x(core::f32::consts::FRAC_PI_2),
        thickness: thickness_of(tips, TIP_RADIUS[species]),
        length: 1.0,
    };
    let mut tree = BranchGraph::new(info, Vec3::ZERO, root);
    let mut tips = vec![tips];
    for id in 0.. {
        let Some(&own) = tips.get(id) else { return tree };
        let order = usize::from(tree.nodes()[id].order);
        let shares = shares(own, order, &mut draws);
        let child = |slot: usize| {
            let mut draws = draws.clone().at((3 * id + slot) as u64);
            let parent = &tree.nodes()[id];
            (shares[slot] > 0).then(|| signature(species, slot, shares[slot], parent, &mut draws))
        };
        tree.grow(id as NodeId, [child(0), child(1), child(2)]);
        tips.extend(shares.into_iter().filter(|&tips| tips > 0));
    }
    tree
}

/// Tips of the children by slot.
fn shares(tips: u32, order: usize, draws: &mut Draws) -> [u32; 3] {
    if tips == 1 {
        let on = draws.uniform() < GOES_ON[order.min(GOES_ON.len() - 1)];
        return [u32::from(on), 0, 0];
    }
    if draws.uniform() >= FORKS {
        return [tips, 0, 0];
    }
    let mut some = |most: u32| 1 + draws.index(most as usize) as u32;
    match some(if tips > 2 { 3 } else { 2 }) {
        1 => {
            let first = some(tips - 1);
            [first, tips - first, 0]
        }
        2 => {
            let first = some(tips - 1);
            [first, 0, tips - first]
        }
        _ => {
            let first = some(tips - 2);
            let second = some(tips - first - 1);
            [first, second, tips - first - second]
        }
    }
}

fn signature(
    species: usize,
    number: usize,
    tips: u32,
    parent: &Node,
    draws: &mut Draws,
) -> ChildSignature {
    let mut normal = || draws.normal() as f32;
    let turn = Turn { swing: Vec2::new(normal(), normal()), roll: normal() };
    ChildSignature {
        rotation: slot(species, number).rotation(turn, parent, GRAVITROPISM),
        thickness: thickness_of(tips, TIP_RADIUS[species]),
        length: 0.5 + 0.5 * draws.uniform() as f32,
    }
}
