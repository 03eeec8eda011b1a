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

mod bounds;
mod foretelling;
mod tables;

use deeptree_graph::signature::inheritance::{
    self, Inheritance, Question, REACH_LEN, REACH_OUTPUTS,
};
use deeptree_graph::signature::situated::{
    self, Branching, CLASSES, LENGTH_ORDERS, ROTATION_OUTPUTS, RotationContext, SPLIT_LEN,
    SPLIT_OUTPUTS, Sibling, Slot, Turn,
};
use deeptree_graph::signature::size::{self, Bequest, SIZE_LEN, Size};
use deeptree_graph::signature::{thickness_of, tip_count};
use deeptree_graph::{ChildSignature, MAX_CHILDREN, Passage, Plan, Purpose, Quat, Vec2, Vec3};

use super::{Active, Branchlet, Overflow, Workspace, network, sampling};
use crate::mlp::Mlp;
use crate::points::{Hearing, corrected};
use crate::weights::{ReadWeightsError, Table, Weights, check_positive};

#[derive(Clone, Debug)]
pub(super) struct Situated {
    existence: Mlp,
    split: Mlp,
    reach: Mlp,
    size: Mlp,
    /// One a slot.
    rotations: [Mlp; MAX_CHILDREN],
    /// Which branchings are not seldom in a species, by class: see [`LEAST_SHARE`].
    usual: Vec<[bool; CLASSES]>,
    /// How rotations lie, by species and slot.
    slots: Vec<[Slot; MAX_CHILDREN]>,
    /// The law of an apical child's roll off its slot's, by species.
    rolls: Table,
    /// The law of lengths, by species and order.
    lengths: Table,
    /// The law of the angles of buds off their slot's, by species and slot of laterals; none where
    /// the networks of rotations tell them.
    buds: Option<Table>,
    /// What corrects the networks by the points around a node.
    hearing: Option<Box<Hearing>>,
}

/// How often the swing of a child that would end below the ground, enter an obstacle or leave its
/// volume is drawn, before the branch ends there; or turns back, if the last of them would leave a volume. The teacher has no such
/// node, and the learner seldom proposes one that is in the ground or in an obstacle.
const ATTEMPTS: u64 = 8;

/// A branching that a smaller share of the nodes of its species have is drawn only where the plan
/// leaves nothing else, or where points are heard, which make the plan a guess. A network gives it some probability where it has seen little, such as near the ground: twigs of one tip whose only
/// child is a lateral stood 50 times too often in oaks.
const LEAST_SHARE: f32 = 1e-4;

/// The tips that a node bears, and the nearest plan to its own that it can keep with them.
fn tips_and_plan(active: &Active<'_>) -> (u32, Plan) {
    let tips = tip_count(active.node.thickness, active.tree.tip_radius);
    (tips, active.plan.kept(tips))
}

/// A node of the frontier on its way to a branchlet.
#[derive(Clone, Copy)]
struct Draft {
    row: usize,
    tips: u32,
    plan: Plan,
    branching: Branching,
    child_tips: [u32; MAX_CHILDREN],
    child_reaches: [u16; MAX_CHILDREN],
    child_nodes: [u32; MAX_CHILDREN],
    siblings: [Option<Sibling>; MAX_CHILDREN],
}

impl Draft {
    /// What is known of the reach of the child in `slot`.
    fn inheritance(&self, slot: usize) -> Inheritance {
        let Self { plan, branching, child_tips, child_reaches, .. } = *self;
        Inheritance { branching, child_tips, reach: plan.reach, slot, earlier: child_reaches }
    }

    /// What is known of the nodes below the child in `slot`.
    fn bequest(&self, slot: usize) -> Bequest {
        let Self { plan, branching, child_tips, child_reaches, child_nodes, .. } = *self;
        let (nodes, earlier) = (plan.nodes, child_nodes);
        Bequest { branching, child_tips, child_reaches, nodes, slot, earlier }
    }

    /// What is to grow below the child in `slot`.
    fn child_plan(&self, slot: usize) -> Plan {
        Plan { reach: self.child_reaches[slot], nodes: self.child_nodes[slot] }
    }
}

/// A child that was given its place, or given up.
struct Placed {
    turn: Turn,
    /// None when every attempt ends below the ground or where no branch can go.
    child: Option<ChildSignature>,
    /// How often it was drawn again.
    redrawn: u8,
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
        check_positive("lengths", lengths.values())?;
        let laterals = [Some(species), Some(MAX_CHILDREN - 1), None];
        let buds = match weights.any_table("buds") {
            Some(_) => Some(law("buds", &laterals)?),
            None => None,
        };
        let usual = match weights.any_table("branchings") {
            Some(_) => {
                let shares = weights.table("branchings", &[Some(species), Some(CLASSES)])?;
                let share = |species, class: usize| shares.row(species)[class];
                let row =
                    |species| std::array::from_fn(|class| share(species, class) >= LEAST_SHARE);
                (0..species).map(row).collect()
            }
            None => vec![[true; CLASSES]; species],
        };
        Ok(Self {
            existence: network(weights, "existence", features, CLASSES)?,
            split: network(weights, "split", features + SPLIT_LEN, SPLIT_OUTPUTS)?,
            reach: network(weights, "reach", features + REACH_LEN, REACH_OUTPUTS)?,
            size: network(weights, "size", features + SIZE_LEN, SPLIT_OUTPUTS)?,
            rotations: [rotation(0)?, rotation(1)?, rotation(2)?],
            usual,
            slots: weights.slots()?,
            rolls,
            lengths,
            buds,
            hearing: Hearing::read(weights)?.map(Box::new),
        })
    }

    pub(super) fn weight_count(&self) -> usize {
        let rotations: usize = self.rotations.iter().map(Mlp::weight_count).sum();
        let others = [&self.existence, &self.split, &self.reach, &self.size].map(Mlp::weight_count);
        let hearing = self.hearing.as_ref().map_or(0, |hearing| hearing.weight_count());
        others.iter().sum::<usize>() + rotations + hearing
    }

    pub(super) const fn hears_points(&self) -> bool {
        self.hearing.is_some()
    }

    /// Notes what is heard at the nodes of a frontier.
    fn hear<'a>(
        &self,
        frontier: impl Iterator<Item = &'a Active<'a>> + Clone,
        work: &mut Workspace,
    ) {
        let is_any = frontier.clone().any(|active| active.points.is_some());
        let hearing = self.hearing.as_ref().filter(|_| is_any);
        let places = frontier.map(|active| (active.node, active.points));
        work.heard = hearing.and_then(|hearing| hearing.hear(work.path, places));
    }

    pub(super) fn branchlets(
        &self,
        species: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        branchlets: &mut [Branchlet],
    ) -> Result<(), Overflow> {
        let features = situated::len(species);
        let plans: Vec<(u32, Plan)> = frontier.iter().map(tips_and_plan).collect();
        work.encode(frontier, features, |i, active, row| encode(active, plans[i].1, species, row));
        self.hear(frontier.iter(), work);
        let mut drafts = self.draw_branchings(frontier, &plans, work)?;
        self.draw_splits(features, frontier, work, &mut drafts)?;
        for slot in 0..MAX_CHILDREN {
            self.draw_reaches(slot, features, frontier, work, &mut drafts)?;
        }
        for slot in 0..MAX_CHILDREN {
            self.draw_sizes(slot, features, frontier, work, &mut drafts)?;
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
        plans: &[(u32, Plan)],
        work: &mut Workspace,
    ) -> Result<Vec<Draft>, Overflow> {
        let heard = work.heard.take();
        let by = heard.as_ref().zip(self.hearing.as_ref().map(|hearing| &hearing.existence));
        let logits = corrected(by, work.run_nodes(&self.existence), 0..frontier.len());
        let mut drafts = Vec::with_capacity(frontier.len());
        for (row, (active, logits)) in frontier.iter().zip(logits.chunks_exact(CLASSES)).enumerate()
        {
            let (tips, plan) = plans[row];
            if let Some(settled) = active.settled {
                let tip_radius = active.tree.tip_radius;
                drafts.push(Draft {
                    row,
                    tips,
                    plan,
                    branching: settled.branching(tips, tip_radius),
                    child_tips: settled.child_tips(tip_radius),
                    child_reaches: settled.child_plans().map(|plan| plan.reach),
                    child_nodes: settled.child_plans().map(|plan| plan.nodes),
                    siblings: [None; MAX_CHILDREN],
                });
                continue;
            }
            let mut draws = active.seed.draws(active.lineage, Purpose::Existence);
            // Where points are heard, the plan is a guess, which what they say may contradict.
            let is_guess = heard.as_ref().is_some_and(|heard| heard.is_told(row));
            // What earlier draws have left may not be kept to the node.
            let allows = |class| plan.allows(Branching::from_class(class), tips);
            let usual = |class| allows(class) && self.usual[active.tree.species][class];
            let (is_kept, is_usual) = ((0..CLASSES).any(allows), (0..CLASSES).any(usual));
            let fits = |class| Branching::from_class(class).fits(tips, plan.reach);
            let possible = |class| match (is_guess, is_usual, is_kept) {
                (true, ..) => Branching::from_class(class).is_ever_possible(),
                (_, true, _) => usual(class),
                (_, _, true) => allows(class),
                (_, _, false) => fits(class),
            };
            let class =
                sampling::categorical(logits, possible, &mut draws).ok_or(Overflow { row })?;
            let branching = Branching::from_class(class);
            let (tips, plan) = if is_guess { plan.bent_to(branching, tips) } else { (tips, plan) };
            if branching.children() > 0 {
                let child_tips = [tips - u32::from(branching.dropped); MAX_CHILDREN];
                drafts.push(Draft {
                    row,
                    tips,
                    plan,
                    branching,
                    child_tips,
                    child_reaches: [0; MAX_CHILDREN],
                    child_nodes: [0; MAX_CHILDREN],
                    siblings: [None; MAX_CHILDREN],
                });
            }
        }
        work.heard = heard;
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
            .filter(|&i| frontier[drafts[i].row].settled.is_none())
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
                let taken =
                    sampling::split(outputs, q.tips, q.children, draft.plan.reach, &mut draws)
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
            if !draft.branching.has(slot) || frontier[draft.row].settled.is_some() {
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
            let reach = sampling::reach(outputs, draft.plan.reach - 1, *question, &mut draws);
            draft.child_reaches[slot] = reach.ok_or(Overflow { row: draft.row })?;
        }
        Ok(())
    }

    /// How many nodes grow below the children in `slot`.
    fn draw_sizes(
        &self,
        slot: usize,
        features: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        drafts: &mut [Draft],
    ) -> Result<(), Overflow> {
        let mut open = Vec::new();
        for (i, draft) in drafts.iter_mut().enumerate() {
            if !draft.branching.has(slot) || frontier[draft.row].settled.is_some() {
                continue;
            }
            let known = draft.bequest(slot);
            match known.question() {
                Size::Settled(nodes) => draft.child_nodes[slot] = nodes,
                Size::Open { least, most } => open.push((i, known, (least, most))),
            }
        }
        let outputs = work.run(
            &self.size,
            features,
            &open,
            |(i, ..)| drafts[*i].row,
            |(_, known, _), out| size::encode(known, out),
        );
        for ((i, _, bounds), outputs) in open.iter().zip(outputs.chunks_exact(SPLIT_OUTPUTS)) {
            let draft = &mut drafts[*i];
            let active = &frontier[draft.row];
            let mut draws = active.seed.draws(active.lineage, Purpose::ChildSize).at(slot as u64);
            let nodes = sampling::count(outputs, *bounds, &mut draws);
            draft.child_nodes[slot] = nodes.ok_or(Overflow { row: draft.row })?;
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
        for draft in drafts.iter_mut() {
            let active = &frontier[draft.row];
            let Some(child) = active.settled.and_then(|settled| settled.standing()[slot]) else {
                continue;
            };
            let law = self.slots[active.tree.species][slot];
            let turn = law.turn(child.rotation, active.node, active.tree.gravitropism);
            draft.siblings[slot] = Some(Sibling { tips: draft.child_tips[slot], turn });
            branchlets[draft.row].children[slot] = Some(child);
            branchlets[draft.row].plans[slot] = draft.child_plan(slot);
        }
        let having: Vec<(usize, f32)> = (0..drafts.len())
            .filter(|&i| drafts[i].branching.has(slot) && drafts[i].siblings[slot].is_none())
            .map(|i| (i, self.draw_roll(slot, &frontier[drafts[i].row])))
            .collect();
        let heard = work.heard.take();
        let by = heard.as_ref().zip(self.hearing.as_ref().map(|hearing| &hearing.rotations[slot]));
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
                    parent_reach: draft.plan.reach,
                    plan: draft.child_plan(slot),
                    slot: self.slots[tree.species][slot],
                    roll,
                    own: self.own_turn(&frontier[draft.row]),
                    earlier: &draft.siblings[..slot],
                };
                situated::encode_rotation(node, tree, &context, out);
            },
        );
        let outputs = corrected(by, outputs, having.iter().map(|&(i, _)| drafts[i].row));
        for (&(i, roll), outputs) in having.iter().zip(outputs.chunks_exact(ROTATION_OUTPUTS)) {
            let draft = &mut drafts[i];
            let active = &frontier[draft.row];
            let tips = draft.child_tips[slot];
            let Placed { turn, child, redrawn } = self
                .place_child(slot, active, tips, roll, outputs)
                .ok_or(Overflow { row: draft.row })?;
            branchlets[draft.row].redrawn += redrawn;
            branchlets[draft.row].given_up += u8::from(child.is_none());
            if child.is_none() {
                branchlets[draft.row].lost_tips += tips;
                branchlets[draft.row].lost_nodes += 1 + draft.child_nodes[slot];
            }
            draft.siblings[slot] = Some(Sibling { tips, turn });
            branchlets[draft.row].plans[slot] = draft.child_plan(slot);
            // What comes again is as thick as it was.
            let former = active.settled.and_then(|settled| settled.children[slot]);
            branchlets[draft.row].children[slot] = child.map(|child| ChildSignature {
                thickness: former.map_or(child.thickness, |former| former.thickness),
                ..child
            });
        }
        work.heard = heard;
        Ok(())
    }

    /// How a node itself is turned, in deviations of its slot.
    fn own_turn(&self, active: &Active<'_>) -> Turn {
        let Active { node, parent, tree, .. } = active;
        let slot = &self.slots[tree.species][usize::from(node.slot)];
        parent.map_or_else(Turn::default, |parent| {
            slot.turn(node.rotation, parent, tree.gravitropism)
        })
    }

    /// The child in `slot`; nothing when the numbers overflow.
    fn place_child(
        &self,
        slot: usize,
        active: &Active<'_>,
        tips: u32,
        roll: f32,
        outputs: &[f32],
    ) -> Option<Placed> {
        let Active { node, lineage, seed, tree, room, .. } = active;
        let lineage = lineage.child(slot as u8);
        let order = (usize::from(node.order) + usize::from(slot > 0)).min(LENGTH_ORDERS - 1);
        let length = sampling::normal_score(
            self.lengths_of(tree.species, order),
            &mut seed.draws(lineage, Purpose::ChildLength),
        );
        let law = self.slots[tree.species][slot];
        let (alignment, bud) = (law.alignment(roll, node), self.bud_law(slot, active));
        let passage = |rotation: Quat| {
            let tip = node.position + length * (node.orientation * (rotation * Vec3::NEG_Z));
            if tip.y < 0.0 {
                return Passage::Blocked;
            }
            room.map_or(Passage::Free, |room| room.passage(node.position, tip))
        };
        let placed = |turn, rotation, redrawn: u64| {
            let thickness = thickness_of(tips, tree.tip_radius);
            let child = Some(ChildSignature { rotation, thickness, length });
            Placed { turn, child, redrawn: redrawn as u8 }
        };
        let (mut turn, mut last) = (Turn { swing: Vec2::ZERO, roll }, Passage::Free);
        let mut rotation = Quat::IDENTITY;
        for attempt in 0..ATTEMPTS {
            // The first of these draws is the roll's.
            let mut draws = seed.draws(lineage, Purpose::ChildRotation).at(1 + attempt);
            turn.swing = sampling::swing(outputs, alignment, &mut draws)?;
            if let Some(bud) = bud {
                let mut draws = seed.draws(lineage, Purpose::BudAngle).at(attempt);
                turn.swing.x = sampling::normal_score(bud, &mut draws) / law.scale.x;
            }
            rotation = law.rotation(turn, node, tree.gravitropism);
            if !rotation.is_finite() {
                return None;
            }
            last = passage(rotation);
            if last == Passage::Free {
                return Some(placed(turn, rotation, attempt));
            }
        }
        let mut draws = seed.draws(lineage, Purpose::ChildRotation).at(1 + ATTEMPTS);
        let is_free = |rotation| passage(rotation) == Passage::Free;
        let turns = match last {
            Passage::Outside => true,
            Passage::Astray => node.order == 0 && slot == 0,
            Passage::Blocked | Passage::Free => false,
        };
        let along = turns.then(|| bounds::turned(rotation, &mut draws, is_free)).flatten();
        Some(along.map_or(Placed { turn, child: None, redrawn: ATTEMPTS as u8 }, |rotation| {
            placed(law.turn(rotation, node, tree.gravitropism), rotation, ATTEMPTS)
        }))
    }
}

/// Writes what the networks read of a node.
fn encode(active: &Active<'_>, plan: Plan, species: usize, row: &mut [f32]) {
    situated::encode(active.node, &active.tree, plan, &active.sense, species, row);
}

/// The first existing child at `from` or after.
fn next_slot(branching: Branching, from: usize) -> usize {
    (from..MAX_CHILDREN).find(|&slot| branching.has(slot)).unwrap_or(MAX_CHILDREN - 1)
}
