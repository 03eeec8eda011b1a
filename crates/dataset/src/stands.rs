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
use deeptree_graph::{BranchGraph, Draws, Lineage, Purpose, Seed, TreeInfo, TreeTraits, Vec2};
#[cfg(feature = "parallel")]
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

mod error;

pub use error::StandsError;

/// Name of the plan's file in the folder of a corpus of stands.
pub const STANDS_FILE: &str = "stands.toml";

/// Trees of a stand, at least and at most.
const TREES: Range<usize> = 2..21;
/// Nearest and farthest mean distance of neighbours in metres; their logarithm is drawn evenly.
const SPACING: Range<f64> = 2.5..18.0;
/// Part of the spacing that trees stand off their grid, at most.
const JITTER: f64 = 0.4;
/// Of ten stands, those of one species, and those of trees of many ages.
const PURE: usize = 5;
const AGED: usize = 4;
/// Growth cycles of trees of stands of many ages.
const AGES: Range<usize> = 12..36;
/// From the seed of a stand's first tree to that of the next stand's.
const SEEDS: u64 = 64;

/// What a corpus of stands holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandsPlan {
    /// The format of the corpus.
    pub format: u32,
    /// The species of the trees.
    pub species: Vec<String>,
    /// How many stands there are.
    pub stands: u32,
    /// How many of them are for training: the first.
    pub training_stands: u32,
    /// The seed of the first tree.
    pub first_seed: u64,
    /// The parameters that the trees were grown with, by name.
    pub profile: String,
    /// How many stands a file has.
    pub shard_stands: u32,
}

/// A row of the plan of a stand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plant {
    /// Number of its species.
    pub species: usize,
    /// Where its foot is: x and z in metres.
    pub at: [f32; 2],
    /// Its seed.
    pub seed: u64,
    /// Age in growth cycles; the species' own where there is none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub age: Option<u32>,
}

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

impl StandsPlan {
    /// A plan with four fifths of the stands for training.
    #[must_use]
    pub fn new(species: Vec<String>, stands: u32, first_seed: Seed, profile: &str) -> Self {
        Self {
            format: 1,
            species,
            stands,
            training_stands: stands - stands.div_ceil(5),
            first_seed: first_seed.0,
            profile: profile.to_owned(),
            shard_stands: 20,
        }
    }

    /// The plan of a stand: 2 to 20 trees on a square grid of 2.5 to 18 m, each up to two fifths of
    /// that off its place. Half of the stands have one species, the others up to four; in two of
    /// five, the trees are of 12 to 35 growth cycles, in the others of their species' own age.
    #[must_use]
    pub fn stand(&self, number: u32) -> Vec<Plant> {
        let seed = Seed(self.first_seed).of_tree(u64::from(number) * SEEDS);
        let mut draws = seed.draws(Lineage::ROOT, Purpose::Planting);
        let count = TREES.start + draws.index(TREES.len());
        let [low, high] = [SPACING.start, SPACING.end].map(libm::log);
        let spacing = libm::exp(low + draws.uniform() * (high - low));
        let kinds = if draws.index(10) < PURE { 1 } else { 2 + draws.index(3) };
        let kinds: Vec<usize> = (0..kinds).map(|_| draws.index(self.species.len())).collect();
        let is_aged = draws.index(10) < AGED;
        let jitter = JITTER * draws.uniform();
        let side = (1..).find(|side| side * side >= count).unwrap_or(1);
        let place = |draws: &mut Draws, cell: usize| {
            (spacing * (cell as f64 + jitter * (2.0 * draws.uniform() - 1.0))) as f32
        };
        (0..count)
            .map(|row| Plant {
                species: kinds[draws.index(kinds.len())],
                at: [place(&mut draws, row % side), place(&mut draws, row / side)],
                seed: seed.of_tree(row as u64).0,
                age: is_aged.then(|| (AGES.start + draws.index(AGES.len())) as u32),
            })
            .collect()
    }

    /// Are these stands for training, or to judge by?
    #[must_use]
    pub fn numbers(&self, training: bool) -> Range<u32> {
        if training { 0..self.training_stands } else { self.training_stands..self.stands }
    }

    fn shards(&self) -> impl Iterator<Item = (String, Range<u32>)> + use<> {
        let (size, stands) = (self.shard_stands.max(1), self.stands);
        (0..stands.div_ceil(size)).map(move |index| {
            let first = index * size;
            (format!("stands-{index:03}.parquet"), first..first.saturating_add(size).min(stands))
        })
    }

    fn check(&self) -> Result<(), StandsError> {
        let what = if self.format != 1 {
            "its format is another than 1"
        } else if self.species.is_empty() || self.stands == 0 || self.shard_stands == 0 {
            "it has no species, no stands or shards without stands"
        } else if self.training_stands > self.stands {
            "it has more stands for training than stands"
        } else if self.first_seed > i64::MAX as u64 - u64::from(u32::MAX) * SEEDS {
            "its seeds do not fit into its file; stay below 2^62"
        } else {
            return Ok(());
        };
        Err(StandsError::Plan { what })
    }
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

impl Plant {
    /// Where another stands as seen from this one, in metres.
    #[must_use]
    pub fn to(&self, other: &Self) -> Vec2 {
        Vec2::from(other.at) - Vec2::from(self.at)
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
