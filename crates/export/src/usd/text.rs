//! Pieces of USD's text format.

use std::fmt::Display;
use std::io::{self, Write};

use deeptree_graph::Vec3;

use crate::beside::slug;

/// A name as an identifier: letters, digits and `_`, and no digit first.
pub(super) fn identifier(name: &str) -> String {
    let plain = slug(name);
    if plain.starts_with(|c: char| c.is_ascii_digit()) || plain.is_empty() {
        format!("_{plain}")
    } else {
        plain
    }
}

/// A text in quotes.
pub(super) fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            _ if c.is_control() => quoted.push(' '),
            _ => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

pub(super) fn tuple(v: Vec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

/// `declaration = [item, item, …]`, and what follows it on the line.
pub(super) fn array<T: Display>(
    declaration: &str,
    items: impl Iterator<Item = T>,
    after: &str,
    out: &mut impl Write,
) -> io::Result<()> {
    write!(out, "        {declaration} = [")?;
    for (i, item) in items.enumerate() {
        write!(out, "{}{item}", if i == 0 { "" } else { ", " })?;
    }
    writeln!(out, "]{after}")
}
