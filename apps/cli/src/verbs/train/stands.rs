//! `train --only competition`: what trees make of each other, from corpora of stands.

use anyhow::{Context, Result, ensure};
use deeptree_dataset::{Alone, Plant, StandTree, Stands};
use deeptree_graph::signature::competition::Contender;
use deeptree_graph::signature::tip_count;
use deeptree_graph::{Seed, TreeTraits, Vec2};
use deeptree_infer::{Model, Predictor};
use deeptree_learn::{Rivalries, Rivalry, train_competition};

use super::training::{of_nodes, read_model, refuse, write};
use crate::args::{self, Args, UsageError};

pub(super) fn run(args: &Args, verb: &args::Train) -> Result<()> {
    refuse("competition", &of_nodes(verb))?;
    let few_and_small = [
        ("epochs", verb.epochs.is_some()),
        ("samples", verb.samples.is_some()),
        ("trees", verb.trees.is_some()),
        ("device", verb.device != "cpu"),
    ];
    refuse("competition", &few_and_small)?;
    let path = verb.model.as_deref();
    let path = path.ok_or_else(|| UsageError("name the --model to keep the others of".into()))?;
    let (weights, report) = read_model(path)?;
    let model = Model::from_weights(&weights)?;
    let mut set = Rivalries { train: Vec::new(), validation: Vec::new(), data_hash: String::new() };
    let mut hashes = Vec::new();
    for path in &verb.data {
        let corpus = Stands::open(path)?;
        let numbers = numbers(&corpus.plan().species, &model)
            .with_context(|| format!("{} does not fit the model", path.display()))?;
        hashes.push(corpus.hash()?);
        for (training, part) in [(true, &mut set.train), (false, &mut set.validation)] {
            for stand in corpus.stands(training)? {
                part.extend(rivalries(&model, &numbers, &stand));
            }
        }
    }
    set.data_hash = hashes.join("+");
    let (bytes, report) = train_competition(&set, Seed(verb.seed), (&weights, &report))?;
    write(args, verb, &bytes, &report)
}

/// The numbers of a corpus' species in the model.
pub(super) fn numbers(species: &[String], model: &Model) -> Result<Vec<usize>> {
    let number = |name: &String| {
        let found = model.species().iter().position(|known| known == name);
        ensure!(found.is_some(), "the model does not know the species {name}");
        Ok(found.unwrap_or_default())
    };
    species.iter().map(number).collect()
}

/// Each tree of a stand among the others.
fn rivalries(model: &Model, numbers: &[usize], stand: &[StandTree]) -> Vec<Rivalry> {
    let contender = |tree: &StandTree| {
        let StandTree { plant: Plant { species, .. }, alone, tree, .. } = tree;
        let traits = alone.traits();
        Contender {
            species: numbers[*species],
            age: tree.info.age as f32,
            nodes: traits.nodes,
            height: traits.height,
        }
    };
    let contenders: Vec<Contender> = stand.iter().map(contender).collect();
    let one = |(i, tree): (usize, &StandTree)| {
        let to = |j: usize| (tree.plant.to(&stand[j].plant), contenders[j]);
        let others: Vec<(Vec2, Contender)> = (0..stand.len()).filter(|&j| j != i).map(to).collect();
        let tip_radius = model.tip_radius(contenders[i].species);
        let tips = tip_count(tree.tree.root().thickness, tip_radius);
        let Alone { tips: tips_alone, .. } = tree.alone;
        let (here, alone) =
            (TreeTraits::of(&tree.tree).state(tips), tree.alone.traits().state(tips_alone));
        Rivalry { own: contenders[i], others, shift: std::array::from_fn(|k| here[k] - alone[k]) }
    };
    stand.iter().enumerate().map(one).collect()
}
