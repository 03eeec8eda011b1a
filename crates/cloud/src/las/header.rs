//! The header of a LAS file and the records after it.

use std::io::{ErrorKind, Read};

use crate::error::ReadCloudError;

use super::{EXTRA_RECORD, LAZ_RECORD, LasError};

/// Length of the header of LAS 1.4, of which older ones are the beginning.
pub(super) const LENGTH: usize = 375;
/// Sizes of point formats 0 to 10 in bytes.
pub(super) const SIZES: [usize; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];
/// Records after the header are not looked at beyond this many bytes.
const MOST_RECORDS: u64 = 64 << 20;

/// What a file says of its points.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) format: u8,
    pub(super) is_packed: bool,
    /// Bytes of a point, extra bytes included.
    pub(super) size: usize,
    pub(super) count: u64,
    pub(super) scale: [f64; 3],
    pub(super) offset: [f64; 3],
    /// How points are packed.
    pub(super) packing: Option<Vec<u8>>,
    /// The names of extra bytes.
    pub(super) extra: Option<Vec<u8>>,
}

impl Header {
    /// Reads up to the first point.
    pub(super) fn read(input: &mut impl Read) -> Result<Self, ReadCloudError> {
        let mut bytes = [0; LENGTH];
        let old = 227;
        fill(input, &mut bytes[..old])?;
        if &bytes[..4] != b"LASF" {
            return Err(LasError::Magic.into());
        }
        let length = usize::from(u16_at(&bytes, 94));
        check("the length of the header", length as u64, length >= old)?;
        fill(input, &mut bytes[old..length.clamp(old, LENGTH)])?;
        skip(input, length.saturating_sub(LENGTH) as u64)?;
        let points_at = u64::from(u32_at(&bytes, 96));
        check("the offset of the points", points_at, points_at >= length as u64)?;
        // The two highest bits tell that points are packed.
        let (format, is_packed) = (bytes[104] & 0x3f, bytes[104] & 0xc0 != 0);
        check("the point format", u64::from(format), usize::from(format) < SIZES.len())?;
        let size = usize::from(u16_at(&bytes, 105));
        check("the size of a point", size as u64, size >= SIZES[usize::from(format)])?;
        let has_long_count = bytes[25] >= 4 && length >= LENGTH;
        let count = match u64::from(u32_at(&bytes, 107)) {
            0 if has_long_count => u64::from_le_bytes(array(&bytes, 247)),
            count => count,
        };
        let numbers = |at: usize| std::array::from_fn(|k| f64_at(&bytes, at + 8 * k));
        let mut header = Self {
            format,
            is_packed,
            size,
            count,
            scale: numbers(131),
            offset: numbers(155),
            packing: None,
            extra: None,
        };
        header.read_records(input, u32_at(&bytes, 100), points_at - length as u64)?;
        Ok(header)
    }

    /// Reads the records between the header and the points, `left` bytes in all.
    fn read_records(
        &mut self,
        input: &mut impl Read,
        count: u32,
        mut left: u64,
    ) -> Result<(), ReadCloudError> {
        for _ in 0..count {
            let mut head = [0; 54];
            if left < head.len() as u64 || left > MOST_RECORDS {
                break;
            }
            fill(input, &mut head)?;
            left -= head.len() as u64;
            let length = u16_at(&head, 20);
            if u64::from(length) > left {
                break;
            }
            left -= u64::from(length);
            let mut data = vec![0; usize::from(length)];
            fill(input, &mut data)?;
            let user = head[2..18].split(|b| *b == 0).next().unwrap_or_default();
            match (user, u16_at(&head, 18)) {
                record if record == LAZ_RECORD => self.packing = Some(data),
                record if record == EXTRA_RECORD => self.extra = Some(data),
                _ => {}
            }
        }
        Ok(skip(input, left)?)
    }
}

fn check(field: &'static str, value: u64, holds: bool) -> Result<(), LasError> {
    if holds { Ok(()) } else { Err(LasError::Header { field, value }) }
}

fn fill(input: &mut impl Read, bytes: &mut [u8]) -> Result<(), ReadCloudError> {
    input.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => LasError::CutOff.into(),
        _ => error.into(),
    })
}

fn skip(input: &mut impl Read, bytes: u64) -> std::io::Result<()> {
    std::io::copy(&mut input.take(bytes), &mut std::io::sink()).map(drop)
}

/// `N` bytes from a place that is within them.
pub(super) fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|k| bytes[at + k])
}

pub(super) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(array(bytes, at))
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(array(bytes, at))
}

pub(super) fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(array(bytes, at))
}
