//! The losses, each a mean over the batch.
//!
//! Targets come as dense rows beside the outputs: on every backend a product with a one-hot row is
//! faster forwards and backwards than a gather.

use burn::tensor::{Tensor, activation::log_softmax, activation::sigmoid};
use deeptree_graph::MAX_CHILDREN;
use deeptree_graph::signature::paper::CHILD_LEN;
use deeptree_graph::signature::situated::{
    CLASSES, LOG_SCALE, ROTATION_COMPONENTS, SPLIT_COMPONENTS, SPLIT_OUTPUTS,
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

/// Columns of the targets of [`reach`]: 1 for an heir, −1 for none and 0 where it is not asked; then
/// the bin of a child that is not the heir, as for [`split`].
pub(crate) const REACH_TARGETS: usize = 1 + SPLIT_TARGETS;

/// Columns of the targets of [`rotation`]: x and y of the swing, each once a component, whether it is
/// aligned, and whether it goes straight on if it is.
pub(crate) const ROTATION_TARGETS: usize = 2 * ROTATION_COMPONENTS + 2;

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
    log_bin(outputs, targets).mean().neg()
}

/// Negative log-likelihood of the reach of a child: of being the heir or not, where that is asked,
/// and of its bin where it is not the heir. An heir's bin is open at both ends, with probability 1.
///
/// # Shapes  outputs: `[batch, REACH_OUTPUTS]`; targets: `[batch, REACH_TARGETS]`
pub(crate) fn reach(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
    let heir = columns(&targets, 0, 1);
    let odds = log_sigmoid(columns(&outputs, 0, 1) * heir.clone()) * heir.abs();
    let bin = columns(&targets, 1, SPLIT_TARGETS);
    (odds + log_bin(columns(&outputs, 1, SPLIT_OUTPUTS), bin)).mean().neg()
}

/// Log-likelihood of the bin of each row.
fn log_bin(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<2> {
    const K: usize = SPLIT_COMPONENTS;
    let log_weight = log_softmax(columns(&outputs, 0, K), 1);
    let mean = columns(&outputs, K, K);
    let per_scale =
        (-columns(&outputs, 2 * K, K).clamp(*LOG_SCALE.start(), *LOG_SCALE.end())).exp();
    let low = (columns(&targets, 0, K) - mean.clone()) * per_scale.clone();
    let high = (columns(&targets, K, K) - mean) * per_scale.clone();
    let width = columns(&targets, 2 * K, K) * per_scale;
    let between = (width.clone() * 0.5).tanh().log() + (-width).exp().log1p();
    log_sum_exp(log_weight + log_sigmoid(high) + log_sigmoid(-low) + between)
}

/// `log σ(x) = min(x, 0) − log(1 + e^(−|x|))`, in fewer operations than Burn's own.
fn log_sigmoid(x: Tensor<2>) -> Tensor<2> {
    x.clone().clamp_max(0.0) - (-x.abs()).exp().log1p()
}

/// Negative log-likelihood of the swing of the child in `slot`, under a mixture of Gaussian laws and
/// the aligned law.
///
/// `p(x, y) = Σ_i w_i N(x; μ_i, σ_i²) N(y; ν_i + τ_i a_i (x − μ_i) / σ_i, τ_i²)` where the swing is
/// not aligned. Where it is, `w_a N(x; μ_a, σ_a²)` for a lateral; for slot 0 `w_a` alone where the
/// shoot goes straight on, and otherwise `w_a Σ_i w_i N(x; μ_i, σ_i²) / Σ_i w_i`.
///
/// # Shapes  outputs: `[batch, ROTATION_OUTPUTS]`; targets: `[batch, ROTATION_TARGETS]`
pub(crate) fn rotation(outputs: Tensor<2>, targets: Tensor<2>, slot: usize) -> Tensor<1> {
    const K: usize = ROTATION_COMPONENTS;
    let half_log_tau = 0.5 * core::f64::consts::TAU.ln();
    let bounded = |t: Tensor<2>| t.clamp(*LOG_SCALE.start(), *LOG_SCALE.end());
    let row = |i: usize| columns(&outputs, K + 3 + i * K, K);
    let (x, y) = (columns(&targets, 0, K), columns(&targets, K, K));
    let is_aligned = columns(&targets, 2 * K, 1);
    let log_weight = log_softmax(columns(&outputs, 0, K + 1), 1);

    let (log_x, log_y) = (bounded(row(2)), bounded(row(3)));
    let first = (x.clone() - row(0)) * (-log_x.clone()).exp();
    let second = (y - row(1)) * (-log_y.clone()).exp() - row(4) * first.clone();
    let log_density = (first.clone().square() + second.square()) * -0.5 - log_x.clone() - log_y;
    let log_weights = columns(&log_weight, 0, K);
    let free = log_sum_exp(log_weights.clone() + log_density) - 2.0 * half_log_tau;

    let mut aligned = columns(&log_weight, K, 1);
    if slot == 0 {
        let is_bent = -columns(&targets, 2 * K + 1, 1) + 1.0;
        let of_x = first.square() * -0.5 - log_x;
        let shares = log_sum_exp(log_weights.clone());
        let density = log_sum_exp(log_weights + of_x) - shares - half_log_tau;
        aligned = aligned + density * is_bent;
    } else {
        let log_x = bounded(columns(&outputs, K + 2, 1));
        let off = (columns(&x, 0, 1) - columns(&outputs, K + 1, 1)) * (-log_x.clone()).exp();
        aligned = aligned - off.square() * 0.5 - log_x - half_log_tau;
    }
    let is_free = -is_aligned.clone() + 1.0;
    (free * is_free + aligned * is_aligned).mean().neg()
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
    let (squares, distance) = child_errors(outputs, targets);
    squares.mean() + distance.mean()
}

/// Squared errors of thickness and length, and cosine distance of the quaternions, row by row.
fn child_errors(outputs: Tensor<2>, targets: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
    let (q, label) = (columns(&outputs, 0, 4), columns(&targets, 0, 4));
    let norm = (q.clone().square().sum_dim(1) + 1e-12).sqrt();
    let cosine = (q * label).sum_dim(1) / norm;
    let error = columns(&outputs, 4, 2) - columns(&targets, 4, 2);
    (error.square(), -cosine + 1.0)
}

/// The classifier's loss, plus the regressor's of each slot over the children there are.
///
/// # Shapes  outputs, targets: `[batch, JOINT_LEN]`: existence by slot, then qx … l by slot
pub(crate) fn joint(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
    const C: usize = MAX_CHILDREN;
    let mut loss = classifier(columns(&outputs, 0, C), columns(&targets, 0, C));
    for slot in 0..C {
        let child = |of: &Tensor<2>| columns(of, C + slot * CHILD_LEN, CHILD_LEN);
        let (squares, distance) = child_errors(child(&outputs), child(&targets));
        let exists = columns(&targets, slot, 1);
        let count = exists.clone().sum().clamp_min(1.0);
        loss = loss + ((squares.mean_dim(1) + distance) * exists).sum() / count;
    }
    loss
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::tensor::{Device, TensorData};
    use deeptree_graph::signature::inheritance::REACH_OUTPUTS;
    use deeptree_graph::signature::paper::JOINT_LEN;
    use deeptree_graph::signature::situated::{Alignment, ROTATION_OUTPUTS, SPLIT_OUTPUTS};
    use deeptree_graph::{Lineage, Purpose, Seed, Vec2};

    use crate::tasks::SwingTarget;

    type Loss = fn(Tensor<2>, Tensor<2>) -> Tensor<1>;

    fn row(values: &[f32]) -> Tensor<2> {
        Tensor::from_data(TensorData::new(values.to_vec(), [1, values.len()]), &Device::flex())
    }

    fn value(loss: Loss, outputs: &[f32], targets: &[f32]) -> f32 {
        loss(row(outputs), row(targets)).into_scalar()
    }

    fn random(n: usize, seed: u64, scale: f64) -> Vec<f32> {
        let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::Evaluation);
        (0..n).map(|_| (scale * draws.normal()) as f32).collect()
    }

    /// Targets of the bin from `low` to `high`.
    fn bin(low: f32, high: f32) -> Vec<f32> {
        [low, high, high - low].into_iter().flat_map(|x| [x; SPLIT_COMPONENTS]).collect()
    }

    #[test]
    fn cross_entropy_of_two_possible_classes_is_that_of_a_coin() {
        let mut targets = [0.0; EXISTENCE_TARGETS];
        targets[CLASSES..].fill(IMPOSSIBLE);
        (targets[7], targets[CLASSES + 7], targets[CLASSES + 9]) = (1.0, 0.0, 0.0);
        let mut outputs = [30.0; CLASSES];
        (outputs[7], outputs[9]) = (3f32.ln(), 0.0);
        // Odds of 3 to 1.
        let loss = value(existence, &outputs, &targets);
        assert!((loss - (4.0f32 / 3.0).ln()).abs() < 1e-6, "{loss}");
    }

    #[test]
    fn one_logistic_of_scale_1_shares_out_evenly() {
        // The logit of a uniform share has the standard logistic law.
        let outputs = [0.0; SPLIT_OUTPUTS];
        for (low, high, p) in [
            (-OPEN_END, (0.25f32 / 0.75).ln(), 0.25f32),
            ((0.25f32 / 0.75).ln(), 0.0, 0.25),
            (0.0, OPEN_END, 0.5),
            (-OPEN_END, OPEN_END, 1.0),
        ] {
            let loss = value(split, &outputs, &bin(low, high));
            assert!((loss + p.ln()).abs() < 1e-6, "{loss} {p}");
        }
    }

    #[test]
    fn split_agrees_with_the_plain_difference_of_sigmoids() {
        for seed in 0..50 {
            let outputs = random(SPLIT_OUTPUTS, seed, 1.5);
            for (low, high) in [(-OPEN_END, -1.0), (-1.0, -0.9), (0.3, 2.0), (2.0, OPEN_END)] {
                let loss = f64::from(value(split, &outputs, &bin(low, high)));
                let plain = -crate::tasks::bin_probability(&outputs, low, high).ln();
                assert!((loss - plain).abs() < 1e-4 * plain.max(1.0), "{loss} {plain}");
            }
        }
    }

    /// Targets of a reach: whether it is the heir's, where asked, and its bin.
    fn heir(heir: f32, low: f32, high: f32) -> Vec<f32> {
        [vec![heir], bin(low, high)].concat()
    }

    #[test]
    fn reach_agrees_with_the_plain_product_of_odds_and_bin() {
        for seed in 0..50 {
            let outputs = random(REACH_OUTPUTS, seed, 1.5);
            let p = 1.0 / (1.0 + f64::from(-outputs[0]).exp());
            for (is_heir, odds) in [(1.0, p), (-1.0, 1.0 - p), (0.0, 1.0)] {
                for (low, high) in [(-OPEN_END, OPEN_END), (-OPEN_END, -1.0), (-0.2, 0.9)] {
                    let loss = f64::from(value(reach, &outputs, &heir(is_heir, low, high)));
                    let bin = crate::tasks::bin_probability(&outputs[1..], low, high);
                    let plain = -(odds * bin).ln();
                    assert!((loss - plain).abs() < 1e-4 * plain.max(1.0), "{loss} {plain}");
                }
            }
        }
    }

    /// Targets of a swing that can be aligned so.
    fn swing(x: f32, y: f32, alignment: Alignment, is_aligned: bool) -> Vec<f32> {
        let mut targets = vec![0.0; ROTATION_TARGETS];
        SwingTarget { swing: Vec2::new(x, y), alignment, is_aligned }.write(&mut targets);
        targets
    }

    fn lateral(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        rotation(outputs, targets, 1)
    }

    fn apical(outputs: Tensor<2>, targets: Tensor<2>) -> Tensor<1> {
        rotation(outputs, targets, 0)
    }

    #[test]
    fn rotation_agrees_with_the_plain_sum_of_densities() {
        for seed in 0..50 {
            let outputs = random(ROTATION_OUTPUTS, seed, 0.7);
            let at = random(2, 1000 + seed, 1.0);
            for (alignment, loss) in [
                (Alignment::Straight, apical as Loss),
                (Alignment::Gravity, apical),
                (Alignment::Bud, lateral),
            ] {
                for is_aligned in [false, true] {
                    let targets = swing(at[0], at[1], alignment, is_aligned);
                    let loss = f64::from(value(loss, &outputs, &targets));
                    let swing = Vec2::new(at[0], at[1]);
                    let plain = SwingTarget { swing, alignment, is_aligned }.nll(&outputs);
                    assert!((loss - plain).abs() < 1e-4 * plain.abs().max(1.0), "{loss} {plain}");
                }
            }
        }
    }

    #[test]
    fn quaternions_at_a_right_angle_have_distance_1_whatever_their_length() {
        let outputs = [0.0, 0.0, 5.0, 0.0, 0.25, 1.0];
        let targets = [0.0, 0.0, 0.0, 1.0, 0.05, 0.9];
        let expected = 1.0 + (0.2f32 * 0.2 + 0.1 * 0.1) / 2.0;
        assert!((value(regressor, &outputs, &targets) - expected).abs() < 1e-6);
        assert!(value(regressor, &[0.0, 0.0, 0.0, 3.0, 0.05, 0.9], &targets).abs() < 1e-6);
    }

    #[test]
    fn classifier_at_even_odds_errs_by_a_quarter() {
        assert_eq!(value(classifier, &[0.0; 3], &[0.0, 1.0, 1.0]), 0.25);
    }

    #[test]
    fn the_joint_loss_is_the_sum_of_the_published_ones_over_the_children_there_are() {
        let (outputs, mut targets) = (random(JOINT_LEN, 1, 1.0), random(JOINT_LEN, 2, 1.0));
        targets[..3].copy_from_slice(&[1.0, 0.0, 1.0]);
        let child = |values: &[f32], slot: usize| values[3 + 6 * slot..][..6].to_vec();
        let one = |slot| value(regressor, &child(&outputs, slot), &child(&targets, slot));
        let expected = value(classifier, &outputs[..3], &targets[..3]) + one(0) + one(2);
        assert!((value(joint, &outputs, &targets) - expected).abs() < 1e-5);
        // A batch: what a slot adds is the mean over the rows that have it.
        let rows = |a: &[f32], b: &[f32]| {
            Tensor::from_data(TensorData::new([a, b].concat(), [2, JOINT_LEN]), &Device::flex())
        };
        let mut alone = targets.clone();
        alone[2] = 0.0;
        let both: f32 = joint(rows(&outputs, &outputs), rows(&targets, &alone)).into_scalar();
        let existence = [&targets, &alone].map(|t| value(classifier, &outputs[..3], &t[..3]));
        let expected = (existence[0] + existence[1]) / 2.0 + one(0) + one(2);
        assert!((both - expected).abs() < 1e-5, "{both} {expected}");
    }

    #[test]
    fn gradients_match_central_differences() {
        // The second child is missing.
        let mut family = random(JOINT_LEN, 7, 1.0);
        family[..3].copy_from_slice(&[1.0, 0.0, 1.0]);
        let cases: [(Loss, usize, Vec<f32>); 11] = [
            (split, SPLIT_OUTPUTS, bin(-0.4, 0.1)),
            (split, SPLIT_OUTPUTS, bin(0.7, OPEN_END)),
            (reach, REACH_OUTPUTS, heir(1.0, -OPEN_END, OPEN_END)),
            (reach, REACH_OUTPUTS, heir(-1.0, -0.4, 0.1)),
            (reach, REACH_OUTPUTS, heir(0.0, 0.7, OPEN_END)),
            (apical, ROTATION_OUTPUTS, swing(0.4, -0.7, Alignment::Straight, false)),
            (apical, ROTATION_OUTPUTS, swing(0.4, 0.0, Alignment::Gravity, true)),
            (lateral, ROTATION_OUTPUTS, swing(-1.1, 0.3, Alignment::Bud, false)),
            (lateral, ROTATION_OUTPUTS, swing(0.2, 0.0, Alignment::Bud, true)),
            (regressor, 6, random(6, 6, 1.0)),
            (joint, JOINT_LEN, family),
        ];
        for (number, (loss, width, targets)) in cases.into_iter().enumerate() {
            let outputs = random(width, 40 + number as u64, 0.7);
            let leaf = row(&outputs).autodiff().require_grad();
            let mut gradients = loss(leaf.clone(), row(&targets).autodiff()).backward();
            let gradient = crate::mlp::values(leaf.grad_remove(&mut gradients).unwrap());
            for (i, &exact) in gradient.iter().enumerate() {
                let at = |shift: f32| {
                    let mut moved = outputs.clone();
                    moved[i] += shift;
                    value(loss, &moved, &targets)
                };
                let rough = (at(1e-2) - at(-1e-2)) / 2e-2;
                assert!((exact - rough).abs() < 2e-3, "case {number}, output {i}: {exact} {rough}");
            }
        }
    }

    #[test]
    fn losses_stay_finite_far_from_the_truth() {
        for scale in [1e2, 1e4] {
            let outputs = random(ROTATION_OUTPUTS, 1, scale);
            for is_aligned in [false, true] {
                for (loss, alignment) in
                    [(lateral as Loss, Alignment::Bud), (apical, Alignment::Gravity)]
                {
                    let targets = swing(3.0, -3.0, alignment, is_aligned);
                    assert!(value(loss, &outputs, &targets).is_finite());
                }
            }
            let outputs = random(SPLIT_OUTPUTS, 2, scale);
            for (low, high) in [(-OPEN_END, -9.0), (-0.001, 0.001), (9.0, OPEN_END)] {
                assert!(value(split, &outputs, &bin(low, high)).is_finite());
            }
            let outputs = random(REACH_OUTPUTS, 3, scale);
            for (is_heir, low, high) in [(1.0, -OPEN_END, OPEN_END), (-1.0, -0.001, 0.001)] {
                assert!(value(reach, &outputs, &heir(is_heir, low, high)).is_finite());
            }
        }
    }
}
