//! Kind `situated`, of networks with random weights.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::situated::{PLAN, SPECIES, branchlets, tree, weights};
use deeptree_graph::signature::situated::{Branching, CLASSES, Turn};
use deeptree_graph::signature::tip_count;
use deeptree_graph::{Kin, Kinsman, MAX_CHILDREN, Share, Vec3};
use deeptree_infer::{Model, Predictor, ReadWeightsError, Table, Weights, WeightsBuilder};

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

#[test]
fn laterals_stand_at_the_angles_of_their_buds() {
    let law = |angle: f32| {
        let mut builder = WeightsBuilder::from_weights(&weights());
        let shape = vec![SPECIES.len(), MAX_CHILDREN - 1, 2];
        let angles = vec![angle; SPECIES.len() * (MAX_CHILDREN - 1) * 2];
        builder.table("buds", Table::new(shape, angles).unwrap());
        // Laterals do not roll.
        let shape = [Some(SPECIES.len()), Some(MAX_CHILDREN), Some(3)];
        let table = weights().table("rotation_scale", &shape).unwrap().clone();
        let mut scales = table.values().to_vec();
        for slots in scales.chunks_exact_mut(3 * MAX_CHILDREN) {
            (slots[5], slots[8]) = (0.0, 0.0);
        }
        builder.table("rotation_scale", Table::new(table.shape().to_vec(), scales).unwrap());
        Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap()
    };
    let (tree, mut seen) = (tree(), 0);
    for angle in [0.05, 0.2] {
        let model = Model::from_weights(&law(angle)).unwrap();
        let slots = law(angle).slots().unwrap()[1];
        for (parent, branchlet) in tree.nodes().iter().zip(branchlets(&model, 1)) {
            for (slot, child) in slots.iter().zip(branchlet.children) {
                let Some(child) = child.filter(|_| slot.shows_bud(parent)) else { continue };
                let turn = slot.turn(child.rotation, parent, -0.1);
                let bud = parent.orientation * slot.rotation(Turn::default(), parent, -0.1);
                // Nearly upright planes and nearly vertical fronts tell angles less well.
                let front = parent.orientation * child.rotation * Vec3::NEG_Z;
                if (bud * Vec3::X).y.abs() > 0.1 && front.y.abs() < 0.99 {
                    let found = turn.swing.x * slot.scale.x;
                    assert!((found - angle).abs() < 1e-3, "{found} {angle}");
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn laws_of_kin_are_read_and_blended_and_broken_ones_refused() {
    let kinsman = |i: usize, size: f64| {
        let numbers = std::array::from_fn(|k| size + k as f64 + ((i * (k + 3)) % 11) as f64);
        Kinsman { age: 30.0, gravitropism: -0.1, numbers }
    };
    let law = |size: f64| Kin::fit(&(0..100).map(|i| kinsman(i, size)).collect::<Vec<_>>());
    let rows = |laws: &[Kin]| laws.iter().flat_map(Kin::to_row).collect::<Vec<f32>>();
    let with = |rows: Vec<f32>| {
        let mut builder = WeightsBuilder::from_weights(&weights());
        let table = Table::new(vec![SPECIES.len(), rows.len() / SPECIES.len()], rows).unwrap();
        builder.table("kin", table);
        Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap()
    };
    let laws = [2.0, 5.0, 14.0].map(law);
    let sound = with(rows(&laws));
    let model = Model::from_weights(&sound).unwrap();
    assert_eq!(model.kin(1), Some(&laws[1].rounded()));
    assert_eq!(Model::from_weights(&weights()).unwrap().kin(1), None);

    // Between laws that differ by where they are, a tree between stands as one of either does.
    let half = |species| Share { species, weight: 1 };
    let blend = Model::from_weights(&sound.blend(&[half(0), half(2)]).unwrap()).unwrap();
    let [between, own] =
        [blend.kin(0).unwrap().standing(&kinsman(7, 8.0)), laws[0].standing(&kinsman(7, 2.0))];
    assert!(between.iter().zip(own).all(|(a, b)| (a - b).abs() < 1e-2), "{between:?} {own:?}");

    let mut broken = rows(&laws);
    // The last of the triangle is on its diagonal.
    broken[2 * Kin::COLUMNS - 1] *= -1.0;
    let refused = Model::from_weights(&with(broken));
    assert!(matches!(refused, Err(ReadWeightsError::NotKin { row: 1 })), "{refused:?}");
    let short = rows(&laws)[..3 * (Kin::COLUMNS - 1)].to_vec();
    assert!(Model::from_weights(&with(short)).is_err());
}
