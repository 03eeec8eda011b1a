//! Kind `situated`: every factor of the chain rule is a law that is drawn from.
//!
//! `p(children | n) = p(x, r | n) · p(N₁, N₂, N₃ | n, x, r) · p(R₁, R₂, R₃ | n, x, r, N)
//!   · Π p(q_i | n, x, r, N, R_i, q_<i) · p(l_i | o)`
//!
//! with `p(q) = p(roll) · p(swing | roll, …)`.
//!
//! R is the reach: nodes on the longest path below, which children inherit so that growth ends as
//! far out as the root was told.
//!
//! Source: DeepTree §4.2, Eq. 2 to 5. Deviation: laws instead of point estimates, thickness by the
//! pipe model with integer tip counts, and the reach.

use deeptree_graph::signature::inheritance::{
    self, Inheritance, Question, REACH_LEN, REACH_OUTPUTS,
};
use deeptree_graph::signature::situated::{
    self, Branching, CLASSES, LENGTH_ORDERS, ROTATION_OUTPUTS, RotationContext, SPLIT_LEN,
    SPLIT_OUTPUTS, Sibling, Slot, Turn,
};
use deeptree_graph::signature::{thickness_of, tip_count};
use deeptree_graph::{ChildSignature, MAX_CHILDREN, Purpose, Vec2, Vec3, least_reach};

use super::{Active, Branchlet, Overflow, Workspace, network, roots, sampling};
use crate::mlp::Mlp;
use crate::weights::{ReadWeightsError, Table, Weights};

#[derive(Clone, Debug)]
pub(super) struct Situated {
    existence: Mlp,
    split: Mlp,
    reach: Mlp,
    /// One a slot.
    rotations: [Mlp; MAX_CHILDREN],
    /// How rotations lie, by species and slot.
    slots: Vec<[Slot; MAX_CHILDREN]>,
    /// The law of an apical child's roll off its slot's, by species.
    rolls: Table,
    /// The law of lengths, by species and order.
    lengths: Table,
}

/// How often the swing of a child that would end below the ground is drawn, before the branch
/// ends there. The teacher has no node below the ground, and the learner seldom proposes one.
const ATTEMPTS: u64 = 8;

/// What growth must keep to at a node.
#[derive(Clone, Copy)]
struct Plan {
    tips: u32,
    reach: u16,
}

impl Plan {
    /// The plan of a node, which reaches as far as its tips need at least: only a root can have a
    /// plan that cannot be kept otherwise.
    fn of(active: &Active<'_>) -> Self {
        let tips = tip_count(active.node.thickness, active.tree.tip_radius);
        Self { tips, reach: active.reach.max(least_reach(tips)) }
    }
}

/// A node of the frontier on its way to a branchlet.
#[derive(Clone, Copy)]
struct Draft {
    row: usize,
    tips: u32,
    reach: u16,
    branching: Branching,
    child_tips: [u32; MAX_CHILDREN],
    child_reaches: [u16; MAX_CHILDREN],
    siblings: [Option<Sibling>; MAX_CHILDREN],
}

impl Draft {
    /// What is known of the reach of the child in `slot`.
    fn inheritance(&self, slot: usize) -> Inheritance {
        let Self { reach, branching, child_tips, child_reaches, .. } = *self;
        Inheritance { branching, child_tips, reach, slot, earlier: child_reaches }
    }
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
        let per_slot = |name| weights.table(name, &[Some(species), Some(MAX_CHILDREN), Some(3)]);
        let (means, scales) = (per_slot("rotation_mean")?, per_slot("rotation_scale")?);
        for scale in scales.values().chunks_exact(3) {
            roots::check_positive("rotation_scale", &scale[..2])?;
        }
        let slots = (0..species)
            .map(|s| {
                std::array::from_fn(|slot| {
                    let (mean, scale) = (&means.row(s)[3 * slot..], &scales.row(s)[3 * slot..]);
                    Slot {
                        mean: Vec2::from_slice(mean),
                        roll: mean[2],
                        scale: Vec2::from_slice(scale),
                        roll_scale: scale[2],
                    }
                })
            })
            .collect();
        let law = |name: &str, shape: &[Option<usize>]| {
            let table = weights.table(name, shape)?;
            if table.shape().last().is_some_and(|&values| values >= 2) {
                return Ok(table.clone());
            }
            Err(ReadWeightsError::Shape {
                tensor: name.to_owned(),
                shape: table.shape().to_vec(),
                expected: shape.iter().map(|size| size.or(Some(65))).collect(),
            })
        };
        let rolls = law("rolls", &[Some(species), None])?;
        let lengths = law("lengths", &[Some(species), Some(LENGTH_ORDERS), None])?;
        roots::check_positive("lengths", lengths.values())?;
        Ok(Self {
            existence: network(weights, "existence", features, CLASSES)?,
            split: network(weights, "split", features + SPLIT_LEN, SPLIT_OUTPUTS)?,
            reach: network(weights, "reach", features + REACH_LEN, REACH_OUTPUTS)?,
            rotations: [rotation(0)?, rotation(1)?, rotation(2)?],
            slots,
            rolls,
            lengths,
        })
    }

    pub(super) fn weight_count(&self) -> usize {
        let rotations: usize = self.rotations.iter().map(Mlp::weight_count).sum();
        let others = [&self.existence, &self.split, &self.reach].map(Mlp::weight_count);
        others.iter().sum::<usize>() + rotations
    }

    pub(super) fn branchlets(
        &self,
        species: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        branchlets: &mut [Branchlet],
    ) -> Result<(), Overflow> {
        let features = situated::len(species);
        let plans: Vec<Plan> = frontier.iter().map(Plan::of).collect();
        work.encode(frontier, features, |i, active, row| {
            let Active { node, tree, sense, .. } = active;
            situated::encode(node, tree, plans[i].reach, sense, species, row);
        });
        let mut drafts = self.draw_branchings(frontier, &plans, work)?;
        self.draw_splits(features, frontier, work, &mut drafts)?;
        for slot in 0..MAX_CHILDREN {
            self.draw_reaches(slot, features, frontier, work, &mut drafts)?;
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
        plans: &[Plan],
        work: &mut Workspace,
    ) -> Result<Vec<Draft>, Overflow> {
        let logits = work.run_nodes(&self.existence);
        let mut drafts = Vec::with_capacity(frontier.len());
        for (row, (active, logits)) in frontier.iter().zip(logits.chunks_exact(CLASSES)).enumerate()
        {
            let Plan { tips, reach } = plans[row];
            let mut draws = active.seed.draws(active.lineage, Purpose::Existence);
            let possible = |class| Branching::from_class(class).fits(tips, reach);
            let class =
                sampling::categorical(logits, possible, &mut draws).ok_or(Overflow { row })?;
            let branching = Branching::from_class(class);
            if branching.children() > 0 {
                let child_tips = [tips - u32::from(branching.dropped); MAX_CHILDREN];
                drafts.push(Draft {
                    row,
                    tips,
                    reach,
                    branching,
                    child_tips,
                    child_reaches: [0; MAX_CHILDREN],
                    siblings: [None; MAX_CHILDREN],
                });
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
                let taken = sampling::split(outputs, q.tips, q.children, draft.reach, &mut draws)
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

    /// How far the children in `slot` reach.
    fn draw_reaches(
        &self,
        slot: usize,
        features: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        drafts: &mut [Draft],
    ) -> Result<(), Overflow> {
        let mut open = Vec::new();
        for (i, draft) in drafts.iter_mut().enumerate() {
            if !draft.branching.has(slot) {
                continue;
            }
            let known = draft.inheritance(slot);
            match known.question() {
                Question::Settled(reach) => draft.child_reaches[slot] = reach,
                Question::Open { asks_heir, bins, least } => {
                    open.push((i, known, (asks_heir, bins, least)));
                }
            }
        }
        let outputs = work.run(
            &self.reach,
            features,
            &open,
            |(i, ..)| drafts[*i].row,
            |(_, known, _), out| inheritance::encode(known, out),
        );
        for ((i, _, question), outputs) in open.iter().zip(outputs.chunks_exact(REACH_OUTPUTS)) {
            let draft = &mut drafts[*i];
            let active = &frontier[draft.row];
            let mut draws = active.seed.draws(active.lineage, Purpose::ChildReach).at(slot as u64);
            let reach = sampling::reach(outputs, draft.reach - 1, *question, &mut draws);
            draft.child_reaches[slot] = reach.ok_or(Overflow { row: draft.row })?;
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
        let having: Vec<(usize, f32)> = (0..drafts.len())
            .filter(|&i| drafts[i].branching.has(slot))
            .map(|i| (i, self.draw_roll(slot, &frontier[drafts[i].row])))
            .collect();
        let outputs = work.run(
            &self.rotations[slot],
            features,
            &having,
            |&(i, _)| drafts[i].row,
            |&(i, roll), out| {
                let draft = &drafts[i];
                let Active { node, tree, .. } = &frontier[draft.row];
                let context = RotationContext {
                    branching: draft.branching,
                    parent_tips: draft.tips,
                    tips: draft.child_tips[slot],
                    parent_reach: draft.reach,
                    reach: draft.child_reaches[slot],
                    slot: self.slots[tree.species][slot],
                    roll,
                    earlier: &draft.siblings[..slot],
                };
                situated::encode_rotation(node, tree, &context, out);
            },
        );
        for (&(i, roll), outputs) in having.iter().zip(outputs.chunks_exact(ROTATION_OUTPUTS)) {
            let draft = &mut drafts[i];
            let active = &frontier[draft.row];
            let tips = draft.child_tips[slot];
            let (turn, child) = self
                .place_child(slot, active, tips, roll, outputs)
                .ok_or(Overflow { row: draft.row })?;
            draft.siblings[slot] = Some(Sibling { tips, turn });
            branchlets[draft.row].children[slot] = child;
            branchlets[draft.row].reaches[slot] = draft.child_reaches[slot];
        }
        Ok(())
    }

    /// The roll of the child in `slot`, in deviations of the slot. A lateral has none: its bud has
    /// its place on the shoot.
    fn draw_roll(&self, slot: usize, active: &Active<'_>) -> f32 {
        let Slot { roll_scale, .. } = self.slots[active.tree.species][slot];
        if slot > 0 || roll_scale == 0.0 {
            return 0.0;
        }
        let mut draws = active.seed.draws(active.lineage.child(slot as u8), Purpose::ChildRotation);
        sampling::normal_score(self.rolls.row(active.tree.species), &mut draws) / roll_scale
    }

    /// The child in `slot` with its turn; no child when every attempt ends below the ground, and
    /// none of both when the numbers overflow.
    fn place_child(
        &self,
        slot: usize,
        active: &Active<'_>,
        tips: u32,
        roll: f32,
        outputs: &[f32],
    ) -> Option<(Turn, Option<ChildSignature>)> {
        let Active { node, lineage, seed, tree, .. } = active;
        let lineage = lineage.child(slot as u8);
        let order = (usize::from(node.order) + usize::from(slot > 0)).min(LENGTH_ORDERS - 1);
        let lengths = self.lengths.row(tree.species);
        let values = lengths.len() / LENGTH_ORDERS;
        let length = sampling::normal_score(
            &lengths[order * values..][..values],
            &mut seed.draws(lineage, Purpose::ChildLength),
        );
        let mut turn = Turn { swing: Vec2::ZERO, roll };
        for attempt in 0..ATTEMPTS {
            // The first of these draws is the roll's.
            let mut draws = seed.draws(lineage, Purpose::ChildRotation).at(1 + attempt);
            turn.swing = sampling::swing(outputs, slot, &mut draws)?;
            let rotation = self.slots[tree.species][slot].rotation(turn, node, tree.gravitropism);
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
