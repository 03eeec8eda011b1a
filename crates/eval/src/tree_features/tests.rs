use super::*;
use deeptree_graph::Seed;
use deeptree_growth::{Parameters, Profile, SPECIES, Species, grow};

fn edge(rotation: Quat, length: f32) -> Option<ChildSignature> {
    Some(ChildSignature { rotation, thickness: 0.02, length })
}

/// A trunk of two upright 1 m internodes; at the first a lateral of 0.5 m at 60°.
fn hand_made() -> BranchGraph {
    let info = TreeInfo { species: "oak".into(), age: 2, gravitropism: 0.0, seed: 0 };
    let up = Quat::from_rotation_x(90f32.to_radians());
    let root = ChildSignature { rotation: up, thickness: 0.04, length: 1.0 };
    let mut tree = BranchGraph::new(info, Vec3::new(3.0, 1.0, -2.0), root);
    let side = Quat::from_rotation_x(-60f32.to_radians());
    let rolled = Quat::from_rotation_z(0.4);
    tree.grow(0, [edge(rolled, 1.0), edge(side, 0.5), None]);
    tree
}

fn feature(tree: &BranchGraph, name: &str) -> f64 {
    let index = names().iter().position(|known| known == name).expect(name);
    tree_features(tree)[index]
}

fn grown(species: &str, seed: u64) -> BranchGraph {
    let parameters = Species::named(species).unwrap().parameters(Profile::Reference).clone();
    let parameters = Parameters { age: 16.0, ..parameters };
    grow(species, &parameters, Seed(seed)).unwrap().tree
}

#[test]
fn names_are_unique_and_as_many_as_the_features() {
    let mut unique = names().to_vec();
    unique.sort();
    unique.dedup();
    assert_eq!(unique.len(), names().len());
    assert_eq!(tree_features(&hand_made()).len(), names().len());
    assert!((100..=250).contains(&names().len()), "{} features", names().len());
}

#[test]
fn features_of_a_hand_made_tree_are_those_worked_out_by_hand() {
    let tree = hand_made();
    let sin60 = 3f64.sqrt() / 2.0;
    let expected = [
        ("nodes", 3.0),
        ("branches", 2.0),
        ("ends", 2.0),
        ("height", 2.0),
        ("crown/base", 0.5),
        ("crown/radius", 0.5 * sin60),
        ("trunk/length", 2.0),
        ("trunk/thickness", 0.04),
        ("trunk/lean", 0.0),
        ("trunk/straightness", 1.0),
        ("path/mean", 1.75),
        ("path/max", 2.0),
        ("branch_length/mean", 1.25),
        ("branch_length/q10", 0.65),
        ("branching_distance/mean", 2.5 / 3.0),
        ("angle_1/mean", 0.0),
        ("angle_2/mean", 60f64.to_radians()),
        ("angle_3/mean", 0.0),
        ("roll/mean", 0.4),
        ("roll/sin", 0.4f64.sin()),
        ("thickness_ratio/apical/mean", 0.5),
        ("tips/largest_share/mean", 0.5),
        ("children/011", 1.0 / 3.0),
        ("children/000", 2.0 / 3.0),
        ("lean/nodes", 1.0),
        ("at_height/bin9", 1.0 / 3.0),
        ("at_height/bin5", 1.0 / 3.0),
        ("at_radius/bin9", 1.0 / 3.0),
        ("o0/nodes", 2.0),
        ("o0/direction", 1.0),
        ("o0/height", 1.5),
        ("o1/branches", 1.0),
        ("o1/direction", 0.5),
        ("o1/height", 1.25),
        ("o1/radius", 0.5 * sin60),
        ("o4/nodes", 0.0),
    ];
    for (name, value) in expected {
        let found = feature(&tree, name);
        assert!((found - value).abs() < 1e-5, "{name}: {found}, by hand {value}");
    }
}

#[test]
fn features_of_all_species_and_of_a_stump_are_finite() {
    let trees = SPECIES.iter().map(|species| grown(species, 7)).chain([stump()]);
    for tree in trees {
        assert!(tree_features(&tree).iter().all(|x| x.is_finite()), "{}", tree.info.species);
    }
}

#[test]
fn a_tree_turned_about_the_vertical_keeps_its_features() {
    let tree = grown("oak", 3);
    let turn = Quat::from_rotation_y(std::f32::consts::PI / 8.0);
    let mut root = edge(turn * tree.root().rotation, tree.root().length).unwrap();
    root.thickness = tree.root().thickness;
    let mut turned = BranchGraph::new(tree.info.clone(), Vec3::ZERO, root);
    for (id, node) in tree.nodes().iter().enumerate().filter(|(_, node)| node.child_count() > 0) {
        let signature = |child: Option<u32>| {
            let child = tree.node(child?);
            let mut signature = edge(child.rotation, child.length)?;
            signature.thickness = child.thickness;
            Some(signature)
        };
        turned.grow(id as u32, node.children.map(signature));
    }
    let pairs = tree_features(&tree).into_iter().zip(tree_features(&turned)).zip(names());
    for ((before, after), name) in pairs {
        // Bins may change by nodes whose height rounding moves over an edge.
        let tolerance = if name.contains("bin") { 5e-3 } else { 1e-3 * (1.0 + before.abs()) };
        assert!((before - after).abs() < tolerance, "{name}: {before}, turned {after}");
    }
}
