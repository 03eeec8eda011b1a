//! What a PLY file says of itself.

use std::io::{BufRead, Read};

use crate::cloud::Up;
use crate::error::ReadCloudError;

/// Why a header is no PLY header.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PlyError {
    #[error("it does not begin with the line `ply`")]
    Magic,
    #[error("its header does not end within {} kB; is it cut off?", MOST_BYTES >> 10)]
    Endless,
    #[error("line {line} of its header is not understood: `{text}`")]
    Line { line: usize, text: String },
    #[error("its header has no line `format`")]
    NoFormat,
    #[error("it has no element `vertex` with properties x, y and z that are no lists")]
    NoPoints,
}

/// The longest header in bytes.
const MOST_BYTES: u64 = 1 << 16;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Its size in bytes.
    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value of its little-endian bytes, of which there are at least as many as its size.
    pub(super) fn value(self, b: [u8; 8]) -> f64 {
        let four = [b[0], b[1], b[2], b[3]];
        match self {
            Self::I8 => f64::from(b[0].cast_signed()),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::I32 => f64::from(i32::from_le_bytes(four)),
            Self::U32 => f64::from(u32::from_le_bytes(four)),
            Self::F32 => f64::from(f32::from_le_bytes(four)),
            Self::F64 => f64::from_le_bytes(b),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// The type of the length of a list.
    pub(super) list: Option<Scalar>,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) up: Option<Up>,
}

impl Header {
    pub(super) fn read(input: &mut impl BufRead) -> Result<Self, ReadCloudError> {
        let mut input = input.take(MOST_BYTES);
        let (mut encoding, mut up, mut elements) = (None, None, Vec::new());
        for line in 1.. {
            let mut bytes = Vec::new();
            input.read_until(b'\n', &mut bytes)?;
            if bytes.last() != Some(&b'\n') {
                return Err(if line == 1 { PlyError::Magic } else { PlyError::Endless }.into());
            }
            let text = String::from_utf8_lossy(&bytes);
            let words: Vec<&str> = text.split_whitespace().collect();
            if line == 1 {
                if words != ["ply"] {
                    return Err(PlyError::Magic.into());
                }
                continue;
            }
            match words[..] {
                ["end_header"] => break,
                ["comment" | "obj_info", ..] => up = said_up(&text).or(up),
                [] => {}
                ["format", name, _] if encoding_named(name).is_some() => {
                    encoding = encoding_named(name);
                }
                _ if add(&mut elements, &words) => {}
                _ => {
                    let text = text.trim().chars().take(60).collect();
                    return Err(PlyError::Line { line, text }.into());
                }
            }
        }
        Ok(Self { encoding: encoding.ok_or(PlyError::NoFormat)?, elements, up })
    }
}

fn encoding_named(name: &str) -> Option<Encoding> {
    Some(match name {
        "ascii" => Encoding::Ascii,
        "binary_little_endian" => Encoding::LittleEndian,
        "binary_big_endian" => Encoding::BigEndian,
        _ => return None,
    })
}

fn said_up(comment: &str) -> Option<Up> {
    let says = |what: &str| comment.contains(what);
    match (says("y up"), says("z up")) {
        (true, false) => Some(Up::Y),
        (false, true) => Some(Up::Z),
        _ => None,
    }
}

/// Adds an element or a property; false when the words are neither.
fn add(elements: &mut Vec<Element>, words: &[&str]) -> bool {
    let mut property = |name: &str, scalar: &str, list: Option<&str>| {
        let list = list.map(Scalar::named);
        match (elements.last_mut(), Scalar::named(scalar), list) {
            (Some(element), Some(scalar), None | Some(Some(_))) => {
                let list = list.flatten();
                element.properties.push(Property { name: name.to_owned(), scalar, list });
                true
            }
            _ => false,
        }
    };
    match *words {
        ["property", "list", length, scalar, name] => property(name, scalar, Some(length)),
        ["property", scalar, name] => property(name, scalar, None),
        ["element", name, count] => count.parse().is_ok_and(|count| {
            elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            true
        }),
        _ => false,
    }
}
