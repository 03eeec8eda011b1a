//! Why training stops.

use std::path::PathBuf;

use crate::Processor;

/// Why a model was not trained.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum TrainError {
    #[error("the training set has no {part} trees; give at least one")]
    NoTrees { part: &'static str },
    #[error("there are {trees} {part} trees, but the surroundings of {given}; give one for each")]
    SurroundingsCount { part: &'static str, trees: usize, given: usize },
    #[error("there are {trees} {part} trees, but {given} scans; give one for each")]
    ScanCount { part: &'static str, trees: usize, given: usize },
    #[error("the scan of {part} tree {tree} does not name a node of the tree for each point")]
    Scan { part: &'static str, tree: usize },
    #[error(
        "all training trees of species `{species}` have grown in environments; add some of the \
         open field"
    )]
    NoOpenField { species: String },
    #[error("{part} tree {tree} is of species `{species}`, which is not in the set's list")]
    UnknownSpecies { part: &'static str, tree: usize, species: String },
    #[error("no training tree is of species `{species}`; add one, or take it from the list")]
    MissingSpecies { species: String },
    #[error(
        "{part} tree {tree}, node {node}: {tips} tips, its children bear {children_tips}, so {} \
         were dropped; a node drops 0 to 3, one for each free slot. The trees must keep the pipe \
         model (thickness² adds up at forks); train kind `paper` on trees that do not",
        i64::from(*tips) - i64::from(*children_tips)
    )]
    PipeModel { part: &'static str, tree: usize, node: usize, tips: u32, children_tips: u32 },
    #[error(
        "{part} tree {tree}, node {node}: thickness {thickness}; it must be above 0 and finite"
    )]
    Thickness { part: &'static str, tree: usize, node: usize, thickness: f32 },
    #[error("option `{option}` is {value}; it must be {expected}")]
    Option { option: String, value: String, expected: &'static str },
    #[error("this build cannot train on {processor}; build with the feature `{processor}`")]
    Processor { processor: Processor },
    #[error(
        "network {network}: the loss is {loss} at step {step}; lower the learning rate (a \
         checkpoint of the epoch before is kept)"
    )]
    Diverged { network: String, step: u64, loss: f32 },
    #[error("stopped as asked, network {network} after epoch {epoch}; run again to continue")]
    Stopped { network: String, epoch: u32 },
    #[error(
        "{path} was made with other settings ({difference}); use those again, or delete the \
         folder to start anew"
    )]
    OtherRun { path: PathBuf, difference: String },
    #[error("the model's other networks cannot be kept: {what}")]
    OtherModel { what: &'static str },
    #[error("{path} is damaged ({what}); delete it to train that network anew")]
    Checkpoint { path: PathBuf, what: &'static str },
    #[error("cannot {action} {path}")]
    File {
        action: &'static str,
        path: PathBuf,
        #[source]
        source: std::io::Error,
    },
    #[error("cannot start a worker thread")]
    Worker(#[source] rayon::ThreadPoolBuildError),
    #[error("the set's species are {found}; the model that is to hear of points knows {known}")]
    OtherSpecies { found: String, known: String },
    #[error("the trained networks do not make a model file")]
    Model(#[from] deeptree_infer::ReadWeightsError),
    #[error("the settings or the report cannot be written as TOML")]
    Toml(#[from] toml::ser::Error),
    #[error("the file beside the model does not tell how it was trained")]
    Report(#[source] toml::de::Error),
}
