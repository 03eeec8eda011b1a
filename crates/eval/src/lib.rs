//! How trees are measured, and what the paper measured.

#![forbid(unsafe_code)]

pub mod auc;
pub mod development;
pub mod distances;
pub mod diversity;
pub mod memorisation;
mod metrics;
pub mod perceptual;
pub mod published;
pub mod report;
mod table;
pub mod tree_features;
#[cfg(feature = "two-sample")]
pub mod two_sample;

pub use metrics::{METRICS, Metric, Moments, TreeMetrics};
pub use table::{Row, Table};
