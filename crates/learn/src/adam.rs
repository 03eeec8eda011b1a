//! Adam and the running average of the weights, on flat parameters.
//!
//! Written here rather than taken from Burn, so that a checkpoint holds the whole state and a
//! resumed run continues bit for bit.

use burn::tensor::Tensor;

/// Decay of the first moment, of the second, and what keeps the division finite: the values of
/// Kingma and Ba 2015.
const BETA1: f64 = 0.9;
const BETA2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Everything that changes while a network trains.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Parameters.
    pub(crate) parameters: Tensor<1>,
    /// Running mean of the gradient.
    pub(crate) first: Tensor<1>,
    /// Running mean of its square.
    pub(crate) second: Tensor<1>,
    /// Running average of the parameters: what is validated and written.
    pub(crate) average: Tensor<1>,
    /// Steps taken.
    pub(crate) step: u64,
}

impl State {
    pub(crate) fn new(parameters: Tensor<1>) -> Self {
        let zeros = parameters.zeros_like();
        Self {
            first: zeros.clone(),
            second: zeros,
            average: parameters.clone(),
            parameters,
            step: 0,
        }
    }

    /// One step of Adam, and one of the average.
    ///
    /// `m ← β₁m + (1−β₁)g`, `v ← β₂v + (1−β₂)g²`, `θ ← θ − λ · m̂ / (√v̂ + ε)` with the hats
    /// corrected for the start at zero; `average ← d · average + (1−d) · θ` with
    /// `d = min(decay, (1 + step) / (10 + step))`, so that the start is forgotten soon.
    ///
    /// # Source
    ///
    /// Kingma and Ba 2015, "Adam", Algorithm 1.
    pub(crate) fn update(self, gradient: Tensor<1>, learning_rate: f64, decay: f64) -> Self {
        let step = self.step + 1;
        let first = self.first * BETA1 + gradient.clone() * (1.0 - BETA1);
        let second = self.second * BETA2 + gradient.square() * (1.0 - BETA2);
        let unbias = |beta: f64| 1.0 - beta.powf(step as f64);
        let root = (second.clone() / unbias(BETA2)).sqrt() + EPSILON;
        let change = first.clone() / root * (learning_rate / unbias(BETA1));
        let parameters = self.parameters - change;
        let decay = decay.min((1 + step) as f64 / (10 + step) as f64);
        let average = self.average * decay + parameters.clone() * (1.0 - decay);
        Self { parameters, first, second, average, step }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mlp::{flat, values};
    use burn::tensor::Device;

    fn state(values: &[f32]) -> State {
        State::new(flat(values.to_vec(), &Device::flex()))
    }

    #[test]
    fn the_first_step_is_the_learning_rate_against_the_sign_of_the_gradient() {
        let gradient = flat(vec![5.0, -0.01], &Device::flex());
        let after = state(&[1.0, 1.0]).update(gradient, 0.1, 0.0);
        let parameters = values(after.parameters);
        assert!((parameters[0] - 0.9).abs() < 1e-5 && (parameters[1] - 1.1).abs() < 1e-5);
        assert_eq!(values(after.average), parameters);
    }

    #[test]
    fn a_parabola_is_descended_to_its_lowest_point() {
        let mut state = state(&[4.0]);
        for _ in 0..800 {
            let gradient = (state.parameters.clone() - 1.5) * 2.0;
            state = state.update(gradient, 0.02, 0.9);
        }
        assert!((values(state.parameters)[0] - 1.5).abs() < 1e-3);
        assert!((values(state.average)[0] - 1.5).abs() < 1e-3);
    }
}
