//! From trees to a model file: all networks of a kind, side by side.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use burn::tensor::Device;
use deeptree_graph::{Kin, Seed};
use deeptree_infer::{Model, ReadWeightsError, Table, Weights, WeightsBuilder};

use crate::checkpoint;
use crate::course::{Course, Dense, Outlook, Points};
use crate::kept::Kept;
use crate::mlp::Mlp;
use crate::options::Schedule;
use crate::report::{Report, hexadecimal};
use crate::rotations::Rotations;
use crate::set::{Corpus, species_numbers};
use crate::tables;
use crate::tasks::{Lesson, Network};
use crate::training::{Trainer, total};
use crate::{
    Kind, NetworkReport, Scans, TrainError, TrainEvent, TrainOptions, TrainProgress, TrainingSet,
};

/// A model, and how it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainedModel {
    /// Bytes of the model file, which [`deeptree_infer::Weights`] reads.
    pub weights: Vec<u8>,
    /// What is written beside it.
    pub report: Report,
}

/// Trains all networks of a kind.
///
/// After each epoch of a network its state goes into `checkpoints`; with the same set and options
/// a later call continues there, and ends with the same weights as one that was never cut off (on
/// the main processor).
///
/// # Errors
///
/// When the set or the options cannot be trained with, a checkpoint is damaged or of another run,
/// the training diverges, or `progress` stops it. What the checkpoints hold is kept.
pub fn train(
    set: &TrainingSet,
    options: &TrainOptions,
    checkpoints: &Path,
    progress: &dyn TrainProgress,
) -> Result<TrainedModel, TrainError> {
    train_those(set, options, None, checkpoints, progress)
}

/// Trains some networks of a model anew, and keeps all else of it, with its figures. With the set that
/// the model was made of this is what [`train`] gives, where nothing that the others learn has changed.
/// Of other trees, turns are told in the deviations that the model has, unless all networks that read
/// them are trained.
///
/// # Errors
///
/// As [`train`]; and when the model was made with other options (but for `workers`) or of trees with
/// other tips, or a network is none of its kind's.
pub fn retrain(
    set: &TrainingSet,
    options: &TrainOptions,
    only: &[String],
    (model, report): (&Weights, &Report),
    checkpoints: &Path,
    progress: &dyn TrainProgress,
) -> Result<TrainedModel, TrainError> {
    let kept = Kept::new(set, options, only, model, report)?;
    train_those(set, options, Some(&kept), checkpoints, progress)
}

fn train_those(
    set: &TrainingSet,
    options: &TrainOptions,
    kept: Option<&Kept<'_>>,
    checkpoints: &Path,
    progress: &dyn TrainProgress,
) -> Result<TrainedModel, TrainError> {
    options.validate()?;
    set.check()?;
    let species = species_numbers("training", &set.train, &set.species)?;
    let judged = species_numbers("validation", &set.validation, &set.species)?;
    let tip_radius = tables::tip_radii(&set.train, &species, set.species.len());
    if let Some(missing) = tip_radius.iter().position(|radius| !radius.is_finite()) {
        return Err(TrainError::MissingSpecies { species: set.species[missing].clone() });
    }
    let around = [&set.train_surroundings[..], &set.validation_surroundings];
    if let Some(kept) = kept {
        kept.check_tips(&tip_radius)?;
    }
    let kin = match options.kind {
        Kind::Paper | Kind::Joint => Vec::new(),
        Kind::Situated => match kept.map(Kept::kin).transpose()?.flatten() {
            Some(kept) => kept,
            None => tables::kin(&set.train, around[0], &species, &tip_radius),
        },
    };
    let train = Corpus::new("training", &set.train, around[0], &species, &tip_radius, &kin);
    let validation =
        Corpus::new("validation", &set.validation, around[1], &judged, &tip_radius, &kin);
    train.check_open_field(&set.species)?;
    let rotations = match options.kind {
        Kind::Paper | Kind::Joint => None,
        Kind::Situated => {
            train.check_pipe_model()?;
            validation.check_pipe_model()?;
            let kept = kept.map(Kept::rotations).transpose()?.flatten();
            Some(kept.unwrap_or_else(|| Rotations::new(&train, set.species.len())))
        }
    };
    checkpoint::open(checkpoints, set, &set.data_hash, options)?;

    let lesson = |corpus| Lesson::new(corpus, set.species.len(), rotations.as_ref(), options);
    let (lesson, judge) = (lesson(&train), lesson(&validation));
    let run = Run { set, options, train: lesson, validation: judge, kin: &kin, kept };
    let networks = run.networks(checkpoints, progress)?;
    let weights = run.weights(&networks, &tip_radius)?;
    // What is written must be what inference reads.
    Model::from_bytes(&weights)?;
    let report = run.report(&networks, &weights)?;
    Ok(TrainedModel { weights, report })
}

/// Trains networks that hear of points, for a model of kind `situated`, which stays as it is; the
/// result is that model with them, and its report with theirs.
///
/// The trees are best other ones than those that the model was trained on: the networks are told of
/// trees that the model knows. See [`train`] on checkpoints.
///
/// # Errors
///
/// As [`train`]; and when the scans are not those of the trees, the report is of another model, or the
/// model is not of kind `situated` or does not know the set's species in their order.
pub fn train_points(
    set: &TrainingSet,
    scans: &Scans,
    (base, report): (&Weights, &Report),
    options: &TrainOptions,
    checkpoints: &Path,
    progress: &dyn TrainProgress,
) -> Result<(Vec<u8>, Report), TrainError> {
    options.validate()?;
    set.check()?;
    scans.check(set)?;
    report.check(base, Kind::Situated)?;
    if set.species != base.species() {
        let [found, known] = [&set.species, base.species()].map(|names| names.join(", "));
        return Err(TrainError::OtherSpecies { found, known });
    }
    let species = species_numbers("training", &set.train, &set.species)?;
    let judged = species_numbers("validation", &set.validation, &set.species)?;
    let device = options.device.device()?;
    let data_hash = format!("{} for {}", set.data_hash, hexadecimal(base.sha256()));
    checkpoint::open(checkpoints, set, &data_hash, options)?;
    let course = Points::new(
        base,
        (&set.train, &scans.train, &species),
        (&set.validation, &scans.validation, &judged),
        options.batch,
        Seed(options.seed),
        device.clone(),
    )?;
    let own =
        Finished::train(Network::Points, &course, set, options, &device, checkpoints, progress)?;
    let mut model = WeightsBuilder::from_weights(base);
    for (name, table) in &own.tensors {
        model.table(name, table.clone());
    }
    let weights = model.to_bytes()?;
    let network = NetworkReport { data_hash: Some(set.data_hash.clone()), ..own.report };
    let report = report.with(own.name, network, &weights)?;
    Ok((weights, report))
}

struct Run<'a> {
    set: &'a TrainingSet,
    options: &'a TrainOptions,
    train: Lesson<'a>,
    validation: Lesson<'a>,
    /// By species.
    kin: &'a [Kin],
    kept: Option<&'a Kept<'a>>,
}

/// A network that is done.
struct Finished {
    name: &'static str,
    tensors: Vec<(String, Table)>,
    report: NetworkReport,
}

impl Finished {
    fn train(
        network: Network,
        course: &dyn Course,
        set: &TrainingSet,
        options: &TrainOptions,
        device: &Device,
        checkpoints: &Path,
        progress: &dyn TrainProgress,
    ) -> Result<Self, TrainError> {
        let schedule = options.schedule(network, course.samples());
        let batch = schedule.batch as f64;
        let trainer = Trainer {
            network,
            course,
            schedule,
            seed: Seed(options.seed),
            validation_samples: options.validation_samples,
            device,
            checkpoints,
            progress,
        };
        let trained = trainer.run()?;
        let named = set.species.iter().cloned().zip(&trained.tallies);
        let report = NetworkReport {
            sizes: course.sizes(),
            weight_count: course.parameters(),
            samples: course.samples(),
            steps: trained.steps,
            seconds: trained.seconds,
            samples_per_second: trained.steps as f64 * batch / trained.seconds.max(1e-9),
            data_hash: None,
            total: course.figures(&total(&trained.tallies)),
            species: named.map(|(name, tally)| (name, course.figures(tally))).collect(),
        };
        let tensors = course.tensors(&trained.parameters)?;
        Ok(Self { name: network.name(), tensors, report })
    }
}

impl Run<'_> {
    /// Trains the networks, as many side by side as there are workers.
    fn networks(
        &self,
        checkpoints: &Path,
        progress: &dyn TrainProgress,
    ) -> Result<Vec<Finished>, TrainError> {
        let mut networks = Network::all(self.options.kind);
        networks.retain(|&one| one != Network::Outlook || self.train.corpus.has_surroundings());
        networks.retain(|&one| self.kept.is_none_or(|kept| kept.only.contains(&one)));
        let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
        let progress = Until { progress, failed: &failed };
        let results: Mutex<Vec<_>> = Mutex::new(Vec::new());
        let work = || {
            while !failed.load(Ordering::Relaxed) {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(&network) = networks.get(number) else { return };
                let result = self.network(network, checkpoints, &progress);
                failed.fetch_or(result.is_err(), Ordering::Relaxed);
                let mut results = results.lock().unwrap_or_else(|poison| poison.into_inner());
                results.push((number, result));
            }
        };
        // One thread each: two networks side by side beat two threads in one step.
        let pool = || rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let workers = self.options.workers.min(networks.len());
        let pools: Vec<_> =
            (0..workers).map(|_| pool()).collect::<Result<_, _>>().map_err(TrainError::Worker)?;
        std::thread::scope(|scope| {
            pools.iter().for_each(|pool| drop(scope.spawn(|| pool.install(work))));
        });
        let results = results.into_inner().unwrap_or_else(|poison| poison.into_inner());
        in_order(results)
    }

    fn network(
        &self,
        network: Network,
        checkpoints: &Path,
        progress: &dyn TrainProgress,
    ) -> Result<Finished, TrainError> {
        let device = self.options.device.device()?;
        let course = self.course(network, device.clone());
        Finished::train(network, &*course, self.set, self.options, &device, checkpoints, progress)
    }

    fn course(&self, network: Network, device: Device) -> Box<dyn Course + '_> {
        let (seed, species) = (Seed(self.options.seed), self.set.species.len());
        // What does not depend on how many samples there are.
        let Schedule { hidden, batch, .. } = self.options.schedule(network, 1);
        if network == Network::Outlook {
            let (train, validation) = (self.train.corpus, self.validation.corpus);
            let grids = Outlook::new(train, validation, species, &hidden, batch, seed, device);
            return Box::new(grids);
        }
        let (train, validation) = (self.train.task(network), self.validation.task(network));
        let mlp = Mlp::new(train.inputs(), &hidden, train.outputs());
        let mlp = if network.has_gains() { mlp.with_gains(species) } else { mlp };
        let unread = self.options.unread(network, species);
        Box::new(Dense { network, mlp, train, validation, batch, unread, seed, species, device })
    }

    /// The model without its networks.
    fn tables(&self, tip_radius: &[f32]) -> Result<WeightsBuilder, ReadWeightsError> {
        let species = &self.set.species;
        let mut model = WeightsBuilder::new(self.options.kind.into(), species);
        tables::write_common(&mut model, self.train.corpus, species, tip_radius)?;
        if let Some(rotations) = self.train.rotations {
            tables::write_lengths(&mut model, self.train.corpus, rotations.slots.len())?;
            tables::write_turns(&mut model, self.train.corpus, rotations)?;
            tables::write_kin(&mut model, self.kin)?;
        }
        Ok(model)
    }

    fn weights(
        &self,
        networks: &[Finished],
        tip_radius: &[f32],
    ) -> Result<Vec<u8>, ReadWeightsError> {
        let mut model = match self.kept {
            Some(kept) => WeightsBuilder::from_weights(kept.model),
            None => self.tables(tip_radius)?,
        };
        if let (Some(rotations), Some(true)) =
            (self.train.rotations, self.kept.map(Kept::tells_turns_anew))
        {
            tables::write_turns(&mut model, self.train.corpus, rotations)?;
        }
        if self.kept.is_some_and(Kept::tells_standings_anew) {
            tables::write_kin(&mut model, self.kin)?;
        }
        if networks.iter().any(|network| network.name == Network::Existence.name()) {
            let species = self.set.species.len();
            tables::write_branchings(&mut model, self.train.corpus, species)?;
        }
        for Finished { name, tensors, .. } in networks {
            model.without(name);
            for (name, table) in tensors {
                model.table(name, table.clone());
            }
        }
        model.to_bytes()
    }

    fn report(&self, networks: &[Finished], weights: &[u8]) -> Result<Report, ReadWeightsError> {
        let reports = networks.iter().map(|one| (one.name.into(), one.report.clone()));
        if let Some(kept) = self.kept {
            return kept.report_with(reports, self.set, self.options, weights);
        }
        let networks: BTreeMap<String, NetworkReport> = reports.collect();
        Ok(Report {
            data_hash: self.set.data_hash.clone(),
            species: self.set.species.clone(),
            training_trees: self.set.train.len(),
            training_nodes: self.train.corpus.nodes(),
            validation_trees: self.set.validation.len(),
            seconds: networks.values().map(|one| one.seconds).sum(),
            weight_count: networks.values().map(|one| one.weight_count).sum(),
            bytes: weights.len(),
            sha256: hexadecimal(Weights::from_bytes(weights)?.sha256()),
            options: self.options.clone(),
            trend: None,
            networks,
        })
    }
}

/// The results in the order of the networks, or the first error of them.
fn in_order(
    mut results: Vec<(usize, Result<Finished, TrainError>)>,
) -> Result<Vec<Finished>, TrainError> {
    results.sort_by_key(|(number, _)| *number);
    // A network that stopped because another failed must not hide why.
    let stopped = |result: &Result<_, _>| matches!(result, Err(TrainError::Stopped { .. }));
    results.sort_by_key(|(_, result)| stopped(result));
    results.into_iter().map(|(_, result)| result).collect()
}

/// Stops all networks after one failed.
struct Until<'a> {
    progress: &'a dyn TrainProgress,
    failed: &'a AtomicBool,
}

impl TrainProgress for Until<'_> {
    fn event(&self, event: TrainEvent) {
        self.progress.event(event);
    }

    fn keep_going(&self) -> bool {
        !self.failed.load(Ordering::Relaxed) && self.progress.keep_going()
    }
}
