//! From clouds to a table.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding};
use parquet::data_type::{DataType, DoubleType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use parquet::schema::types::ColumnPath;

use crate::cloud::{Cloud, Up};
use crate::columns::Columns;

use super::UP_KEY;

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteCloudError {
    /// The output failed.
    #[error("the Parquet table could not be written")]
    Parquet(#[from] ParquetError),
    /// The clouds of one table have the same columns, origin and axes.
    #[error("cloud {tree} has other columns, another origin or other axes than the first")]
    Unlike {
        /// The number of the cloud.
        tree: u32,
    },
}

/// Rows of a group: some 5 MB.
const GROUP_ROWS: usize = 200_000;

/// Writes one cloud.
///
/// # Errors
///
/// When the output fails.
pub fn write(cloud: &Cloud, out: &mut (impl Write + Send)) -> Result<(), WriteCloudError> {
    let shape = Shape { is_numbered: false, ..Shape::of(cloud) };
    let mut file = open(out, &shape)?;
    write_rows(&mut file, cloud, &shape, 0)?;
    file.close()?;
    Ok(())
}

/// What all clouds of a table have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    is_numbered: bool,
    is_far: bool,
    up: Up,
    present: [bool; 6],
}

impl Shape {
    fn of(cloud: &Cloud) -> Self {
        Self {
            is_numbered: true,
            is_far: cloud.origin != [0.0; 3],
            up: cloud.up,
            present: cloud.columns.present(),
        }
    }

    fn schema(&self) -> String {
        let mut text = "message points {\n".to_owned();
        if self.is_numbered {
            text.push_str("REQUIRED INT32 tree (INTEGER(32,false));\n");
        }
        for axis in ["x", "y", "z"] {
            let kind = if self.is_far { "DOUBLE" } else { "FLOAT" };
            text.push_str(&format!("REQUIRED {kind} {axis};\n"));
        }
        for (name, present) in Columns::NAMES.iter().zip(self.present) {
            match *name {
                _ if !present => {}
                "intensity" => text.push_str("REQUIRED FLOAT intensity;\n"),
                name => text.push_str(&format!("REQUIRED INT32 {name} (INTEGER(32,false));\n")),
            }
        }
        text + "}"
    }

    fn properties(&self) -> WriterProperties {
        let up = if self.up == Up::Y { "y" } else { "z" };
        let note = KeyValue::new(UP_KEY.to_owned(), up.to_owned());
        let mut properties = WriterProperties::builder()
            .set_created_by("deeptree".to_owned())
            .set_compression(Compression::SNAPPY)
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_offset_index_disabled(true)
            .set_key_value_metadata(Some(vec![note]));
        for axis in ["x", "y", "z"].map(ColumnPath::from) {
            properties = properties
                .set_column_dictionary_enabled(axis.clone(), false)
                .set_column_encoding(axis, Encoding::BYTE_STREAM_SPLIT);
        }
        properties.build()
    }
}

fn open<W: Write + Send>(out: W, shape: &Shape) -> Result<SerializedFileWriter<W>, ParquetError> {
    let schema = Arc::new(parse_message_type(&shape.schema())?);
    SerializedFileWriter::new(out, schema, Arc::new(shape.properties()))
}

/// Writes a table of numbered clouds, one by one. Equal clouds give equal bytes.
pub struct ScanWriter<W: Write + Send> {
    file: SerializedFileWriter<W>,
    shape: Shape,
}

impl<W: Write + Send> std::fmt::Debug for ScanWriter<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ScanWriter").field("shape", &self.shape).finish_non_exhaustive()
    }
}

impl<W: Write + Send> ScanWriter<W> {
    /// Starts a table of clouds that are all like `first` in columns, origin and axes.
    ///
    /// # Errors
    ///
    /// When `out` cannot be written to.
    pub fn new(out: W, first: &Cloud) -> Result<Self, WriteCloudError> {
        let shape = Shape::of(first);
        Ok(Self { file: open(out, &shape)?, shape })
    }

    /// Appends a cloud under a number, which no other cloud may have.
    ///
    /// # Errors
    ///
    /// When the output fails or the cloud is unlike the first.
    pub fn write(&mut self, tree: u32, cloud: &Cloud) -> Result<(), WriteCloudError> {
        if Shape::of(cloud) != self.shape {
            return Err(WriteCloudError::Unlike { tree });
        }
        Ok(write_rows(&mut self.file, cloud, &self.shape, tree)?)
    }

    /// Ends the table, which is unreadable before, and gives the output back.
    ///
    /// # Errors
    ///
    /// When the output fails.
    pub fn finish(self) -> Result<W, WriteCloudError> {
        Ok(self.file.into_inner()?)
    }
}

fn write_rows<W: Write + Send>(
    file: &mut SerializedFileWriter<W>,
    cloud: &Cloud,
    shape: &Shape,
    tree: u32,
) -> Result<(), ParquetError> {
    for first in (0..cloud.len()).step_by(GROUP_ROWS) {
        let rows = first..cloud.len().min(first + GROUP_ROWS);
        let mut group = file.next_row_group()?;
        if shape.is_numbered {
            put::<Int32Type, W>(&mut group, &vec![tree.cast_signed(); rows.len()])?;
        }
        for axis in 0..3 {
            let offsets = cloud.points[rows.clone()].iter().map(|p| p[axis]);
            if shape.is_far {
                let far = offsets.map(|c| cloud.origin[axis] + f64::from(c));
                put::<DoubleType, W>(&mut group, &far.collect::<Vec<f64>>())?;
            } else {
                put::<FloatType, W>(&mut group, &offsets.collect::<Vec<f32>>())?;
            }
        }
        write_attributes(&mut group, &cloud.columns, rows)?;
        group.close()?;
    }
    Ok(())
}

fn write_attributes<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    columns: &Columns,
    rows: std::ops::Range<usize>,
) -> Result<(), ParquetError> {
    if let Some(column) = &columns.intensity {
        put::<FloatType, W>(group, &column[rows.clone()])?;
    }
    let mut whole = |values: Vec<u32>| {
        let values: Vec<i32> = values.into_iter().map(u32::cast_signed).collect();
        put::<Int32Type, W>(group, &values)
    };
    if let Some(column) = &columns.class {
        whole(column[rows.clone()].iter().map(|class| u32::from(class.code())).collect())?;
    }
    if let Some(column) = &columns.branch {
        whole(column[rows.clone()].to_vec())?;
    }
    if let Some(column) = &columns.order {
        whole(column[rows.clone()].iter().copied().map(u32::from).collect())?;
    }
    if let Some(column) = &columns.node {
        whole(column[rows.clone()].to_vec())?;
    }
    if let Some(column) = &columns.station {
        whole(column[rows].iter().copied().map(u32::from).collect())?;
    }
    Ok(())
}

fn put<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[T::T],
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("more columns than the schema has".to_owned()));
    };
    column.typed::<T>().write_batch(values, None, None)?;
    column.close()
}
