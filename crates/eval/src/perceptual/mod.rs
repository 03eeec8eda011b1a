//! The variables of a perceptual metric of trees, and the vectors made of them.
//!
//! ICTreeF (Polasek et al. 2021) describes a tree by 46 lists of samples, taken of its *chains*:
//! maximal runs of nodes without a fork. A network trained on human comparisons maps statistics
//! and histograms of these lists to a score. The weights of that network are not public, so there
//! is no score here: only the variables that it would have seen. Two sets of trees can be compared
//! by them, variable by variable.
//!
//! | step | item |
//! |---|---|
//! | tree → 46 lists of samples and 7 scalars | [`Variables::of`] |
//! | lists → count, minimum, maximum, mean, variance | [`Variables::statistics`] |
//! | lists of a reference set → edges of 8 bins | [`BinEdges::fit`] |
//! | lists → densities in the bins | [`BinEdges::histograms`] |
//!
//! The peculiarities of the published implementation change the numbers, so they are kept, and
//! described where they occur. Measures are in float32, as there. A node's thickness is its radius,
//! and the tree's first node is where its first chain starts: the edge below it is not measured.
//! Lengths are in metres, volumes in cubic metres, angles in radians; y is up.

mod chains;
mod features;
mod fitness;
mod forks;
mod pooled;
mod samples;
#[cfg(test)]
mod tests;
mod variable;

pub use features::{BINS, BinEdges, HISTOGRAMS_LEN, STATISTICS, STATISTICS_LEN};
pub use pooled::{Pooled, Scatter};
pub use samples::{Common, Samples, Variables};
pub use variable::{CONSTANT, VARIABLES, Variable, ZERO_MEAN};
