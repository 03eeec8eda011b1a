//! Simulated scans beside the shards of a corpus.

use std::fs::File;
use std::path::Path;

use deeptree_cloud::table::{ScanWriter, Scans, WriteCloudError};
use deeptree_cloud::{Cloud, ReadCloudError, ReadOptions};
use deeptree_export::write_atomically;
use deeptree_graph::{BranchGraph, Seed};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::builder::{BuildError, BuildReport, Progress};
use crate::corpus::Corpus;
use crate::plan::{CorpusPlan, Split};
use crate::shard::Shard;

/// A scan of a tree of a corpus, in the frame of the tree: metres, y up.
#[derive(Clone, Debug, PartialEq)]
pub struct CorpusScan {
    /// Index of the species in the plan.
    pub species: usize,
    /// The tree's number within its species.
    pub number: u32,
    /// What the scanner saw of it.
    pub cloud: Cloud,
}

/// Why the scans of a shard are not as planned. Building the scans again mends it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ScanError {
    #[error("{file} cannot be opened; build the corpus with scans to make it")]
    Open { file: String, source: std::io::Error },
    #[error("{file} cannot be read; build the corpus with scans again to mend it")]
    Table { file: String, source: ReadCloudError },
    #[error("{file} does not hold tree {number} where it should; build the scans again")]
    OtherTree { file: String, number: u32 },
}

/// Scans every tree of a finished corpus, or goes on where that was stopped.
///
/// `scan` makes the cloud of a tree and its seed, y up, on several threads at once; how many changes
/// nothing in the files. Each shard gets a table of its own.
///
/// # Errors
///
/// When the corpus cannot be read or its folder cannot be written to.
pub fn build_scans(
    corpus: &Corpus,
    scan: impl Fn(&BranchGraph, Seed) -> Cloud + Sync,
    mut progress: impl FnMut(Progress<'_>),
) -> Result<BuildReport, BuildError> {
    let (plan, dir) = (corpus.plan(), corpus.dir());
    let trees = u64::from(plan.trees) * plan.species.len() as u64;
    let mut trees_done = 0;
    let mut report = BuildReport::default();
    for shard in Shard::all(plan) {
        let kept = read(&shard, plan, dir).is_ok();
        if kept {
            report.kept += 1;
        } else {
            report.written += 1;
            report.replaced += usize::from(dir.join(shard.scan_name(plan)).exists());
            write(&shard, plan, dir, &scan)?;
        }
        trees_done += shard.numbers.len() as u64;
        progress(Progress { species: &plan.species[shard.species], kept, trees_done, trees });
    }
    Ok(report)
}

fn write(
    shard: &Shard,
    plan: &CorpusPlan,
    dir: &Path,
    scan: &(impl Fn(&BranchGraph, Seed) -> Cloud + Sync),
) -> Result<(), BuildError> {
    let mut reader = shard.clone().open(plan, dir)?;
    let trees = std::iter::from_fn(|| reader.next(plan)).collect::<Result<Vec<_>, _>>()?;
    #[cfg(feature = "parallel")]
    let each = trees.par_iter();
    #[cfg(not(feature = "parallel"))]
    let each = trees.iter();
    let clouds: Vec<Cloud> = each.map(|tree| scan(&tree.tree, Seed(tree.tree.info.seed))).collect();
    write_atomically(&dir.join(shard.scan_name(plan)), |out| -> Result<(), WriteCloudError> {
        let Some(first) = clouds.first() else { return Ok(()) };
        let mut table = ScanWriter::new(out, first)?;
        for (tree, cloud) in trees.iter().zip(&clouds) {
            table.write(tree.number, cloud)?;
        }
        table.finish().map(drop)
    })?;
    Ok(())
}

/// The scans of a shard, each held against the plan.
fn read(shard: &Shard, plan: &CorpusPlan, dir: &Path) -> Result<Vec<CorpusScan>, ScanError> {
    let file = shard.scan_name(plan);
    let open = |source| ScanError::Open { file: file.clone(), source };
    let handle = File::open(dir.join(&file)).map_err(open)?;
    let table = |source| ScanError::Table { file: file.clone(), source };
    let scans = Scans::open(handle, &ReadOptions::default()).map_err(table)?;
    let mut numbers = shard.numbers.clone();
    let mut all = Vec::with_capacity(numbers.len());
    for scan in scans {
        let (number, reading) = scan.map_err(table)?;
        if numbers.next() != Some(number) {
            return Err(ScanError::OtherTree { file, number });
        }
        all.push(CorpusScan { species: shard.species, number, cloud: reading.cloud });
    }
    match numbers.next() {
        None => Ok(all),
        Some(number) => Err(ScanError::OtherTree { file, number }),
    }
}

impl Corpus {
    /// The scans of one part of all species, in the order of [`Corpus::trees`], a shard at a time;
    /// ends after the first error.
    pub fn scans(&self, split: Split) -> impl Iterator<Item = Result<CorpusScan, ScanError>> + '_ {
        let numbers = self.plan().numbers(split);
        let mut ended = false;
        let shards = Shard::all(self.plan());
        let of_shard = move |shard: Shard| {
            let wanted = numbers.clone();
            let apart = shard.numbers.end <= wanted.start || wanted.end <= shard.numbers.start;
            let read = if apart { Ok(Vec::new()) } else { read(&shard, self.plan(), self.dir()) };
            let (scans, error) = match read {
                Ok(scans) => (scans, None),
                Err(error) => (Vec::new(), Some(Err(error))),
            };
            let within = scans.into_iter().filter(move |scan| wanted.contains(&scan.number));
            within.map(Ok).chain(error)
        };
        shards.flat_map(of_shard).take_while(move |scan| {
            let goes_on = !ended;
            ended = scan.is_err();
            goes_on
        })
    }
}
