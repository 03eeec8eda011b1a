//! The samples of scanned trees, and batches of them as tensors.

use burn::tensor::{Tensor, TensorData};
use deeptree_graph::signature::points::{self, POINT_LEN, SUMMARY_LEN, encode, summary};
use deeptree_graph::{BranchGraph, Draws, MAX_CHILDREN, Vec3};
use deeptree_infer::Model;

use super::Points;
use super::laws::LAWS;
use super::told::Told;
use crate::Scan;
use crate::rotations::Rotations;

/// One in so many training samples is told of no points, so that the networks know what to say
/// without them.
const ONE_DEAF: u64 = 5;

/// Points of a node that a training step looks at, drawn from those there are: a cloud could as well
/// have fewer.
const POINTS_A_STEP: usize = 96;

/// Scanned trees as they are told, and the samples that they hold.
pub(super) struct Trees<'a> {
    pub(super) trees: &'a [BranchGraph],
    pub(super) told: Vec<Option<Told>>,
    /// Of each law: tree and node.
    pub(super) samples: [Vec<(u32, u32)>; LAWS],
}

impl<'a> Trees<'a> {
    pub(super) fn new(
        trees: &'a [BranchGraph],
        scans: &[Scan],
        species: &[usize],
        model: &Model,
        rotations: &Rotations,
    ) -> Self {
        let each = trees.iter().zip(scans).zip(species);
        let told: Vec<Option<Told>> = each
            .map(|((tree, scan), &species)| Told::new(tree, scan, species, model, rotations))
            .collect();
        let mut samples: [Vec<(u32, u32)>; LAWS] = Default::default();
        let known = told.iter().map(Option::is_some);
        for (number, (tree, _)) in trees.iter().zip(known).enumerate().filter(|(_, t)| t.1) {
            for (id, node) in tree.nodes().iter().enumerate() {
                let spot = (number as u32, id as u32);
                samples[0].push(spot);
                for slot in (0..MAX_CHILDREN).filter(|&slot| node.children[slot].is_some()) {
                    samples[1 + slot].push(spot);
                }
            }
        }
        Self { trees, told, samples }
    }
}

/// The samples of one law in one batch, as tensors.
pub(super) struct Batch {
    /// `[batch · points, POINT_LEN]`, and 1 where there is a point.
    pub(super) places: Tensor<2>,
    pub(super) stands: Tensor<3>,
    pub(super) summary: Tensor<2>,
    /// What the model says.
    pub(super) said: Tensor<2>,
    /// The same as it is told to the network that corrects it.
    pub(super) told: Tensor<2>,
    pub(super) targets: Tensor<2>,
    /// Shape of the points.
    pub(super) rows: usize,
    pub(super) points: usize,
}

impl Batch {
    pub(super) fn autodiff(self) -> Self {
        Self {
            places: self.places.autodiff(),
            stands: self.stands.autodiff(),
            summary: self.summary.autodiff(),
            said: self.said.autodiff(),
            told: self.told.autodiff(),
            targets: self.targets.autodiff(),
            ..self
        }
    }
}

/// Which of the points around a node are told.
#[derive(Clone, Copy)]
pub(super) enum Hears<'a> {
    All,
    Nothing,
    /// Those that are drawn, and of some samples none.
    Some(&'a Draws),
}

impl Hears<'_> {
    fn is_deaf(self, sample: usize) -> bool {
        match self {
            Self::All => false,
            Self::Nothing => true,
            Self::Some(draws) => {
                draws.clone().at(sample as u64).at(1).bits().is_multiple_of(ONE_DEAF)
            }
        }
    }
}

/// Keeps `most` points of more, drawn without replacement.
fn some(points: &mut Vec<Vec3>, most: usize, draws: &mut Draws) {
    if points.len() <= most {
        return;
    }
    for i in 0..most {
        let k = i + (draws.bits() % (points.len() - i) as u64) as usize;
        points.swap(i, k);
    }
    points.truncate(most);
}

impl Points<'_> {
    /// What is heard at some nodes, and what the model says of them.
    pub(super) fn batch_of(
        &self,
        of: &Trees<'_>,
        law: usize,
        spots: &[(u32, u32)],
        hears: Hears<'_>,
    ) -> Batch {
        let laws = &self.laws;
        let (inputs, targets) = (laws.inputs(law), laws.targets(law));
        let mut rows = vec![0.0; spots.len() * inputs];
        let mut wanted = vec![0.0; spots.len() * targets];
        let (mut all, mut near, mut summaries) = (Vec::new(), Vec::new(), Vec::new());
        for (i, &(tree, node)) in spots.iter().enumerate() {
            let Some(told) = &of.told[tree as usize] else { continue };
            let (row, target) =
                (&mut rows[i * inputs..][..inputs], &mut wanted[i * targets..][..targets]);
            laws.encode(law, &of.trees[tree as usize], told, node as usize, row, target);
            let node = &told.nodes[node as usize];
            told.cloud.around(node.position, &mut near);
            if hears.is_deaf(i) {
                near.clear();
            }
            summaries.extend(summary(node, &near));
            if let Hears::Some(draws) = hears {
                some(&mut near, POINTS_A_STEP, &mut draws.clone().at(i as u64));
            }
            let mut places = vec![0.0; near.len() * POINT_LEN];
            for (&point, place) in near.iter().zip(places.chunks_exact_mut(POINT_LEN)) {
                encode(node, point, place);
            }
            all.push(places);
        }
        let points = all.iter().map(Vec::len).max().unwrap_or(0).max(POINT_LEN) / POINT_LEN;
        let mut places = vec![0.0; spots.len() * points * POINT_LEN];
        let mut stands = vec![0.0; spots.len() * points];
        for (i, own) in all.iter().enumerate() {
            places[i * points * POINT_LEN..][..own.len()].copy_from_slice(own);
            stands[i * points..][..own.len() / POINT_LEN].fill(1.0);
        }
        let said = laws.say(law, &rows);
        let told = said.iter().map(|&value| points::said(value)).collect();
        let (count, outputs) = (spots.len(), laws.outputs(law));
        let flat = |values: Vec<f32>, rows: usize, width: usize| -> Tensor<2> {
            Tensor::from_data(TensorData::new(values, [rows, width]), &self.device)
        };
        let stands = TensorData::new(stands, [count, points, 1]);
        Batch {
            places: flat(places, count * points, POINT_LEN),
            stands: Tensor::from_data(stands, &self.device),
            summary: flat(summaries, count, SUMMARY_LEN),
            said: flat(said, count, outputs),
            told: flat(told, count, outputs),
            targets: flat(wanted, count, targets),
            rows: count,
            points,
        }
    }
}
