//! What the training loop sees of a network: where it starts, where a step leads down, and how it is
//! judged.

mod dense;
mod outlook;
mod points;

use burn::tensor::Tensor;
use deeptree_graph::Draws;
use deeptree_infer::{ReadWeightsError, Table};

pub(crate) use dense::Dense;
pub(crate) use outlook::Outlook;
pub(crate) use points::Points;

use crate::report::{Figures, Tally};

/// A network with what it learns. Its parameters are one flat tensor.
pub(crate) trait Course {
    /// How many samples there are to learn from.
    fn samples(&self) -> usize;

    /// Widths of the layers, inputs first.
    fn sizes(&self) -> Vec<usize>;

    /// How many parameters there are.
    fn parameters(&self) -> usize;

    /// Where they start.
    fn initial(&self, draws: &Draws) -> Vec<f32>;

    /// The loss of the batch of a step, and its gradient.
    fn descend(&self, parameters: &Tensor<1>, step: u64) -> (Tensor<1>, Tensor<1>);

    /// Judges the network on at most `limit` samples of the validation trees, evenly spread; a tally
    /// a species.
    fn validate(&self, parameters: &Tensor<1>, limit: usize) -> Vec<Tally>;

    /// What a tally says.
    fn figures(&self, tally: &Tally) -> Figures;

    /// The tensors of the model file, with their names.
    fn tensors(&self, parameters: &[f32]) -> Result<Vec<(String, Table)>, ReadWeightsError>;
}
