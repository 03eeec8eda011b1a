//! A corpus that was built.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::plan::{CorpusPlan, PLAN_FILE, PlanError, Split};
use crate::shard::{CorpusTree, Shard, ShardError, ShardReader};

/// Why a corpus could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum CorpusError {
    #[error("{} cannot be read; name the folder of a corpus", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{} cannot be used", path.display())]
    Plan { path: PathBuf, source: PlanError },
    #[error("{} is missing; the corpus is not finished: build it again to go on", path.display())]
    MissingShard { path: PathBuf },
    #[error(transparent)]
    Shard(#[from] ShardError),
}

/// The folder of a finished corpus.
#[derive(Clone, Debug)]
pub struct Corpus {
    dir: PathBuf,
    plan: CorpusPlan,
}

impl Corpus {
    /// Opens the corpus in the folder `dir`.
    ///
    /// # Errors
    ///
    /// When the folder has no plan or not all of its shards. What is in the shards is looked at
    /// when they are read.
    pub fn open(dir: &Path) -> Result<Self, CorpusError> {
        let path = dir.join(PLAN_FILE);
        let text = fs::read_to_string(&path)
            .map_err(|source| CorpusError::Io { path: path.clone(), source })?;
        let plan =
            CorpusPlan::from_toml(&text).map_err(|source| CorpusError::Plan { path, source })?;
        let mut paths = Shard::all(&plan).map(|shard| dir.join(shard.file_name(&plan)));
        if let Some(path) = paths.find(|path| !path.is_file()) {
            return Err(CorpusError::MissingShard { path });
        }
        drop(paths);
        Ok(Self { dir: dir.to_owned(), plan })
    }

    pub(crate) fn dir(&self) -> &Path {
        &self.dir
    }

    /// What the corpus holds.
    #[must_use]
    pub fn plan(&self) -> &CorpusPlan {
        &self.plan
    }

    /// The trees of all species, by species and number.
    #[must_use]
    pub fn trees(&self, split: Split) -> Trees<'_> {
        self.over(Shard::all(&self.plan).collect(), split)
    }

    /// The trees of one species, an index into the plan, by number.
    ///
    /// # Panics
    ///
    /// When the plan has no such species.
    #[must_use]
    pub fn trees_of(&self, species: usize, split: Split) -> Trees<'_> {
        assert!(species < self.plan.species.len(), "the corpus has no species {species}");
        self.over(Shard::of_species(&self.plan, species).collect(), split)
    }

    fn over(&self, shards: Vec<Shard>, split: Split) -> Trees<'_> {
        let numbers = self.plan.numbers(split);
        let overlaps =
            |shard: &Shard| shard.numbers.start < numbers.end && numbers.start < shard.numbers.end;
        let mut shards: Vec<Shard> = shards.into_iter().filter(overlaps).collect();
        shards.reverse();
        Trees { corpus: self, split, shards, open: None }
    }

    /// SHA-256 of the plan and the shards, with their names, in hexadecimal digits: which data a
    /// model was trained on.
    ///
    /// # Errors
    ///
    /// When a file cannot be read.
    pub fn hash(&self) -> Result<String, CorpusError> {
        let mut hash = Sha256::new();
        let shards = Shard::all(&self.plan).map(|shard| shard.file_name(&self.plan));
        for name in std::iter::once(PLAN_FILE.to_owned()).chain(shards) {
            let path = self.dir.join(&name);
            add_file(&mut hash, &name, &path).map_err(|source| CorpusError::Io { path, source })?;
        }
        Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
    }
}

/// Lengths go in before what they measure: no two corpora give the same bytes to hash.
fn add_file(hash: &mut Sha256, name: &str, path: &Path) -> io::Result<()> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    hash.update((name.len() as u64).to_le_bytes());
    hash.update(name.as_bytes());
    hash.update(length.to_le_bytes());
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(()),
            n => hash.update(&buffer[..n]),
        }
    }
}

/// Trees of a corpus, read as they are asked for; ends after the first error.
pub struct Trees<'a> {
    corpus: &'a Corpus,
    split: Split,
    /// Those still to come, the next one last.
    shards: Vec<Shard>,
    open: Option<ShardReader>,
}

impl std::fmt::Debug for Trees<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Trees").field("split", &self.split).field("shards", &self.shards).finish()
    }
}

impl Trees<'_> {
    fn next_tree(&mut self) -> Result<Option<CorpusTree>, CorpusError> {
        let plan = &self.corpus.plan;
        loop {
            if let Some(reader) = &mut self.open {
                match reader.next(plan).transpose()? {
                    Some(tree) if plan.numbers(self.split).contains(&tree.number) => {
                        return Ok(Some(tree));
                    }
                    Some(_) => continue,
                    None => self.open = None,
                }
            }
            let Some(shard) = self.shards.pop() else { return Ok(None) };
            self.open = Some(shard.open(plan, &self.corpus.dir)?);
        }
    }
}

impl Iterator for Trees<'_> {
    type Item = Result<CorpusTree, CorpusError>;

    fn next(&mut self) -> Option<Self::Item> {
        let tree = self.next_tree().transpose();
        if matches!(tree, Some(Err(_))) {
            self.shards.clear();
            self.open = None;
        }
        tree
    }
}
