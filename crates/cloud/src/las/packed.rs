//! Compressed points.
//!
//! The library that unpacks them believes the sizes it reads. It gets an input that cannot seek, so
//! that it does without the table of chunks, and the sizes of the layers of each chunk are looked at
//! before it does.
//!
//! Its reader of times calls itself for each change of sequence, of which a damaged file can tell
//! without end. Where times have a layer of their own they are left out. Elsewhere they are in
//! between the rest; there the library runs on a large stack, of which the input looks how much is
//! used up.

use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::thread;

use laz::{DecompressionSelection, LasZipDecompressor, LazItem, LazItemType, LazVlr};

use crate::error::ReadCloudError;

use super::LasError;
use super::header::{Header, u32_at};
use super::read::Take;

/// The layers of a chunk have no more bytes: a hundred times what 50 000 points need, which is the
/// usual chunk.
const MOST_BYTES: u64 = 256 << 20;

/// Stack to unpack on, and how much of it can be used up when the input is asked for more; in bytes.
/// From one byte of input to the next the library calls itself 36 000 times at most: a symbol that
/// repeats has 5 of 2¹⁵ parts left for the others, so it takes 2.2e-4 bits. What is left of the stack
/// then is 1.4 kB a call, many times what one takes.
const STACK: usize = 64 << 20;
const MOST_STACK: usize = 16 << 20;

/// Hands over the bytes of each point, as many as there are.
pub(super) fn unpack(
    input: impl Read + Send + Sync,
    header: &Header,
    take: &mut Take<'_>,
) -> Result<(), ReadCloudError> {
    let record = header.packing.as_deref().ok_or(LasError::Packing)?;
    let packing = LazVlr::from_buffer(record).map_err(|_| LasError::Packing)?;
    // The library reads what an item is by its type and not by its size: where they disagree, it
    // would take for the sizes of layers what is none.
    let fits = |item: &LazItem| item.size() == size_of(item.item_type());
    if packing.items_size() != header.size as u64 || !packing.items().iter().all(fits) {
        return Err(LasError::Packing.into());
    }
    thread::scope(|scope| {
        let work = || each_point(Ahead::new(input), packing, header, take);
        let thread = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work)?;
        // The library panics on some damaged files; nothing it has left half-done is used again.
        thread.join().unwrap_or_else(|_| Err(LasError::Damaged.into()))
    })
}

/// What is not skipped of a point: all that is read of it.
fn selection() -> DecompressionSelection {
    DecompressionSelection::base()
        .decompress_z()
        .decompress_classification()
        .decompress_intensity()
        .decompress_point_source_id()
        .decompress_extra_bytes()
}

fn each_point<R: Read + Send + Sync>(
    input: Ahead<R>,
    packing: LazVlr,
    header: &Header,
    take: &mut Take<'_>,
) -> Result<(), ReadCloudError> {
    let layers = layers(&packing);
    let mut chunk = u64::from(packing.chunk_size());
    let has_varying_chunks = packing.uses_variable_size_chunks();
    let mut unpacker = LasZipDecompressor::selective(input, packing, selection())
        .map_err(|_| LasError::Packing)?;
    let mut point = vec![0; header.size];
    let mut left_in_chunk = 0;
    for _ in 0..header.count {
        if layers > 0 && left_in_chunk == 0 {
            match unpacker.get_mut().next_chunk(header.size, layers)? {
                None => break,
                Some(count) if has_varying_chunks => chunk = u64::from(count),
                Some(_) => {}
            }
            left_in_chunk = chunk;
        }
        match unpacker.decompress_one(&mut point) {
            Ok(()) => take(&point)?,
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => break,
            Err(_) => return Err(LasError::Damaged.into()),
        }
        left_in_chunk = left_in_chunk.saturating_sub(1);
    }
    Ok(())
}

/// Bytes of an item in a point that is not packed.
fn size_of(kind: LazItemType) -> u16 {
    match kind {
        LazItemType::Point10 => 20,
        LazItemType::Point14 => 30,
        LazItemType::GpsTime | LazItemType::RGBNIR14 => 8,
        LazItemType::RGB12 | LazItemType::RGB14 => 6,
        LazItemType::WavePacket13 | LazItemType::WavePacket14 => 29,
        LazItemType::Byte(count) | LazItemType::Byte14(count) => count,
    }
}

/// How many layers a chunk has; none in the older ways of packing.
fn layers(packing: &LazVlr) -> usize {
    let layers = |kind: LazItemType| match kind {
        LazItemType::Point14 => 9,
        LazItemType::RGB14 | LazItemType::WavePacket14 => 1,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(count) => usize::from(count),
        _ => 0,
    };
    packing.items().iter().map(|item| layers(item.item_type())).sum()
}

/// An input whose next bytes can be looked at.
struct Ahead<R> {
    input: R,
    bytes: Vec<u8>,
    /// How many of them were read.
    read: usize,
    /// Where the stack was when it was made.
    stack: usize,
}

/// Where the stack is.
#[inline(never)]
fn stack() -> usize {
    let here = 0u8;
    std::ptr::from_ref(std::hint::black_box(&here)).addr()
}

impl<R: Read> Ahead<R> {
    fn new(input: R) -> Self {
        Self { input, bytes: Vec::new(), read: 0, stack: stack() }
    }

    /// How many points the next chunk has; none at the end of the input.
    ///
    /// A chunk begins with a point of `size` bytes, the number of points, and the sizes of layers.
    fn next_chunk(&mut self, size: usize, layers: usize) -> Result<Option<u32>, ReadCloudError> {
        self.bytes.drain(..self.read);
        self.read = 0;
        let wanted = size + 4 + 4 * layers;
        let missing = wanted.saturating_sub(self.bytes.len()) as u64;
        (&mut self.input).take(missing).read_to_end(&mut self.bytes)?;
        if self.bytes.len() < wanted {
            return Ok(None);
        }
        let sizes = self.bytes[size + 4..wanted].as_chunks::<4>().0;
        let bytes: u64 = sizes.iter().map(|b| u64::from(u32::from_le_bytes(*b))).sum();
        if bytes > MOST_BYTES {
            return Err(LasError::Damaged.into());
        }
        Ok(Some(u32_at(&self.bytes, size)))
    }
}

impl<R: Read> Read for Ahead<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.stack.abs_diff(stack()) > MOST_STACK {
            return Err(ErrorKind::InvalidData.into());
        }
        if self.read == self.bytes.len() {
            return self.input.read(out);
        }
        let count = (&self.bytes[self.read..]).read(out)?;
        self.read += count;
        Ok(count)
    }
}

impl<R> Seek for Ahead<R> {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Err(ErrorKind::Unsupported.into())
    }
}
