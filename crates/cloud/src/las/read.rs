//! Reading LAS.

use std::io::{BufReader, ErrorKind, Read};

use crate::columns::{Attributes, Class};
use crate::error::ReadCloudError;
use crate::gather::{Gather, ReadOptions, Reading};

#[cfg(not(feature = "laz"))]
use super::LasError;
use super::extra::{self, Extra, i32_at};
use super::header::{Header, SIZES, u16_at};

/// Takes the bytes of a point.
pub(super) type Take<'a> = dyn FnMut(&[u8]) -> Result<(), ReadCloudError> + Send + 'a;

/// Reads the points of a LAS or LAZ file.
///
/// Points that the header promises but the file does not have are counted as missing.
///
/// # Errors
///
/// When the input fails, is no LAS file, is damaged, or has no points.
pub fn read(
    input: impl Read + Send + Sync,
    options: &ReadOptions,
) -> Result<Reading, ReadCloudError> {
    let mut input = BufReader::with_capacity(1 << 16, input);
    let header = Header::read(&mut input)?;
    let layout = Layout::of(&header);
    let mut gather = Gather::new(*options, layout.present());
    let mut read = 0;
    let mut take = |point: &[u8]| {
        read += 1;
        let (place, attributes) = layout.point(&header, point);
        gather.push(place, &attributes)
    };
    if header.is_packed {
        unpack(input, &header, &mut take)?;
    } else {
        each_record(&mut input, &header, &mut take)?;
    }
    gather.dropped().missing = header.count - read;
    gather.finish()
}

/// Hands over the bytes of each point, as many as there are.
fn each_record(
    input: &mut impl Read,
    header: &Header,
    take: &mut Take<'_>,
) -> Result<(), ReadCloudError> {
    let mut point = vec![0; header.size];
    for _ in 0..header.count {
        match input.read_exact(&mut point) {
            Ok(()) => take(&point)?,
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => break,
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

#[cfg(feature = "laz")]
fn unpack(
    input: impl Read + Send + Sync,
    header: &Header,
    take: &mut Take<'_>,
) -> Result<(), ReadCloudError> {
    super::packed::unpack(input, header, take)
}

#[cfg(not(feature = "laz"))]
fn unpack(_: impl Read, _: &Header, _: &mut Take<'_>) -> Result<(), ReadCloudError> {
    Err(LasError::NoLaz.into())
}

/// Where the fields of a point are.
struct Layout {
    class: usize,
    /// Older formats keep flags in the upper bits of the class.
    class_mask: u8,
    station: usize,
    extra: [Option<Extra>; 6],
}

impl Layout {
    fn of(header: &Header) -> Self {
        let start = SIZES[usize::from(header.format)];
        let extra = header.extra.as_deref().map(|record| extra::find(record, start));
        let extra = extra.unwrap_or_default();
        if header.format < 6 {
            Self { class: 15, class_mask: 31, station: 18, extra }
        } else {
            Self { class: 16, class_mask: 255, station: 20, extra }
        }
    }

    fn present(&self) -> [bool; 6] {
        let [.., branch, order, node, _] = self.extra.map(|extra| extra.is_some());
        [true, true, branch, order, node, true]
    }

    fn point(&self, header: &Header, point: &[u8]) -> ([f64; 3], Attributes) {
        let place = std::array::from_fn(|k| {
            f64::from(i32_at(point, 4 * k)) * header.scale[k] + header.offset[k]
        });
        let extra = |k: usize| self.extra[k].map_or(0.0, |extra| extra.value(point));
        // Casts saturate, and NaN is 0.
        let attributes = Attributes {
            intensity: f32::from(u16_at(point, 12)),
            class: Class::from_code(point[self.class] & self.class_mask),
            branch: extra(2) as u32,
            order: extra(3) as u16,
            node: extra(4) as u32,
            station: u16_at(point, self.station),
        };
        (place, attributes)
    }
}
