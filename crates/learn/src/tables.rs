//! What a model knows besides its networks: laws that are tabulated, not learned.

use deeptree_graph::signature::situated::{CLASSES, LENGTH_ORDERS, MOST_SCORE};
use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{BranchGraph, Kin, Kinsman, MAX_CHILDREN, NodeId};
use deeptree_infer::{ROOT_COLUMNS, ReadWeightsError, Table, WeightsBuilder};

use crate::Surroundings;
use crate::rotations::Rotations;
use crate::set::{Corpus, Spot};

/// Values that a law is kept by, at evenly spaced normal scores.
const SCORES: usize = 65;

/// Radius of the thinnest node of each species: a twig that bears one tip.
pub(crate) fn tip_radii(trees: &[BranchGraph], species: &[usize], count: usize) -> Vec<f32> {
    let mut radii = vec![f32::INFINITY; count];
    for (tree, &species) in trees.iter().zip(species) {
        let thinnest = tree.nodes().iter().map(|node| node.thickness);
        radii[species] = thinnest.fold(radii[species], f32::min);
    }
    radii
}

/// The law by which the training trees of each species in the open field stand among each other.
pub(crate) fn kin(
    trees: &[BranchGraph],
    surroundings: &[Option<Surroundings>],
    species: &[usize],
    tip_radius: &[f32],
) -> Vec<Kin> {
    let mut all = vec![Vec::new(); tip_radius.len()];
    let open = trees.iter().zip(species).zip(surroundings).filter(|(_, around)| around.is_none());
    for ((tree, &species), _) in open {
        let tips = tip_count(tree.root().thickness, tip_radius[species]);
        all[species].push(Kinsman::of(tree, tips));
    }
    all.iter().map(|trees| Kin::fit(trees).rounded()).collect()
}

/// Writes how trees stand among each other.
pub(crate) fn write_kin(model: &mut WeightsBuilder, kin: &[Kin]) -> Result<(), ReadWeightsError> {
    let rows = kin.iter().flat_map(Kin::to_row).collect();
    model.table("kin", Table::new(vec![kin.len(), Kin::COLUMNS], rows)?);
    Ok(())
}

/// The law of each edge length, by species and order, roots left out, in metres: what the vigour of
/// a shoot leaves of its last step. An order without edges has the law of the species.
fn lengths(corpus: &Corpus<'_>, species: usize) -> Vec<f32> {
    let mut lengths = vec![vec![Vec::new(); LENGTH_ORDERS]; species];
    corpus.each_child(|conditions, _, child| {
        lengths[conditions.species][usize::from(child.order).min(LENGTH_ORDERS - 1)]
            .push(child.length);
    });
    let laws = lengths.into_iter().flat_map(|orders| {
        let all = orders.concat();
        orders.into_iter().map(move |own| if own.is_empty() { all.clone() } else { own })
    });
    laws.flat_map(scores).collect()
}

/// The law of an apical child's roll off the centre of its slot, by species, in radians.
fn rolls(corpus: &Corpus<'_>, rotations: &Rotations) -> Vec<f32> {
    let mut rolls = vec![Vec::new(); rotations.slots.len()];
    corpus.each_child(|&TreeConditions { species, .. }, _, child| {
        if child.slot == 0 {
            let slot = rotations.slots[species][0];
            rolls[species].push(slot.split(child.rotation).0 * slot.roll_scale);
        }
    });
    rolls.into_iter().flat_map(scores).collect()
}

/// The law of the angles of buds off the centre of their slot, by species and slot of laterals, in
/// radians; of those that show them.
fn buds(corpus: &Corpus<'_>, rotations: &Rotations) -> Vec<f32> {
    let mut angles = vec![[const { Vec::new() }; MAX_CHILDREN - 1]; rotations.slots.len()];
    corpus.each_child(|conditions, parent, child| {
        let slot = &rotations.slots[conditions.species][usize::from(child.slot)];
        if child.slot > 0 && slot.shows_bud(parent) {
            let turn = rotations.turn(conditions, parent, child);
            angles[conditions.species][usize::from(child.slot) - 1]
                .push(turn.swing.x * slot.scale.x);
        }
    });
    angles.into_iter().flatten().flat_map(scores).collect()
}

/// The values at [`SCORES`] normal scores, `x(Φ(z))` with z evenly from −[`MOST_SCORE`] to
/// [`MOST_SCORE`], linear between order statistics; zeros where there are none.
fn scores(mut values: Vec<f32>) -> [f32; SCORES] {
    values.sort_unstable_by(f32::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return [0.0; SCORES] };
    std::array::from_fn(|i| {
        let score = MOST_SCORE * (2.0 * i as f64 / (SCORES - 1) as f64 - 1.0);
        let share = 0.5 * libm::erfc(-score * core::f64::consts::FRAC_1_SQRT_2);
        let place = (share * values.len() as f64 - 0.5).clamp(0.0, last as f64);
        let (low, part) = (place as usize, place.fract());
        let (a, b) = (f64::from(values[low]), f64::from(values[(low + 1).min(last)]));
        (a + (b - a) * part) as f32
    })
}

/// Roots of a species that a model keeps: the density that new trees start from is fitted to them.
const ROOTS: usize = 800;

/// Writes the tables that all kinds have: the radii of tips, and the roots of training trees, evenly
/// spread over those of each species in the open field: what an environment makes of a tree is told
/// apart from them.
pub(crate) fn write_common(
    model: &mut WeightsBuilder,
    corpus: &Corpus<'_>,
    species: &[String],
    tip_radius: &[f32],
) -> Result<(), ReadWeightsError> {
    model.table("tip_radius", Table::new(vec![species.len()], tip_radius.to_vec())?);
    for (number, name) in species.iter().enumerate() {
        let trees = corpus.trees.iter().zip(&corpus.conditions);
        let open = trees.zip(corpus.surroundings).filter(|(_, around)| around.is_none());
        let own = open.map(|(tree, _)| tree).filter(|(_, own)| own.species == number);
        let trees: Vec<_> = own.collect();
        let kept = trees.len().min(ROOTS);
        let roots: Vec<f32> = (0..kept)
            .map(|i| trees[i * trees.len() / kept])
            .flat_map(|(tree, conditions)| {
                let (root, [x, y, z, w]) = (tree.root(), tree.root().rotation.to_array());
                let shared = [conditions.age, conditions.gravitropism];
                let own = [x, y, z, w, root.thickness, root.length, shared[0], shared[1]];
                own.into_iter().chain(conditions.traits.to_array())
            })
            .collect();
        model.table(
            format!("roots.{name}"),
            Table::new(vec![roots.len() / ROOT_COLUMNS, ROOT_COLUMNS], roots)?,
        );
    }
    Ok(())
}

/// Writes the share of each class of branchings among the nodes of each species in the open field.
pub(crate) fn write_branchings(
    model: &mut WeightsBuilder,
    corpus: &Corpus<'_>,
    species: usize,
) -> Result<(), ReadWeightsError> {
    let mut counts = vec![[0u64; CLASSES]; species];
    for (tree, around) in (0..).zip(corpus.surroundings) {
        if around.is_some() {
            continue;
        }
        let own = &mut counts[corpus.conditions[tree as usize].species];
        for node in 0..corpus.trees[tree as usize].len() as NodeId {
            own[corpus.shares(Spot { tree, node }).branching().class()] += 1;
        }
    }
    let shares = counts.iter().flat_map(|own| {
        let nodes = own.iter().sum::<u64>().max(1) as f64;
        own.map(|count| (count as f64 / nodes) as f32)
    });
    model.table("branchings", Table::new(vec![species, CLASSES], shares.collect())?);
    Ok(())
}

/// Writes the laws of lengths.
pub(crate) fn write_lengths(
    model: &mut WeightsBuilder,
    corpus: &Corpus<'_>,
    species: usize,
) -> Result<(), ReadWeightsError> {
    let lengths = lengths(corpus, species);
    model.table("lengths", Table::new(vec![species, LENGTH_ORDERS, SCORES], lengths)?);
    Ok(())
}

/// Writes the laws of rolls and of the angles of buds, and how rotations lie.
pub(crate) fn write_turns(
    model: &mut WeightsBuilder,
    corpus: &Corpus<'_>,
    rotations: &Rotations,
) -> Result<(), ReadWeightsError> {
    let slots = &rotations.slots;
    let species = slots.len();
    model.table("rolls", Table::new(vec![species, SCORES], rolls(corpus, rotations))?);
    let buds = buds(corpus, rotations);
    model.table("buds", Table::new(vec![species, MAX_CHILDREN - 1, SCORES], buds)?);
    let mean = slots.iter().flatten().flat_map(|slot| slot.mean.extend(slot.roll).to_array());
    let scale =
        slots.iter().flatten().flat_map(|slot| slot.scale.extend(slot.roll_scale).to_array());
    for (name, values) in [("rotation_mean", mean.collect()), ("rotation_scale", scale.collect())] {
        model.table(name, Table::new(vec![species, MAX_CHILDREN, 3], values)?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_of_a_uniform_law_are_the_normal_distribution_function() {
        let values = scores((0..100_000).rev().map(|i| i as f32 / 100_000.0).collect());
        // Φ(−1), Φ(0), Φ(1), Φ(2) from tables.
        for (i, share) in [(24, 0.158_655), (32, 0.5), (40, 0.841_345), (48, 0.977_25)] {
            assert!((values[i] - share).abs() < 2e-5, "{i}: {}", values[i]);
        }
        assert_eq!(scores(vec![2.5]), [2.5; SCORES]);
        assert_eq!(scores(vec![]), [0.0; SCORES]);
    }
}
