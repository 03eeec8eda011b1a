//! The file formats of trees.

use std::path::Path;
use std::str::FromStr;

use crate::args::UsageError;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Glb,
    Gltf,
    Obj,
    Ply,
    Usda,
    Usdz,
    Tree,
    Csv,
    Parquet,
    Dtree,
}

impl Format {
    pub(crate) const ALL: [Self; 10] = [
        Self::Glb,
        Self::Gltf,
        Self::Obj,
        Self::Ply,
        Self::Usda,
        Self::Usdz,
        Self::Tree,
        Self::Csv,
        Self::Parquet,
        Self::Dtree,
    ];

    /// The extension, without its dot.
    pub(crate) const fn extension(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Usda => "usda",
            Self::Usdz => "usdz",
            Self::Tree => "tree",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::Dtree => "dtree",
        }
    }

    /// Can one file hold several trees?
    pub(crate) const fn is_table(self) -> bool {
        matches!(self, Self::Csv | Self::Parquet)
    }

    /// Does it hold the surfaces of a tree?
    pub(crate) const fn is_surface(self) -> bool {
        !matches!(self, Self::Tree | Self::Csv | Self::Parquet | Self::Dtree)
    }

    /// Is it glTF, in one file or in several?
    pub(crate) const fn is_gltf(self) -> bool {
        matches!(self, Self::Glb | Self::Gltf)
    }

    /// The format that the extension of a path names; none when it has no extension.
    pub(crate) fn of_path(path: &Path) -> Result<Option<Self>, UsageError> {
        match path.extension() {
            None => Ok(None),
            Some(extension) => extension
                .to_string_lossy()
                .to_lowercase()
                .parse()
                .map(Some)
                .map_err(|problem| UsageError(format!("{}: {problem}", path.display()))),
        }
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let name = name.trim_start_matches('.');
        Self::ALL.into_iter().find(|format| format.extension() == name).ok_or_else(|| {
            let known: Vec<String> =
                Self::ALL.iter().map(|format| format!(".{}", format.extension())).collect();
            format!("there is no format '.{name}'; the formats are {}", known.join(" "))
        })
    }
}
