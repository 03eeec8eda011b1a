//! Reading files whole, but not endless ones.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::SceneError;
use crate::mesh::TriangleMesh;

/// The most bytes a file may have: a million faces fit several times.
pub(crate) const MAX_BYTES: u64 = 512 << 20;

pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    let failed = |source| SceneError::Read { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(SceneError::TooLarge { path: path.to_owned() });
    }
    Ok(bytes)
}

/// The mesh of a file, named from a folder.
pub(crate) fn mesh(folder: &Path, file: &str) -> Result<TriangleMesh, SceneError> {
    let named = |problem| SceneError::Mesh { file: file.to_owned(), problem };
    let bytes = bytes(&folder.join(file))?;
    TriangleMesh::from_bytes(file, &bytes).map_err(named)
}
