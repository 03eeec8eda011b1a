//! Skeleton tables in Parquet: the rows of [`deeptree_graph::codec::csv`] in columns, with what all
//! nodes of a tree share.
//!
//! | column | as written | unit |
//! |---|---|---|
//! | `tree`, `id` | `INT32`, unsigned | – |
//! | `parent` | `INT32`; −1 at the root | – |
//! | `x`, `y`, `z` | `FLOAT`; tip of the internode, y up | m |
//! | `radius` | `FLOAT` | m |
//! | `order`, `slot` | `INT32`; `order` is never read: it follows from the slots | – |
//! | `length` | `FLOAT` | m |
//! | `qx`, `qy`, `qz`, `qw` | `FLOAT`; against the parent's frame | unit quaternion |
//! | `species` | `BYTE_ARRAY`, UTF-8 | – |
//! | `age` | `INT32` | growth cycles |
//! | `gravitropism` | `FLOAT` | – |
//! | `seed` | `INT64`, unsigned | – |
//!
//! The hash of the model that grew the trees is in the file's metadata under [`MODEL_KEY`], and
//! what stood around tree `k` under [`ENVIRONMENT_KEY`] and `k`: the text of a scene file, with the
//! line `form = "…"` before it for a tree that was kept in a volume.
//!
//! Tables written elsewhere may leave out the columns that a CSV table may, and the last four; may
//! have others besides; and may use 32 or 64 bits for a number, and columns that could hold nulls
//! but do not. The rows of a tree stand together.

mod read;
mod write;

pub use read::{ReadTableError, TableReader};
pub use write::{TableMeta, TableWriter, WriteTableError};

/// Key of the model's hash in the metadata of the file.
pub const MODEL_KEY: &str = "deeptree.model";

/// Key of what stood around a tree in the metadata of the file, up to the tree's number.
pub const ENVIRONMENT_KEY: &str = "deeptree.environment.";

/// Key in the file's metadata, followed by the number of a tree, of the stand it has grown in.
pub const STAND_KEY: &str = "deeptree.stand.";

#[cfg(test)]
mod tests;
