//! The losses, each a mean over the batch.
//!
//! Targets come as dense rows beside the outputs: on every backend a product with a one-hot row is
//! faster forwards and backwards than a gather.

use burn::tensor::{Tensor, activation::log_softmax, activation::sigmoid};
use deeptree_graph::signature::situated::{
    CLASSES, LOG_SCALE, ROTATION_COMPONENTS, SPLIT_COMPONENTS,
};

/// What is added to the logit of an impossible class: its probability is 0 in single precision.
pub(crate) const IMPOSSIBLE: f32 = -1e9;

/// Logit of a share of 0 or 1: far outside of what a component can reach.
pub(crate) const OPEN_END: f32 = 1e4;

/// Columns of the targets of [`existence`]: a one-hot of the class, and what to add to the logits.
pub(crate) const EXISTENCE_TARGETS: usize = 2 * CLASSES;

/// Columns of the targets of [`split`]: the bin's lower and upper end and its width, each once a
/// component.
pub(crate) const SPLIT_TARGETS: usize = 3 * SPLIT_COMPONENTS;

/// Columns of the targets of [`rotation`]: the turn, once a component.
pub(crate) const ROTATION_TARGETS: usize = 3 * ROTATION_COMPONENTS;

/// The columns `from..from + width`.
fn columns(tensor: &Tensor<2>, from: usize, width: usize) -> Tensor<2> {
    tensor.clone().narrow(1, from, width)
}

/// `log Σ_i exp(x_i)` of each row.
fn log_sum_exp(x: Tensor<2>) -> Tensor<2> {
    let peak = x.clone().detach().max_dim(1);
    (x - peak.clone()).exp().sum_dim(1).log() + peak
}

/// Cross-entropy of a categorical law over the possible classes.
///
/// # Shapes  outputs: `[batch, CLASSES]`; targets: `[batch, EXISTENCE_TARGETS]`
pub(crate) fn existence(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
    let rows = outputs.dims()[0] as f64;
    let label = columns(&targets, 0, CLASSES);
    let possible = columns(&targets, CLASSES, CLASSES);
    (log_softmax(outputs + possible, 1) * label).sum() / -rows
}

/// Negative log-likelihood of a bin under a mixture of logistic laws.
///
/// `P(lo, hi) = Σ_i w_i [σ(b_i) − σ(a_i)]` with `a_i = (lo − μ_i) / s_i`, `b_i = (hi − μ_i) / s_i`.
/// Each difference is taken as `σ(b) σ(−a) (1 − e^(a−b))`: the plain one would cancel where bins
/// are narrow. `1 − e^(−d)` in turn is `tanh(d/2) (1 + e^(−d))`.
///
/// # Shapes  outputs: `[batch, SPLIT_OUTPUTS]`; targets: `[batch, SPLIT_TARGETS]`
pub(crate) fn split(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
    const K: usize = SPLIT_COMPONENTS;
    let log_weight = log_softmax(columns(&outputs, 0, K), 1);
    let mean = columns(&outputs, K, K);
    let per_scale =
        (-columns(&outputs, 2 * K, K).clamp(*LOG_SCALE.start(), *LOG_SCALE.end())).exp();
    let low = (columns(&targets, 0, K) - mean.clone()) * per_scale.clone();
    let high = (columns(&targets, K, K) - mean) * per_scale.clone();
    let width = columns(&targets, 2 * K, K) * per_scale;
    let between = (width.clone() * 0.5).tanh().log() + (-width).exp().log1p();
    log_sum_exp(log_weight + log_sigmoid(high) + log_sigmoid(-low) + between).mean().neg()
}

/// `log σ(x) = min(x, 0) − log(1 + e^(−|x|))`, in fewer operations than Burn's own.
fn log_sigmoid(x: Tensor<2>) -> Tensor<2> {
    x.clone().clamp_max(0.0) - (-x.abs()).exp().log1p()
}

/// Negative log-likelihood of a turn under a mixture of Gaussian laws with diagonal covariance.
///
/// `p(x) = Σ_i w_i Π_j N(x_j; μ_ij, σ_ij²)`
///
/// # Shapes  outputs: `[batch, ROTATION_OUTPUTS]`; targets: `[batch, ROTATION_TARGETS]`
pub(crate) fn rotation(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
    const K: usize = ROTATION_COMPONENTS;
    let rows = outputs.dims()[0];
    let log_weight = log_softmax(columns(&outputs, 0, K), 1);
    let mean = columns(&outputs, K, 3 * K);
    let log_deviation = columns(&outputs, 4 * K, 3 * K).clamp(*LOG_SCALE.start(), *LOG_SCALE.end());
    let residual = (targets - mean) * (-log_deviation.clone()).exp();
    let log_density = (residual.square() * -0.5 - log_deviation).reshape([rows, K, 3]);
    let log_density = log_density.sum_dim(2).reshape([rows, K]);
    log_sum_exp(log_weight + log_density).mean().neg() + 1.5 * core::f64::consts::TAU.ln()
}

/// Mean squared error of sigmoid outputs against which children exist.
///
/// # Shapes  outputs, targets: `[batch, 3]`
pub(crate) fn classifier(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
    (sigmoid(outputs) - targets).square().mean()
}

/// Mean squared error of thickness and length, plus the cosine distance `1 − cos` of the
/// quaternions.
///
/// # Shapes  outputs, targets: `[batch, 6]`: qx, qy, qz, qw, t, l
pub(crate) fn regressor(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
    let (q, label) = (columns(&outputs, 0, 4), columns(&targets, 0, 4));
    let norm = (q.clone().square().sum_dim(1) + 1e-12).sqrt();
    let cosine = (q * label).sum_dim(1) / norm;
    let error = columns(&outputs, 4, 2) - columns(&targets, 4, 2);
    error.square().mean() + (-cosine + 1.0).mean()
}
