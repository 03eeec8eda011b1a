//! Chapter: the open loop. The networks are asked on the true states of fresh teacher's trees, and
//! what they say is held against what the teacher did next.

mod show;

use anyhow::Result;
use deeptree_eval::ORDERS;
use deeptree_eval::calibration::{Reliability, TreeMean, Uniformity};
use deeptree_eval::report::Chapter;
use deeptree_generate::DEFAULT_BATCH;
use deeptree_graph::{BranchGraph, MAX_CHILDREN, Node, NodeId};
use deeptree_growth::Species;
use deeptree_infer::{Chance, Foretold, Known, KnownTree, Model, Predictor, Rank, Workspace};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::study::Study;
use super::trees;

/// Trees of each species.
const FULL: u32 = 200;
const QUICK: u32 = 6;

/// Bins of the way from the foot, and their width in metres; the last is that and all beyond.
const DEPTHS: usize = 8;
const DEPTH: f32 = 5.0;

/// The laws whose ranks are looked at, in the order of [`ranks`].
const LAWS: [&str; 11] = [
    "split",
    "reach",
    "size",
    "roll",
    "swing 1 x",
    "swing 1 y",
    "swing 2 x",
    "swing 2 y",
    "swing 3 x",
    "swing 3 y",
    "length",
];

/// The other chances, in the order of [`chances`].
const CHANCES: [&str; 4] = ["heir", "aligned 1", "aligned 2", "aligned 3"];

/// What a model said of the trees of a species.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Said {
    trees: u32,
    /// Of "there is a child in this slot": over all slots, by slot, by order and by depth.
    existence: Reliability,
    by_slot: [Reliability; MAX_CHILDREN],
    by_order: [Reliability; ORDERS],
    by_depth: [Reliability; DEPTHS],
    /// Children of a node, and how many more than told, over the nodes.
    children: TreeMean,
    excess: TreeMean,
    /// −ln of the probability of the true branching.
    surprise: TreeMean,
    chances: [Reliability; CHANCES.len()],
    laws: [Law; LAWS.len()],
}

/// The ranks of one law: of all nodes, by order and by depth of the node that it was asked of.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Law {
    all: Uniformity,
    by_order: [Uniformity; ORDERS],
    by_depth: [Uniformity; DEPTHS],
}

/// A species, judged by the model and by kind `paper`.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Judged {
    species: String,
    model: Said,
    paper: Option<Said>,
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("open-loop", "Open loop: what the networks say of true states");
    let Some(model) = &study.model else {
        chapter.text("Not measured: only the growth model was asked for.");
        return Ok(chapter);
    };
    let mut all = Vec::new();
    for species in &study.species {
        all.push(Judged {
            species: species.name.clone(),
            model: judge(study, species, "DT", model)?,
            paper: match &study.paper {
                Some(paper) => Some(judge(study, species, "paper", paper)?),
                None => None,
            },
        });
    }
    let total = Judged {
        species: "all".to_owned(),
        model: total(all.iter().map(|one| &one.model)),
        paper: study
            .paper
            .is_some()
            .then(|| total(all.iter().filter_map(|one| one.paper.as_ref()))),
    };
    show::write(&mut chapter, &all, &total)?;
    study.save("open-loop.csv", show::csv(&all).as_bytes())?;
    let json = json!({ "species": all, "total": total });
    study.save("open-loop.json", serde_json::to_string_pretty(&json)?.as_bytes())?;
    Ok(chapter)
}

fn total<'a>(all: impl Iterator<Item = &'a Said>) -> Said {
    all.fold(Said::default(), |mut sum, one| {
        sum.merge(one);
        sum
    })
}

fn judge(study: &Study<'_>, species: &Species, set: &str, model: &Model) -> Result<Said> {
    let name = &species.name;
    study.part(&format!("open-loop-{name}-{set}"), || {
        let count = study.scale(FULL, QUICK).min(study.trees());
        let first = study.verb.seed;
        let number = model.species().iter().position(|known| known == name);
        let Some(number) = number else { return Ok(Said::default()) };
        let what = format!("{name} open loop {set}");
        let trees = trees::many(study, &what, first, count, |work, seed| {
            let tree = trees::grown(study, species, seed)?.tree;
            Said::of(model, number, &tree, work)
        })?;
        Ok(total(trees.iter()))
    })
}

impl Said {
    fn of(model: &Model, species: usize, tree: &BranchGraph, work: &mut Workspace) -> Result<Self> {
        let known = KnownTree::new(model, species, tree);
        let ids: Vec<NodeId> = (0..tree.len() as NodeId).collect();
        let mut said = Self { trees: 1, ..Self::default() };
        for ids in ids.chunks(DEFAULT_BATCH) {
            let nodes: Vec<Known<'_>> = ids.iter().map(|&id| known.node(id)).collect();
            for (&id, foretold) in ids.iter().zip(model.foretell(&nodes, work)?) {
                said.add(tree.node(id), &foretold);
            }
        }
        said.each_reliability(Reliability::close);
        said.each_mean(TreeMean::close);
        said.each_uniformity(Uniformity::close);
        Ok(said)
    }

    fn add(&mut self, node: &Node, foretold: &Foretold) {
        let order = usize::from(node.order).min(ORDERS - 1);
        let depth = ((node.root_distance / DEPTH) as usize).min(DEPTHS - 1);
        for (slot, told) in foretold.children.into_iter().enumerate() {
            let happened = node.children[slot].is_some();
            let of_order = &mut self.by_order[order];
            let own = [&mut self.by_slot[slot], of_order, &mut self.by_depth[depth]];
            own.into_iter().chain([&mut self.existence]).for_each(|one| one.add(told, happened));
        }
        let children = f64::from(node.child_count());
        self.children.add(children);
        self.excess.add(foretold.children.iter().sum::<f64>() - children);
        if let Some(probability) = foretold.branching {
            self.surprise.add(-probability.max(f64::MIN_POSITIVE).ln());
        }
        for (found, said) in self.chances.iter_mut().zip(chances(foretold)) {
            for Chance { probability, happened } in said.into_iter().flatten() {
                found.add(probability, happened);
            }
        }
        for (law, said) in self.laws.iter_mut().zip(ranks(foretold)) {
            for Rank { low, high } in said.into_iter().flatten() {
                law.all.add(low, high);
                law.by_order[order].add(low, high);
                law.by_depth[depth].add(low, high);
            }
        }
    }

    fn each_reliability(&mut self, mut visit: impl FnMut(&mut Reliability)) {
        visit(&mut self.existence);
        let cells = self.by_slot.iter_mut().chain(&mut self.by_order).chain(&mut self.by_depth);
        cells.chain(&mut self.chances).for_each(visit);
    }

    fn each_mean(&mut self, visit: impl FnMut(&mut TreeMean)) {
        [&mut self.children, &mut self.excess, &mut self.surprise].into_iter().for_each(visit);
    }

    fn each_uniformity(&mut self, mut visit: impl FnMut(&mut Uniformity)) {
        for Law { all, by_order, by_depth } in &mut self.laws {
            visit(all);
            by_order.iter_mut().chain(by_depth).for_each(&mut visit);
        }
    }

    /// Adds other trees.
    fn merge(&mut self, other: &Self) {
        self.trees += other.trees;
        // Both are walked through in the same order.
        let mut other = other.clone();
        let (mut reliabilities, mut means, mut uniformities) = (vec![], vec![], vec![]);
        other.each_reliability(|one| reliabilities.push(std::mem::take(one)));
        other.each_mean(|one| means.push(std::mem::take(one)));
        other.each_uniformity(|one| uniformities.push(std::mem::take(one)));
        let mut reliabilities = reliabilities.iter();
        self.each_reliability(|one| reliabilities.next().into_iter().for_each(|o| one.merge(o)));
        let mut means = means.iter();
        self.each_mean(|one| means.next().into_iter().for_each(|o| one.merge(o)));
        let mut uniformities = uniformities.iter();
        self.each_uniformity(|one| uniformities.next().into_iter().for_each(|o| one.merge(o)));
    }
}

/// What was said besides of children, by name.
fn chances(said: &Foretold) -> [Vec<Option<Chance>>; CHANCES.len()] {
    let [first, second, third] = said.aligned;
    [said.heirs.to_vec(), vec![first], vec![second], vec![third]]
}

/// The ranks, by law.
fn ranks(said: &Foretold) -> [Vec<Option<Rank>>; LAWS.len()] {
    let ([x1, x2, x3], [y1, y2, y3]) = (said.swings_x, said.swings_y);
    let of_one = |rank| vec![rank];
    [
        said.splits.to_vec(),
        said.reaches.to_vec(),
        said.sizes.to_vec(),
        of_one(said.roll),
        of_one(x1),
        of_one(y1),
        of_one(x2),
        of_one(y2),
        of_one(x3),
        of_one(y3),
        said.lengths.to_vec(),
    ]
}
