//! The forward pass of a dense layer, with the same bits on every path.
//!
//! `y[r][o] = act(bias[o] + Σ x[r][i]·w[i][o])`, over the inputs that are not zero.
//!
//! The sum starts at the bias, takes the inputs in index order and rounds after every multiply and
//! after every add. Paths differ only in how many outputs they hold in registers at once; rows and
//! outputs never meet in a sum, so neither the width nor the batch can change a bit. Fused
//! multiply-add is out: WebAssembly has none. The vectors are those of `fearless_simd`, so there is
//! no unsafe code here.
//!
//! Most inputs are zero ([`Rows`]), so those that are not are listed first, and the sums run over
//! the list. This gives the full sum: weights are finite, so the product with a zero is a zero, and
//! a sum to which a zero is added stays what it is. Only a sum that is itself zero can get another
//! sign, which the rectifier, and any sum that goes on, takes away again.

mod dispatch;
mod path;
mod rows;
mod scalar;
mod strip;

use core::ops::Range;

pub(crate) use dispatch::{run, thin};
pub use path::{SimdPath, UnknownPath};
pub(crate) use rows::Rows;

/// Outputs a panel holds: the lanes of the widest vector register there is.
pub(crate) const LANES: usize = 16;

/// The weights of one input to the outputs of one panel; aligned so that no load crosses a cache
/// line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f32; LANES]);

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}

/// A layer as the kernels stream it: outputs cut into panels of [`LANES`], the last one padded
/// with zeros.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Packed {
    /// How many inputs a row has.
    pub(crate) inputs: usize,
    /// `[panels][inputs]`.
    pub(crate) weights: Vec<Lanes>,
    /// `[panels]`.
    pub(crate) bias: Vec<Lanes>,
}

impl Packed {
    /// Floats from one row of outputs to the next.
    pub(crate) fn output_stride(&self) -> usize {
        self.bias.len() * LANES
    }
}

/// What a layer does with its sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activation {
    /// Nothing.
    Linear,
    /// `v > 0 ? v : 0`; −0 and NaN give +0.
    Relu,
}

/// Rows to send through a layer.
pub(crate) struct Job<'a> {
    /// The layer.
    pub(crate) layer: &'a Packed,
    /// What it does with its sums.
    pub(crate) activation: Activation,
    /// What it reads: rows of `layer.inputs` numbers.
    pub(crate) inputs: &'a Rows,
    /// Which of these rows.
    pub(crate) rows: Range<usize>,
    /// `[rows][layer.output_stride()]`.
    pub(crate) outputs: &'a mut [f32],
}

/// Rows with their zeros.
#[derive(Clone, Copy)]
pub(crate) struct Full<'a> {
    /// `[rows][width]`.
    pub(crate) values: &'a [f32],
    /// Floats of a row.
    pub(crate) width: usize,
    /// Which number of its row the first of these is.
    pub(crate) first: u32,
}
