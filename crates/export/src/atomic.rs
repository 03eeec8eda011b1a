//! Files that are there whole or not at all.

use std::error::Error;
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Names to try for the temporary file; so many are taken only if that many runs were killed.
const ATTEMPTS: u32 = 1000;

/// Why a file was not written. Nothing was left behind, and an older file is as it was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// No file can be made in the folder.
    #[error(
        "cannot create {}; check that its folder exists and that you may write there",
        path.display()
    )]
    Create {
        /// The file that was to be written.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The contents could not be made or written.
    #[error("cannot write {}; see the cause, and whether the disk is full", path.display())]
    Contents {
        /// The file that was to be written.
        path: PathBuf,
        /// What the writer says.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The contents did not reach the disk.
    #[error("{} did not reach the disk; make room on it and try again", path.display())]
    Flush {
        /// The file that was to be written.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The complete file could not get its name.
    #[error(
        "cannot put the new file in the place of {}; check that it is not a folder, write-protected \
         or held open by another program",
        path.display()
    )]
    Replace {
        /// The file that was to be written.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// A file beside its final place, removed again unless it gets there.
struct Temporary {
    path: PathBuf,
    keep: bool,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.keep {
            // There is nobody to tell, and the first error says what went wrong.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// A file for what waits to be written: hidden, and gone when it is no longer used.
pub struct Spool {
    file: File,
    _temporary: Temporary,
}

impl Spool {
    /// Makes one in the folder of `path`.
    ///
    /// # Errors
    ///
    /// When no file can be made there.
    pub fn beside(path: &Path) -> Result<Self, WriteError> {
        let made = create_beside(path);
        let (file, temporary) =
            made.map_err(|source| WriteError::Create { path: path.to_owned(), source })?;
        Ok(Self { file, _temporary: temporary })
    }
}

impl Read for Spool {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.file.read(bytes)
    }
}

impl Write for Spool {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Spool {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Writes a file under a temporary name in its folder and renames it when it is complete.
///
/// Before the name changes, the contents are brought to the disk, so that a full disk is noticed
/// while an older file is still there. A new file gets the usual permissions, one that replaces
/// another gets that one's; a link stays, and the file it leads to is replaced. What is no regular
/// file, such as a pipe or a device, is written to as it is.
///
/// # Errors
///
/// When the file cannot be created, written, brought to the disk or renamed, or `write` fails.
pub fn write_atomically<E: Into<Box<dyn Error + Send + Sync>>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), WriteError> {
    let old = fs::metadata(path).ok();
    if old.as_ref().is_some_and(|old| !old.is_file() && !old.is_dir()) {
        return write_in_place(path, write);
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let create = |source| WriteError::Create { path: path.to_owned(), source };
    let (file, mut temporary) = create_beside(&target).map_err(create)?;
    if let Some(old) = old.filter(fs::Metadata::is_file) {
        file.set_permissions(old.permissions()).map_err(create)?;
    }
    let file = fill(path, file, write)?;
    let flush = |source| WriteError::Flush { path: path.to_owned(), source };
    file.sync_all().map_err(flush)?;
    // Closed first: some systems do not rename an open file.
    drop(file);
    fs::rename(&temporary.path, &target)
        .map_err(|source| WriteError::Replace { path: path.to_owned(), source })?;
    temporary.keep = true;
    Ok(())
}

fn write_in_place<E: Into<Box<dyn Error + Send + Sync>>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), WriteError> {
    let file = OpenOptions::new()
        .write(true)
        .open(path)
        .map_err(|source| WriteError::Create { path: path.to_owned(), source })?;
    fill(path, file, write).map(drop)
}

/// Lets `write` fill the file, and empties the buffer into it.
fn fill<E: Into<Box<dyn Error + Send + Sync>>>(
    path: &Path,
    file: File,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<File, WriteError> {
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)
        .map_err(|e| WriteError::Contents { path: path.to_owned(), source: e.into() })?;
    let flush = |source| WriteError::Flush { path: path.to_owned(), source };
    buffered.flush().map_err(flush)?;
    buffered.into_inner().map_err(|e| flush(e.into_error()))
}

/// Creates a hidden file beside `target` that nobody else has.
fn create_beside(target: &Path) -> io::Result<(File, Temporary)> {
    let name = target.file_name().ok_or_else(|| io::Error::from(ErrorKind::InvalidFilename))?;
    for attempt in 0..ATTEMPTS {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{attempt}.part"));
        let path = target.with_file_name(hidden);
        match OpenOptions::new().read(true).write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, Temporary { path, keep: false })),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(ErrorKind::AlreadyExists.into())
}
