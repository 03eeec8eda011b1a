//! Kind `paper`: the classifier and the cascade of regressors as published.
//!
//! Source: DeepTree §4.2, Eq. 2 to 5, and Algorithm 1. Deviation: Algorithm 1 adds a child when
//! α > p_i although the label 1 means "add"; here a child exists when α < p_i.

use deeptree_graph::signature::paper::{self, CHILD_LEN};
use deeptree_graph::{ChildSignature, MAX_CHILDREN, Purpose, Quat};

use super::{Active, Branchlet, Foretold, Known, Overflow, Workspace, laws, network};
use crate::mlp::Mlp;
use crate::weights::{ReadWeightsError, Weights};

/// A regressor can ask for less than nothing; a branch thinner than this cannot be seen.
const MIN_THICKNESS: f32 = 1e-4;

/// A regressor can ask for anything; an edge longer than this leaves the growth space.
const MAX_LENGTH: f32 = 64.0;

#[derive(Clone, Debug)]
pub(super) struct Paper {
    classifier: Mlp,
    regressors: [Mlp; MAX_CHILDREN],
}

impl Paper {
    pub(super) fn new(weights: &Weights) -> Result<Self, ReadWeightsError> {
        let features = paper::len(weights.species().len());
        let regressor = |slot: usize| {
            let inputs = features + slot * CHILD_LEN;
            network(weights, &format!("regressor{}", slot + 1), inputs, CHILD_LEN)
        };
        Ok(Self {
            classifier: network(weights, "classifier", features, MAX_CHILDREN)?,
            regressors: [regressor(0)?, regressor(1)?, regressor(2)?],
        })
    }

    pub(super) fn weight_count(&self) -> usize {
        let regressors: usize = self.regressors.iter().map(Mlp::weight_count).sum();
        self.classifier.weight_count() + regressors
    }

    pub(super) fn foretell(
        &self,
        species: usize,
        known: &[Known<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<Foretold>, Overflow> {
        encode(species, known, |known| &known.active, work);
        let logits = work.run_nodes(&self.classifier);
        foretell_children(logits.chunks_exact(MAX_CHILDREN))
    }

    pub(super) fn branchlets(
        &self,
        species: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        branchlets: &mut [Branchlet],
    ) -> Result<(), Overflow> {
        let features = paper::len(species);
        encode(species, frontier, |active| active, work);
        let mut exists = self.draw_existence(frontier, work)?;
        for ((active, exists), branchlet) in frontier.iter().zip(&mut exists).zip(&mut *branchlets)
        {
            if let Some(settled) = active.settled {
                *exists = settled.put_standing(branchlet);
            }
        }
        for (slot, regressor) in self.regressors.iter().enumerate() {
            let having: Vec<usize> =
                exists.iter().enumerate().filter(|(_, has)| has[slot]).map(|(i, _)| i).collect();
            let outputs = work.run(
                regressor,
                features,
                &having,
                |&i| i,
                |&i, out| {
                    let earlier = branchlets[i].children.iter();
                    for (child, out) in earlier.zip(out.chunks_exact_mut(CHILD_LEN)) {
                        paper::encode_child(child.as_ref(), out);
                    }
                },
            );
            for (&i, outputs) in having.iter().zip(outputs.chunks_exact(CHILD_LEN)) {
                let child = child_signature(outputs).ok_or(Overflow { row: i })?;
                branchlets[i].children[slot] = Some(child);
            }
        }
        Ok(())
    }

    fn draw_existence(
        &self,
        frontier: &[Active<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<[bool; MAX_CHILDREN]>, Overflow> {
        let logits = work.run_nodes(&self.classifier);
        frontier
            .iter()
            .zip(logits.chunks_exact(MAX_CHILDREN))
            .enumerate()
            .map(|(row, (active, logits))| draw_children(active, logits).ok_or(Overflow { row }))
            .collect()
    }
}

/// Encodes the node of each item.
pub(super) fn encode<'a, T>(
    species: usize,
    items: &'a [T],
    of: impl Fn(&'a T) -> &'a Active<'a>,
    work: &mut Workspace,
) {
    work.encode(items, paper::len(species), |_, item, row| {
        let active = of(item);
        paper::encode(active.node, &active.tree, species, row);
    });
}

/// Which children a node has, from the logits of the three; none when they overflowed.
pub(super) fn draw_children(active: &Active<'_>, logits: &[f32]) -> Option<[bool; MAX_CHILDREN]> {
    if logits.iter().any(|logit| logit.is_nan()) {
        return None;
    }
    let mut draws = active.seed.draws(active.lineage, Purpose::Existence);
    Some(std::array::from_fn(|slot| {
        let p = 1.0 / (1.0 + libm::expf(-logits[slot]));
        (draws.uniform() as f32) < p
    }))
}

/// What the logits of the three children of each node say of them; of a regressed signature there
/// is no law.
pub(super) fn foretell_children<'a>(
    rows: impl Iterator<Item = &'a [f32]>,
) -> Result<Vec<Foretold>, Overflow> {
    let foretell = |(row, logits): (usize, &[f32])| {
        let children = std::array::from_fn(|slot| laws::logistic(f64::from(logits[slot])));
        if logits.iter().any(|logit| logit.is_nan()) {
            return Err(Overflow { row });
        }
        Ok(Foretold { children, ..Foretold::default() })
    };
    rows.enumerate().map(foretell).collect()
}

/// The guard rails: a unit quaternion, a thickness above 0, and a length within the growth space.
pub(super) fn child_signature(outputs: &[f32]) -> Option<ChildSignature> {
    if !outputs.iter().all(|x| x.is_finite()) {
        return None;
    }
    let rotation = Quat::from_slice(outputs);
    let norm = rotation.length();
    Some(ChildSignature {
        rotation: if norm > 1e-6 { rotation / norm } else { Quat::IDENTITY },
        thickness: outputs[4].clamp(MIN_THICKNESS, MAX_LENGTH),
        length: outputs[5].clamp(0.0, MAX_LENGTH),
    })
}
