//! Corpora: folders of grown trees that networks are trained and judged on.
//!
//! ```text
//! DIR/corpus.toml               the plan: species, trees, seeds, split
//! DIR/<species>-<shard>.parquet skeleton tables of a few trees each
//! DIR/<species>-<shard>.scans.parquet, where there are scans: a point cloud of each of them
//! ```
//!
//! [`build`] makes a corpus from a [`CorpusPlan`] and goes on where it was stopped; [`Corpus`]
//! reads it. Tree `k` of every species has the seed `first_seed + k`, and the plan alone decides
//! which trees are for training: a corpus has the same bytes wherever it is built. A plan may have
//! the age and the gravitropism of each tree drawn from ranges, put each into a random scene of its
//! own, and keep each within a form. What stood around a tree is stored with it, in the metadata of
//! its shard.
//!
//! [`build_stands`] makes a corpus of another kind: trees that have grown together.
//!
//! [`build_scans`] adds a simulated scan of each tree. Scans are no part of what a corpus is: they can
//! be made again from its trees.

#![forbid(unsafe_code)]

mod builder;
mod corpus;
mod plan;
mod priors;
mod scans;
mod shard;
mod stands;

pub use builder::{BuildError, BuildReport, Progress, build};
pub use corpus::{Corpus, CorpusError, Trees};
pub use plan::{CorpusPlan, PLAN_FILE, PlanError, Split};
pub use priors::{Priors, Span, SpansError};
pub use scans::{CorpusScan, ScanError, build_scans};
pub use shard::{CorpusTree, ShardError};
pub use stands::{
    Alone, Plant, STANDS_FILE, StandTree, Stands, StandsError, StandsPlan, build_stands,
};
