//! From a table to clouds.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};

use bytes::Bytes;
use parquet::basic::{ConvertedType, LogicalType, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::{ColumnDescriptor, SchemaDescriptor};

use crate::cloud::Up;
use crate::columns::Attributes;
use crate::error::ReadCloudError;
use crate::gather::{Gather, ReadOptions, Reading};
use crate::names::{Layout, field};

use super::UP_KEY;

/// Why a table holds no points that can be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum TableError {
    #[error("it may be damaged or cut off")]
    Parquet(#[from] ParquetError),
    #[error("its parts contradict each other")]
    Damaged,
    #[error("it has no columns `x`, `y` and `z` of numbers")]
    NoPoints,
    #[error("it is a table of skeletons, not of points")]
    Skeletons,
}

/// How many rows are decoded at a time; it bounds the memory that a small hostile file can ask for.
const BATCH: usize = 1 << 14;

/// Reads all points of a table as one cloud.
///
/// # Errors
///
/// When the file is no Parquet file, has no coordinates, or has no points.
pub fn read(file: File, options: &ReadOptions) -> Result<Reading, ReadCloudError> {
    all(Rows::open(|| Ok(Box::new(SerializedFileReader::new(file)?)))?, options)
}

/// As [`read`], from the bytes of a file.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(bytes: Vec<u8>, options: &ReadOptions) -> Result<Reading, ReadCloudError> {
    let bytes = Bytes::from(bytes);
    all(Rows::open(|| Ok(Box::new(SerializedFileReader::new(bytes)?)))?, options)
}

/// Does a file hold a table of points?
#[must_use]
pub fn holds_points(file: File) -> bool {
    Rows::open(|| Ok(Box::new(SerializedFileReader::new(file)?))).is_ok()
}

fn all(mut rows: Rows, options: &ReadOptions) -> Result<Reading, ReadCloudError> {
    let mut gather = rows.gather(options);
    while let Some(row) = rows.next()? {
        match row.point {
            Some((place, attributes)) => gather.push(place, &attributes)?,
            None => gather.dropped().not_finite += 1,
        }
    }
    gather.finish()
}

/// Reads the clouds of a table one by one, with their numbers; ends after the first error.
pub struct Scans {
    rows: Rows,
    options: ReadOptions,
    /// The first row of the cloud to come.
    waiting: Option<Row>,
    ended: bool,
}

impl std::fmt::Debug for Scans {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scans").field("options", &self.options).finish_non_exhaustive()
    }
}

impl Scans {
    /// Opens a table.
    ///
    /// # Errors
    ///
    /// When the file is no Parquet file or has no coordinates.
    pub fn open(file: File, options: &ReadOptions) -> Result<Self, ReadCloudError> {
        let rows = Rows::open(|| Ok(Box::new(SerializedFileReader::new(file)?)))?;
        Ok(Self { rows, options: *options, waiting: None, ended: false })
    }

    fn next_scan(&mut self) -> Result<Option<(u32, Reading)>, ReadCloudError> {
        let first = match self.waiting.take() {
            Some(row) => Some(row),
            None => self.rows.next()?,
        };
        let Some(first) = first else { return Ok(None) };
        let tree = first.tree;
        let mut gather = self.rows.gather(&self.options);
        let mut row = Some(first);
        while let Some(one) = row {
            if one.tree != tree {
                self.waiting = Some(one);
                break;
            }
            match one.point {
                Some((place, attributes)) => gather.push(place, &attributes)?,
                None => gather.dropped().not_finite += 1,
            }
            row = self.rows.next()?;
        }
        Ok(Some((tree, gather.finish()?)))
    }
}

impl Iterator for Scans {
    type Item = Result<(u32, Reading), ReadCloudError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let scan = self.next_scan().transpose();
        self.ended = !matches!(scan, Some(Ok(_)));
        scan
    }
}

/// One row; no point where a coordinate is missing.
struct Row {
    tree: u32,
    point: Option<([f64; 3], Attributes)>,
}

/// A column of numbers and where it stands.
#[derive(Clone, Copy)]
struct Column {
    index: usize,
    is_nullable: bool,
    is_unsigned: bool,
}

/// The rows of a table, in order.
struct Rows {
    file: Box<dyn FileReader>,
    columns: Vec<Column>,
    layout: Layout,
    tree: Option<usize>,
    next_group: usize,
    group: Vec<ColumnReader>,
    /// The rows that were decoded, column by column.
    batch: Vec<Vec<Option<f64>>>,
    at: usize,
}

impl Rows {
    fn open(
        file: impl FnOnce() -> Result<Box<dyn FileReader>, TableError>,
    ) -> Result<Self, ReadCloudError> {
        let file = contained(file)?;
        let schema = file.metadata().file_metadata().schema_descr();
        let (names, columns) = columns(schema);
        if names.iter().any(|name| name == "parent") {
            return Err(TableError::Skeletons.into());
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let layout = Layout::of_names(&names).ok_or(TableError::NoPoints)?;
        let tree = names.iter().position(|name| *name == "tree");
        let (group, batch) = (Vec::new(), Vec::new());
        Ok(Self { file, columns, layout, tree, next_group: 0, group, batch, at: 0 })
    }

    fn gather(&self, options: &ReadOptions) -> Gather {
        let notes = self.file.metadata().file_metadata().key_value_metadata();
        let note = notes.and_then(|notes| notes.iter().find(|note| note.key == UP_KEY));
        let up = match note.and_then(|note| note.value.as_deref()) {
            Some("y") => Up::Y,
            Some("z") => Up::Z,
            _ => options.up,
        };
        Gather::new(ReadOptions { up, ..*options }, self.layout.present())
    }

    fn next(&mut self) -> Result<Option<Row>, ReadCloudError> {
        while self.at == self.batch.first().map_or(0, Vec::len) {
            if !contained(|| self.next_batch())? {
                return Ok(None);
            }
        }
        let at = self.at;
        self.at += 1;
        let value = |k: usize| self.batch[k][at];
        let tree = self.tree.and_then(value).unwrap_or_default() as u32;
        let row: [Option<f64>; MOST] =
            std::array::from_fn(|k| if k < self.batch.len() { value(k) } else { None });
        Ok(Some(Row { tree, point: self.layout.point(&row) }))
    }

    /// Decodes more rows; false at the end of the table.
    fn next_batch(&mut self) -> Result<bool, TableError> {
        self.at = 0;
        self.batch.clear();
        if self.group.is_empty() {
            if self.next_group == self.file.num_row_groups() {
                return Ok(false);
            }
            let group = self.file.get_row_group(self.next_group)?;
            self.next_group += 1;
            let open = |column: &Column| group.get_column_reader(column.index);
            self.group = self.columns.iter().map(open).collect::<Result<_, _>>()?;
        }
        for (reader, column) in self.group.iter_mut().zip(&self.columns) {
            self.batch.push(numbers(reader, *column)?);
        }
        let rows = self.batch[0].len();
        if self.batch.iter().any(|column| column.len() != rows) {
            return Err(TableError::Damaged);
        }
        if rows == 0 {
            self.group.clear();
        }
        Ok(true)
    }
}

/// Columns that mean something: the number of the tree, three coordinates, six attributes.
const MOST: usize = 10;

/// The names and places of the columns of numbers that mean something, each once.
fn columns(schema: &SchemaDescriptor) -> (Vec<String>, Vec<Column>) {
    let known = |name: &str| {
        ["tree", "x", "y", "z", "parent"].contains(&name)
            || crate::columns::Columns::NAMES.contains(&name)
    };
    let (mut names, mut columns): (Vec<String>, Vec<Column>) = (Vec::new(), Vec::new());
    for (index, column) in schema.columns().iter().enumerate() {
        let [name] = column.path().parts() else { continue };
        let name = field(name);
        let numbers = [Type::INT32, Type::INT64, Type::FLOAT, Type::DOUBLE];
        let is_number = column.max_rep_level() == 0 && numbers.contains(&column.physical_type());
        if is_number && known(&name) && !names.contains(&name) {
            names.push(name);
            let is_nullable = column.max_def_level() > 0;
            columns.push(Column { index, is_nullable, is_unsigned: is_unsigned(column) });
        }
    }
    (names, columns)
}

fn is_unsigned(column: &ColumnDescriptor) -> bool {
    matches!(
        column.logical_type_ref(),
        Some(LogicalType::Integer(integer)) if !integer.is_signed
    ) || column.converted_type() == ConvertedType::UINT_32
}

/// The next numbers of a column, at most [`BATCH`].
fn numbers(reader: &mut ColumnReader, column: Column) -> Result<Vec<Option<f64>>, TableError> {
    let nullable = column.is_nullable;
    match reader {
        ColumnReader::Int32ColumnReader(reader) if column.is_unsigned => {
            values(reader, nullable, |v| f64::from(v.cast_unsigned()))
        }
        ColumnReader::Int32ColumnReader(reader) => values(reader, nullable, f64::from),
        ColumnReader::Int64ColumnReader(reader) => values(reader, nullable, |v| v as f64),
        ColumnReader::FloatColumnReader(reader) => values(reader, nullable, f64::from),
        ColumnReader::DoubleColumnReader(reader) => values(reader, nullable, |v| v),
        _ => Err(TableError::Damaged),
    }
}

fn values<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    nullable: bool,
    widen: impl Fn(T::T) -> f64,
) -> Result<Vec<Option<f64>>, TableError> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    loop {
        let rows = if nullable { levels.len() } else { values.len() };
        let wanted = nullable.then_some(&mut levels);
        let (records, _, _) = reader.read_records(BATCH - rows, wanted, None, &mut values)?;
        if records == 0 || rows + records >= BATCH {
            break;
        }
    }
    let mut values = values.into_iter().map(widen);
    if !nullable {
        return Ok(values.map(Some).collect());
    }
    Ok(levels.into_iter().map(|level| if level > 0 { values.next() } else { None }).collect())
}

/// Runs a part of the Parquet library, which panics on some damaged files, and turns its panics
/// into errors. Nothing that a panic leaves half-done is used again: the reader ends.
fn contained<T>(read: impl FnOnce() -> Result<T, TableError>) -> Result<T, TableError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or(Err(TableError::Damaged))
}
