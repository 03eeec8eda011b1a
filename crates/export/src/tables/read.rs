//! From a table to trees.

mod columns;

use std::collections::BTreeSet;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::bytes::Bytes;
use deeptree_graph::{BranchGraph, GraphError, Quat, Row, TreeInfo, Vec3};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use self::columns::{Batch, Float, Int, Layout, OpenGroup};
use super::{ENVIRONMENT_KEY, MODEL_KEY, STAND_KEY};

/// Why a table could not be read. Rows count from 1 through the whole file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadTableError {
    #[error("this is no readable Parquet file; it may be damaged or cut off")]
    Parquet(#[from] ParquetError),
    #[error("this Parquet file is damaged: its parts contradict each other")]
    Damaged,
    #[error("there is no column `{column}`; the table needs one")]
    MissingColumn { column: &'static str },
    #[error("column `{column}` holds {found}; it must hold {wanted}")]
    ColumnType { column: &'static str, found: String, wanted: &'static str },
    #[error("column `{column}` has another number of rows than the others; the file is damaged")]
    Ragged { column: &'static str },
    #[error("row {row}, column `{column}`: a null; fill it or leave the column out")]
    Null { row: u64, column: &'static str },
    #[error("row {row}, column `{column}`: {value} is not {wanted}")]
    BadNumber { row: u64, column: &'static str, value: i64, wanted: &'static str },
    #[error("row {row}, column `species`: the name is not UTF-8")]
    SpeciesNotUtf8 { row: u64 },
    #[error(
        "row {row}: species, age, gravitropism or seed differ from the other rows of tree {tree}"
    )]
    InfoChanges { row: u64, tree: u32 },
    #[error("row {row}: tree {tree} goes on after another; sort the table by `tree`")]
    TreeApart { row: u64, tree: u32 },
    #[error("tree {tree}, whose first row is row {row}, is not a tree")]
    Graph { tree: u32, row: u64, source: GraphError },
}

/// Reads a table tree by tree, in the order of the file; ends after the first error.
///
/// A tree whose nodes stand in level order reads back from a table of
/// [`TableWriter`](super::TableWriter) as the same bits.
pub struct TableReader {
    file: Box<dyn FileReader>,
    layout: Layout,
    info: TreeInfo,
    next_group: usize,
    group: Option<OpenGroup>,
    batch: Batch,
    /// The row of `batch` that is read next.
    at: usize,
    /// How many rows stand before `batch`.
    before: u64,
    growing: Option<Growing>,
    finished: BTreeSet<u32>,
    ended: bool,
}

/// The tree whose rows are being read.
struct Growing {
    number: u32,
    info: TreeInfo,
    first_row: u64,
    rows: Vec<Row>,
}

impl std::fmt::Debug for TableReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TableReader").field("at_row", &(self.before + self.at as u64)).finish()
    }
}

impl TableReader {
    /// Opens a table. `info` is used where the table lacks a column.
    ///
    /// # Errors
    ///
    /// When the file is not a Parquet file or lacks a column that a skeleton needs.
    pub fn new(file: File, info: TreeInfo) -> Result<Self, ReadTableError> {
        Self::over(contained(|| Ok(Box::new(SerializedFileReader::new(file)?)))?, info)
    }

    /// As [`Self::new`], from the bytes of a file.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn from_bytes(bytes: Vec<u8>, info: TreeInfo) -> Result<Self, ReadTableError> {
        let bytes = Bytes::from(bytes);
        Self::over(contained(|| Ok(Box::new(SerializedFileReader::new(bytes)?)))?, info)
    }

    fn over(file: Box<dyn FileReader>, info: TreeInfo) -> Result<Self, ReadTableError> {
        let layout = Layout::find(file.metadata().file_metadata().schema_descr())?;
        Ok(Self {
            file,
            layout,
            info,
            next_group: 0,
            group: None,
            batch: Batch::default(),
            at: 0,
            before: 0,
            growing: None,
            finished: BTreeSet::new(),
            ended: false,
        })
    }

    /// Hash of the model that grew the trees, where the file names one.
    #[must_use]
    pub fn model(&self) -> Option<&str> {
        self.note(MODEL_KEY)
    }

    /// What stood around a tree, as the text of an environment, where the file says it.
    #[must_use]
    pub fn environment(&self, tree: u32) -> Option<&str> {
        self.note(&format!("{ENVIRONMENT_KEY}{tree}"))
    }

    /// The stand that a tree has grown in, as the text of its plan, where the file says it.
    #[must_use]
    pub fn stand(&self, tree: u32) -> Option<&str> {
        self.note(&format!("{STAND_KEY}{tree}"))
    }

    fn note(&self, key: &str) -> Option<&str> {
        let pairs = self.file.metadata().file_metadata().key_value_metadata()?;
        pairs.iter().find(|pair| pair.key == key)?.value.as_deref()
    }

    /// The next tree, or none at the end of the table.
    fn next_tree(&mut self) -> Result<Option<(u32, BranchGraph)>, ReadTableError> {
        loop {
            if self.at == self.batch.len && !contained(|| self.next_batch())? {
                return self.growing.take().map(Growing::finish).transpose();
            }
            let row_number = self.before + self.at as u64 + 1;
            let number = self.tree_number(row_number)?;
            let info = self.tree_info(row_number)?;
            let mut whole = None;
            if self.growing.as_ref().is_none_or(|growing| growing.number != number) {
                if !self.finished.insert(number) {
                    return Err(ReadTableError::TreeApart { row: row_number, tree: number });
                }
                let new = Growing { number, info, first_row: row_number, rows: Vec::new() };
                whole = self.growing.replace(new);
            } else if self.growing.as_ref().is_some_and(|growing| growing.info != info) {
                return Err(ReadTableError::InfoChanges { row: row_number, tree: number });
            }
            let row = self.row(row_number)?;
            if let Some(growing) = &mut self.growing {
                growing.rows.push(row);
            }
            self.at += 1;
            if let Some(whole) = whole {
                return whole.finish().map(Some);
            }
        }
    }

    /// Reads on, through empty row groups; false at the end of the file.
    fn next_batch(&mut self) -> Result<bool, ReadTableError> {
        self.before += self.batch.len as u64;
        self.at = 0;
        self.batch.len = 0;
        loop {
            if let Some(group) = &mut self.group {
                group.read(&mut self.batch, self.before)?;
                if self.batch.len > 0 {
                    return Ok(true);
                }
            }
            if self.next_group == self.file.num_row_groups() {
                return Ok(false);
            }
            let group = self.file.get_row_group(self.next_group)?;
            self.group = Some(OpenGroup::open(group.as_ref(), &self.layout)?);
            self.next_group += 1;
        }
    }

    fn tree_number(&self, row: u64) -> Result<u32, ReadTableError> {
        match self.batch.int(Int::Tree, self.at) {
            None => Ok(0),
            Some(value) => fit(value, row, "tree", "a whole number from 0 to 4294967295"),
        }
    }

    fn tree_info(&self, row: u64) -> Result<TreeInfo, ReadTableError> {
        let (batch, at) = (&self.batch, self.at);
        let species = match batch.species(at) {
            None => self.info.species.clone(),
            Some(name) => std::str::from_utf8(name)
                .map_err(|_| ReadTableError::SpeciesNotUtf8 { row })?
                .to_owned(),
        };
        let age = match batch.int(Int::Age, at) {
            None => self.info.age,
            Some(value) => {
                fit(value, row, "age", "a number of growth cycles from 0 to 4294967295")?
            }
        };
        Ok(TreeInfo {
            species,
            age,
            gravitropism: batch.float(Float::Gravitropism, at).unwrap_or(self.info.gravitropism),
            seed: batch.int(Int::Seed, at).map_or(self.info.seed, i64::cast_unsigned),
        })
    }

    fn row(&self, row: u64) -> Result<Row, ReadTableError> {
        let int = |column| self.batch.int(column, self.at);
        // The layout has made sure of the columns without which there is no skeleton.
        let float = |column| self.batch.float(column, self.at).unwrap_or_default();
        let slot = match int(Int::Slot) {
            None => None,
            Some(value) => Some(fit(value, row, "slot", "0 (apical), 1 or 2 (lateral)")?),
        };
        let edge = self.layout.has_edges().then(|| {
            let [x, y, z, w] = [Float::Qx, Float::Qy, Float::Qz, Float::Qw].map(float);
            (Quat::from_xyzw(x, y, z, w), float(Float::Length))
        });
        Ok(Row {
            id: int(Int::Id).unwrap_or_default(),
            parent: int(Int::Parent).unwrap_or_default(),
            slot,
            position: Vec3::new(float(Float::X), float(Float::Y), float(Float::Z)),
            radius: float(Float::Radius),
            edge,
        })
    }
}

impl Iterator for TableReader {
    type Item = Result<(u32, BranchGraph), ReadTableError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let tree = self.next_tree().transpose();
        self.ended = !matches!(tree, Some(Ok(_)));
        tree
    }
}

/// Runs a part of the Parquet library, which panics on some damaged files, and turns its panics
/// into errors. Nothing that a panic leaves half-done is used again: the reader ends.
fn contained<T>(read: impl FnOnce() -> Result<T, ReadTableError>) -> Result<T, ReadTableError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or(Err(ReadTableError::Damaged))
}

impl Growing {
    fn finish(self) -> Result<(u32, BranchGraph), ReadTableError> {
        let Self { number: tree, info, first_row: row, rows } = self;
        match BranchGraph::from_rows(info, &rows) {
            Ok(graph) => Ok((tree, graph)),
            Err(source) => Err(ReadTableError::Graph { tree, row, source }),
        }
    }
}

fn fit<T: TryFrom<i64>>(
    value: i64,
    row: u64,
    column: &'static str,
    wanted: &'static str,
) -> Result<T, ReadTableError> {
    T::try_from(value).map_err(|_| ReadTableError::BadNumber { row, column, value, wanted })
}
