//! Point clouds as scanners write them.
//!
//! ```
//! let text = "# x y z intensity\n448262.125 5411932.5 170.25 900\n448262.5 5411932.5 171.75 40\n";
//! let reading = deeptree_cloud::xyz::read(text.as_bytes(), &Default::default()).unwrap();
//! let cloud = reading.cloud;
//! assert_eq!(cloud.len(), 2);
//! assert_eq!(cloud.position(1), [448262.5, 5411932.5, 171.75]);
//! assert_eq!(cloud.columns.intensity, Some(vec![900.0, 40.0]));
//! assert!(reading.dropped.is_empty());
//! ```
//!
//! A [`Cloud`] holds places in `f32` relative to an origin in `f64`, so that coordinates of a land
//! survey keep their precision. Readers drop what is no point, count it in [`Dropped`], and can
//! thin while they read, so that memory stays bounded whatever the file.
//!
//! | format | module |
//! |---|---|
//! | text, one point a line: `.xyz .txt .csv .asc .pts` | [`xyz`] |
//! | Stanford PLY, ascii or binary | [`ply`] |
//! | LAS 1.0 to 1.4, and LAZ with the feature `laz` | [`las`] |
//! | Parquet, with the feature `parquet` | `table` |

#![forbid(unsafe_code)]

mod cloud;
mod columns;
mod error;
mod files;
mod gather;
pub mod las;
mod names;
pub mod ply;
#[cfg(feature = "parquet")]
pub mod table;
#[cfg(test)]
mod testing;
mod thin;
pub mod xyz;

pub use cloud::{Cloud, Up};
pub use columns::{Attributes, Class, Columns};
pub use error::ReadCloudError;
pub use files::read_file;
pub use gather::{Dropped, ReadOptions, Reading};
