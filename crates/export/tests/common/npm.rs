//! Packages of npm, for tests that look at files with programs written in JavaScript.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A folder of the build folder in which the packages are installed; none, with a line about it,
/// where they cannot be had.
///
/// They are installed beside and put into place whole: tests that run at once, and those after an
/// interrupted one, see all of a package or nothing.
pub(crate) fn install(packages: &[&str]) -> Option<PathBuf> {
    let builds = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let place = builds.join(packages.join("+"));
    if place.is_dir() {
        return Some(place);
    }
    let beside = tempfile::tempdir_in(builds).unwrap();
    std::fs::write(beside.path().join("package.json"), "{}").unwrap();
    let install = Command::new("npm")
        .args(["install", "--no-audit", "--no-fund", "--prefix"])
        .arg(beside.path())
        .args(packages)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    if !install.is_ok_and(|status| status.success()) {
        eprintln!("skipped: npm could not install {packages:?}");
        return None;
    }
    // Who comes second finds the place taken, by the same packages.
    let moved = std::fs::rename(beside.path(), &place);
    assert!(place.is_dir(), "{}: {moved:?}", place.display());
    Some(place)
}
