//! The files of a corpus: a few trees of one species each.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use deeptree_export::tables::{ReadTableError, TableReader};
use deeptree_graph::{BranchGraph, TreeInfo};
use deeptree_scene::{Environment, SceneError};

use crate::plan::CorpusPlan;

/// A tree of a corpus.
#[derive(Clone, Debug, PartialEq)]
pub struct CorpusTree {
    /// Index of the species in the plan.
    pub species: usize,
    /// The tree's number within its species.
    pub number: u32,
    /// The tree.
    pub tree: BranchGraph,
    /// What stood around it, as stored with it.
    pub environment: Environment,
}

/// Why a shard is not as planned. Building the corpus again mends it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ShardError {
    #[error("{} cannot be opened; build the corpus again to make it", path.display())]
    Open { path: PathBuf, source: io::Error },
    #[error("{} cannot be read; build the corpus again to mend it", path.display())]
    Table { path: PathBuf, source: ReadTableError },
    #[error(
        "{} holds tree {found} of {species} with seed {seed}, not tree {number} of the plan; \
         build the corpus again to mend it",
        path.display()
    )]
    OtherTree { path: PathBuf, found: u32, species: String, seed: u64, number: u32 },
    #[error(
        "{} ends before tree {number} of the plan; build the corpus again to mend it",
        path.display()
    )]
    TooFew { path: PathBuf, number: u32 },
    #[error(
        "{} does not say what stood around tree {number}; build the corpus again to mend it",
        path.display()
    )]
    NoEnvironment { path: PathBuf, number: u32 },
    #[error(
        "{} says no usable scene for tree {number}; build the corpus again to mend it",
        path.display()
    )]
    Environment { path: PathBuf, number: u32, source: SceneError },
}

/// The trees that one file of the corpus holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    /// Index of the species in the plan.
    pub(crate) species: usize,
    /// The number of the shard within its species.
    pub(crate) index: u32,
    /// The numbers of its trees.
    pub(crate) numbers: Range<u32>,
}

impl Shard {
    /// All shards of a plan, in the order in which they are built.
    pub(crate) fn all(plan: &CorpusPlan) -> impl Iterator<Item = Self> + '_ {
        (0..plan.species.len()).flat_map(|species| Self::of_species(plan, species))
    }

    pub(crate) fn of_species(
        plan: &CorpusPlan,
        species: usize,
    ) -> impl Iterator<Item = Self> + use<> {
        let (size, trees) = (plan.shard_trees, plan.trees);
        (0..trees.div_ceil(size)).map(move |index| {
            let first = index * size;
            Self { species, index, numbers: first..first.saturating_add(size).min(trees) }
        })
    }

    pub(crate) fn file_name(&self, plan: &CorpusPlan) -> String {
        format!("{}-{:03}.parquet", plan.species[self.species], self.index)
    }

    /// The table of the scans of its trees.
    pub(crate) fn scan_name(&self, plan: &CorpusPlan) -> String {
        format!("{}-{:03}.scans.parquet", plan.species[self.species], self.index)
    }

    /// Reads the trees and holds each against the plan.
    pub(crate) fn open(self, plan: &CorpusPlan, dir: &Path) -> Result<ShardReader, ShardError> {
        let path = dir.join(self.file_name(plan));
        let file =
            File::open(&path).map_err(|source| ShardError::Open { path: path.clone(), source })?;
        // Shards have all columns: nothing of this is used.
        let none = TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: 0 };
        let table = TableReader::new(file, none)
            .map_err(|source| ShardError::Table { path: path.clone(), source })?;
        Ok(ShardReader { path, table, shard: self, ended: false })
    }
}

/// The trees of one shard; ends after the first error.
pub(crate) struct ShardReader {
    path: PathBuf,
    table: TableReader,
    /// Its numbers are those still to come.
    shard: Shard,
    ended: bool,
}

impl ShardReader {
    /// The next tree, held against `plan`; none at the end.
    pub(crate) fn next(&mut self, plan: &CorpusPlan) -> Option<Result<CorpusTree, ShardError>> {
        if self.ended {
            return None;
        }
        let tree = self.read(plan).transpose();
        self.ended = !matches!(tree, Some(Ok(_)));
        tree
    }

    fn read(&mut self, plan: &CorpusPlan) -> Result<Option<CorpusTree>, ShardError> {
        let path = || self.path.clone();
        let read = self
            .table
            .next()
            .transpose()
            .map_err(|source| ShardError::Table { path: path(), source })?;
        let Some((found, tree)) = read else {
            return match self.shard.numbers.next() {
                Some(number) => Err(ShardError::TooFew { path: path(), number }),
                None => Ok(None),
            };
        };
        // One tree too many is compared with the tree that the next shard starts with.
        let number = self.shard.numbers.start;
        let (species, seed) = (self.shard.species, tree.info.seed);
        let planned = self.shard.numbers.next() == Some(found)
            && tree.info.species == plan.species[species]
            && seed == plan.seed(found).0
            && plan.priors(found).hold(&tree.info);
        if planned {
            let environment = self.environment(plan, number)?;
            Ok(Some(CorpusTree { species, number, tree, environment }))
        } else {
            let species = tree.info.species;
            Err(ShardError::OtherTree { path: path(), found, species, seed, number })
        }
    }

    /// What is stored to have stood around a tree. Corpora name no files, so none is looked for.
    fn environment(&self, plan: &CorpusPlan, number: u32) -> Result<Environment, ShardError> {
        if !plan.has_environments() {
            return Ok(Environment::default());
        }
        let path = || self.path.clone();
        let text = self.table.environment(number);
        let text = text.ok_or_else(|| ShardError::NoEnvironment { path: path(), number })?;
        Environment::parse(text, Path::new("")).map_err(|source| ShardError::Environment {
            path: path(),
            number,
            source,
        })
    }
}
