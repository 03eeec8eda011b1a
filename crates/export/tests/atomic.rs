//! A file is there whole or not at all.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::error::Error;
use std::fs;
use std::io::{self, Write};

use deeptree_export::{WriteError, write_atomically};

fn names(folder: &std::path::Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_failed_writer_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.obj");
    write_atomically(&path, |w| w.write_all(b"old")).unwrap();
    let result = write_atomically(&path, |w| {
        w.write_all(&[b'x'; 100_000])?;
        Err(io::Error::other("no more wood"))
    });
    let error = result.unwrap_err();
    assert!(matches!(error, WriteError::Contents { .. }));
    assert!(error.to_string().contains("tree.obj"), "{error}");
    assert_eq!(error.source().unwrap().to_string(), "no more wood");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["tree.obj"]);
}

#[test]
fn a_panicking_writer_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.obj");
    let run = || write_atomically(&path, |_| -> io::Result<()> { panic!("in the writer") });
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
    assert!(names(folder.path()).is_empty());
}

#[test]
fn errors_name_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let nowhere = folder.path().join("missing/tree.glb");
    let error = write_atomically(&nowhere, |_| io::Result::Ok(())).unwrap_err();
    assert!(matches!(error, WriteError::Create { .. }));
    assert!(error.to_string().contains("missing"), "{error}");
    let error = write_atomically(folder.path(), |_| io::Result::Ok(())).unwrap_err();
    assert!(matches!(error, WriteError::Replace { .. }), "{error:?}");
}

#[test]
fn a_bare_file_name_is_written_to_the_current_folder() {
    // Has no parent folder in its path; the name is unlike any file of the crate.
    let path = std::path::Path::new("atomic-test-bare-name.tmp");
    write_atomically(path, |w| w.write_all(b"bare")).unwrap();
    let contents = fs::read(path);
    fs::remove_file(path).unwrap();
    assert_eq!(contents.unwrap(), b"bare");
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    fn mode(path: &std::path::Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn new_files_have_the_permissions_of_any_new_file() {
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        fs::write(&plain, b"").unwrap();
        write_atomically(&ours, |w| w.write_all(b"new")).unwrap();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn replaced_files_keep_their_permissions_and_links_stay() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_atomically(&link, |w| w.write_all(b"new")).unwrap();
        assert_eq!((fs::read(&file).unwrap(), mode(&file)), (b"new".to_vec(), 0o640));
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }

    #[test]
    fn a_full_disk_is_an_error() {
        let full = std::path::Path::new("/dev/full");
        if full.exists() {
            write_atomically(full, |w| w.write_all(b"no room")).unwrap_err();
        }
    }
}
