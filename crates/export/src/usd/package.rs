//! Packages: ZIP archives whose files are stored as they are and begin at multiples of 64 bytes.
//!
//! # Source
//!
//! .ZIP File Format Specification 6.3, PKWARE, §4.3 and §4.4; `usdz` file format specification 1.3,
//! Pixar (no compression, alignment, the root layer first).

use std::io::{self, Seek, SeekFrom, Write};

/// Where the contents of a file may begin: at multiples of so many bytes.
const ALIGNMENT: u64 = 64;
/// Bytes of a file's header before its name.
const HEADER: u64 = 30;
/// Where checksum and lengths stand in a header.
const SUMS: u64 = 14;
/// Which extra field fills a header up, and its own bytes.
const PADDING: u16 = 0x1986;
const EXTRA_HEADER: u64 = 4;
/// The least version of programs that read this; the first of 1980, the earliest date there is.
const VERSION: u16 = 20;
const DATE: u16 = 0x0021;

/// A file of the package.
struct Entry {
    name: String,
    /// Where its header stands.
    offset: u64,
    checksum: u32,
    length: u64,
}

/// A package that is being written.
pub(super) struct Package<'a, W> {
    out: &'a mut W,
    /// Where the package begins in the output.
    start: u64,
    /// Bytes written.
    position: u64,
    entries: Vec<Entry>,
}

impl<'a, W: Write + Seek> Package<'a, W> {
    pub(super) fn new(out: &'a mut W) -> io::Result<Self> {
        let start = out.stream_position()?;
        Ok(Self { out, start, position: 0, entries: Vec::new() })
    }

    /// Adds a file, whose contents `write` writes.
    pub(super) fn add<E: From<io::Error>>(
        &mut self,
        name: String,
        write: impl FnOnce(&mut Contents<'_, W>) -> Result<(), E>,
    ) -> Result<(), E> {
        let offset = self.position;
        let mut extra = ALIGNMENT - (offset + HEADER + name.len() as u64) % ALIGNMENT;
        if extra < EXTRA_HEADER {
            extra += ALIGNMENT;
        }
        self.write(&0x0403_4B50u32.to_le_bytes())?;
        self.write(&numbers([VERSION, 0, 0, 0, DATE]))?;
        // Checksum and lengths are not known yet.
        self.write(&[0; 12])?;
        self.write(&numbers([name.len() as u16, extra as u16]))?;
        self.write(name.as_bytes())?;
        self.write(&numbers([PADDING, (extra - EXTRA_HEADER) as u16]))?;
        self.write(&vec![0; (extra - EXTRA_HEADER) as usize])?;

        let mut contents =
            Contents { out: &mut *self.out, checksum: crc32fast::Hasher::new(), length: 0 };
        write(&mut contents)?;
        let (checksum, length) = (contents.checksum.finalize(), contents.length);
        self.position += length;
        let lengths = number(length)?;
        self.out.seek(SeekFrom::Start(self.start + offset + SUMS))?;
        self.out.write_all([checksum, lengths, lengths].map(u32::to_le_bytes).as_flattened())?;
        self.out.seek(SeekFrom::Start(self.start + self.position))?;
        self.entries.push(Entry { name, offset, checksum, length });
        Ok(())
    }

    /// Writes the list of all files, which ends the package.
    pub(super) fn finish(mut self) -> io::Result<()> {
        let directory = self.position;
        let entries = std::mem::take(&mut self.entries);
        for Entry { name, offset, checksum, length } in &entries {
            let length = number(*length)?;
            self.write(&0x0201_4B50u32.to_le_bytes())?;
            self.write(&numbers([VERSION, VERSION, 0, 0, 0, DATE]))?;
            self.write([*checksum, length, length].map(u32::to_le_bytes).as_flattened())?;
            // No extra field, no comment, the first disk, and no attributes.
            self.write(&numbers([name.len() as u16, 0, 0, 0, 0, 0, 0]))?;
            self.write(&number(*offset)?.to_le_bytes())?;
            self.write(name.as_bytes())?;
        }
        let length = number(self.position - directory)?;
        let count = entries.len() as u16;
        self.write(&0x0605_4B50u32.to_le_bytes())?;
        self.write(&numbers([0, 0, count, count]))?;
        self.write([length, number(directory)?].map(u32::to_le_bytes).as_flattened())?;
        self.write(&numbers([0]))?;
        self.out.flush()
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.position += bytes.len() as u64;
        self.out.write_all(bytes)
    }
}

/// The contents of a file, summed up while they are written.
pub(super) struct Contents<'a, W> {
    out: &'a mut W,
    checksum: crc32fast::Hasher,
    length: u64,
}

impl<W: Write> Write for Contents<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = self.out.write(bytes)?;
        self.checksum.update(&bytes[..taken]);
        self.length += taken as u64;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A length or a place, which the format counts with 32 bits.
fn number(number: u64) -> io::Result<u32> {
    u32::try_from(number).map_err(|_| io::ErrorKind::FileTooLarge.into())
}

fn numbers<const N: usize>(numbers: [u16; N]) -> Vec<u8> {
    numbers.map(u16::to_le_bytes).concat()
}
