//! What the networks of kind `situated` say of branchlets that are known.

use deeptree_graph::signature::inheritance::{
    self, Inheritance, Question, REACH_LEN, REACH_OUTPUTS,
};
use deeptree_graph::signature::situated::{
    self, Branching, CLASSES, LENGTH_ORDERS, ROTATION_OUTPUTS, RotationContext, SPLIT_LEN,
    SPLIT_OUTPUTS, Sibling, Slot,
};
use deeptree_graph::signature::size::{self, Bequest, SIZE_LEN, Size};
use deeptree_graph::signature::tip_count;
use deeptree_graph::{MAX_CHILDREN, Node, Plan};

use super::{Situated, encode, tips_and_plan};
use crate::points::corrected;
use crate::predictor::foretold::{Chance, Foretold, Known};
use crate::predictor::{Overflow, Workspace, laws};

/// A node with its children as the networks are told of them.
struct Truth<'a> {
    row: usize,
    own_tips: u32,
    plan: Plan,
    /// None where the children bear more tips than the node, or too few: no tree of the pipe model.
    branching: Option<Branching>,
    tips: [u32; MAX_CHILDREN],
    plans: [Plan; MAX_CHILDREN],
    siblings: [Option<Sibling>; MAX_CHILDREN],
    known: &'a Known<'a>,
}

impl<'a> Truth<'a> {
    fn of(row: usize, known: &'a Known<'a>, slots: &[Slot; MAX_CHILDREN]) -> Self {
        let active = &known.active;
        let (own_tips, plan) = tips_and_plan(active);
        let tips = known.children.map(|child| {
            child.map_or(0, |child| tip_count(child.node.thickness, active.tree.tip_radius))
        });
        let plans =
            known.children.map(|child| child.map_or_else(Plan::default, |child| child.plan));
        let has = |slot: usize| u8::from(known.children[slot].is_some()) << slot;
        let subset = (0..MAX_CHILDREN).map(has).sum();
        let dropped = own_tips.checked_sub(tips.iter().sum());
        let branching = dropped.and_then(|dropped| {
            let dropped = u8::try_from(dropped).ok().filter(|&dropped| dropped <= 3)?;
            let branching = Branching { subset, dropped };
            plan.allows(branching, own_tips).then_some(branching)
        });
        let sibling = |slot: usize| {
            let child = known.children[slot]?.node;
            let turn = slots[slot].turn(child.rotation, active.node, active.tree.gravitropism);
            Some(Sibling { tips: tips[slot], turn })
        };
        let siblings = std::array::from_fn(sibling);
        Self { row, own_tips, plan, branching, tips, plans, siblings, known }
    }

    /// What is known when the reach of the child in `slot` is decided.
    fn inheritance(&self, branching: Branching, slot: usize) -> Inheritance {
        let (child_tips, earlier) = (self.tips, self.plans.map(|plan| plan.reach));
        Inheritance { branching, child_tips, reach: self.plan.reach, slot, earlier }
    }

    /// What is known when the nodes below the child in `slot` are decided.
    fn bequest(&self, branching: Branching, slot: usize) -> Bequest {
        let child_reaches = self.plans.map(|plan| plan.reach);
        let (nodes, earlier) = (self.plan.nodes, self.plans.map(|plan| plan.nodes));
        Bequest { branching, child_tips: self.tips, child_reaches, nodes, slot, earlier }
    }
}

/// A question to a network on the child in a slot.
struct Asked<'a, T> {
    truth: &'a Truth<'a>,
    branching: Branching,
    slot: usize,
    what: T,
}

impl Situated {
    pub(in crate::predictor) fn foretell(
        &self,
        species: usize,
        known: &[Known<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<Foretold>, Overflow> {
        let features = situated::len(species);
        let truth = |(row, known)| Truth::of(row, known, self.slots_of(known));
        let truths: Vec<Truth<'_>> = known.iter().enumerate().map(truth).collect();
        work.encode(&truths, features, |_, truth, row| {
            encode(&truth.known.active, truth.plan, species, row);
        });
        self.hear(known.iter().map(|known| &known.active), work);
        let mut all = self.foretell_branchings(&truths, work)?;
        self.foretell_splits(features, &truths, work, &mut all)?;
        self.foretell_reaches(features, &truths, work, &mut all)?;
        self.foretell_sizes(features, &truths, work, &mut all)?;
        for slot in 0..MAX_CHILDREN {
            self.foretell_rotations(slot, features, &truths, work, &mut all)?;
        }
        for (truth, foretold) in truths.iter().zip(&mut all) {
            self.foretell_tables(truth, foretold);
        }
        Ok(all)
    }

    fn slots_of(&self, known: &Known<'_>) -> &[Slot; MAX_CHILDREN] {
        &self.slots[known.active.tree.species]
    }

    fn foretell_branchings(
        &self,
        truths: &[Truth<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<Foretold>, Overflow> {
        let heard = work.heard.take();
        let by = heard.as_ref().zip(self.hearing.as_ref().map(|hearing| &hearing.existence));
        let logits = corrected(by, work.run_nodes(&self.existence), 0..truths.len());
        let foretell = |(truth, logits): (&Truth<'_>, &[f32])| {
            let (tips, plan) = (truth.own_tips, truth.plan);
            let is_guess = heard.as_ref().is_some_and(|heard| heard.is_told(truth.row));
            let possible = |class| match Branching::from_class(class) {
                branching if is_guess => branching.is_ever_possible(),
                branching => plan.allows(branching, tips),
            };
            let odds = laws::softmax(logits, possible).ok_or(Overflow { row: truth.row })?;
            let child = |slot| {
                let classes = (0..CLASSES).filter(|&class| Branching::from_class(class).has(slot));
                classes.map(|class| odds[class]).sum()
            };
            Ok(Foretold {
                children: std::array::from_fn(child),
                branching: truth.branching.map(|branching| odds[branching.class()]),
                ..Foretold::default()
            })
        };
        let all = truths.iter().zip(logits.chunks_exact(CLASSES)).map(foretell).collect();
        work.heard = heard;
        all
    }

    fn foretell_splits(
        &self,
        features: usize,
        truths: &[Truth<'_>],
        work: &mut Workspace,
        all: &mut [Foretold],
    ) -> Result<(), Overflow> {
        let mut asked = Vec::new();
        for (truth, branching, slot) in children(truths) {
            let left = truth.own_tips - u32::from(branching.dropped);
            let left = left - truth.tips[..slot].iter().sum::<u32>();
            let children = (slot..MAX_CHILDREN).filter(|&slot| branching.has(slot)).count() as u32;
            if children >= 2 {
                asked.push(Asked { truth, branching, slot, what: (left, children) });
            }
        }
        let outputs = work.run(
            &self.split,
            features,
            &asked,
            |asked| asked.truth.row,
            |asked, out| {
                let out = &mut out[..SPLIT_LEN];
                situated::encode_split(asked.branching, asked.slot, asked.what.0, out);
            },
        );
        for (Asked { truth, slot, what, .. }, outputs) in
            asked.iter().zip(outputs.chunks_exact(SPLIT_OUTPUTS))
        {
            let question = (what.0, what.1, truth.plan.reach);
            let rank = laws::split(outputs, question, truth.tips[*slot]);
            all[truth.row].splits[*slot] = rank.ok_or(Overflow { row: truth.row })?;
        }
        Ok(())
    }

    fn foretell_reaches(
        &self,
        features: usize,
        truths: &[Truth<'_>],
        work: &mut Workspace,
        all: &mut [Foretold],
    ) -> Result<(), Overflow> {
        let mut asked = Vec::new();
        for (truth, branching, slot) in children(truths) {
            let known = truth.inheritance(branching, slot);
            if let Question::Open { asks_heir, bins, least } = known.question() {
                asked.push(Asked { truth, branching, slot, what: (known, asks_heir, bins, least) });
            }
        }
        let outputs = work.run(
            &self.reach,
            features,
            &asked,
            |asked| asked.truth.row,
            |asked, out| inheritance::encode(&asked.what.0, &mut out[..REACH_LEN]),
        );
        for (Asked { truth, slot, what, .. }, outputs) in
            asked.iter().zip(outputs.chunks_exact(REACH_OUTPUTS))
        {
            let (_, asks_heir, bins, least) = *what;
            let (own, foretold) = (truth.plans[*slot].reach, &mut all[truth.row]);
            let is_heir = own + 1 >= truth.plan.reach;
            let overflow = Overflow { row: truth.row };
            if asks_heir {
                let probability = laws::logistic(f64::from(outputs[0]));
                if probability.is_nan() {
                    return Err(overflow);
                }
                foretold.heirs[*slot] = Some(Chance { probability, happened: is_heir });
            }
            if !(asks_heir && is_heir) {
                let rank = laws::reach(&outputs[1..], (bins, least), own);
                foretold.reaches[*slot] = rank.ok_or(overflow)?;
            }
        }
        Ok(())
    }

    fn foretell_sizes(
        &self,
        features: usize,
        truths: &[Truth<'_>],
        work: &mut Workspace,
        all: &mut [Foretold],
    ) -> Result<(), Overflow> {
        let mut asked = Vec::new();
        for (truth, branching, slot) in children(truths) {
            let known = truth.bequest(branching, slot);
            if let Size::Open { least, most } = known.question() {
                asked.push(Asked { truth, branching, slot, what: (known, (least, most)) });
            }
        }
        let outputs = work.run(
            &self.size,
            features,
            &asked,
            |asked| asked.truth.row,
            |asked, out| size::encode(&asked.what.0, &mut out[..SIZE_LEN]),
        );
        for (Asked { truth, slot, what, .. }, outputs) in
            asked.iter().zip(outputs.chunks_exact(SPLIT_OUTPUTS))
        {
            let rank = laws::count(outputs, what.1, truth.plans[*slot].nodes);
            all[truth.row].sizes[*slot] = Some(rank.ok_or(Overflow { row: truth.row })?);
        }
        Ok(())
    }

    fn foretell_rotations(
        &self,
        slot: usize,
        features: usize,
        truths: &[Truth<'_>],
        work: &mut Workspace,
        all: &mut [Foretold],
    ) -> Result<(), Overflow> {
        let having = children(truths).filter(|child| child.2 == slot);
        let asked: Vec<Asked<'_, Sibling>> = having
            .filter_map(|(truth, branching, slot)| {
                let what = truth.siblings[slot]?;
                Some(Asked { truth, branching, slot, what })
            })
            .collect();
        let heard = work.heard.take();
        let by = heard.as_ref().zip(self.hearing.as_ref().map(|hearing| &hearing.rotations[slot]));
        let outputs = work.run(
            &self.rotations[slot],
            features,
            &asked,
            |asked| asked.truth.row,
            |asked, out| {
                let Asked { truth, branching, what, .. } = asked;
                let context = RotationContext {
                    branching: *branching,
                    parent_tips: truth.own_tips,
                    tips: what.tips,
                    parent_reach: truth.plan.reach,
                    plan: truth.plans[slot],
                    slot: self.slots_of(truth.known)[slot],
                    roll: what.turn.roll,
                    own: self.own_turn(&truth.known.active),
                    earlier: &truth.siblings[..slot],
                };
                let active = &truth.known.active;
                situated::encode_rotation(active.node, &active.tree, &context, out);
            },
        );
        let outputs = corrected(by, outputs, asked.iter().map(|asked| asked.truth.row));
        for (Asked { truth, what, .. }, outputs) in
            asked.iter().zip(outputs.chunks_exact(ROTATION_OUTPUTS))
        {
            let law = self.slots_of(truth.known)[slot];
            let alignment = law.alignment(what.turn.roll, truth.known.active.node);
            let is_aligned = law.is_aligned(alignment, what.turn);
            let said = laws::swing(outputs, alignment, what.turn.swing, is_aligned);
            let (chance, [mut x, mut y]) = said.ok_or(Overflow { row: truth.row })?;
            if let Some(bud) = self.bud_law(slot, &truth.known.active) {
                x = Some(laws::of_scores(bud, what.turn.swing.x * law.scale.x));
                y = y.and_then(|_| laws::about_y(outputs, what.turn.swing.y));
            }
            let foretold = &mut all[truth.row];
            foretold.aligned[slot] = Some(chance);
            (foretold.swings_x[slot], foretold.swings_y[slot]) = (x, y);
        }
        work.heard = heard;
        Ok(())
    }

    /// Roll and lengths, which are no networks' but tables'.
    fn foretell_tables(&self, truth: &Truth<'_>, foretold: &mut Foretold) {
        let species = truth.known.active.tree.species;
        let Slot { roll_scale, .. } = self.slots[species][0];
        if let Some(Sibling { turn, .. }) = truth.siblings[0]
            && roll_scale > 0.0
        {
            foretold.roll = Some(laws::of_scores(self.rolls.row(species), turn.roll * roll_scale));
        }
        foretold.lengths = truth.known.children.map(|child| {
            let Node { order, length, .. } = child?.node;
            let order = usize::from(*order).min(LENGTH_ORDERS - 1);
            Some(laws::of_scores(self.lengths_of(species, order), *length))
        });
    }
}

/// The children that the networks are asked about, slot by slot.
fn children<'a>(
    truths: &'a [Truth<'a>],
) -> impl Iterator<Item = (&'a Truth<'a>, Branching, usize)> {
    truths.iter().flat_map(|truth| {
        let of = move |branching: Branching| {
            let slots = (0..MAX_CHILDREN).filter(move |&slot| branching.has(slot));
            slots.map(move |slot| (truth, branching, slot))
        };
        truth.branching.into_iter().flat_map(of)
    })
}
