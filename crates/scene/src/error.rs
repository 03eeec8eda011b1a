//! Why a scene cannot be used.

use std::io;
use std::path::PathBuf;

use crate::boxes::BoxProblem;
use crate::mesh::MeshError;

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SceneError {
    #[error("cannot read {}", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{} is larger than {} MB; reduce it first", path.display(), crate::files::MAX_BYTES >> 20)]
    TooLarge { path: PathBuf },
    #[error("{} is not UTF-8; a scene is a text file", path.display())]
    NotText { path: PathBuf },
    #[error("line {line}: {message}")]
    Toml { line: usize, message: String },
    #[error("box {number}: {problem}")]
    Box { number: usize, problem: BoxProblem },
    #[error("mesh {file}: {problem}")]
    Mesh { file: String, problem: MeshError },
    #[error("an obstacle stands on the tree's foot; keep the first 1.1 m above it free")]
    OverRoot,
    #[error("there is no form `{name}`; the forms are cone, cube, ring and a .obj or .glb file")]
    UnknownForm { name: String },
    #[error(
        "the mesh {file} is not closed: {open_edges} edges have not one face on each side, all the same way round"
    )]
    OpenForm { file: String, open_edges: usize },
    #[error(
        "no voxel of the growth space lies within the mesh {file}; its tree stands at the origin, y up, in metres"
    )]
    EmptyForm { file: String },
}
