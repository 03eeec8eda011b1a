//! A line of text and its parts.

use std::io::{BufRead, Read};

use crate::error::ReadCloudError;

/// The longest line in bytes.
const LONGEST: usize = 1 << 16;

/// The lines of a text, one at a time.
pub(super) struct Lines<R> {
    input: R,
    at: u64,
    line: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(input: R) -> Self {
        Self { input, at: 0, line: Vec::new() }
    }

    /// The next line without blanks around it and its number counted from 1, or none at the end.
    pub(super) fn next(&mut self) -> Result<Option<(u64, &str)>, ReadCloudError> {
        self.line.clear();
        self.at += 1;
        let line = self.at;
        (&mut self.input).take(LONGEST as u64 + 1).read_until(b'\n', &mut self.line)?;
        if self.line.is_empty() {
            return Ok(None);
        }
        if self.line.contains(&0) {
            return Err(ReadCloudError::NotText { line });
        }
        if self.line.len() > LONGEST {
            return Err(ReadCloudError::LongLine { line, most: LONGEST });
        }
        // The byte-order mark of some editors.
        let bytes = self.line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&self.line);
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text,
            // A name in another encoding; no number has such bytes.
            Err(error) => std::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or_default(),
        };
        Ok(Some((line, text.trim())))
    }
}

/// A line without its comment, or the text of a line that is a comment as a whole.
pub(super) fn without_comment(line: &str) -> (&str, bool) {
    let start = [line.find('#'), line.find("//")].into_iter().flatten().min();
    match start {
        Some(0) => (line.trim_start_matches(['#', '/']).trim(), true),
        Some(start) => (line[..start].trim_end(), false),
        None => (line, false),
    }
}

/// The fields of a line: between commas or semicolons, and between blanks.
pub(super) fn fields(line: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(line);
    std::iter::from_fn(move || {
        let text = rest?.trim_start();
        let end = text.find(|c: char| c.is_whitespace() || c == ',' || c == ';');
        let (field, after) = text.split_at(end.unwrap_or(text.len()));
        let after = after.trim_start();
        let after = after.strip_prefix([',', ';']).unwrap_or(after);
        rest = (!after.is_empty()).then_some(after);
        Some(field)
    })
}

/// Are there commas within the fields that blanks or semicolons separate, one in each?
pub(super) fn has_decimal_commas(line: &str) -> bool {
    let mut parts = line.split([' ', '\t', ';']).filter(|part| !part.is_empty()).peekable();
    let decimal = |part: &str| {
        part.split_once(',').is_some_and(|(whole, rest)| {
            let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
            digits(whole.trim_start_matches('-')) && digits(rest)
        })
    };
    parts.clone().count() >= 3 && parts.all(decimal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str) -> Vec<&str> {
        fields(line).collect()
    }

    #[test]
    fn any_separator_parts_fields() {
        for line in ["1 2 3", "1,2,3", "1;2;3", "1\t2\t3", "1, 2 ;\t3", "  1   2   3"] {
            assert_eq!(split(line), ["1", "2", "3"], "{line:?}");
        }
    }

    #[test]
    fn an_empty_field_between_commas_is_one() {
        assert_eq!(split("1,,3"), ["1", "", "3"]);
    }

    #[test]
    fn decimal_commas_are_told_from_separators() {
        for line in ["1,5 2,5 3,5", "-1,5;2,5;3,5", "448262,12\t5411932,50\t1,5"] {
            assert!(has_decimal_commas(line), "{line:?}");
        }
        for line in ["1,2,3", "1, 2, 3", "1.5,2.5,3.5 1,2,3", "1 2 3", "1,2 3,4"] {
            assert!(!has_decimal_commas(line), "{line:?}");
        }
    }
}
