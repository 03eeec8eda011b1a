//! `train --only trend`: how whole trees change with age and gravitropism, from corpora.

use anyhow::{Context, Result, ensure};
use deeptree_dataset::{Corpus, Split};
use deeptree_graph::TreeTraits;
use deeptree_graph::signature::tip_count;
use deeptree_infer::{Model, Predictor};
use deeptree_learn::{Surveyed, train_trend};

use super::stands::numbers;
use super::training::{of_nodes, read_model, refuse, write};
use crate::args::{self, Args, UsageError};
use crate::report;

pub(super) fn run(args: &Args, verb: &args::Train) -> Result<()> {
    refuse("trend", &of_nodes(verb))?;
    let of_networks = [
        ("epochs", verb.epochs.is_some()),
        ("samples", verb.samples.is_some()),
        ("device", verb.device != "cpu"),
    ];
    refuse("trend", &of_networks)?;
    let path = verb.model.as_deref();
    let path = path.ok_or_else(|| UsageError("name the --model to keep the others of".into()))?;
    let (weights, told) = read_model(path)?;
    let model = Model::from_weights(&weights)?;
    let (mut trees, mut hashes) = (Vec::new(), Vec::new());
    for path in &verb.data {
        let corpus =
            Corpus::open(path).with_context(|| format!("{} is no corpus", path.display()))?;
        let numbers = numbers(&corpus.plan().species, &model)
            .with_context(|| format!("{} does not fit the model", path.display()))?;
        let hash = corpus.hash()?;
        ensure!(
            !hashes.contains(&hash),
            "{} holds the same trees as another corpus; name it once",
            path.display()
        );
        hashes.push(hash);
        ensure!(
            !corpus.plan().has_environments(),
            "{}: its trees stand among obstacles; name a corpus of the open field",
            path.display()
        );
        survey(args, verb, &corpus, &model, &numbers, &mut trees)?;
    }
    let (bytes, told) = train_trend(&trees, hashes.join("+"), (&weights, &told))?;
    write(args, verb, &bytes, &told)
}

/// The training trees of a corpus as wholes; `numbers` are those of its species in the model.
fn survey(
    args: &Args,
    verb: &args::Train,
    corpus: &Corpus,
    model: &Model,
    numbers: &[usize],
    trees: &mut Vec<Surveyed>,
) -> Result<()> {
    let plan = corpus.plan();
    let most = verb.trees.map_or(plan.training_trees, |most| most.min(plan.training_trees));
    let bar = report::bar(args, u64::from(most) * plan.species.len() as u64, "surveying");
    for tree in corpus.trees(Split::Train) {
        let tree = tree?;
        if tree.number >= most {
            continue;
        }
        let (species, tree) = (numbers[tree.species], tree.tree);
        let tips = tip_count(tree.root().thickness, model.tip_radius(species));
        trees.push(Surveyed {
            species,
            age: tree.info.age as f32,
            gravitropism: tree.info.gravitropism,
            state: TreeTraits::of(&tree).state(tips),
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}
