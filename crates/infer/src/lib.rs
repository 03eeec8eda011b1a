//! Inference: the weights file, and multilayer perceptrons that give the same bits everywhere.
//!
//! - [`Weights`] reads a model file and refuses a damaged or hostile one with a typed error;
//! - [`Model`] draws the children of nodes;
//! - [`Outlook`] says what an environment makes of a tree;
//! - [`Mlp`] runs one network over a batch of rows;
//! - [`SimdPath`] names the instruction sets it can run on; none of them changes a bit.
//!
//! Same weights and same inputs give the same outputs, bit for bit, for any batch size, batch
//! composition, instruction set and build profile: every output accumulates its inputs in index
//! order, with separate multiply and add, in `f32`.

#![forbid(unsafe_code)]

mod competition;
mod kernels;
mod mlp;
mod outlook;
mod points;
mod predictor;
mod weights;

pub use competition::Competition;
pub use kernels::{SimdPath, UnknownPath};
pub use mlp::{Dense, Mlp, MlpError, Scratch};
pub use outlook::{Code, Expectation, Outlook};
pub use predictor::{
    Active, Branchlet, Chance, Foretold, Former, Known, KnownChild, KnownTree, Model, Overflow,
    Predictor, ROOT_COLUMNS, Rank, Root, Settled, TREND_COLUMNS, Trend, Workspace,
};
pub use weights::{
    BlendError, ModelKind, ReadWeightsError, Table, Weights, WeightsBuilder, gain_name, layer_names,
};
