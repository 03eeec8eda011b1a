//! Files that belong to a main file and stand beside it, such as pictures.

use std::path::{Path, PathBuf};

/// Names the files beside a main file: its own name without the extension, and what they are.
pub(crate) struct Beside<'a> {
    main: &'a Path,
    stem: &'a str,
}

/// The main file names others, and its own name is no text.
#[derive(Debug, thiserror::Error)]
#[error("the name of {} is no UTF-8, which the files beside it need; choose another name", path.display())]
pub struct NameError {
    /// The main file.
    pub path: PathBuf,
}

impl<'a> Beside<'a> {
    pub(crate) fn new(main: &'a Path) -> Result<Self, NameError> {
        let stem = main.file_stem().and_then(|stem| stem.to_str());
        let stem = stem.ok_or_else(|| NameError { path: main.to_owned() })?;
        Ok(Self { main, stem })
    }

    /// The name of the file that ends so.
    pub(crate) fn name(&self, end: &str) -> String {
        format!("{}{end}", self.stem)
    }

    /// The name of the picture that is called so.
    pub(crate) fn picture(&self, name: &str) -> String {
        self.name(&format!("_{}.png", slug(name)))
    }

    /// Where the file of this name stands.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.main.with_file_name(name)
    }
}

/// A name in letters, digits and `_`, which no format and no file system minds.
pub(crate) fn slug(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    name.chars().map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_stand_beside_the_main_file_and_have_plain_names() {
        let beside = Beside::new(Path::new("woods/my oak.gltf")).expect("a name");
        let name = beside.picture("Oak bark: color");
        assert_eq!(name, "my oak_oak_bark__color.png");
        assert_eq!(beside.path(&name), Path::new("woods/my oak_oak_bark__color.png"));
    }
}
