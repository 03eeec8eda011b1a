//! What the networks make of the points around a node.
//!
//! | tensor | shape | what |
//! |---|---|---|
//! | `points.point.<layer>.weight`, `.bias` | 7 → 16 → 32 | reads one point; the largest of all, and not below 0, goes on |
//! | `points.code.0.weight`, `.bias` | 32 → 12 | from that to the code, with a rectifier after it |
//! | `points.existence.<layer>.…` | 14 + 32 → 16 → 32 | reads code, summary and what `existence` said; is added to it |
//! | `points.rotation1.…` to `3` | 14 + 27 → 16 → 27 | the same for the swings |
//!
//! See [`deeptree_graph::signature::points`] for what is read.

use std::borrow::Cow;

use deeptree_graph::signature::points::{
    self, CODE, POINT_LEN, POINT_WIDTHS, SUMMARY_LEN, encode, summary,
};
use deeptree_graph::signature::situated::{CLASSES, ROTATION_OUTPUTS};
use deeptree_graph::{CloudIndex, MAX_CHILDREN, Node, Vec3};

use crate::kernels::SimdPath;
use crate::mlp::{Mlp, Scratch};
use crate::predictor::network;
use crate::weights::{ReadWeightsError, Weights};

const NAME: &str = "points";

/// Numbers that are told of the points around a node.
const TOLD: usize = CODE + SUMMARY_LEN;

/// The networks that hear of points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hearing {
    point: Mlp,
    code: Mlp,
    pub(crate) existence: Mlp,
    /// One a slot.
    pub(crate) rotations: [Mlp; MAX_CHILDREN],
}

impl Hearing {
    /// The networks of a model; `None` of a model that was not trained on points.
    ///
    /// # Errors
    ///
    /// When one of them is missing, or has another shape than it must have.
    pub(crate) fn read(weights: &Weights) -> Result<Option<Self>, ReadWeightsError> {
        if !weights.has_network(NAME) {
            return Ok(None);
        }
        let network = |name: &str, inputs, outputs| {
            network(weights, &format!("{NAME}.{name}"), inputs, outputs)
        };
        let rotation = |slot: usize| {
            network(&format!("rotation{}", slot + 1), TOLD + ROTATION_OUTPUTS, ROTATION_OUTPUTS)
        };
        Ok(Some(Self {
            point: network("point", POINT_LEN, POINT_WIDTHS[1])?,
            code: network("code", POINT_WIDTHS[1], CODE)?,
            existence: network("existence", TOLD + CLASSES, CLASSES)?,
            rotations: [rotation(0)?, rotation(1)?, rotation(2)?],
        }))
    }

    pub(crate) fn weight_count(&self) -> usize {
        let rotations: usize = self.rotations.iter().map(Mlp::weight_count).sum();
        let others = [&self.point, &self.code, &self.existence].map(Mlp::weight_count);
        others.iter().sum::<usize>() + rotations
    }

    /// What is heard at some nodes, each with the cloud that it stands in; `None` where none has one.
    pub(crate) fn hear<'n>(
        &self,
        path: SimdPath,
        nodes: impl Iterator<Item = (&'n Node, Option<&'n CloudIndex>)>,
    ) -> Option<Heard> {
        let mut heard = Heard { told: Vec::new(), stands: Vec::new(), path };
        let (mut scratch, mut near, mut rows) = (Scratch::new(), Vec::new(), Vec::new());
        for (node, cloud) in nodes {
            heard.stands.push(cloud.is_some());
            let Some(cloud) = cloud else {
                // Nobody reads it.
                heard.told.extend([0.0; TOLD]);
                continue;
            };
            near.clear();
            cloud.around(node.position, &mut near);
            let largest = self.largest(path, node, &near, &mut rows, &mut scratch);
            let code = self.code.forward(path, &largest, &mut scratch);
            heard.told.extend(code.iter().map(|&x| if x > 0.0 { x } else { 0.0 }));
            heard.told.extend(summary(node, &near));
        }
        heard.stands.contains(&true).then_some(heard)
    }

    /// The largest that is said of any point, channel by channel, and not below 0.
    fn largest(
        &self,
        path: SimdPath,
        node: &Node,
        points: &[Vec3],
        rows: &mut Vec<f32>,
        scratch: &mut Scratch,
    ) -> [f32; POINT_WIDTHS[1]] {
        rows.resize(points.len() * POINT_LEN, 0.0);
        for (&point, row) in points.iter().zip(rows.chunks_exact_mut(POINT_LEN)) {
            encode(node, point, row);
        }
        let mut largest = [0.0; POINT_WIDTHS[1]];
        for said in self.point.forward(path, rows, scratch).chunks_exact(POINT_WIDTHS[1]) {
            for (largest, &x) in largest.iter_mut().zip(said) {
                *largest = if x > *largest { x } else { *largest };
            }
        }
        largest
    }
}

/// What is heard at the nodes of a frontier.
#[derive(Clone, Debug)]
pub(crate) struct Heard {
    /// Code and summary of each node.
    told: Vec<f32>,
    /// Does the node stand in a cloud? Otherwise nothing is corrected.
    stands: Vec<bool>,
    path: SimdPath,
}

impl Heard {
    /// Does the node stand in a cloud? Then what is to grow below it is a guess.
    pub(crate) fn is_told(&self, row: usize) -> bool {
        self.stands[row]
    }

    /// What a law's network said, with the correction of the network that hears of points; `rows`
    /// are the nodes of the frontier that it was said of.
    fn correct(&self, by: &Mlp, said: &mut [f32], rows: impl Iterator<Item = usize>) {
        let width = by.outputs();
        let (mut inputs, mut asked) = (Vec::new(), Vec::new());
        for (i, (row, said)) in rows.zip(said.chunks_exact(width)).enumerate() {
            if self.stands[row] {
                inputs.extend(&self.told[row * TOLD..][..TOLD]);
                inputs.extend(said.iter().map(|&value| points::said(value)));
                asked.push(i);
            }
        }
        let mut scratch = Scratch::new();
        let added = by.forward(self.path, &inputs, &mut scratch);
        for (&i, added) in asked.iter().zip(added.chunks_exact(width)) {
            let said = &mut said[i * width..][..width];
            said.iter_mut().zip(added).for_each(|(said, added)| *said += added);
        }
    }
}

/// What a law's network said, corrected where something is heard.
pub(crate) fn corrected<'s>(
    heard: Option<(&Heard, &Mlp)>,
    said: &'s [f32],
    rows: impl Iterator<Item = usize>,
) -> Cow<'s, [f32]> {
    let Some((heard, by)) = heard else { return Cow::Borrowed(said) };
    let mut said = said.to_vec();
    heard.correct(by, &mut said, rows);
    Cow::Owned(said)
}
