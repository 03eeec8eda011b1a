//! What a model keeps when some of its networks are trained anew.

use deeptree_infer::{ReadWeightsError, Table, Weights};

use crate::tasks::Network;
use crate::{NetworkReport, Report, TrainError, TrainOptions, TrainingSet};

/// How far the tables of turns may be from those of the model, in deviations.
const NEAR: f32 = 0.02;

/// A model of such trees and the same options, whose other networks are kept.
pub(crate) struct Kept<'a> {
    /// The networks to train.
    pub(crate) only: Vec<Network>,
    pub(crate) model: &'a Weights,
    pub(crate) report: &'a Report,
}

impl<'a> Kept<'a> {
    pub(crate) fn new(
        set: &TrainingSet,
        options: &TrainOptions,
        only: &[String],
        model: &'a Weights,
        report: &'a Report,
    ) -> Result<Self, TrainError> {
        report.check(model, options.kind)?;
        // How those were trained before that are trained anew makes no difference.
        let mut told = TrainOptions { workers: options.workers, ..report.options.clone() };
        for name in only {
            match options.networks.get(name) {
                Some(own) => told.networks.insert(name.clone(), own.clone()),
                None => told.networks.remove(name),
            };
        }
        if set.species != report.species {
            let what = "it is for other species; name trees of its species, or train all networks";
            return Err(TrainError::OtherModel { what });
        }
        if *options != told {
            let what = "it was trained with other options; name those, or train all networks";
            return Err(TrainError::OtherModel { what });
        }
        let all = Network::all(options.kind);
        let number = |name: &String| {
            let found = all.iter().find(|network| network.name() == name);
            found.copied().ok_or_else(|| TrainError::Option {
                option: "only".into(),
                value: format!("`{name}`"),
                expected: "the name of a network of this kind",
            })
        };
        let numbers: Vec<Network> = only.iter().map(number).collect::<Result<_, _>>()?;
        let is_open = set.train_surroundings.iter().all(Option::is_none);
        if numbers.contains(&Network::Outlook) && is_open {
            return Err(TrainError::Option {
                option: "only".into(),
                value: "`outlook`".into(),
                expected: "trees in scenes or volumes, from which it learns",
            });
        }
        Ok(Self { only: numbers, model, report })
    }

    /// Checks that the networks of these trees can be used with the tables of the model: that turns
    /// are told them in the same deviations, and tips in the same radii.
    pub(crate) fn check_tables(&self, tables: &Weights) -> Result<(), TrainError> {
        let both =
            |name| Some((tables.any_table(name)?.values(), self.model.any_table(name)?.values()));
        let scales = self.model.any_table("rotation_scale").map_or(&[][..], Table::values);
        let is_near = |name| {
            let Some((ours, theirs)) = both(name) else { return false };
            let mut all = ours.iter().zip(theirs).zip(scales);
            // What is exactly aligned depends on whether a slot has a mean swing at all.
            let is_near = |a: f32, b: f32, scale: f32| {
                (a - b).abs() <= NEAR * scale.max(0.01) && (a == 0.0) == (b == 0.0)
            };
            ours.len() == theirs.len() && all.all(|((&a, &b), &scale)| is_near(a, b, scale))
        };
        // Environments are not told by turns.
        let is_of_turns = |&network: &Network| network != Network::Outlook;
        let has_turns = tables.contains("rotation_scale") && self.only.iter().any(is_of_turns);
        let turns = !has_turns || (is_near("rotation_mean") && is_near("rotation_scale"));
        if turns && both("tip_radius").is_some_and(|(ours, theirs)| ours == theirs) {
            return Ok(());
        }
        let what = "rotations or tips lie otherwise in these trees; train all networks";
        Err(TrainError::OtherModel { what })
    }

    /// What is told of the model with the networks that were trained anew; they say of which trees
    /// where those are not the model's.
    pub(crate) fn report_with(
        &self,
        networks: impl Iterator<Item = (String, NetworkReport)>,
        set: &TrainingSet,
        options: &TrainOptions,
        weights: &[u8],
    ) -> Result<Report, ReadWeightsError> {
        let mut report = self.report.clone();
        let data_hash = (set.data_hash != report.data_hash).then(|| set.data_hash.clone());
        for (name, network) in networks {
            let network = NetworkReport { data_hash: data_hash.clone(), ..network };
            report = report.with(&name, network, weights)?;
            match options.networks.get(&name) {
                Some(own) => report.options.networks.insert(name, own.clone()),
                None => report.options.networks.remove(&name),
            };
        }
        Ok(report)
    }
}
