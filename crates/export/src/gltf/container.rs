//! Files around a description: the binary container, and how JSON text is padded.

use std::io::{self, Write};

use super::GltfError;

/// First word of a GLB file: "glTF".
const MAGIC: u32 = 0x4654_6C67;
/// Kind of the chunk with the description: "JSON".
const JSON_CHUNK: u32 = 0x4E4F_534A;
/// Kind of the chunk with the numbers: "BIN\0".
const BIN_CHUNK: u32 = 0x004E_4942;
/// Bytes before the first chunk.
const HEADER: u64 = 12;
/// Bytes before the contents of a chunk.
const CHUNK_HEADER: u64 = 8;

/// Writes all of a GLB file but the contents of the binary chunk, which has `binary` bytes, a
/// multiple of 4, and follows unless it is empty.
pub(super) fn write_head(
    mut text: Vec<u8>,
    binary: u64,
    out: &mut impl Write,
) -> Result<(), GltfError> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunks = if binary > 0 { 2 } else { 1 };
    let bytes = HEADER + chunks * CHUNK_HEADER + text.len() as u64 + binary;
    let total = u32::try_from(bytes).map_err(|_| GltfError::TooLarge { bytes })?;
    write_words(out, [MAGIC, 2, total])?;
    write_words(out, [text.len() as u32, JSON_CHUNK])?;
    out.write_all(&text)?;
    if binary > 0 {
        write_words(out, [binary as u32, BIN_CHUNK])?;
    }
    Ok(())
}

fn write_words<const N: usize>(out: &mut impl Write, words: [u32; N]) -> io::Result<()> {
    out.write_all(words.map(u32::to_le_bytes).as_flattened())
}
