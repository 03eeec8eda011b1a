//! What holds for trees among obstacles, in volumes and in stands.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_graph::codec::csv::CsvWriter;
use deeptree_graph::{BranchGraph, Seed, Vec3, branches};
use deeptree_growth::{
    Parameters, Planted, Profile, SPECIES, Species, grow, grow_around, grow_stand,
};
use deeptree_scene::{BoxShape, Cuboid, Environment, Scene, SceneMesh, TriangleMesh, Volume};
use sha2::{Digest, Sha256};

fn reference(species: &str) -> Parameters {
    Species::named(species).unwrap().parameters(Profile::Reference).clone()
}

fn young(species: &str) -> Parameters {
    Parameters { age: 24.0, ..reference(species) }
}

fn grown(species: &str, seed: u64, environment: &Environment) -> BranchGraph {
    grow_around(species, &reference(species), Seed(seed), environment).unwrap().tree
}

fn among(scene: Scene) -> Environment {
    Environment { scene, volume: None }
}

/// A wall that hides half of the sky, from x on.
fn slab(x: f32) -> Environment {
    let (min, max) = (Vec3::new(x, 0.0, -100.0), Vec3::new(x + 60.0, 100.0, 100.0));
    let wall = Cuboid::new(BoxShape::Aligned { min, max }).unwrap();
    among(Scene::new(vec![wall], Vec::new()).unwrap())
}

fn bytes(trees: &[BranchGraph]) -> Vec<u8> {
    let mut table = CsvWriter::new(Vec::new()).unwrap();
    for (i, tree) in trees.iter().enumerate() {
        table.write(i as u32, tree).unwrap();
    }
    table.finish().unwrap()
}

fn hash(trees: &[BranchGraph]) -> String {
    Sha256::digest(bytes(trees)).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Mean branch number, and mean x of all nodes.
fn figures(species: &str, environment: &Environment) -> (f64, f64) {
    let (mut number, mut x, mut nodes) = (0, 0.0, 0);
    for seed in 0..6 {
        let tree = grown(species, seed, environment);
        number += branches(&tree).len();
        x += tree.nodes().iter().map(|node| f64::from(node.position.x)).sum::<f64>();
        nodes += tree.len();
    }
    (number as f64 / 6.0, x / nodes as f64)
}

/// Another implementation of the same rules measured, over four trees: beside a wall at x ≥ 3 the
/// mean x of oaks shifts by −3.4 m, of willows by −7.3 and of maples by −1.1, and 40 to 60 % of the
/// branches are missing; with the wall at x ≥ 6 fewer are. Standard errors of the means of so few
/// trees are about a metre for oaks and willows and a third for maples.
#[test]
fn beside_a_wall_trees_lean_away_and_lose_half_of_their_branches() {
    for (species, shift, tolerance) in
        [("oak", -3.4, 1.5), ("willow", -7.3, 2.5), ("maple", -1.1, 0.7)]
    {
        let (open, middle) = figures(species, &Environment::default());
        let (near, moved) = figures(species, &slab(3.0));
        let found = moved - middle;
        assert!((found - shift).abs() < tolerance, "{species}: {found:.2} m, measured {shift}");
        let share = near / open;
        assert!((0.35..=0.65).contains(&share), "{species}: {share:.2} of the branches are left");
        if species != "willow" {
            let (far, _) = figures(species, &slab(6.0));
            assert!(far > near, "{species}: {far} {near}");
        }
    }
}

/// Measured so over few trees: a maple in the cone has 488 branches, against 803 in the open.
#[test]
fn a_maple_in_the_cone_has_the_branches_that_were_measured() {
    let cone = Environment { volume: Some(Volume::Cone), ..Environment::default() };
    let (number, _) = figures("maple", &cone);
    assert!((number / 488.0 - 1.0).abs() < 0.15, "{number}");
}

#[test]
fn no_node_is_inside_an_obstacle_and_no_edge_goes_through_one() {
    let mut near = 0;
    for (k, species) in SPECIES.iter().enumerate() {
        for seed in 0..4 {
            let environment = among(Scene::random(Seed(10 * k as u64 + seed)));
            let tree =
                grow_around(species, &young(species), Seed(seed), &environment).unwrap().tree;
            for node in tree.nodes() {
                assert!(!environment.scene.contains(node.position), "{species} {seed}");
                assert!(!environment.scene.crosses(node.base(), node.position), "{species} {seed}");
                near += usize::from(environment.occupancy().at(node.position));
            }
        }
    }
    assert!(near > 100, "the obstacles stood in no tree's way");
}

#[test]
fn branches_do_not_slip_through_a_sheet() {
    // A sheet without thickness at x = 1.5: no base is ever inside it.
    let sheet = "v 1.5 0 -90\nv 1.5 0 90\nv 1.5 90 90\nv 1.5 90 -90\nf 1 2 3 4\n";
    let mesh = TriangleMesh::from_bytes("sheet.obj", sheet.as_bytes()).unwrap();
    let mesh = SceneMesh { file: "sheet.obj".to_owned(), mesh };
    let environment = among(Scene::new(Vec::new(), vec![mesh]).unwrap());
    for seed in 0..3 {
        let tree = grow_around("maple", &young("maple"), Seed(seed), &environment).unwrap().tree;
        assert!(tree.len() > 50);
        assert!(tree.nodes().iter().all(|node| node.position.x < 1.5), "{seed}");
    }
}

#[test]
fn trees_stay_in_their_volume_and_spread_through_it() {
    for volume in [Volume::Cone, Volume::Cube, Volume::Ring] {
        let environment = Environment { volume: Some(volume.clone()), ..Environment::default() };
        let mut taken = deeptree_graph::Occupancy::EMPTY;
        for seed in 0..4 {
            let tree = grown("maple", seed, &environment);
            for node in tree.nodes() {
                assert!(volume.admits(node.position), "{}: {}", volume.name(), node.position);
                taken.set(deeptree_graph::Voxel::holding(node.position).unwrap());
            }
        }
        let free = deeptree_graph::Occupancy::SIDE.pow(3) - environment.occupancy().count();
        let share = taken.count() as f64 / free as f64;
        assert!(share > 0.6, "{}: {share:.2} of its voxels are reached", volume.name());
    }
}

#[test]
fn the_open_field_is_an_environment_without_anything() {
    let parameters = young("walnut");
    let open = grow("walnut", &parameters, Seed(9)).unwrap();
    let around = grow_around("walnut", &parameters, Seed(9), &Environment::default()).unwrap();
    assert_eq!(open, around);
    // Nor does an obstacle matter that hides no sky and stands in nobody's way.
    let shape =
        BoxShape::Aligned { min: Vec3::new(60.0, 0.0, 0.0), max: Vec3::new(61.0, 0.5, 1.0) };
    let far = among(Scene::new(vec![Cuboid::new(shape).unwrap()], Vec::new()).unwrap());
    assert_eq!(grow_around("walnut", &parameters, Seed(9), &far).unwrap(), open);
}

fn planted<'a>(
    species: &'a str,
    parameters: &'a Parameters,
    seed: u64,
    at: [f32; 2],
) -> Planted<'a> {
    Planted { species, parameters, seed: Seed(seed), at: Vec3::new(at[0], 0.0, at[1]) }
}

#[test]
fn a_tree_that_stands_alone_is_the_tree_by_itself() {
    let (oak, pine) = (young("oak"), young("pine"));
    let alone = [grow("oak", &oak, Seed(1)).unwrap(), grow("pine", &pine, Seed(2)).unwrap()];
    let one = grow_stand(&[planted("oak", &oak, 1, [7.0, -3.0])]).unwrap();
    assert_eq!(one[..], alone[..1]);
    // 300 m apart no crown reaches the other.
    let far = [planted("oak", &oak, 1, [0.0, 0.0]), planted("pine", &pine, 2, [300.0, 0.0])];
    assert_eq!(grow_stand(&far).unwrap()[..], alone[..]);
    assert_eq!(grow_stand(&[]).unwrap(), []);
}

#[test]
fn the_order_of_the_plan_changes_no_tree_and_neighbours_cost_branches() {
    let (oak, maple) = (young("oak"), young("maple"));
    let young_maple = Parameters { age: 15.0, ..maple.clone() };
    let plan = [
        planted("oak", &oak, 1, [0.0, 0.0]),
        planted("maple", &maple, 2, [4.0, 1.0]),
        planted("oak", &oak, 3, [-2.0, 4.5]),
        planted("maple", &young_maple, 4, [1.0, -5.0]),
    ];
    let trees = grow_stand(&plan).unwrap();
    let order = [2, 0, 3, 1];
    let again = grow_stand(&order.map(|i| plan[i].clone())).unwrap();
    for (k, i) in order.into_iter().enumerate() {
        assert_eq!(again[k], trees[i]);
    }
    for (tree, planted) in trees.iter().zip(&plan) {
        let alone = grow(planted.species, planted.parameters, planted.seed).unwrap().tree;
        assert_eq!(tree.tree.info, alone.info);
        let (crowded, free) = (branches(&tree.tree).len(), branches(&alone).len());
        assert!(crowded < free, "{} {:?}: {crowded} {free}", planted.species, planted.seed);
    }
    let moved: Vec<Planted<'_>> = plan
        .iter()
        .map(|tree| Planted { at: tree.at + Vec3::new(64.0, 0.0, -128.0), ..tree.clone() })
        .collect();
    assert_eq!(grow_stand(&moved).unwrap(), trees, "only where the trees are to each other counts");
}

/// The bits of trees in random scenes, in the three volumes and in a stand; see the golden hash of
/// trees in the open field in `invariants.rs`.
const GOLDEN: &str = "7f2f42c77bb38be6ccdc5b8e7b6422d352c2a5a9c91d4d0622c1a917efeaf0b0";

#[test]
fn trees_in_environments_have_the_golden_bits() {
    let maple = young("maple");
    let mut trees: Vec<BranchGraph> = Vec::new();
    for seed in 0..6 {
        let environment = among(Scene::random(Seed(seed)));
        trees.push(grow_around("maple", &maple, Seed(seed), &environment).unwrap().tree);
    }
    for volume in [Volume::Cone, Volume::Cube, Volume::Ring] {
        let environment = Environment { volume: Some(volume), ..Environment::default() };
        trees.push(grow_around("maple", &maple, Seed(0), &environment).unwrap().tree);
    }
    let stand = [planted("maple", &maple, 0, [0.0, 0.0]), planted("maple", &maple, 1, [4.0, 3.0])];
    trees.extend(grow_stand(&stand).unwrap().into_iter().map(|grown| grown.tree));
    assert_eq!(hash(&trees), GOLDEN, "the growth model's trees in environments have changed");
}
