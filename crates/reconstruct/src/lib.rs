//! From a point cloud to a branch graph, and how well the two agree.

#![forbid(unsafe_code)]

pub mod fit;
mod kdtree;

pub use fit::Fit;
pub use kdtree::KdTree;
