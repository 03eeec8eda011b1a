//! The columns of a table as arrays of one type each, whatever types the file stores them in.

use parquet::basic::{ConvertedType, LogicalType, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::file::reader::RowGroupReader;
use parquet::schema::types::{ColumnDescriptor, SchemaDescriptor};

use super::ReadTableError;

/// How many rows are decoded at a time. It bounds the memory that a small hostile file can ask
/// for.
const BATCH: usize = 1 << 14;

/// The columns of whole numbers.
#[derive(Clone, Copy)]
pub(super) enum Int {
    Tree,
    Id,
    Parent,
    Slot,
    Age,
    Seed,
}

const INTS: [&str; 6] = ["tree", "id", "parent", "slot", "age", "seed"];

/// The columns of real numbers.
#[derive(Clone, Copy)]
pub(super) enum Float {
    X,
    Y,
    Z,
    Radius,
    Length,
    Qx,
    Qy,
    Qz,
    Qw,
    Gravitropism,
}

const FLOATS: [&str; 10] =
    ["x", "y", "z", "radius", "length", "qx", "qy", "qz", "qw", "gravitropism"];

/// Where a column stands and how it is stored.
#[derive(Clone, Copy)]
struct Place {
    name: &'static str,
    index: usize,
    unsigned: bool,
    nullable: bool,
}

/// Where the columns stand; none for those that the table lacks.
pub(super) struct Layout {
    ints: [Option<Place>; INTS.len()],
    floats: [Option<Place>; FLOATS.len()],
    species: Option<Place>,
}

impl Layout {
    pub(super) fn find(schema: &SchemaDescriptor) -> Result<Self, ReadTableError> {
        let mut layout =
            Self { ints: [None; INTS.len()], floats: [None; FLOATS.len()], species: None };
        let whole = [Type::INT32, Type::INT64];
        for (place, name) in layout.ints.iter_mut().zip(INTS) {
            *place = find(schema, name, &whole, "whole numbers of 32 or 64 bits")?;
        }
        let real = [Type::FLOAT, Type::DOUBLE];
        for (place, name) in layout.floats.iter_mut().zip(FLOATS) {
            *place = find(schema, name, &real, "floating-point numbers of 32 or 64 bits")?;
        }
        layout.species = find(schema, "species", &[Type::BYTE_ARRAY], "text")?;
        layout.check()?;
        Ok(layout)
    }

    fn check(&self) -> Result<(), ReadTableError> {
        let ints = [Int::Id, Int::Parent].map(|c| (self.ints[c as usize], INTS[c as usize]));
        let mut floats = vec![Float::X, Float::Y, Float::Z, Float::Radius];
        let rotation = [Float::Qx, Float::Qy, Float::Qz, Float::Qw];
        // Half a rotation is a slip, not a table without rotations.
        if rotation.iter().any(|&column| self.has(column)) {
            floats.extend(rotation);
            floats.push(Float::Length);
        }
        let floats = floats.into_iter().map(|c| (self.floats[c as usize], FLOATS[c as usize]));
        for (place, column) in ints.into_iter().chain(floats) {
            place.ok_or(ReadTableError::MissingColumn { column })?;
        }
        Ok(())
    }

    fn has(&self, column: Float) -> bool {
        self.floats[column as usize].is_some()
    }

    /// Are rotations and lengths given?
    pub(super) fn has_edges(&self) -> bool {
        self.has(Float::Qw)
    }
}

fn find(
    schema: &SchemaDescriptor,
    name: &'static str,
    types: &[Type],
    wanted: &'static str,
) -> Result<Option<Place>, ReadTableError> {
    let mut columns = schema.columns().iter().enumerate();
    let found = columns.find(|(_, column)| column.path().parts() == [name]);
    let Some((index, column)) = found else { return Ok(None) };
    if column.max_rep_level() > 0 || !types.contains(&column.physical_type()) {
        let found = match column.max_rep_level() {
            0 => format!("the type {}", column.physical_type()),
            _ => "lists".to_owned(),
        };
        return Err(ReadTableError::ColumnType { column: name, found, wanted });
    }
    let nullable = column.max_def_level() > 0;
    Ok(Some(Place { name, index, unsigned: is_unsigned(column), nullable }))
}

fn is_unsigned(column: &ColumnDescriptor) -> bool {
    matches!(
        column.logical_type_ref(),
        Some(LogicalType::Integer(integer)) if !integer.is_signed
    ) || matches!(column.converted_type(), ConvertedType::UINT_32 | ConvertedType::UINT_64)
}

/// Some rows of a table. A column that the table lacks is empty.
#[derive(Default)]
pub(super) struct Batch {
    pub(super) len: usize,
    ints: [Vec<i64>; INTS.len()],
    floats: [Vec<f32>; FLOATS.len()],
    species: Vec<ByteArray>,
}

impl Batch {
    pub(super) fn int(&self, column: Int, at: usize) -> Option<i64> {
        self.ints[column as usize].get(at).copied()
    }

    pub(super) fn float(&self, column: Float, at: usize) -> Option<f32> {
        self.floats[column as usize].get(at).copied()
    }

    pub(super) fn species(&self, at: usize) -> Option<&[u8]> {
        self.species.get(at).map(ByteArray::data)
    }
}

/// A row group in the course of being read.
pub(super) struct OpenGroup {
    ints: [Option<OpenColumn>; INTS.len()],
    floats: [Option<OpenColumn>; FLOATS.len()],
    species: Option<OpenColumn>,
}

struct OpenColumn {
    place: Place,
    reader: ColumnReader,
}

impl OpenGroup {
    pub(super) fn open(
        group: &dyn RowGroupReader,
        layout: &Layout,
    ) -> Result<Self, ReadTableError> {
        let open = |place: &Option<Place>| match place {
            Some(place) => {
                let reader = group.get_column_reader(place.index)?;
                Ok(Some(OpenColumn { place: *place, reader }))
            }
            None => Ok::<_, ReadTableError>(None),
        };
        let mut this = Self {
            ints: [const { None }; INTS.len()],
            floats: [const { None }; FLOATS.len()],
            species: open(&layout.species)?,
        };
        for (column, place) in this.ints.iter_mut().zip(&layout.ints) {
            *column = open(place)?;
        }
        for (column, place) in this.floats.iter_mut().zip(&layout.floats) {
            *column = open(place)?;
        }
        Ok(this)
    }

    /// Replaces the rows of `batch` by the next ones, none at the end of the row group. `before`
    /// rows stand before them in the file.
    pub(super) fn read(&mut self, batch: &mut Batch, before: u64) -> Result<(), ReadTableError> {
        let mut len = None;
        let mut check = |column: &OpenColumn, found: usize| {
            if *len.get_or_insert(found) == found {
                Ok(())
            } else {
                Err(ReadTableError::Ragged { column: column.place.name })
            }
        };
        for (column, values) in self.ints.iter_mut().zip(&mut batch.ints) {
            let Some(column) = column else { continue };
            column.ints(values, before)?;
            check(column, values.len())?;
        }
        for (column, values) in self.floats.iter_mut().zip(&mut batch.floats) {
            let Some(column) = column else { continue };
            column.floats(values, before)?;
            check(column, values.len())?;
        }
        if let Some(column) = &mut self.species {
            column.bytes(&mut batch.species, before)?;
            check(column, batch.species.len())?;
        }
        batch.len = len.unwrap_or(0);
        Ok(())
    }
}

impl OpenColumn {
    fn ints(&mut self, out: &mut Vec<i64>, before: u64) -> Result<(), ReadTableError> {
        let unsigned = self.place.unsigned;
        let widen =
            |value: i32| if unsigned { i64::from(value.cast_unsigned()) } else { i64::from(value) };
        out.clear();
        match &mut self.reader {
            ColumnReader::Int32ColumnReader(reader) => {
                out.extend(values(reader, &self.place, before)?.into_iter().map(widen));
            }
            ColumnReader::Int64ColumnReader(reader) => {
                *out = values(reader, &self.place, before)?;
            }
            _ => return Err(self.wrong_type("whole numbers")),
        }
        Ok(())
    }

    fn floats(&mut self, out: &mut Vec<f32>, before: u64) -> Result<(), ReadTableError> {
        out.clear();
        match &mut self.reader {
            ColumnReader::FloatColumnReader(reader) => {
                *out = values(reader, &self.place, before)?;
            }
            ColumnReader::DoubleColumnReader(reader) => {
                let doubles = values(reader, &self.place, before)?;
                out.extend(doubles.into_iter().map(|value| value as f32));
            }
            _ => return Err(self.wrong_type("floating-point numbers")),
        }
        Ok(())
    }

    fn bytes(&mut self, out: &mut Vec<ByteArray>, before: u64) -> Result<(), ReadTableError> {
        match &mut self.reader {
            ColumnReader::ByteArrayColumnReader(reader) => {
                *out = values(reader, &self.place, before)?;
                Ok(())
            }
            _ => Err(self.wrong_type("text")),
        }
    }

    /// A row group whose column is not of the type that the schema tells.
    fn wrong_type(&self, wanted: &'static str) -> ReadTableError {
        let found = "another type than the schema says".to_owned();
        ReadTableError::ColumnType { column: self.place.name, found, wanted }
    }
}

/// The next values of a column, at most [`BATCH`].
fn values<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    place: &Place,
    before: u64,
) -> Result<Vec<T::T>, ReadTableError> {
    let (mut out, mut levels) = (Vec::new(), Vec::new());
    while out.len() < BATCH {
        let levels = place.nullable.then_some(&mut levels);
        let (records, _, _) = reader.read_records(BATCH - out.len(), levels, None, &mut out)?;
        if records == 0 {
            break;
        }
    }
    // Levels of a column that can hold nulls: 0 where it does.
    match levels.iter().position(|&level| level == 0) {
        Some(at) => Err(ReadTableError::Null { row: before + at as u64 + 1, column: place.name }),
        None => Ok(out),
    }
}
