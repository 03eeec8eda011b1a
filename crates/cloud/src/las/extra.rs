//! Extra bytes of points, by name.

use crate::columns::Columns;
use crate::names::field;

use super::header::{array, f64_at};

/// Length of the description of one field in bytes.
const LENGTH: usize = 192;

/// A number among the extra bytes of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extra {
    at: usize,
    kind: u8,
    scale: f64,
    offset: f64,
}

impl Extra {
    /// The value; zero where the point is too short.
    pub(super) fn value(&self, point: &[u8]) -> f64 {
        let Some(bytes) = point.get(self.at..self.at + size(self.kind, 0)) else { return 0.0 };
        let b: [u8; 8] = std::array::from_fn(|k| bytes.get(k).copied().unwrap_or_default());
        let four = [b[0], b[1], b[2], b[3]];
        let raw = match self.kind {
            1 => f64::from(b[0]),
            2 => f64::from(b[0].cast_signed()),
            3 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            4 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            5 => f64::from(u32::from_le_bytes(four)),
            6 => f64::from(i32::from_le_bytes(four)),
            7 => u64::from_le_bytes(b) as f64,
            8 => i64::from_le_bytes(b) as f64,
            9 => f64::from(f32::from_le_bytes(four)),
            _ => f64::from_le_bytes(b),
        };
        raw * self.scale + self.offset
    }
}

/// Size of a kind in bytes; kind 0 says it itself. Kinds above 10 are two or three of a kind.
fn size(kind: u8, undocumented: u8) -> usize {
    const SIZES: [usize; 10] = [1, 1, 2, 2, 4, 4, 8, 8, 4, 8];
    match kind {
        0 => usize::from(undocumented),
        kind => SIZES[usize::from(kind - 1) % 10] * (1 + usize::from(kind - 1) / 10),
    }
}

/// Where those of [`Columns::NAMES`] are that are extra bytes; `start` is where these begin.
pub(super) fn find(record: &[u8], start: usize) -> [Option<Extra>; 6] {
    let mut found = [None; 6];
    let mut at = start;
    for one in record.chunks_exact(LENGTH) {
        let (kind, options) = (one[2], one[3]);
        let name = one[4..36].split(|b| *b == 0).next().unwrap_or_default();
        let name = field(&String::from_utf8_lossy(name));
        let column = Columns::NAMES.iter().position(|known| *known == name);
        if let Some(column) = column.filter(|_| (1..=10).contains(&kind)) {
            let scale = if options & 8 != 0 { f64_at(one, 112) } else { 1.0 };
            let offset = if options & 16 != 0 { f64_at(one, 136) } else { 0.0 };
            found[column] = Some(Extra { at, kind, scale, offset });
        }
        at += size(kind, options);
    }
    found
}

/// The record that describes fields of these kinds and names.
pub(super) fn record(fields: &[(u8, &str)]) -> Vec<u8> {
    let mut record = Vec::with_capacity(fields.len() * LENGTH);
    for (kind, name) in fields {
        let mut one = [0; LENGTH];
        one[2] = *kind;
        one[4..4 + name.len()].copy_from_slice(name.as_bytes());
        record.extend(one);
    }
    record
}

/// The signed whole number at a place.
pub(super) fn i32_at(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(array(bytes, at))
}
