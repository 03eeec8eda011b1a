//! How trees are measured, and what the paper measured.

#![forbid(unsafe_code)]

pub mod auc;
pub mod calibration;
pub mod criteria;
pub mod development;
pub mod distances;
pub mod diversity;
pub mod histogram;
mod intersections;
pub mod jackknife;
pub mod memorisation;
mod metrics;
mod packed;
pub mod perceptual;
pub mod published;
pub mod report;
mod set;
mod table;
pub mod tree_features;
#[cfg(feature = "two-sample")]
pub mod two_sample;

pub use intersections::{intersections, intersections_between};
pub use metrics::{METRICS, Metric, Moments, TreeMetrics};
pub use set::{ORDERS, Slice, TreeRecord, TreeSet};
pub use table::{Row, Table, mean_and_sd};
