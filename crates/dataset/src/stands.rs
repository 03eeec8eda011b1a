//! Corpora of stands: trees that have grown together.
//!
//! ```text
//! DIR/stands.toml         what it holds: species, stands, seeds, split
//! DIR/stands-000.parquet  skeleton tables of a few stands each
//! ```
//!
//! The trees of all stands are numbered through. With each tree are stored the plan of its stand, its
//! row there, and what it becomes by itself: what the others make of a tree is the difference.

use std::fs::{self, File};
use std::ops::Range;
use std::path::Path;

use deeptree_export::tables::{TableMeta, TableReader, TableWriter, WriteTableError};
use deeptree_export::write_atomically;
use deeptree_graph::{BranchGraph, TreeInfo, TreeTraits};
#[cfg(feature = "parallel")]
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

mod error;
mod plan;

pub use error::StandsError;
pub use plan::{Plant, STANDS_FILE, StandsPlan};

/// What a tree becomes by itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alone {
    /// Tips above its root.
    pub tips: u32,
    /// Its traits.
    pub traits: [f32; TreeTraits::COUNT],
}

/// A tree of a stand.
#[derive(Clone, Debug, PartialEq)]
pub struct StandTree {
    /// Its row of the plan.
    pub plant: Plant,
    /// What it has become.
    pub tree: BranchGraph,
    /// What it becomes by itself.
    pub alone: Alone,
}

/// What is stored with a tree.
#[derive(Serialize, Deserialize)]
struct Note {
    stand: u32,
    row: usize,
    alone: Alone,
    plan: Vec<Plant>,
}

/// Builds a corpus of stands in the folder `dir`, or finishes it: files that are there are kept.
///
/// `grow` makes the trees of a plan, and each by itself. `progress` is told how many stands are
/// done.
///
/// # Errors
///
/// When the folder holds another corpus or cannot be written to, or `grow` fails.
pub fn build_stands<E: std::error::Error + Send + Sync + 'static>(
    plan: &StandsPlan,
    dir: &Path,
    grow: impl Fn(&[Plant]) -> Result<Vec<(BranchGraph, Alone)>, E> + Sync,
    mut progress: impl FnMut(u32),
) -> Result<(), StandsError> {
    plan.check()?;
    let path = dir.join(STANDS_FILE);
    fs::create_dir_all(dir).map_err(|source| StandsError::Io { path: dir.to_owned(), source })?;
    if path.exists() {
        if read_plan(dir)? != *plan {
            return Err(StandsError::OtherCorpus { path });
        }
    } else {
        let text = toml::to_string(plan)?;
        write_atomically(&path, |out| std::io::Write::write_all(out, text.as_bytes()))?;
    }
    let corpus = Stands { dir: dir.to_owned(), plan: plan.clone() };
    let mut first_tree = 0;
    for (name, numbers) in plan.shards() {
        let plans: Vec<Vec<Plant>> = numbers.clone().map(|number| plan.stand(number)).collect();
        if corpus.shard(&name, numbers.clone(), first_tree).is_err() {
            #[cfg(feature = "parallel")]
            let each = plans.par_iter();
            #[cfg(not(feature = "parallel"))]
            let each = plans.iter();
            let grown: Vec<Result<_, E>> = each.map(|plants| grow(plants)).collect();
            let mut trees = Vec::new();
            for (stand, grown) in numbers.clone().zip(grown) {
                let grown =
                    grown.map_err(|source| StandsError::Grow { stand, source: source.into() })?;
                trees.push(grown);
            }
            write_shard(&dir.join(&name), numbers.start, first_tree, &plans, &trees)?;
        }
        first_tree += plans.iter().map(Vec::len).sum::<usize>() as u32;
        progress(numbers.end);
    }
    Ok(())
}

fn write_shard(
    path: &Path,
    first_stand: u32,
    first_tree: u32,
    plans: &[Vec<Plant>],
    trees: &[Vec<(BranchGraph, Alone)>],
) -> Result<(), StandsError> {
    let mut notes = Vec::new();
    for ((stand, plan), trees) in (first_stand..).zip(plans).zip(trees) {
        for (row, (tree, alone)) in trees.iter().enumerate() {
            let note = Note { stand, row, alone: *alone, plan: plan.clone() };
            notes.push((tree, toml::to_string(&note)?));
        }
    }
    Ok(write_atomically(path, |out| -> Result<(), WriteTableError> {
        let mut table = TableWriter::new(out, &TableMeta::default())?;
        for (number, (tree, note)) in (first_tree..).zip(&notes) {
            table.write(number, tree)?;
            table.note_stand(number, note);
        }
        table.finish().map(drop)
    })?)
}

fn read_plan(dir: &Path) -> Result<StandsPlan, StandsError> {
    let path = dir.join(STANDS_FILE);
    let text = fs::read_to_string(&path)
        .map_err(|source| StandsError::Io { path: path.clone(), source })?;
    let plan: StandsPlan =
        toml::from_str(&text).map_err(|source| StandsError::Toml { path, source })?;
    plan.check()?;
    Ok(plan)
}

/// The folder of a finished corpus of stands.
#[derive(Clone, Debug)]
pub struct Stands {
    dir: std::path::PathBuf,
    plan: StandsPlan,
}

impl Stands {
    /// Opens the corpus in the folder `dir`.
    ///
    /// # Errors
    ///
    /// When the folder has no plan. What is in the files is looked at when they are read.
    pub fn open(dir: &Path) -> Result<Self, StandsError> {
        Ok(Self { dir: dir.to_owned(), plan: read_plan(dir)? })
    }

    /// What the corpus holds.
    #[must_use]
    pub const fn plan(&self) -> &StandsPlan {
        &self.plan
    }

    /// The stands for training, or those to judge by, in their order.
    ///
    /// # Errors
    ///
    /// When a file is missing, damaged, or not as planned.
    pub fn stands(&self, training: bool) -> Result<Vec<Vec<StandTree>>, StandsError> {
        let wanted = self.plan.numbers(training);
        let mut stands = Vec::new();
        let mut first_tree = 0;
        for (name, numbers) in self.plan.shards() {
            let trees: usize = numbers.clone().map(|number| self.plan.stand(number).len()).sum();
            if numbers.start < wanted.end && wanted.start < numbers.end {
                let read = self.shard(&name, numbers.clone(), first_tree)?;
                let read = numbers.zip(read).filter(|(number, _)| wanted.contains(number));
                stands.extend(read.map(|(_, stand)| stand));
            }
            first_tree += trees as u32;
        }
        Ok(stands)
    }

    /// SHA-256 of the plan and the files, in hexadecimal digits.
    ///
    /// # Errors
    ///
    /// When a file cannot be read.
    pub fn hash(&self) -> Result<String, StandsError> {
        let mut hash = Sha256::new();
        let names = self.plan.shards().map(|(name, _)| name);
        for name in std::iter::once(STANDS_FILE.to_owned()).chain(names) {
            let path = self.dir.join(name);
            let bytes = fs::read(&path).map_err(|source| StandsError::Io { path, source })?;
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(&bytes);
        }
        Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
    }

    /// The stands of a file, whose first tree has the number `number`.
    fn shard(
        &self,
        name: &str,
        stands: Range<u32>,
        mut number: u32,
    ) -> Result<Vec<Vec<StandTree>>, StandsError> {
        let path = self.dir.join(name);
        let file =
            File::open(&path).map_err(|source| StandsError::Io { path: path.clone(), source })?;
        // The files have all columns: nothing of this is used.
        let none = TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: 0 };
        let unlike = || StandsError::Shard { path: path.clone() };
        let table = |source| StandsError::Table { path: path.clone(), source };
        let mut reader = TableReader::new(file, none).map_err(table)?;
        let mut all = Vec::new();
        for stand in stands {
            let mut trees = Vec::new();
            for (row, plant) in self.plan.stand(stand).into_iter().enumerate() {
                let (found, tree) = reader.next().ok_or_else(unlike)?.map_err(table)?;
                let note = reader.stand(found).ok_or_else(unlike)?;
                let note: Note = toml::from_str(note).map_err(|_| unlike())?;
                let is_planned = found == number
                    && (note.stand, note.row, tree.info.seed) == (stand, row, plant.seed)
                    && note.plan.get(row) == Some(&plant)
                    && self.plan.species.get(plant.species) == Some(&tree.info.species);
                if !is_planned {
                    return Err(unlike());
                }
                trees.push(StandTree { plant, tree, alone: note.alone });
                number += 1;
            }
            all.push(trees);
        }
        if reader.next().is_some() { Err(unlike()) } else { Ok(all) }
    }
}

impl Alone {
    /// Of a tree that has grown by itself.
    #[must_use]
    pub fn of(tree: &BranchGraph, tip_radius: f32) -> Self {
        let tips = deeptree_graph::signature::tip_count(tree.root().thickness, tip_radius);
        Self { tips, traits: TreeTraits::of(tree).to_array() }
    }

    /// Its traits.
    #[must_use]
    pub const fn traits(&self) -> TreeTraits {
        TreeTraits::from_array(self.traits)
    }
}
