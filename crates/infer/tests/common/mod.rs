//! Pseudo-random networks.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used, reason = "shared by the tests")]

pub mod situated;

use deeptree_graph::{Draws, Lineage, Purpose, Seed};
use deeptree_infer::{Dense, Mlp};

/// The draws of test case `seed`.
pub fn draws(seed: u64) -> Draws {
    Seed(seed).draws(Lineage::ROOT, Purpose::InitialWeights)
}

/// Uniform numbers in [-scale, scale).
pub fn values(draws: &mut Draws, count: usize, scale: f32) -> Vec<f32> {
    (0..count).map(|_| scale * (2.0 * draws.uniform() as f32 - 1.0)).collect()
}

/// The numbers of one layer: inputs, outputs, weight `[inputs, outputs]`, bias.
pub type Numbers = (usize, usize, Vec<f32>, Vec<f32>);

/// The layers of a network of the given widths, scaled so that activations stay about 1.
pub fn layers(draws: &mut Draws, widths: &[usize]) -> Vec<Numbers> {
    let layer = |w: &[usize]| {
        let scale = (3.0 / w[0] as f32).sqrt();
        (w[0], w[1], values(draws, w[0] * w[1], scale), values(draws, w[1], 0.5))
    };
    widths.windows(2).map(layer).collect()
}

/// The network of these layers.
pub fn mlp(layers: &[Numbers]) -> Mlp {
    let dense = |(inputs, outputs, weight, bias): &Numbers| {
        Dense::new(*inputs, *outputs, weight, bias).unwrap()
    };
    Mlp::new(layers.iter().map(dense).collect()).unwrap()
}

/// Compares numbers bit by bit.
pub fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}
