//! The joint network, and models put together of others.
#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic, as tests do")]

use deeptree_graph::signature::paper::{self, CHILD_LEN, JOINT_LEN};
use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{
    BranchGraph, ChildSignature, Lineage, MAX_CHILDREN, Plan, Quat, Seed, Sense, TreeInfo,
    TreeTraits, Vec3,
};
use deeptree_infer::{
    Active, Model, ModelKind, Predictor, ROOT_COLUMNS, Table, Weights, WeightsBuilder, Workspace,
};

/// A model of one species whose single layer ignores what it reads and says `outputs`.
fn model(kind: ModelKind, networks: &[(&str, usize, &[f32])]) -> Weights {
    let mut root = [1.0; ROOT_COLUMNS];
    root[..4].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
    let mut builder = WeightsBuilder::new(kind, ["oak"]);
    builder.table("tip_radius", Table::new(vec![1], vec![0.01]).unwrap());
    builder.table("roots.oak", Table::new(vec![1, ROOT_COLUMNS], root.to_vec()).unwrap());
    for (name, inputs, outputs) in networks {
        let width = outputs.len();
        let weight = Table::new(vec![*inputs, width], vec![0.0; inputs * width]).unwrap();
        builder.layer(name, 0, weight, Table::new(vec![width], outputs.to_vec()).unwrap());
    }
    Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap()
}

fn children(weights: &Weights) -> [Option<ChildSignature>; MAX_CHILDREN] {
    let model = Model::from_weights(weights).unwrap();
    let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
    let signature = model.roots(0)[0].signature;
    let tree = BranchGraph::new(info, Vec3::ZERO, signature);
    let conditions = TreeConditions {
        age: 1.0,
        gravitropism: 0.0,
        species: 0,
        tip_radius: 0.01,
        root_tips: tip_count(signature.thickness, 0.01),
        traits: TreeTraits::of(&tree),
        standing: Default::default(),
    };
    let (lineage, seed) = (Lineage::ROOT, Seed(3));
    let sense = Sense::default();
    let active = Active {
        node: tree.root(),
        parent: None,
        lineage,
        seed,
        tree: conditions,
        plan: Plan::default(),
        sense,
        settled: None,
        room: None,
        points: None,
    };
    let mut branchlets = Vec::new();
    model.branchlets(&[active], &mut Workspace::default(), &mut branchlets).unwrap();
    branchlets[0].children
}

#[test]
fn the_joint_network_says_which_children_there_are_and_what_they_are_like() {
    let mut outputs = [0.0; JOINT_LEN];
    outputs[..3].copy_from_slice(&[100.0, -100.0, 100.0]);
    outputs[3..3 + CHILD_LEN].copy_from_slice(&[0.0, 3.0, 0.0, 4.0, 0.5, 2.0]);
    outputs[3 + 2 * CHILD_LEN..].copy_from_slice(&[0.0, 0.0, -2.0, 0.0, -1.0, 99.0]);
    let weights = model(ModelKind::Joint, &[("joint", paper::len(1), &outputs)]);
    assert_eq!(weights.kind(), ModelKind::Joint);
    let [first, second, third] = children(&weights);
    let first = first.unwrap();
    assert!(first.rotation.angle_between(Quat::from_xyzw(0.0, 0.6, 0.0, 0.8)) < 1e-6);
    assert_eq!((first.thickness, first.length), (0.5, 2.0));
    assert_eq!(second, None);
    // The guard rails of kind `paper`: thickness above 0, lengths within the growth space.
    let third = third.unwrap();
    assert_eq!((third.thickness, third.length), (1e-4, 64.0));
}

#[test]
fn a_joint_network_of_another_width_is_refused() {
    let weights = model(ModelKind::Joint, &[("joint", paper::len(1), &[0.0; JOINT_LEN - 1])]);
    assert!(Model::from_weights(&weights).unwrap_err().to_string().contains("`joint`"));
}

#[test]
fn a_model_can_take_single_networks_of_another() {
    let features = paper::len(1);
    let of = |logit: f32, length: f32| {
        let child = [0.0, 0.0, 0.0, 1.0, 0.1, length];
        model(
            ModelKind::Paper,
            &[
                ("classifier", features, &[logit; 3]),
                ("regressor1", features, &child),
                ("regressor2", features + CHILD_LEN, &child),
                ("regressor3", features + 2 * CHILD_LEN, &child),
            ],
        )
    };
    let (all, none) = (of(100.0, 1.0), of(-100.0, 2.0));
    let mut builder = WeightsBuilder::from_weights(&all);
    assert_eq!(Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap(), all);
    builder.network_of("regressor2", &none);
    let mixed = Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap();
    assert_eq!(children(&mixed).map(|child| child.unwrap().length), [1.0, 2.0, 1.0]);
    builder.network_of("classifier", &none);
    let mixed = Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap();
    assert_eq!(children(&mixed), [None; 3]);
}
