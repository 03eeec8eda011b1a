//! Checkpoints: a file for each network, rewritten after every epoch, and one for the settings.
//!
//! A network's file is a header, the four arrays of its state, and a hash:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | magic, with the version of the layout |
//! | 4, 4, 8, 8 | epochs done, number of parameters, steps, seconds (all little-endian) |
//! | 4 × 4 × parameters | weights, first moment, second moment, average, `f32` |
//! | 32 | SHA-256 of all before |

use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{TrainError, TrainOptions, TrainingSet};

const MAGIC: &[u8; 8] = b"DTCKPT\0\x01";
const HEADER: usize = 32;
const HASH: usize = 32;

/// The state of a network after some epochs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Checkpoint {
    pub(crate) epochs: u32,
    pub(crate) step: u64,
    /// Time trained.
    pub(crate) seconds: f64,
    /// Weights, first moment, second moment, average.
    pub(crate) arrays: [Vec<f32>; 4],
}

impl Checkpoint {
    /// Where the checkpoint of `network` is.
    pub(crate) fn path(folder: &Path, network: &str) -> PathBuf {
        folder.join(format!("{network}.checkpoint"))
    }

    /// Replaces the file at `path` in one step: a crash leaves the old one or the new one.
    pub(crate) fn write(&self, path: &Path) -> Result<(), TrainError> {
        replace(path, &self.to_bytes())
    }

    /// Reads the checkpoint of a network of `parameters` parameters; `None` if there is none.
    pub(crate) fn read(path: &Path, parameters: usize) -> Result<Option<Self>, TrainError> {
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(file_error("read", path, source)),
        };
        let damaged = |what| TrainError::Checkpoint { path: path.into(), what };
        Self::from_bytes(&bytes, parameters).map(Some).map_err(damaged)
    }

    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(self.epochs.to_le_bytes());
        bytes.extend((self.arrays[0].len() as u32).to_le_bytes());
        bytes.extend(self.step.to_le_bytes());
        bytes.extend(self.seconds.to_le_bytes());
        bytes.extend(self.arrays.iter().flatten().flat_map(|x| x.to_le_bytes()));
        let hash = Sha256::digest(&bytes);
        bytes.extend(hash);
        bytes
    }

    fn from_bytes(bytes: &[u8], parameters: usize) -> Result<Self, &'static str> {
        let length = HEADER + 16 * parameters + HASH;
        if bytes.len() != length || !bytes.starts_with(MAGIC) {
            return Err("its length or start is not that of a checkpoint of this network");
        }
        let (content, hash) = bytes.split_at(length - HASH);
        if Sha256::digest(content).as_slice() != hash {
            return Err("its hash does not match its content");
        }
        let (header, arrays) = content.split_at(HEADER);
        if le(header, 12) as usize != parameters {
            return Err("it is of a network of another size");
        }
        let values: Vec<f32> =
            arrays.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let array = |i: usize| values[i * parameters..(i + 1) * parameters].to_vec();
        let wide = |at| u64::from(le(header, at)) | u64::from(le(header, at + 4)) << 32;
        Ok(Self {
            epochs: le(header, 8),
            step: wide(16),
            seconds: f64::from_bits(wide(24)),
            arrays: [array(0), array(1), array(2), array(3)],
        })
    }
}

/// The little-endian number at `at`.
fn le(bytes: &[u8], at: usize) -> u32 {
    (0..4).fold(0, |n, i| n | u32::from(bytes[at + i]) << (8 * i))
}

/// What must be the same for a run to continue another.
#[derive(Serialize, Deserialize)]
struct Settings {
    data_hash: String,
    species: Vec<String>,
    training_trees: usize,
    options: TrainOptions,
}

/// Opens the folder for a run: makes it, or checks that what is in it is of the same run.
pub(crate) fn open(
    folder: &Path,
    set: &TrainingSet,
    data_hash: &str,
    options: &TrainOptions,
) -> Result<(), TrainError> {
    fs::create_dir_all(folder).map_err(|source| file_error("make", folder, source))?;
    let settings = Settings {
        data_hash: data_hash.to_owned(),
        species: set.species.clone(),
        training_trees: set.train.len(),
        options: options.clone(),
    };
    let ours = toml::to_string(&settings)?;
    let path = folder.join("settings.toml");
    match fs::read_to_string(&path) {
        Ok(theirs) => match difference(&theirs, &ours) {
            Some(difference) => Err(TrainError::OtherRun { path: folder.into(), difference }),
            None => Ok(()),
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => replace(&path, ours.as_bytes()),
        Err(source) => Err(file_error("read", &path, source)),
    }
}

/// What differs between two texts of settings, but for what does not change the result.
fn difference(theirs: &str, ours: &str) -> Option<String> {
    let table = |text: &str| text.parse::<toml::Table>().unwrap_or_default();
    let mut found = Vec::new();
    compare("", &table(theirs), &table(ours), &mut found);
    (!found.is_empty()).then(|| found.join("; "))
}

fn compare(prefix: &str, theirs: &toml::Table, ours: &toml::Table, found: &mut Vec<String>) {
    let mut keys: Vec<&String> = theirs.keys().chain(ours.keys()).collect();
    keys.sort_unstable();
    keys.dedup();
    for key in keys {
        let name = format!("{prefix}{key}");
        match (theirs.get(key), ours.get(key)) {
            // How fast it goes, not where to.
            _ if name == "options.workers" => {}
            (Some(toml::Value::Table(theirs)), Some(toml::Value::Table(ours))) => {
                compare(&format!("{name}."), theirs, ours, found);
            }
            (theirs, ours) if theirs == ours => {}
            (theirs, ours) => {
                let text = |v: Option<&toml::Value>| v.map_or("unset".into(), |v| v.to_string());
                found.push(format!("`{name}` was {}, now {}", text(theirs), text(ours)));
            }
        }
    }
}

/// Writes a file beside `path`, and moves it there.
fn replace(path: &Path, bytes: &[u8]) -> Result<(), TrainError> {
    let beside = path.with_extension("new");
    fs::write(&beside, bytes).map_err(|source| file_error("write", &beside, source))?;
    fs::rename(&beside, path).map_err(|source| file_error("replace", path, source))
}

fn file_error(action: &'static str, path: &Path, source: io::Error) -> TrainError {
    TrainError::File { action, path: path.into(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint() -> Checkpoint {
        let array = |x: f32| vec![x, -x, 1.0 / x];
        Checkpoint {
            epochs: 3,
            step: u64::from(u32::MAX) + 7,
            seconds: 0.1,
            arrays: [array(1.0), array(3.0), array(1e-30), array(7.0)],
        }
    }

    #[test]
    fn bytes_come_back_as_the_same_checkpoint() {
        let bytes = checkpoint().to_bytes();
        assert_eq!(Checkpoint::from_bytes(&bytes, 3), Ok(checkpoint()));
    }

    #[test]
    fn every_damaged_byte_and_every_cut_is_noticed() {
        let bytes = checkpoint().to_bytes();
        for i in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[i] ^= 0x40;
            assert!(Checkpoint::from_bytes(&damaged, 3).is_err(), "byte {i}");
            assert!(Checkpoint::from_bytes(&bytes[..i], 3).is_err(), "cut at {i}");
        }
        assert!(Checkpoint::from_bytes(&bytes, 4).is_err());
    }

    #[test]
    fn differences_of_settings_are_named() {
        let theirs = "data_hash = \"a\"\n[options]\nbatch = 8\nworkers = 1\nseed = 1";
        let ours = "data_hash = \"a\"\n[options]\nbatch = 16\nworkers = 2";
        let found = difference(theirs, ours).unwrap();
        assert_eq!(found, "`options.batch` was 8, now 16; `options.seed` was 1, now unset");
        assert_eq!(difference(theirs, theirs), None);
    }
}
