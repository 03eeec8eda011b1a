//! Reading PLY.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};

use crate::error::ReadCloudError;
use crate::gather::{Gather, ReadOptions, Reading};
use crate::names::Layout;

use super::header::{Element, Encoding, Header, PlyError, Scalar};

/// Reads the vertices of a PLY file.
///
/// Vertices that the header promises but the file does not have are counted as missing.
///
/// # Errors
///
/// When the input fails, is no PLY file, or has no vertices.
pub fn read(input: impl Read, options: &ReadOptions) -> Result<Reading, ReadCloudError> {
    let mut input = BufReader::with_capacity(1 << 16, input);
    let header = Header::read(&mut input)?;
    let mut values = Values { input, encoding: header.encoding, word: Vec::new() };
    for element in &header.elements {
        if element.name != "vertex" {
            values.skip(element)?;
            continue;
        }
        let options = ReadOptions { up: header.up.unwrap_or(options.up), ..*options };
        return read_vertices(&mut values, element, options);
    }
    Err(PlyError::NoPoints.into())
}

fn read_vertices(
    values: &mut Values<impl BufRead>,
    element: &Element,
    options: ReadOptions,
) -> Result<Reading, ReadCloudError> {
    // A list has no name here: none of its values is a coordinate or a label.
    let names: Vec<&str> =
        element.properties.iter().map(|p| if p.list.is_some() { "" } else { &p.name }).collect();
    let layout = Layout::of_names(&names).ok_or(PlyError::NoPoints)?;
    let mut gather = Gather::new(options, layout.present());
    let mut row = Vec::new();
    for read in 0..element.count {
        match values.row(element, &mut row) {
            Ok(()) => {}
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                gather.dropped().missing = element.count - read;
                break;
            }
            Err(error) => return Err(error.into()),
        }
        match layout.point(&row) {
            Some((place, attributes)) => gather.push(place, &attributes)?,
            None => gather.dropped().not_finite += 1,
        }
    }
    gather.finish()
}

/// The longest number of an ascii file in bytes.
const LONGEST_WORD: usize = 64;

/// The numbers of a file, one after another.
struct Values<R> {
    input: R,
    encoding: Encoding,
    word: Vec<u8>,
}

impl<R: BufRead> Values<R> {
    /// The properties of one element; none for a list and for what is no number.
    fn row(&mut self, element: &Element, row: &mut Vec<Option<f64>>) -> io::Result<()> {
        row.clear();
        for property in &element.properties {
            let value = match property.list {
                None => self.value(property.scalar)?,
                Some(length) => {
                    self.skip_list(length, property.scalar)?;
                    None
                }
            };
            row.push(value);
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> io::Result<()> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut row = Vec::new();
        (0..element.count).try_for_each(|_| self.row(element, &mut row))
    }

    fn skip_list(&mut self, length: Scalar, scalar: Scalar) -> io::Result<()> {
        // A cast saturates: no list has fewer than none.
        let length = self.value(length)?.unwrap_or_default() as u64;
        if self.encoding == Encoding::Ascii {
            return (0..length).try_for_each(|_| self.value(scalar).map(drop));
        }
        let wanted = length * scalar.size() as u64;
        let skipped = io::copy(&mut (&mut self.input).take(wanted), &mut io::sink())?;
        if skipped == wanted { Ok(()) } else { Err(ErrorKind::UnexpectedEof.into()) }
    }

    fn value(&mut self, scalar: Scalar) -> io::Result<Option<f64>> {
        if self.encoding == Encoding::Ascii {
            self.next_word()?;
            return Ok(std::str::from_utf8(&self.word).ok().and_then(|word| word.parse().ok()));
        }
        let mut bytes = [0; 8];
        let bytes_of_value = &mut bytes[..scalar.size()];
        self.input.read_exact(bytes_of_value)?;
        if self.encoding == Encoding::BigEndian {
            bytes_of_value.reverse();
        }
        Ok(Some(scalar.value(bytes)))
    }

    /// Puts what stands between the next blanks into `word`.
    fn next_word(&mut self) -> io::Result<()> {
        self.word.clear();
        loop {
            let bytes = self.input.fill_buf()?;
            if bytes.is_empty() {
                let ended = self.word.is_empty();
                return if ended { Err(ErrorKind::UnexpectedEof.into()) } else { Ok(()) };
            }
            let blanks = match self.word.is_empty() {
                true => bytes.iter().take_while(|b| b.is_ascii_whitespace()).count(),
                false => 0,
            };
            let letters = bytes[blanks..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
            let room = LONGEST_WORD - self.word.len();
            self.word.extend_from_slice(&bytes[blanks..blanks + letters.min(room)]);
            let taken = blanks + letters;
            let complete = taken < bytes.len() && letters + self.word.len() > 0;
            self.input.consume(taken);
            if complete {
                return Ok(());
            }
        }
    }
}
