//! Reading text.

use std::io::{BufReader, Read};

use crate::error::ReadCloudError;
use crate::gather::{Gather, ReadOptions, Reading};
use crate::names::Layout;

use super::tokens::{Lines, fields, has_decimal_commas, without_comment};

/// Columns beyond these are not looked at.
const MOST: usize = 64;

/// So much of a bad line is shown.
const SHOWN: usize = 60;

/// Reads points from text.
///
/// A line that is no point is dropped and counted.
///
/// # Errors
///
/// When the input fails, is not text, has decimal commas, has no points, or has more lines that are
/// no points than points.
pub fn read(input: impl Read, options: &ReadOptions) -> Result<Reading, ReadCloudError> {
    let mut lines = Lines::new(BufReader::with_capacity(1 << 16, input));
    let mut rows = Rows { options: *options, layout: None, gather: None, bad: None, row: vec![] };
    while let Some((number, line)) = lines.next()? {
        let (text, comment) = without_comment(line);
        if text.is_empty() || rows.gather.is_none() && rows.heading(text) || comment {
            continue;
        }
        rows.take(number, text)?;
    }
    rows.finish()
}

/// The rows so far.
struct Rows {
    options: ReadOptions,
    layout: Option<Layout>,
    /// There from the first row on.
    gather: Option<Gather>,
    /// The first line that was no point: its number and text.
    bad: Option<(u64, String)>,
    /// The numbers of the row at hand.
    row: Vec<Option<f64>>,
}

impl Rows {
    /// Does this line stand before the points and say something about them?
    fn heading(&mut self, text: &str) -> bool {
        let names: Vec<&str> = fields(text).take(MOST).collect();
        let layout = Layout::of_names(&names);
        let named = layout.is_some();
        self.layout = layout.or(self.layout);
        let is_number = |name: &&str| name.parse::<f64>().is_ok();
        named || names.len() == 1 && is_number(&names[0]) || !names.iter().any(is_number)
    }

    fn take(&mut self, number: u64, text: &str) -> Result<(), ReadCloudError> {
        if self.gather.is_none() && has_decimal_commas(text) {
            return Err(ReadCloudError::DecimalComma { line: number });
        }
        let layout = self.layout.unwrap_or(Layout::PLAIN);
        let options = self.options;
        let gather = self.gather.get_or_insert_with(|| Gather::new(options, layout.present()));
        self.row.clear();
        self.row.extend(fields(text).take(layout.width()).map(|field| field.parse().ok()));
        let Some((place, attributes)) = layout.point(&self.row) else {
            gather.dropped().malformed += 1;
            self.bad.get_or_insert_with(|| (number, text.chars().take(SHOWN).collect()));
            return Ok(());
        };
        gather.push(place, &attributes)
    }

    fn finish(self) -> Result<Reading, ReadCloudError> {
        let mut gather = self.gather.ok_or(ReadCloudError::Empty)?;
        if let Some((line, text)) = self.bad {
            gather.dropped().first_malformed = line;
            if gather.dropped().malformed > gather.taken() {
                return Err(ReadCloudError::Row { line, text });
            }
        }
        gather.finish()
    }
}
