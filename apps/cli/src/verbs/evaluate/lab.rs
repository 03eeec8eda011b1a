//! Networks that a chapter trains for itself, and what their trees are like.

use std::io::Write;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::{fs, io};

use anyhow::{Context, Result, ensure};
use deeptree_dataset::{Corpus, CorpusPlan, Split, build};
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_eval::report::{Cell, Tone};
use deeptree_eval::two_sample::{Options, two_sample};
use deeptree_eval::{Metric, Moments, Row, TreeMetrics, tree_features};
use deeptree_export::write_atomically;
use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::{Species, grow};
use deeptree_infer::{Model, Weights, WeightsBuilder};
use deeptree_learn::{Kind, NetworkReport, Report, TrainOptions, TrainingSet, train};
use serde::{Deserialize, Serialize};

use super::study::Study;
use crate::verbs::train::training::Bars;
use crate::{batch, report};

/// Trees of the forests that ask whether trees can be told from the teacher's.
const FOREST_TREES: usize = 100;

/// Steps of each network in a full run: a third of those of the model `paper` that ships, so that
/// 25 networks train in half an hour on two idle cores.
const EPOCHS: u32 = 2;
const STEPS_PER_EPOCH: u64 = 10_000;

/// With `--quick` a few seconds a network, at a learning rate that shows something by then.
const QUICK_STEPS: u64 = 300;
const QUICK_LEARNING_RATE: f64 = 1e-3;

/// A corpus, and models that are trained on it.
pub(super) struct Lab<'a> {
    study: &'a Study<'a>,
    name: &'static str,
    species: Vec<&'a Species>,
    /// Trees of each species in the corpus.
    corpus_trees: u32,
    /// Trees of each species that are grown with each model.
    pub(super) trees: u32,
    set: OnceLock<TrainingSet>,
}

/// Mean and standard deviation.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Spread {
    pub(super) mean: f64,
    pub(super) sd: f64,
}

impl From<&Moments> for Spread {
    fn from(moments: &Moments) -> Self {
        Self { mean: moments.mean, sd: moments.sd() }
    }
}

/// What a set of trees is like.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Stand {
    /// Share of the trees that ended below the budget.
    pub(super) ended: f64,
    pub(super) nodes: Spread,
    pub(super) branch_number: Spread,
    pub(super) branch_length: Spread,
    pub(super) branching_distance: Spread,
    /// Area of a classifier against the teacher's trees with its 95 % interval; none of the
    /// teacher's own.
    pub(super) auc: Option<[f64; 3]>,
}

/// Trees with their features, one row each.
#[derive(Serialize, Deserialize)]
struct Measured {
    stand: Stand,
    features: Vec<Vec<f64>>,
}

impl<'a> Lab<'a> {
    /// A lab for these species; its corpus is grown when it is first needed.
    pub(super) fn new(
        study: &'a Study<'a>,
        name: &'static str,
        species: Vec<&'a Species>,
        corpus_trees: u32,
        trees: u32,
    ) -> Self {
        Self { study, name, species, corpus_trees, trees, set: OnceLock::new() }
    }

    /// The recipe of a kind, shortened for a quick run.
    pub(super) fn options(&self, kind: Kind) -> TrainOptions {
        let mut options = TrainOptions { epochs: EPOCHS, ..TrainOptions::new(kind) };
        options.steps_per_epoch = Some(STEPS_PER_EPOCH);
        if self.study.verb.quick {
            options.epochs = 1;
            options.steps_per_epoch = Some(QUICK_STEPS);
            options.learning_rate = QUICK_LEARNING_RATE;
        }
        options
    }

    /// How the networks were trained, for the reader.
    pub(super) fn recipe(&self) -> String {
        let options = self.options(Kind::Paper);
        let steps = u64::from(options.epochs) * options.steps_per_epoch.unwrap_or(0);
        let training = self.corpus_trees - self.corpus_trees / 5;
        let quick = if self.study.verb.quick {
            " (a quick run: far too little to judge the configurations by)"
        } else {
            ""
        };
        format!(
            "Each network was trained for {steps} steps of {} samples (the model that ships: 60000), \
             learning rate {}, on \
             {training} trees a species{quick}, and judged on {} others; every model grew {} trees \
             a species with a budget of {} nodes",
            options.batch,
            options.learning_rate,
            self.corpus_trees - training,
            self.trees,
            Limits::default().budget
        )
    }

    /// The folder of what a full or a quick run of this program keeps.
    fn folder(&self) -> PathBuf {
        let run = if self.study.verb.quick { "quick" } else { "full" };
        let (profile, trees) = (self.study.verb.profile.name(), self.corpus_trees);
        let names: Vec<&str> = self.species.iter().map(|species| species.name.as_str()).collect();
        let names = if names.len() == 8 { "all".to_owned() } else { names.join("-") };
        self.study
            .verb
            .output
            .join("lab")
            .join(&self.study.program)
            .join(format!("{}-{run}-{profile}-{names}-{trees}", self.name))
    }

    /// The name of a part of this lab.
    fn part_name(&self, name: &str) -> String {
        format!("{}-{name}", self.name)
    }

    /// The corpus in memory.
    fn set(&self) -> Result<&TrainingSet> {
        if let Some(set) = self.set.get() {
            return Ok(set);
        }
        let set = self.read(&self.grown_corpus()?)?;
        Ok(self.set.get_or_init(|| set))
    }

    fn grown_corpus(&self) -> Result<Corpus> {
        let dir = self.folder().join("corpus");
        let names: Vec<String> = self.species.iter().map(|species| species.name.clone()).collect();
        let profile = self.study.verb.profile;
        let plan = CorpusPlan::new(names, self.corpus_trees, Seed(0), profile.name());
        let total = u64::from(self.corpus_trees) * self.species.len() as u64;
        let bar = report::bar(self.study.args, total, "corpus");
        build(
            &plan,
            &dir,
            |name, seed, _priors, _| {
                let species = self.species.iter().find(|species| species.name == name);
                let parameters = species.unwrap_or(&self.species[0]).parameters(profile);
                grow(name, parameters, seed).map(|grown| grown.tree)
            },
            |progress| bar.set_position(progress.trees_done),
        )?;
        bar.finish_and_clear();
        Ok(Corpus::open(&dir)?)
    }

    fn read(&self, corpus: &Corpus) -> Result<TrainingSet> {
        let take = |split| -> Result<Vec<BranchGraph>> {
            corpus.trees(split).map(|tree| Ok(tree?.tree)).collect()
        };
        let (train, validation) = (take(Split::Train)?, take(Split::Validation)?);
        Ok(TrainingSet {
            species: corpus.plan().species.clone(),
            train_surroundings: vec![None; train.len()],
            validation_surroundings: vec![None; validation.len()],
            train,
            validation,
            data_hash: corpus.hash()?,
        })
    }

    /// Trains a model, or takes it from an earlier run; gives its file, and how well it does.
    pub(super) fn train(&self, name: &str, options: &TrainOptions) -> Result<(Vec<u8>, Report)> {
        let path = self.folder().join(format!("{name}.safetensors"));
        let checkpoints = self.folder().join(format!("{name}.checkpoint"));
        let train = || -> Result<Report> {
            let set = self.set()?;
            if !self.study.args.quiet && !self.study.args.json {
                eprintln!("training {} {name}", self.name);
            }
            let bars = Bars::new(self.study.args);
            let trained = train(set, options, &checkpoints, &|event| bars.show(event))?;
            write_atomically(&path, |out| out.write_all(&trained.weights))?;
            Ok(trained.report)
        };
        let report: Report = self.study.part(&self.part_name(&format!("train-{name}")), train)?;
        let bytes =
            fs::read(&path).with_context(|| format!("cannot read the model {}", path.display()))?;
        Ok((bytes, report))
    }

    /// Trains some networks of a model, and takes the others from the model `full`.
    pub(super) fn train_some(
        &self,
        name: &str,
        mut options: TrainOptions,
        networks: &[&str],
        full: &[u8],
    ) -> Result<(Vec<u8>, Report)> {
        let full = Weights::from_bytes(full)?;
        let mut names: Vec<&str> = full
            .names()
            .filter_map(|tensor| tensor.split_once(".0.weight").map(|(network, _)| network))
            .collect();
        names.retain(|network| !networks.contains(network));
        for network in names {
            // Its place is taken; a network must train for a step at least.
            let own = options.networks.entry(network.to_owned()).or_default();
            (own.epochs, own.steps_per_epoch) = (Some(1), Some(1));
        }
        let (bytes, report) = self.train(&format!("{name}-alone"), &options)?;
        let some = Weights::from_bytes(&bytes)?;
        let mut model = WeightsBuilder::from_weights(&full);
        for network in networks {
            model.network_of(network, &some);
        }
        Ok((model.to_bytes()?, report))
    }

    /// Keeps a model that was put together of others, to generate with.
    pub(super) fn keep(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder().join(format!("{name}.safetensors"));
        Ok(write_atomically(&path, |out: &mut io::BufWriter<_>| out.write_all(bytes))?)
    }

    /// A row of trees of the first seed on one scale: the teacher's, and one of each of the models
    /// kept under these names.
    pub(super) fn picture(&self, species: &Species, names: &[String]) -> Result<Vec<u8>> {
        let seed = Seed(self.study.verb.seed);
        let parameters = species.parameters(self.study.verb.profile);
        let mut trees = vec![grow(&species.name, parameters, seed)?.tree];
        let mut work = self.study.verb.model.workspace()?;
        for name in names {
            let path = self.folder().join(format!("{name}.safetensors"));
            let bytes = fs::read(&path)
                .with_context(|| format!("cannot read the model {}", path.display()))?;
            let request = Request::new(&species.name, seed);
            let model = Model::from_bytes(&bytes)?;
            trees.push(generate(&model, &request, Limits::default(), &mut work)?.tree);
        }
        let shots: Vec<Shot<'_>> = trees.iter().map(|tree| Shot::new(tree, View::FRONT)).collect();
        let sheet = Sheet {
            columns: shots.len(),
            width: self.study.scale(1600, 1000),
            row: self.study.scale(420, 300),
        };
        Ok(sheet.png(&shots)?)
    }

    /// The teacher's trees of a species.
    pub(super) fn teacher(&self, species: &Species) -> Result<Stand> {
        Ok(self.measured_teacher(species)?.stand)
    }

    fn measured_teacher(&self, species: &Species) -> Result<Measured> {
        let parameters = species.parameters(self.study.verb.profile);
        self.study.part(&self.part_name(&format!("teacher-{}", species.name)), || {
            self.measure(
                &species.name,
                || Ok(()),
                |(), seed| {
                    let grown = grow(&species.name, parameters, seed)?;
                    Ok((grown.tree, grown.hit_budget))
                },
            )
        })
    }

    /// The trees of a species that a model grows, against the teacher's.
    pub(super) fn stand(&self, model: &[u8], species: &Species) -> Result<Stand> {
        let model = Model::from_bytes(model)?;
        let teacher = self.measured_teacher(species)?;
        let mut learner = self.measure(
            &species.name,
            || self.study.verb.model.workspace(),
            |work, seed| {
                let request = Request::new(&species.name, seed);
                let grown = generate(&model, &request, Limits::default(), work)?;
                Ok((grown.tree, grown.hit_budget))
            },
        )?;
        let options = Options {
            forest_trees: FOREST_TREES,
            refits: 0,
            permutations: 0,
            ..Options::new(Seed(self.study.verb.seed))
        };
        let names = tree_features::names();
        let auc = two_sample(&teacher.features, &learner.features, names, options)?.auc;
        learner.stand.auc = Some([auc.value, auc.low, auc.high]);
        Ok(learner.stand)
    }

    fn measure<W>(
        &self,
        species: &str,
        worker: impl Fn() -> Result<W> + Sync,
        one: impl Fn(&mut W, Seed) -> Result<(BranchGraph, bool)> + Sync,
    ) -> Result<Measured> {
        let (mut row, mut features) = (Row::new(species, ""), Vec::new());
        let bar = report::bar(self.study.args, u64::from(self.trees), species);
        batch::make(
            self.study.verb.seed,
            u64::from(self.trees),
            worker,
            |work, seed| {
                let (tree, hit_budget) = one(work, Seed(seed))?;
                Ok((TreeMetrics::of(&tree), tree_features::tree_features(&tree), hit_budget))
            },
            |_, (metrics, own, hit_budget), _| {
                row.add(&metrics, hit_budget);
                features.push(own);
                bar.inc(1);
                Ok(())
            },
        )?;
        bar.finish_and_clear();
        let of = |metric: Metric| Spread::from(&row.moments[metric as usize]);
        let stand = Stand {
            ended: 1.0 - row.hit_budget as f64 / row.trees as f64,
            nodes: Spread::from(&row.nodes),
            branch_number: of(Metric::BranchNumber),
            branch_length: of(Metric::BranchLength),
            branching_distance: of(Metric::BranchingDistance),
            auc: None,
        };
        Ok(Measured { stand, features })
    }
}

impl Stand {
    /// The columns of [`Self::cells`].
    pub(super) const HEADER: [&'static str; 6] = ["ended", "nodes", "BN", "BL, m", "BD, m", "AUC"];

    /// The figures; beside those of the teacher, with the relative difference of the means.
    pub(super) fn cells(&self, teacher: Option<&Self>) -> Vec<Cell> {
        let tone = |good: bool| match (teacher, good) {
            (None, _) => Tone::Quiet,
            (_, true) => Tone::Good,
            (_, false) => Tone::Bad,
        };
        let spread = |of: fn(&Self) -> Spread, digits: usize| {
            let own = of(self);
            let text = format!("{:.digits$} ± {:.digits$}", own.mean, own.sd);
            match teacher.map(of) {
                None => Cell::new(text, Tone::Quiet),
                Some(teacher) => {
                    let difference = own.mean / teacher.mean - 1.0;
                    Cell::from(format!("{text} ({:+.0} %)", 100.0 * difference))
                }
            }
        };
        let auc = match self.auc {
            None => Cell::new("–", Tone::Quiet),
            Some([value, low, high]) => {
                Cell::new(format!("{value:.2} [{low:.2}, {high:.2}]"), tone(value <= 0.6))
            }
        };
        vec![
            Cell::new(percent(self.ended), tone(self.ended >= 1.0)),
            spread(|stand| stand.nodes, 0),
            spread(|stand| stand.branch_number, 0),
            spread(|stand| stand.branch_length, 2),
            spread(|stand| stand.branching_distance, 2),
            auc,
        ]
    }

    /// The columns of [`Self::csv`].
    pub(super) const CSV: &'static str =
        "ended,nodes,nodes_sd,BN,BN_sd,BL,BL_sd,BD,BD_sd,auc,auc_low,auc_high";

    /// The figures as a part of a line.
    pub(super) fn csv(&self) -> String {
        let spreads = [self.nodes, self.branch_number, self.branch_length, self.branching_distance];
        let spreads: Vec<String> =
            spreads.iter().map(|spread| format!("{},{}", spread.mean, spread.sd)).collect();
        let auc = self.auc.map_or(",,".to_owned(), |[v, low, high]| format!("{v},{low},{high}"));
        format!("{},{},{auc}", self.ended, spreads.join(","))
    }
}

pub(super) fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// What networks make of the validation trees.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Fit {
    /// Share of children told right at a probability of 0.5.
    pub(super) accuracy: f64,
    /// Of thickness and length, m².
    pub(super) mse: f64,
    /// Mean 1 − cos of the quaternions.
    pub(super) cosine_distance: f64,
}

impl Fit {
    /// Of a model of kind `paper` or `joint`: of one species, or of all.
    ///
    /// The regressors' figures are the means over all children of the validation trees.
    pub(super) fn of(report: &Report, species: Option<&str>) -> Result<Self> {
        let figures = |network: &NetworkReport| match species {
            Some(name) => network.species.get(name).cloned(),
            None => Some(network.total.clone()),
        };
        let of = |names: &[&str], figure: &str| -> Result<f64> {
            let (mut sum, mut samples) = (0.0, 0);
            for name in names {
                let found = report.networks.get(*name).and_then(figures);
                // A slot without children has no mean.
                let Some(found) = found.filter(|found| found.samples > 0) else { continue };
                let value = found.values.get(figure);
                sum += value.copied().unwrap_or(f64::NAN) * found.samples as f64;
                samples += found.samples;
            }
            ensure!(samples > 0, "no validation tree has samples of {names:?}");
            Ok(sum / samples as f64)
        };
        let joint = report.networks.contains_key("joint");
        let classifier: &[&str] = if joint { &["joint"] } else { &["classifier"] };
        let regressors: &[&str] =
            if joint { &["joint"] } else { &["regressor1", "regressor2", "regressor3"] };
        Ok(Self {
            accuracy: of(classifier, "accuracy")?,
            mse: of(regressors, "mse")?,
            cosine_distance: of(regressors, "cosine_distance")?,
        })
    }
}
