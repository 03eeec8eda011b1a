//! Kind `situated`, of networks with random weights.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::situated::{PLAN, SPECIES, branchlets, tree, weights};
use deeptree_graph::signature::situated::{Branching, CLASSES};
use deeptree_graph::signature::tip_count;
use deeptree_infer::{Model, Predictor, Table, WeightsBuilder};

/// Whether each node's plan allows a branching, and the subset of children that is drawn for it where
/// the species has no other; without the nodes that could not place all of them.
fn drawn(usual: Branching) -> Vec<(bool, u8)> {
    let mut builder = WeightsBuilder::from_weights(&weights());
    // The others have all but this.
    let mut shares = [[1.0; CLASSES], [0.9e-4; CLASSES], [1.0; CLASSES]];
    shares.iter_mut().for_each(|own| own[usual.class()] = 0.9e-4);
    shares[1][usual.class()] = 1e-4;
    let shares = shares.as_flattened().to_vec();
    builder.table("branchings", Table::new(vec![SPECIES.len(), CLASSES], shares).unwrap());
    let model = Model::from_bytes(&builder.to_bytes().unwrap()).unwrap();
    let all = branchlets(&model, 1);
    let pairs = tree().nodes().to_vec().into_iter().zip(all);
    let placed = pairs.filter(|(_, branchlet)| branchlet.given_up == 0);
    let of = placed.map(|(node, branchlet)| {
        let tips = tip_count(node.thickness, model.tip_radius(1));
        let has = |slot: usize| u8::from(branchlet.children[slot].is_some()) << slot;
        (PLAN.kept(tips).allows(usual, tips), (0..3).map(has).sum())
    });
    of.collect()
}

#[test]
fn what_a_species_has_not_is_drawn_only_where_the_plan_leaves_nothing_else() {
    for subset in [3, 7] {
        let drawn = drawn(Branching { subset, dropped: 0 });
        assert!(drawn.iter().filter(|(allowed, _)| *allowed).count() > 2, "{drawn:?}");
        assert!(drawn.iter().all(|&(allowed, own)| !allowed || own == subset), "{drawn:?}");
    }
    // The plan says that all grow on, so none can end.
    let end = drawn(Branching { subset: 0, dropped: 1 });
    assert!(end.iter().all(|&(allowed, subset)| !allowed && subset != 0), "{end:?}");
    assert!(end.iter().any(|&(_, subset)| subset != end[0].1), "{end:?}");
}
