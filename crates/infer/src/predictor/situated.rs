//! Kind `situated`: every factor of the chain rule is a law that is drawn from.
//!
//! `p(children | n) = p(x, r | n) · p(N₁, N₂, N₃ | n, x, r) · Π p(q_i | n, x, r, N, q_<i) · p(l_i)`
//!
//! Source: DeepTree §4.2, Eq. 2 to 5. Deviation: laws instead of point estimates, and thickness by
//! the pipe model with integer tip counts.

use deeptree_graph::signature::situated::{
    self, Branching, CLASSES, ROTATION_OUTPUTS, SPLIT_LEN, SPLIT_OUTPUTS, Sibling,
};
use deeptree_graph::signature::{thickness_of, tip_count};
use deeptree_graph::{ChildSignature, MAX_CHILDREN, Purpose, Quat, Vec3};

use super::{Active, Branchlet, Overflow, Workspace, network, roots, sampling};
use crate::mlp::Mlp;
use crate::weights::{ReadWeightsError, Table, Weights};

#[derive(Clone, Debug)]
pub(super) struct Situated {
    existence: Mlp,
    split: Mlp,
    /// One a slot.
    rotations: [Mlp; MAX_CHILDREN],
    /// Mean rotation and deviations of the turn, by species and slot.
    slots: Vec<[Slot; MAX_CHILDREN]>,
    length_quantiles: Table,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    mean: Quat,
    scale: Vec3,
}

/// How often the rotation of a child that would end below the ground is drawn, before the branch
/// ends there. The teacher has no node below the ground, and the learner seldom proposes one.
const ATTEMPTS: u64 = 8;

/// A node of the frontier on its way to a branchlet.
#[derive(Clone, Copy)]
struct Draft {
    row: usize,
    tips: u32,
    branching: Branching,
    child_tips: [u32; MAX_CHILDREN],
    siblings: [Option<Sibling>; MAX_CHILDREN],
}

/// "Of `tips` tips, how many does the child in `slot` bear, with `children` left to serve?"
struct SplitQuestion {
    draft: usize,
    slot: usize,
    tips: u32,
    children: u32,
}

impl Situated {
    pub(super) fn new(weights: &Weights) -> Result<Self, ReadWeightsError> {
        let species = weights.species().len();
        let features = situated::len(species);
        let rotation = |slot: usize| {
            let inputs = features + situated::rotation_len(slot);
            network(weights, &format!("rotation{}", slot + 1), inputs, ROTATION_OUTPUTS)
        };
        let per_slot =
            |name, width| weights.table(name, &[Some(species), Some(MAX_CHILDREN), Some(width)]);
        let (means, scales) = (per_slot("rotation_mean", 4)?, per_slot("rotation_scale", 3)?);
        roots::check_positive("rotation_scale", scales.values())?;
        let norm = |q: &[f32]| q.iter().map(|x| x * x).sum::<f32>();
        if let Some(row) = means.values().chunks(4).position(|q| (norm(q) - 1.0).abs() > 1e-3) {
            return Err(ReadWeightsError::NotUnit { tensor: "rotation_mean".to_owned(), row });
        }
        let slots = (0..species)
            .map(|s| {
                std::array::from_fn(|slot| Slot {
                    mean: Quat::from_slice(&means.row(s)[4 * slot..]).normalize(),
                    scale: Vec3::from_slice(&scales.row(s)[3 * slot..]),
                })
            })
            .collect();
        let length_quantiles = weights.table("length_quantiles", &[Some(species), None])?.clone();
        roots::check_positive("length_quantiles", length_quantiles.values())?;
        if length_quantiles.row(0).len() < 2 {
            return Err(ReadWeightsError::Shape {
                tensor: "length_quantiles".to_owned(),
                shape: length_quantiles.shape().to_vec(),
                expected: vec![Some(species), Some(513)],
            });
        }
        Ok(Self {
            existence: network(weights, "existence", features, CLASSES)?,
            split: network(weights, "split", features + SPLIT_LEN, SPLIT_OUTPUTS)?,
            rotations: [rotation(0)?, rotation(1)?, rotation(2)?],
            slots,
            length_quantiles,
        })
    }

    pub(super) fn weight_count(&self) -> usize {
        let rotations: usize = self.rotations.iter().map(Mlp::weight_count).sum();
        self.existence.weight_count() + self.split.weight_count() + rotations
    }

    pub(super) fn branchlets(
        &self,
        species: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        branchlets: &mut [Branchlet],
    ) -> Result<(), Overflow> {
        let features = situated::len(species);
        work.nodes.resize(frontier.len() * features, 0.0);
        for (active, row) in frontier.iter().zip(work.nodes.chunks_exact_mut(features)) {
            situated::encode(active.node, &active.tree, species, row);
        }
        let mut drafts = self.draw_branchings(frontier, work)?;
        self.draw_splits(features, frontier, work, &mut drafts)?;
        for row in work.nodes.chunks_exact_mut(features) {
            row[situated::traits(species)].fill(0.0);
        }
        for slot in 0..MAX_CHILDREN {
            self.draw_children(slot, features, frontier, work, &mut drafts, branchlets)?;
        }
        Ok(())
    }

    /// Which children exist: the nodes that have any.
    fn draw_branchings(
        &self,
        frontier: &[Active<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<Draft>, Overflow> {
        let logits = self.existence.forward(work.path, &work.nodes, &mut work.scratch);
        let mut drafts = Vec::with_capacity(frontier.len());
        for (row, (active, logits)) in frontier.iter().zip(logits.chunks_exact(CLASSES)).enumerate()
        {
            let tips = tip_count(active.node.thickness, active.tree.tip_radius);
            let mut draws = active.seed.draws(active.lineage, Purpose::Existence);
            let possible = |class| Branching::from_class(class).is_possible(tips);
            let class =
                sampling::categorical(logits, possible, &mut draws).ok_or(Overflow { row })?;
            let branching = Branching::from_class(class);
            if branching.children() > 0 {
                let child_tips = [tips - u32::from(branching.dropped); MAX_CHILDREN];
                drafts.push(Draft { row, tips, branching, child_tips, siblings: [None; 3] });
            }
        }
        Ok(drafts)
    }

    /// How the tips are shared: the first child's part, then the second's of the rest; the last
    /// child takes what is left.
    fn draw_splits(
        &self,
        features: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        drafts: &mut [Draft],
    ) -> Result<(), Overflow> {
        let mut questions: Vec<SplitQuestion> = (0..drafts.len())
            .filter(|&i| drafts[i].branching.children() >= 2)
            .map(|draft| SplitQuestion {
                draft,
                slot: next_slot(drafts[draft].branching, 0),
                tips: drafts[draft].child_tips[0],
                children: drafts[draft].branching.children(),
            })
            .collect();
        while !questions.is_empty() {
            let outputs = work.run(
                &self.split,
                features,
                &questions,
                |q| drafts[q.draft].row,
                |q, out| {
                    situated::encode_split(drafts[q.draft].branching, q.slot, q.tips, out);
                },
            );
            let mut more = Vec::new();
            for (q, outputs) in questions.iter().zip(outputs.chunks_exact(SPLIT_OUTPUTS)) {
                let draft = &mut drafts[q.draft];
                let active = &frontier[draft.row];
                let mut draws =
                    active.seed.draws(active.lineage, Purpose::TipSplit).at(q.slot as u64);
                let taken = sampling::split(outputs, q.tips, q.children, &mut draws)
                    .ok_or(Overflow { row: draft.row })?;
                draft.child_tips[q.slot] = taken;
                let slot = next_slot(draft.branching, q.slot + 1);
                let (tips, children) = (q.tips - taken, q.children - 1);
                draft.child_tips[slot] = tips;
                if children >= 2 {
                    more.push(SplitQuestion { draft: q.draft, slot, tips, children });
                }
            }
            questions = more;
        }
        Ok(())
    }

    /// Rotation and length of the children in `slot`.
    fn draw_children(
        &self,
        slot: usize,
        features: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        drafts: &mut [Draft],
        branchlets: &mut [Branchlet],
    ) -> Result<(), Overflow> {
        let having: Vec<usize> =
            (0..drafts.len()).filter(|&i| drafts[i].branching.has(slot)).collect();
        let outputs = work.run(
            &self.rotations[slot],
            features,
            &having,
            |&i| drafts[i].row,
            |&i, out| {
                let Draft { branching, tips, child_tips, siblings, .. } = &drafts[i];
                situated::encode_rotation(
                    *branching,
                    *tips,
                    child_tips[slot],
                    &siblings[..slot],
                    out,
                );
            },
        );
        for (&i, outputs) in having.iter().zip(outputs.chunks_exact(ROTATION_OUTPUTS)) {
            let draft = &mut drafts[i];
            let active = &frontier[draft.row];
            let tips = draft.child_tips[slot];
            let (turn, child) =
                self.place_child(slot, active, tips, outputs).ok_or(Overflow { row: draft.row })?;
            draft.siblings[slot] = Some(Sibling { tips, turn });
            branchlets[draft.row][slot] = child;
        }
        Ok(())
    }

    /// The child in `slot` with its turn; no child when every attempt ends below the ground, and
    /// none of both when the numbers overflow.
    fn place_child(
        &self,
        slot: usize,
        active: &Active<'_>,
        tips: u32,
        outputs: &[f32],
    ) -> Option<(Vec3, Option<ChildSignature>)> {
        let Active { node, lineage, seed, tree } = active;
        let lineage = lineage.child(slot as u8);
        let Slot { mean, scale } = self.slots[tree.species][slot];
        let length = sampling::quantile(
            self.length_quantiles.row(tree.species),
            &mut seed.draws(lineage, Purpose::ChildLength),
        );
        let mut turn = Vec3::ZERO;
        for attempt in 0..ATTEMPTS {
            let mut draws = seed.draws(lineage, Purpose::ChildRotation).at(attempt);
            turn = sampling::turn(outputs, &mut draws)?;
            let rotation = situated::rotation_of(turn, mean, scale);
            let front = node.orientation * (rotation * Vec3::NEG_Z);
            if node.position.y + length * front.y >= 0.0 {
                let thickness = thickness_of(tips, tree.tip_radius);
                return Some((turn, Some(ChildSignature { rotation, thickness, length })));
            }
        }
        Some((turn, None))
    }
}

/// The first existing child at `from` or after.
fn next_slot(branching: Branching, from: usize) -> usize {
    (from..MAX_CHILDREN).find(|&slot| branching.has(slot)).unwrap_or(MAX_CHILDREN - 1)
}
