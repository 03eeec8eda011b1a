//! How trees are measured, and what the paper measured.

#![forbid(unsafe_code)]

mod metrics;
pub mod perceptual;
pub mod published;
mod table;

pub use metrics::{METRICS, Metric, Moments, TreeMetrics};
pub use table::{Row, Table};
