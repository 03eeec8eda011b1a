//! What a model keeps when some of its networks are trained anew.

use deeptree_infer::Weights;

use crate::tasks::Network;
use crate::{Kind, Report, TrainError, TrainOptions, TrainingSet};

/// A model of the same trees and options, whose other networks are kept.
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
        let sha256: String = model.sha256().iter().map(|byte| format!("{byte:02x}")).collect();
        let told = TrainOptions { workers: options.workers, ..report.options.clone() };
        for (what, is_same) in [
            ("the report beside it is of another model", sha256 == report.sha256),
            ("it was trained on other trees", set.data_hash == report.data_hash),
            ("it was trained on other trees", set.train.len() == report.training_trees),
            ("it was trained for other species", set.species == report.species),
            ("it was trained with other options", *options == told),
        ] {
            if !is_same {
                return Err(TrainError::OtherModel { what });
            }
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
        Ok(Self { only: only.iter().map(number).collect::<Result<_, _>>()?, model, report })
    }

    /// The names of the networks that are kept.
    pub(crate) fn networks(&self, kind: Kind) -> impl Iterator<Item = &'static str> {
        let all = Network::all(kind).into_iter();
        all.filter(|network| !self.only.contains(network)).map(Network::name)
    }
}
