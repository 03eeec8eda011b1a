//! What can be wrong with a corpus of stands.

use std::error::Error;
use std::io;
use std::path::PathBuf;

use deeptree_export::WriteError;
use deeptree_export::tables::ReadTableError;

use super::STANDS_FILE;

/// Why a corpus of stands cannot be built or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum StandsError {
    #[error("the plan of the stands cannot be used: {what}")]
    Plan { what: &'static str },
    #[error("{} is not the plan of a corpus of stands", path.display())]
    Toml { path: PathBuf, source: toml::de::Error },
    #[error("the plan or a note of the stands cannot be written as TOML")]
    Text(#[from] toml::ser::Error),
    #[error("{} is of another corpus; choose another folder or the same plan", path.display())]
    OtherCorpus { path: PathBuf },
    #[error("cannot use {}; name the folder of a corpus of stands, which has a {STANDS_FILE}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("stand {stand} could not be grown")]
    Grow { stand: u32, source: Box<dyn Error + Send + Sync> },
    #[error("{} cannot be read; build the corpus again to mend it", path.display())]
    Table { path: PathBuf, source: ReadTableError },
    #[error("{} does not hold the trees of the plan; build the corpus again to mend it", path.display())]
    Shard { path: PathBuf },
    #[error(transparent)]
    Write(#[from] WriteError),
}
