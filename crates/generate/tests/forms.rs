//! Trees that are kept in a volume: what cannot grow at its wall grows elsewhere.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::{depths, shipped};
use deeptree_generate::{Generated, Limits, Request, generate, generate_in};
use deeptree_graph::signature::tip_count;
use deeptree_graph::{NodeId, Seed};
use deeptree_infer::{Model, Predictor, SimdPath, Workspace};
use deeptree_scene::{Environment, Site, Volume};

fn site(volume: Option<Volume>) -> Site {
    Site::new(Environment { volume, ..Environment::default() })
}

fn grown(model: &Model, species: &str, site: &Site, seed: u64, batch: usize) -> Generated {
    let request = Request::new(species, Seed(seed));
    let limits = Limits { batch, ..Limits::default() };
    generate_in(model, &request, site, limits, &mut Workspace::default()).unwrap()
}

#[test]
fn tips_that_cannot_grow_at_a_wall_are_borne_elsewhere() {
    let model = shipped();
    for (name, volume) in [("maple", Volume::Cone), ("pine", Volume::Ring), ("oak", Volume::Cube)] {
        let species = model.species().iter().position(|known| known == name).unwrap();
        let (site, radius) = (site(Some(volume)), model.tip_radius(species));
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
