//! Trees beside a wall, where what cannot grow grows elsewhere, and trees in a volume, whose shoots
//! turn at its bounds.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::{depths, shipped};
use deeptree_generate::{Generated, Limits, Request, generate, generate_in};
use deeptree_graph::signature::tip_count;
use deeptree_graph::{NodeId, Seed, Vec3};
use deeptree_infer::{Model, Predictor, SimdPath, Workspace};
use deeptree_scene::{BoxShape, Cuboid, Environment, Scene, Site, Volume};

fn site(volume: Option<Volume>) -> Site {
    Site::new(Environment { volume, ..Environment::default() })
}

/// A wall two metres from the foot.
fn beside_a_wall() -> Site {
    let (min, max) = (Vec3::new(2.0, 0.0, -12.0), Vec3::new(4.0, 16.0, 12.0));
    let wall = Cuboid::new(BoxShape::Aligned { min, max }).unwrap();
    let scene = Scene::new(vec![wall], Vec::new()).unwrap();
    Site::new(Environment { scene, volume: None })
}

fn grown(model: &Model, species: &str, site: &Site, seed: u64, batch: usize) -> Generated {
    let request = Request::new(species, Seed(seed));
    let limits = Limits { batch, ..Limits::default() };
    generate_in(model, &request, site, limits, &mut Workspace::default()).unwrap()
}

#[test]
fn tips_that_cannot_grow_at_a_wall_are_borne_elsewhere() {
    let model = shipped();
    let site = beside_a_wall();
    for name in ["maple", "pine", "oak"] {
        let species = model.species().iter().position(|known| known == name).unwrap();
        let radius = model.tip_radius(species);
        for seed in 0..3 {
            let Generated { tree, germ, avoided, .. } = grown(&model, name, &site, seed, 512);
            assert!(avoided.given_up > 0);
            assert_eq!(tree.root().thickness, germ.root.signature.thickness);
            let depths = depths(&tree);
            let deepest = *depths.iter().max().unwrap();
            let tips = |id: NodeId| tip_count(tree.node(id).thickness, radius);
            for (id, node) in tree.nodes().iter().enumerate() {
                let borne: u32 = node.children.iter().flatten().map(|&child| tips(child)).sum();
                let own = tips(id as NodeId);
                // A node has three slots, and drops a tip in each that is free; none is left where
                // something has grown on since.
                let is_settled = depths[id] + 2 <= deepest;
                assert!(own >= borne, "{name} {seed}, node {id}: {own} of {borne}");
                assert!(!is_settled || own <= borne + 3, "{name} {seed}, node {id}: {own} {borne}");
            }
        }
    }
}

#[test]
fn in_a_volume_shoots_turn_at_its_bounds_rather_than_end() {
    let model = shipped();
    for (name, volume) in [("maple", Volume::Cone), ("willow", Volume::Ring), ("oak", Volume::Cube)]
    {
        let site = site(Some(volume.clone()));
        for seed in 0..3 {
            let Generated { tree, avoided, .. } = grown(&model, name, &site, seed, 512);
            assert!(tree.nodes()[1..].iter().all(|node| volume.admits(node.position)));
            assert!(avoided.redrawn > tree.len() as u64 / 10, "{name} {seed}: {avoided:?}");
            // A shoot that ends was drawn again eight times before, as one that turns was.
            assert!(16 * avoided.given_up < avoided.redrawn, "{name} {seed}: {avoided:?}");
        }
    }
}

#[test]
fn trees_in_a_cone_have_nearly_the_nodes_that_they_were_told() {
    let model = shipped();
    let site = site(Some(Volume::Cone));
    for name in ["beech", "maple", "walnut"] {
        let trees: Vec<_> = (0..8).map(|seed| grown(&model, name, &site, seed, 512)).collect();
        let told: f32 = trees.iter().map(|tree| tree.germ.root.traits.nodes).sum();
        let grown: usize = trees.iter().map(|tree| tree.tree.len()).sum();
        assert!((grown as f32 / told - 1.0).abs() < 0.12, "{name}: {grown} of {told}");
    }
}

#[test]
fn batches_and_instruction_sets_give_the_same_tree_at_a_wall() {
    let model = shipped();
    let site = site(Some(Volume::Ring));
    let tree = grown(&model, "tulip", &site, 7, 512);
    for batch in [1, 13] {
        assert!(grown(&model, "tulip", &site, 7, batch) == tree, "batch {batch}");
    }
    for path in SimdPath::available() {
        let request = Request::new("tulip", Seed(7));
        let mut work = Workspace::new(path);
        let found = generate_in(&model, &request, &site, Limits::default(), &mut work).unwrap();
        assert!(found == tree, "{path:?}");
    }
}

#[test]
fn where_nothing_stands_the_tree_is_that_of_the_open_field() {
    let (model, site) = (shipped(), site(None));
    for name in ["oak", "willow"] {
        let request = Request::new(name, Seed(3));
        let open = generate(&model, &request, Limits::default(), &mut Workspace::default());
        assert_eq!(grown(&model, name, &site, 3, 512), open.unwrap());
    }
}
