//! What a model keeps when some of its networks are trained anew.

use deeptree_graph::{Kin, MAX_CHILDREN};
use deeptree_infer::{ReadWeightsError, Weights};

use crate::rotations::Rotations;
use crate::tasks::Network;
use crate::{Kind, NetworkReport, Report, TrainError, TrainOptions, TrainingSet};

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

    /// Are all networks trained anew that read turns in deviations of their slots? Then these are told
    /// anew as well.
    pub(crate) fn tells_turns_anew(&self) -> bool {
        let mut all = (0..MAX_CHILDREN).map(Network::Rotation);
        all.all(|network| self.only.contains(&network))
    }

    /// How rotations lie in the slots of the model, where networks that read them are kept.
    pub(crate) fn rotations(&self) -> Result<Option<Rotations>, ReadWeightsError> {
        if self.tells_turns_anew() { Ok(None) } else { Rotations::of(self.model).map(Some) }
    }

    /// Are all networks trained anew that read where trees stand among their kin? Then these laws are
    /// told anew as well.
    pub(crate) fn tells_standings_anew(&self) -> bool {
        let mut all = Network::all(Kind::Situated).into_iter();
        all.all(|network| network == Network::Outlook || self.only.contains(&network))
    }

    /// The laws by which trees stand among their kin, where networks that read them are kept.
    pub(crate) fn kin(&self) -> Result<Option<Vec<Kin>>, TrainError> {
        if self.tells_standings_anew() {
            return Ok(None);
        }
        let kin = self.model.kin()?;
        if kin.is_empty() {
            let what = "it does not tell where trees stand among their kin; train all networks";
            return Err(TrainError::OtherModel { what });
        }
        Ok(Some(kin))
    }

    /// Checks that tips have the radii of the model, in which all networks read thicknesses.
    pub(crate) fn check_tips(&self, radii: &[f32]) -> Result<(), TrainError> {
        if self.model.any_table("tip_radius").is_some_and(|own| own.values() == radii) {
            return Ok(());
        }
        let what = "tips have other radii in these trees; train all networks";
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
