//! What holds for every stand that the shipped model generates.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::shipped;
use deeptree_generate::{
    GenerateError, Generated, Limits, Planted, Request, StandError, generate, generate_stand,
};
use deeptree_graph::{Seed, Vec3};
use deeptree_infer::{Model, Workspace};

/// A tree of a stand: species, seed, x and z.
type Tree = (&'static str, u64, [f32; 2]);

fn stand(model: &Model, trees: &[Tree], limits: Limits) -> Result<Vec<Generated>, StandError> {
    let requests: Vec<Request> =
        trees.iter().map(|&(species, seed, _)| Request::new(species, Seed(seed))).collect();
    let plan: Vec<Planted<'_>> = requests
        .iter()
        .zip(trees)
        .map(|(request, (.., [x, z]))| Planted { request, at: Vec3::new(*x, 0.0, *z), site: None })
        .collect();
    generate_stand(model, &plan, limits, &Workspace::default())
}

fn grown(model: &Model, trees: &[Tree]) -> Vec<Generated> {
    stand(model, trees, Limits::default()).unwrap()
}

fn alone(model: &Model, species: &str, seed: u64) -> Generated {
    let request = Request::new(species, Seed(seed));
    generate(model, &request, Limits::default(), &mut Workspace::default()).unwrap()
}

#[test]
fn a_tree_that_no_other_reaches_is_the_one_it_is_by_itself() {
    let model = shipped();
    let trees = [("maple", 1, [0.0, 0.0]), ("oak", 2, [70.0, 0.0]), ("pine", 3, [0.0, -500.0])];
    for (found, (species, seed, _)) in grown(&model, &trees).iter().zip(trees) {
        assert_eq!(*found, alone(&model, species, seed), "{species}");
    }
    assert_eq!(grown(&model, &trees[..1]), [alone(&model, "maple", 1)]);
}

#[test]
fn neither_the_order_nor_the_place_nor_batches_change_a_tree() {
    let model = shipped();
    let trees = [
        ("maple", 1, [0.0, 0.0]),
        ("oak", 2, [4.0, 1.0]),
        ("maple", 3, [-2.0, 5.0]),
        ("pine", 4, [3.0, -6.0]),
    ];
    let found = grown(&model, &trees);
    for order in [[3, 2, 1, 0], [2, 0, 3, 1]] {
        let again = grown(&model, &order.map(|i| trees[i]));
        assert!(order.iter().zip(&again).all(|(&i, tree)| *tree == found[i]), "{order:?}");
    }
    // Whole metres: the differences of places are the same to the last bit.
    let moved = trees.map(|(species, seed, [x, z])| (species, seed, [x + 128.0, z - 64.0]));
    assert_eq!(grown(&model, &moved), found);
    assert_eq!(stand(&model, &trees, Limits { batch: 7, ..Limits::default() }).unwrap(), found);
    assert_ne!(found[0], alone(&model, "maple", 1));
}

#[test]
fn the_closer_trees_stand_the_fewer_nodes_they_have() {
    let model = shipped();
    // In the growth model, too: 25 maples 12, 8, 5 and 3 m apart.
    let nodes = |spacing: f32| {
        let place = |i: u64| [spacing * (i % 3) as f32, spacing * (i / 3) as f32];
        let trees: Vec<Tree> = (0..9).map(|i| ("maple", i, place(i))).collect();
        grown(&model, &trees).iter().map(|tree| tree.tree.len()).sum::<usize>()
    };
    let found = [100.0, 12.0, 8.0, 5.0, 3.0].map(nodes);
    assert!(found.is_sorted_by(|a, b| 10 * a > 11 * b), "{found:?}");
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_stand() {
    let model = shipped();
    let trees: Vec<Tree> =
        (0..6).map(|i| ("maple", i, [3.0 * (i % 3) as f32, 3.0 * (i / 3) as f32])).collect();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| grown(&model, &trees))
    };
    assert_eq!(on(1), on(5));
}

#[test]
fn what_cannot_be_grown_names_its_tree() {
    let model = shipped();
    let unknown =
        stand(&model, &[("maple", 1, [0.0, 0.0]), ("elm", 2, [9.0, 4.0])], Limits::default());
    let Err(StandError::Tree { at, source }) = unknown else { panic!("an elm was grown") };
    assert_eq!(at, Vec3::new(9.0, 0.0, 4.0));
    assert!(matches!(source, GenerateError::UnknownSpecies { .. }));
    let nowhere = stand(&model, &[("maple", 1, [0.0, f32::NAN])], Limits::default());
    assert!(matches!(nowhere, Err(StandError::NotFinite { .. })));
    assert_eq!(grown(&model, &[]), []);
    // The budget is that of each tree.
    let limits = Limits { budget: 100, ..Limits::default() };
    let small = stand(&model, &[("maple", 1, [0.0, 0.0]), ("oak", 2, [4.0, 0.0])], limits).unwrap();
    assert!(small.iter().all(|tree| tree.hit_budget && tree.tree.len() <= 100));
}
