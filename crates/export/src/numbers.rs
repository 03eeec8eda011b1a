//! Numbers as little-endian bytes.

use std::io::{self, Write};

/// Writes rows of `N` floats.
pub(crate) fn write_floats<const N: usize>(
    out: &mut impl Write,
    rows: impl Iterator<Item = [f32; N]>,
) -> io::Result<()> {
    for row in rows {
        out.write_all(row.map(f32::to_le_bytes).as_flattened())?;
    }
    Ok(())
}

/// A species name on one line: control characters would end a comment or a name early.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
