//! Trees as files: skeleton tables in CSV, the text format of ICTree, and a tree as its seed.
//!
//! Skeleton tables in Parquet need a library and live in `deeptree-export`.

pub mod csv;
pub mod dtree;
pub mod tree_format;
