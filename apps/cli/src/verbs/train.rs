//! `train`: networks from a corpus.

#[cfg(feature = "train")]
mod points;
#[cfg(feature = "train")]
mod stands;
#[cfg(feature = "train")]
mod trend;

use anyhow::Result;

use crate::args::{self, Args};

#[cfg(not(feature = "train"))]
pub(crate) fn run(_: &Args, _: &args::Train) -> Result<()> {
    anyhow::bail!(
        "this build cannot train; build one that can with \
         `cargo run --release --features train -- train …`"
    )
}

#[cfg(feature = "train")]
pub(crate) fn run(args: &Args, verb: &args::Train) -> Result<()> {
    training::run(args, verb)
}

#[cfg(feature = "train")]
pub(super) mod training {
    use std::collections::BTreeMap;
    use std::fmt::Write as _;
    use std::fs;
    use std::io::Write;
    use std::path::{Path, PathBuf};
    use std::sync::Mutex;

    use anyhow::{Context, Result, bail};
    use deeptree_dataset::{Corpus, CorpusPlan, Split};
    use deeptree_export::write_atomically;
    use deeptree_graph::BranchGraph;
    use deeptree_graph::signature::paper::ATTRIBUTES;
    use deeptree_infer::Weights;
    use deeptree_learn::{
        Kind, NetworkOptions, Report, Surroundings, TrainEvent, TrainOptions, TrainingSet, retrain,
        train,
    };
    use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

    use super::{points, stands, trend};
    use crate::args::{self, Args, UsageError};
    use crate::report;
    use crate::verbs::unknown_species;

    pub(super) fn run(args: &Args, verb: &args::Train) -> Result<()> {
        if verb.output.extension().is_none_or(|extension| extension != "safetensors") {
            bail!(UsageError(format!("{}: a model is a .safetensors file", verb.output.display())));
        }
        match &verb.only[..] {
            [network] if network == "competition" => return stands::run(args, verb),
            [table] if table == "trend" => return trend::run(args, verb),
            [network] if network == "points" => return points::run(args, verb),
            _ => {}
        }
        let alone = |name: &&String| ["competition", "points", "trend"].contains(&name.as_str());
        if let Some(name) = verb.only.iter().find(alone) {
            let text = format!("--only {name} is trained by itself; name nothing else with it");
            bail!(UsageError(text));
        }
        let options = options(verb)?;
        let set = only_species(read(args, verb)?, &verb.species)?;
        let bars = Bars::new(args);
        let checkpoints = beside(&verb.output, "checkpoint");
        let progress = |event| bars.show(event);
        let trained = match &verb.model {
            None => train(&set, &options, &checkpoints, &progress)?,
            Some(path) => {
                let (model, report) = read_model(path)?;
                let kept = (&model, &report);
                retrain(&set, &options, &verb.only, kept, &checkpoints, &progress)?
            }
        };

        write(args, verb, &trained.weights, &trained.report)
    }

    /// Writes the model and what is told of it, and says so.
    pub(super) fn write(
        args: &Args,
        verb: &args::Train,
        weights: &[u8],
        report: &Report,
    ) -> Result<()> {
        let text = toml_of(report)?;
        write_atomically(&verb.output, |out| out.write_all(weights))?;
        let toml = verb.output.with_extension("toml");
        write_atomically(&toml, |out| out.write_all(text.as_bytes()))?;
        let text = summary(report, &verb.output, &toml);
        report::say(args, &serde_json::to_value(report)?, &text, false);
        Ok(())
    }

    /// A model, and what the file beside it says.
    pub(super) fn read_model(path: &Path) -> Result<(Weights, Report)> {
        let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let model = Weights::from_bytes(&bytes)
            .with_context(|| format!("{} is no model", path.display()))?;
        let toml = path.with_extension("toml");
        let text =
            fs::read_to_string(&toml).with_context(|| format!("cannot read {}", toml.display()))?;
        let report =
            Report::from_toml(&text).with_context(|| format!("cannot read {}", toml.display()))?;
        Ok((model, report))
    }

    /// The figures over all species; those of each are in the file.
    fn summary(report: &Report, model: &Path, toml: &Path) -> String {
        let mut text = String::new();
        for (name, network) in &report.networks {
            let _ = writeln!(text, "{name:>10}: {}", values(&network.total));
        }
        if let Some(trend) = &report.trend {
            let _ = writeln!(text, "{:>10}: fitted to {} trees", "trend", trend.trees);
        }
        let (bytes, minutes) = (report.bytes, report.seconds / 60.0);
        let files = format!("{} and {}", model.display(), toml.display());
        let _ = write!(
            text,
            "{} weights, {bytes} bytes, {minutes:.0} min → {files}",
            report.weight_count
        );
        text
    }

    fn values(figures: &deeptree_learn::Figures) -> String {
        let values = figures.values.iter().map(|(name, value)| format!("{name} {value:.5}"));
        values.collect::<Vec<_>>().join(", ")
    }

    fn toml_of(report: &Report) -> Result<String> {
        let toml = report.to_toml().context("the report cannot be written as TOML")?;
        Ok(match commit() {
            Some(commit) => format!("commit = \"{commit}\"\n{toml}"),
            None => toml,
        })
    }

    /// The commit that is checked out, where there is a repository.
    fn commit() -> Option<String> {
        let words = ["rev-parse", "HEAD"];
        let output = std::process::Command::new("git").args(words).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
    }

    fn options(verb: &args::Train) -> Result<TrainOptions> {
        let kind = match verb.kind.as_str() {
            "paper" => Kind::Paper,
            "joint" => Kind::Joint,
            _ => Kind::Situated,
        };
        let mut options = TrainOptions::new(kind);
        options.seed = verb.seed;
        if let Some(epochs) = verb.epochs {
            options.epochs = epochs;
            options.networks.clear();
        }
        let networks: [(&str, &[&str], _); 2] = [
            ("classifier", &["classifier"], &verb.classifier_attributes),
            ("regressor", &["regressor1", "regressor2", "regressor3"], &verb.regressor_attributes),
        ];
        for (what, networks, list) in networks {
            let Some(reads) = attributes(what, list)? else { continue };
            if kind != Kind::Paper {
                let text = format!("--{what}-attributes is for --kind paper only");
                bail!(UsageError(text));
            }
            set_reads(&mut options, networks, &reads);
        }
        if let Some(samples) = verb.samples {
            options.steps_per_epoch = Some(samples.div_ceil(options.batch as u64));
        }
        if let Some(workers) = verb.workers {
            options.workers = usize::from(workers);
        }
        options.device = verb.device.parse()?;
        Ok(options)
    }

    /// Refuses what says nothing to a network that is trained by itself: the options it has no use
    /// for, each with whether it was given.
    pub(super) fn refuse(network: &str, options: &[(&str, bool)]) -> Result<(), UsageError> {
        match options.iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((option, _)) => Err(UsageError(format!(
                "--{option} has no effect with --only {network}; leave it out"
            ))),
        }
    }

    /// What neither `points` nor `competition` nor `trend` has a use for: it is of the networks of nodes.
    pub(super) fn of_nodes(verb: &args::Train) -> [(&'static str, bool); 5] {
        [
            ("kind", verb.kind != "situated"),
            ("species", verb.species != "all"),
            ("classifier-attributes", verb.classifier_attributes != "all"),
            ("regressor-attributes", verb.regressor_attributes != "all"),
            ("workers", verb.workers.is_some()),
        ]
    }

    /// The attributes of a list of names separated by commas; none for all.
    fn attributes(what: &str, list: &str) -> Result<Option<Vec<String>>, UsageError> {
        if list == "all" {
            return Ok(None);
        }
        let names: Vec<&str> = list.split(',').collect();
        if let Some(name) = names.iter().find(|name| !ATTRIBUTES.contains(name)) {
            let known = ATTRIBUTES.join(", ");
            let text = format!("--{what}-attributes: no attribute '{name}'; there are {known}");
            return Err(UsageError(text));
        }
        Ok(Some(names.into_iter().map(str::to_owned).collect()))
    }

    /// Lets these networks read these attributes of a node, and no others.
    pub(crate) fn set_reads(
        options: &mut TrainOptions,
        networks: &[&str],
        reads: &[impl AsRef<str>],
    ) {
        let reads: Vec<String> = reads.iter().map(|name| name.as_ref().to_owned()).collect();
        for network in networks {
            let own: &mut NetworkOptions =
                options.networks.entry((*network).to_owned()).or_default();
            own.reads = Some(reads.clone());
        }
    }

    /// What of the set is of these species: a list of names separated by commas, or all.
    fn only_species(set: TrainingSet, names: &str) -> Result<TrainingSet, UsageError> {
        if names == "all" {
            return Ok(set);
        }
        let named: Vec<&str> = names.split(',').collect();
        if let Some(name) =
            named.iter().find(|name| !set.species.iter().any(|known| known == *name))
        {
            return Err(unknown_species(name, &set.species));
        }
        let is_named = |name: &String| named.contains(&name.as_str());
        let of = |trees: Vec<BranchGraph>, around: Vec<Option<Surroundings>>| {
            let all = trees.into_iter().zip(around);
            all.filter(|(tree, _)| is_named(&tree.info.species)).unzip()
        };
        let (train, train_surroundings) = of(set.train, set.train_surroundings);
        let (validation, validation_surroundings) = of(set.validation, set.validation_surroundings);
        Ok(TrainingSet {
            species: set.species.iter().filter(|name| is_named(name)).cloned().collect(),
            train,
            validation,
            train_surroundings,
            validation_surroundings,
            data_hash: set.data_hash,
        })
    }

    /// The corpora in memory, one set of the species of the first.
    pub(super) fn read(args: &Args, verb: &args::Train) -> Result<TrainingSet> {
        let open = |path: &PathBuf| {
            Corpus::open(path).with_context(|| format!("{} is no corpus", path.display()))
        };
        let corpora: Vec<Corpus> = verb.data.iter().map(open).collect::<Result<_>>()?;
        let species = &corpora[0].plan().species;
        for (path, plan) in verb.data.iter().zip(&corpora).map(|(path, c)| (path, c.plan())) {
            if let Some(name) = plan.species.iter().find(|name| !species.contains(name)) {
                bail!(
                    "{} has the species {name}, which {} has not; name the corpus with all \
                     species first",
                    path.display(),
                    verb.data[0].display()
                );
            }
        }
        let hashes = corpora.iter().map(Corpus::hash).collect::<Result<Vec<_>, _>>()?;
        if let Some(i) = (1..hashes.len()).find(|&i| hashes[..i].contains(&hashes[i])) {
            bail!(
                "{} holds the same trees as another corpus; name it once",
                verb.data[i].display()
            );
        }
        let most = |plan: &CorpusPlan| {
            verb.trees.map_or(plan.training_trees, |most| most.min(plan.training_trees))
        };
        let count = |plan: &CorpusPlan| {
            let trees = most(plan) + (plan.trees - plan.training_trees);
            u64::from(trees) * plan.species.len() as u64
        };
        let total = corpora.iter().map(|corpus| count(corpus.plan())).sum();
        let bar = report::bar(args, total, "reading");
        let take = |split| -> Result<(Vec<BranchGraph>, Vec<Option<Surroundings>>)> {
            let (mut trees, mut around) = (Vec::new(), Vec::new());
            for corpus in &corpora {
                for tree in corpus.trees(split) {
                    let tree = tree?;
                    if split == Split::Validation || tree.number < most(corpus.plan()) {
                        trees.push(tree.tree);
                        around.push(Surroundings::of(tree.environment));
                        bar.inc(1);
                    }
                }
            }
            Ok((trees, around))
        };
        let (train, train_surroundings) = take(Split::Train)?;
        let (validation, validation_surroundings) = take(Split::Validation)?;
        let set = TrainingSet {
            species: species.clone(),
            train,
            validation,
            train_surroundings,
            validation_surroundings,
            // In the order in which they are named, which is that of the trees.
            data_hash: hashes.join("+"),
        };
        bar.finish_and_clear();
        Ok(set)
    }

    pub(super) fn beside(path: &Path, suffix: &str) -> PathBuf {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".{suffix}"));
        name.into()
    }

    /// A bar a network; without a terminal, a line an epoch.
    pub(crate) struct Bars {
        all: MultiProgress,
        bars: Mutex<BTreeMap<&'static str, ProgressBar>>,
        lines: bool,
    }

    impl Bars {
        pub(crate) fn new(args: &Args) -> Self {
            let all = MultiProgress::new();
            let lines = !args.quiet && !args.json && all.is_hidden();
            if args.quiet || args.json {
                all.set_draw_target(ProgressDrawTarget::hidden());
            }
            Self { all, bars: Mutex::default(), lines }
        }

        pub(crate) fn show(&self, event: TrainEvent) {
            let Ok(mut bars) = self.bars.lock() else { return };
            match event {
                TrainEvent::Start { network, samples, parameters, steps, epochs_done, .. } => {
                    let bar = self.all.add(ProgressBar::new(steps));
                    if let Ok(style) = ProgressStyle::with_template("{prefix:>10} {wide_bar} {msg}")
                    {
                        bar.set_style(style);
                    }
                    bar.set_prefix(network);
                    bars.insert(network, bar);
                    self.line(|| {
                        format!(
                            "{network}: {parameters} weights, {samples} samples, {steps} steps, \
                             {epochs_done} epochs done"
                        )
                    });
                }
                TrainEvent::Step { network, epoch, step, loss, samples_per_second, left } => {
                    if let Some(bar) = bars.get(network) {
                        bar.set_position(step);
                        bar.set_message(format!(
                            "epoch {epoch}, loss {loss:.4}, {:.0} k samples/s, {} left",
                            samples_per_second / 1e3,
                            HumanDuration(left)
                        ));
                    }
                }
                TrainEvent::Epoch { network, epoch, figures } => {
                    let message = bars.get(network).map(ProgressBar::message).unwrap_or_default();
                    let values = values(&figures);
                    if let Some(bar) = bars.get(network) {
                        bar.set_prefix(format!("{network} ({values})"));
                    }
                    self.line(|| format!("{network}: epoch {epoch}, {values}; {message}"));
                }
                TrainEvent::Done { network } => {
                    if let Some(bar) = bars.remove(network) {
                        bar.finish();
                    }
                }
                _ => {}
            }
        }

        fn line(&self, text: impl FnOnce() -> String) {
            if self.lines {
                eprintln!("{}", text());
            }
        }
    }
}
