//! From trees to a table.

use std::io::Write;
use std::sync::Arc;

use deeptree_graph::{BranchGraph, Node};
use parquet::basic::{Compression, Encoding};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, FloatType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use parquet::schema::types::ColumnPath;

use super::{ENVIRONMENT_KEY, MODEL_KEY, STAND_KEY};

/// A row group is closed by the tree that brings it to this many rows: about 5 MB, small enough to
/// hold in memory, large enough for columns to compress well.
const GROUP_ROWS: usize = 100_000;

const SCHEMA: &str = "
message skeleton {
  REQUIRED INT32 tree (INTEGER(32,false));
  REQUIRED INT32 id (INTEGER(32,false));
  REQUIRED INT32 parent;
  REQUIRED FLOAT x;
  REQUIRED FLOAT y;
  REQUIRED FLOAT z;
  REQUIRED FLOAT radius;
  REQUIRED INT32 order;
  REQUIRED INT32 slot;
  REQUIRED FLOAT length;
  REQUIRED FLOAT qx;
  REQUIRED FLOAT qy;
  REQUIRED FLOAT qz;
  REQUIRED FLOAT qw;
  REQUIRED BYTE_ARRAY species (STRING);
  REQUIRED INT32 age (INTEGER(32,false));
  REQUIRED FLOAT gravitropism;
  REQUIRED INT64 seed (INTEGER(64,false));
}";

/// What holds for all trees of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TableMeta {
    /// Hash of the model that grew the trees, in hexadecimal digits; none for other trees.
    pub model: Option<String>,
}

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum WriteTableError {
    #[error("the Parquet table could not be written")]
    Parquet(#[from] ParquetError),
    #[error("tree {tree} has {nodes} nodes; the `parent` column numbers at most 2147483647")]
    TooManyNodes { tree: u32, nodes: usize },
}

/// Writes a table tree by tree. Equal trees give equal bytes.
pub struct TableWriter<W: Write + Send> {
    file: SerializedFileWriter<W>,
    rows: Rows,
}

impl<W: Write + Send> std::fmt::Debug for TableWriter<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TableWriter").field("waiting_rows", &self.rows.id.len()).finish()
    }
}

impl<W: Write + Send> TableWriter<W> {
    /// Starts a table.
    ///
    /// # Errors
    ///
    /// When `out` cannot be written to.
    pub fn new(out: W, meta: &TableMeta) -> Result<Self, WriteTableError> {
        let schema = Arc::new(parse_message_type(SCHEMA)?);
        let file = SerializedFileWriter::new(out, schema, Arc::new(properties(meta)))?;
        Ok(Self { file, rows: Rows::default() })
    }

    /// Appends the rows of one tree under the number `tree`, which no other tree may have.
    ///
    /// # Errors
    ///
    /// When the output cannot be written to, or the tree has 2³¹ nodes or more.
    pub fn write(&mut self, tree: u32, graph: &BranchGraph) -> Result<(), WriteTableError> {
        if i32::try_from(graph.len()).is_err() {
            return Err(WriteTableError::TooManyNodes { tree, nodes: graph.len() });
        }
        self.rows.extend(tree, graph);
        if self.rows.id.len() >= GROUP_ROWS {
            self.close_group()?;
        }
        Ok(())
    }

    /// Notes what stood around a tree, as the text of an environment.
    pub fn note_environment(&mut self, tree: u32, text: &str) {
        let key = format!("{ENVIRONMENT_KEY}{tree}");
        self.file.append_key_value_metadata(KeyValue::new(key, text.to_owned()));
    }

    /// Notes the stand that a tree has grown in, as the text of its plan.
    pub fn note_stand(&mut self, tree: u32, text: &str) {
        let key = format!("{STAND_KEY}{tree}");
        self.file.append_key_value_metadata(KeyValue::new(key, text.to_owned()));
    }

    /// Ends the table, which is unreadable before, and gives the output back.
    ///
    /// # Errors
    ///
    /// When the output cannot be written to.
    pub fn finish(mut self) -> Result<W, WriteTableError> {
        if !self.rows.id.is_empty() {
            self.close_group()?;
        }
        Ok(self.file.into_inner()?)
    }

    fn close_group(&mut self) -> Result<(), WriteTableError> {
        let mut group = self.file.next_row_group()?;
        self.rows.write(&mut group)?;
        group.close()?;
        self.rows.clear();
        Ok(())
    }
}

/// Encodings by what each column holds: numbers that count up as differences,
/// coordinates as byte streams (neighbours share sign and exponent), few distinct values as a
/// dictionary.
fn properties(meta: &TableMeta) -> WriterProperties {
    let model = meta.model.clone().map(|hash| vec![KeyValue::new(MODEL_KEY.to_owned(), hash)]);
    let mut properties = WriterProperties::builder()
        .set_created_by("deeptree".to_owned())
        .set_compression(Compression::SNAPPY)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_key_value_metadata(model);
    let by_difference = ["id", "parent"].map(|name| (name, Encoding::DELTA_BINARY_PACKED));
    let by_byte =
        ["x", "y", "z", "qx", "qy", "qz", "qw"].map(|name| (name, Encoding::BYTE_STREAM_SPLIT));
    for (name, encoding) in by_difference.into_iter().chain(by_byte) {
        let column = ColumnPath::from(name);
        properties = properties
            .set_column_dictionary_enabled(column.clone(), false)
            .set_column_encoding(column, encoding);
    }
    properties.build()
}

/// The columns of the row group that is being filled.
#[derive(Default)]
struct Rows {
    tree: Vec<i32>,
    id: Vec<i32>,
    parent: Vec<i32>,
    position: [Vec<f32>; 3],
    radius: Vec<f32>,
    order: Vec<i32>,
    slot: Vec<i32>,
    length: Vec<f32>,
    rotation: [Vec<f32>; 4],
    species: Vec<ByteArray>,
    age: Vec<i32>,
    gravitropism: Vec<f32>,
    seed: Vec<i64>,
}

impl Rows {
    fn extend(&mut self, tree: u32, graph: &BranchGraph) {
        let info = &graph.info;
        let rows = self.id.len() + graph.len();
        self.species.resize(rows, ByteArray::from(info.species.as_str()));
        // Unsigned numbers are stored as the signed ones with the same bits.
        self.tree.resize(rows, tree.cast_signed());
        self.age.resize(rows, info.age.cast_signed());
        self.gravitropism.resize(rows, info.gravitropism);
        self.seed.resize(rows, info.seed.cast_signed());
        for (id, node) in graph.nodes().iter().enumerate() {
            self.push(id as i32, node);
        }
    }

    fn push(&mut self, id: i32, node: &Node) {
        self.id.push(id);
        self.parent.push(node.parent.map_or(-1, u32::cast_signed));
        for (column, value) in self.position.iter_mut().zip(node.position.to_array()) {
            column.push(value);
        }
        self.radius.push(node.thickness);
        self.order.push(i32::from(node.order));
        self.slot.push(i32::from(node.slot));
        self.length.push(node.length);
        for (column, value) in self.rotation.iter_mut().zip(node.rotation.to_array()) {
            column.push(value);
        }
    }

    /// Writes the columns in the order of the schema.
    fn write<W: Write + Send>(
        &self,
        group: &mut SerializedRowGroupWriter<'_, W>,
    ) -> Result<(), ParquetError> {
        for column in [&self.tree, &self.id, &self.parent] {
            put::<Int32Type, W>(group, column)?;
        }
        for column in self.position.iter().chain([&self.radius]) {
            put::<FloatType, W>(group, column)?;
        }
        for column in [&self.order, &self.slot] {
            put::<Int32Type, W>(group, column)?;
        }
        for column in [&self.length].into_iter().chain(&self.rotation) {
            put::<FloatType, W>(group, column)?;
        }
        put::<ByteArrayType, W>(group, &self.species)?;
        put::<Int32Type, W>(group, &self.age)?;
        put::<FloatType, W>(group, &self.gravitropism)?;
        put::<Int64Type, W>(group, &self.seed)
    }

    fn clear(&mut self) {
        for column in [
            &mut self.tree,
            &mut self.id,
            &mut self.parent,
            &mut self.order,
            &mut self.slot,
            &mut self.age,
        ] {
            column.clear();
        }
        let vectors = self.position.iter_mut().chain(&mut self.rotation);
        for column in vectors.chain([&mut self.radius, &mut self.length, &mut self.gravitropism]) {
            column.clear();
        }
        self.species.clear();
        self.seed.clear();
    }
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
