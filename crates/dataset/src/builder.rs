//! From a plan to a corpus on disk.

use std::error::Error;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use deeptree_export::tables::{TableMeta, TableWriter, WriteTableError};
use deeptree_export::{WriteError, write_atomically};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_scene::Environment;
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::plan::{CorpusPlan, PLAN_FILE, PlanError};
use crate::priors::Priors;
use crate::shard::{CorpusTree, Shard, ShardError};

/// How far a build has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress<'a> {
    /// The species of the shard that was just finished.
    pub species: &'a str,
    /// Was the shard there already?
    pub kept: bool,
    /// How many trees are finished.
    pub trees_done: u64,
    /// How many trees the corpus will have.
    pub trees: u64,
}

/// What a build did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildReport {
    /// Shards that were grown.
    pub written: usize,
    /// How many of them stand in the place of a damaged one.
    pub replaced: usize,
    /// Shards of an earlier build that were whole.
    pub kept: usize,
}

/// Why a corpus was not finished. Shards that were finished stay.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum BuildError {
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error("cannot use {}; check that it can be written to", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error(
        "{} is of another corpus: its {field} is `{found}`, not `{planned}`; choose another folder \
         or the same plan",
        path.display()
    )]
    OtherCorpus { path: PathBuf, field: &'static str, found: String, planned: String },
    #[error(
        "{} is there but {PLAN_FILE} is not; choose an empty folder or remove the shards",
        path.display()
    )]
    ShardWithoutPlan { path: PathBuf },
    #[error("tree {number} of {species} (seed {seed}) could not be grown")]
    Grow { species: String, number: u32, seed: u64, source: Box<dyn Error + Send + Sync> },
    #[error(
        "tree {number} of {species} (seed {seed}) was grown as {grown_species} with seed \
         {grown_seed}; a grown tree must carry the species and the seed asked for"
    )]
    GrownOther { species: String, number: u32, seed: u64, grown_species: String, grown_seed: u64 },
    #[error(
        "tree {number} of {species} (seed {seed}) was not grown at the age and gravitropism that \
         the plan draws for it"
    )]
    GrownAtOther { species: String, number: u32, seed: u64 },
    #[error(transparent)]
    Shard(#[from] ShardError),
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Builds the corpus of `plan` in the folder `dir`, or finishes it.
///
/// `grow` makes the tree of a species, a seed, what the plan draws for it and what stands around it,
/// on several threads at once; how many changes nothing in the files. A file appears under its name only when it is complete, so a build that
/// was stopped anywhere can be run again: whole shards are kept, damaged ones grown anew. One build
/// at a time may use a folder.
///
/// # Errors
///
/// When the plan cannot be built, the folder holds another corpus or cannot be written to, or
/// `grow` fails.
pub fn build<E: Error + Send + Sync + 'static>(
    plan: &CorpusPlan,
    dir: &Path,
    grow: impl Fn(&str, Seed, &Priors, &Environment) -> Result<BranchGraph, E> + Sync,
    mut progress: impl FnMut(Progress<'_>),
) -> Result<BuildReport, BuildError> {
    plan.check()?;
    fs::create_dir_all(dir).map_err(|source| BuildError::Io { path: dir.to_owned(), source })?;
    claim(plan, dir)?;
    remove_leftovers(plan, dir)?;
    let trees = u64::from(plan.trees) * plan.species.len() as u64;
    let mut trees_done = 0;
    let mut report = BuildReport::default();
    for shard in Shard::all(plan) {
        let kept = is_whole(&shard, plan, dir);
        if kept {
            report.kept += 1;
        } else {
            report.written += 1;
            report.replaced += usize::from(dir.join(shard.file_name(plan)).exists());
            write_shard(&shard, plan, dir, &grow)?;
        }
        trees_done += shard.numbers.len() as u64;
        progress(Progress { species: &plan.species[shard.species], kept, trees_done, trees });
    }
    Ok(report)
}

/// Makes `dir` the folder of this plan, or makes sure that it is.
fn claim(plan: &CorpusPlan, dir: &Path) -> Result<(), BuildError> {
    let path = dir.join(PLAN_FILE);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            // Who knows what these were grown with: the profile is in the plan alone.
            let mut shards = Shard::all(plan).map(|shard| dir.join(shard.file_name(plan)));
            if let Some(path) = shards.find(|path| path.exists()) {
                return Err(BuildError::ShardWithoutPlan { path });
            }
            let write =
                |out: &mut io::BufWriter<_>| io::Write::write_all(out, plan.to_toml().as_bytes());
            return Ok(write_atomically(&path, write)?);
        }
        Err(source) => return Err(BuildError::Io { path, source }),
    };
    match CorpusPlan::from_toml(&text)?.difference(plan) {
        None => Ok(()),
        Some((field, found, planned)) => {
            Err(BuildError::OtherCorpus { path, field, found, planned })
        }
    }
}

/// Removes the temporary files of builds that were killed: `.<file>.<number>.part`.
fn remove_leftovers(plan: &CorpusPlan, dir: &Path) -> Result<(), BuildError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| BuildError::Io { path, source }
    };
    let is_ours = |name: &str| {
        let mut parts = name.strip_prefix('.')?.strip_suffix(".part")?.rsplitn(2, '.');
        let (number, file) = (parts.next()?, parts.next()?);
        let is_of = |shard: Shard| {
            [shard.file_name(plan), shard.scan_name(plan)].contains(&file.to_owned())
        };
        let known = file == PLAN_FILE || Shard::all(plan).any(is_of);
        (known && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(())
    };
    for entry in fs::read_dir(dir).map_err(failed(dir))? {
        let entry = entry.map_err(failed(dir))?;
        if entry.file_name().to_str().and_then(is_ours).is_some() {
            fs::remove_file(entry.path()).map_err(failed(&entry.path()))?;
        }
    }
    Ok(())
}

/// Is the shard there, and does it hold exactly the trees of the plan?
fn is_whole(shard: &Shard, plan: &CorpusPlan, dir: &Path) -> bool {
    let Ok(mut reader) = shard.clone().open(plan, dir) else { return false };
    let as_planned = |tree: &CorpusTree| tree.environment == plan.environment(tree.number);
    std::iter::from_fn(|| reader.next(plan)).all(|tree| tree.is_ok_and(|tree| as_planned(&tree)))
}

fn write_shard<E: Error + Send + Sync + 'static>(
    shard: &Shard,
    plan: &CorpusPlan,
    dir: &Path,
    grow: &(impl Fn(&str, Seed, &Priors, &Environment) -> Result<BranchGraph, E> + Sync),
) -> Result<(), BuildError> {
    let species = plan.species[shard.species].as_str();
    let grow_one = |number| grow_checked(species, number, plan, grow);
    #[cfg(feature = "parallel")]
    let numbers = shard.numbers.clone().into_par_iter();
    #[cfg(not(feature = "parallel"))]
    let numbers = shard.numbers.clone();
    // Collected before the first error is looked for, so that it is always the same one.
    let trees: Vec<Result<BranchGraph, BuildError>> = numbers.map(grow_one).collect();
    let trees = trees.into_iter().collect::<Result<Vec<_>, _>>()?;
    write_atomically(&dir.join(shard.file_name(plan)), |out| -> Result<(), WriteTableError> {
        let mut table = TableWriter::new(out, &TableMeta::default())?;
        for (number, tree) in shard.numbers.clone().zip(&trees) {
            table.write(number, tree)?;
            if plan.has_environments() {
                table.note_environment(number, &plan.environment(number).to_toml());
            }
        }
        table.finish().map(drop)
    })?;
    Ok(())
}

fn grow_checked<E: Error + Send + Sync + 'static>(
    species: &str,
    number: u32,
    plan: &CorpusPlan,
    grow: &(impl Fn(&str, Seed, &Priors, &Environment) -> Result<BranchGraph, E> + Sync),
) -> Result<BranchGraph, BuildError> {
    let (name, seed, priors) = (species.to_owned(), plan.seed(number), plan.priors(number));
    let Seed(seed_number) = seed;
    let environment = plan.environment(number);
    let tree = grow(species, seed, &priors, &environment).map_err(|source| BuildError::Grow {
        species: name.clone(),
        number,
        seed: seed_number,
        source: Box::new(source),
    })?;
    if tree.info.species == species && tree.info.seed == seed_number {
        if priors.hold(&tree.info) {
            return Ok(tree);
        }
        return Err(BuildError::GrownAtOther { species: name, number, seed: seed_number });
    }
    Err(BuildError::GrownOther {
        species: name,
        number,
        seed: seed_number,
        grown_species: tree.info.species,
        grown_seed: tree.info.seed,
    })
}
