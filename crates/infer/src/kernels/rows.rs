//! Rows of numbers without those that are zero.

use core::ops::Range;

/// Rows of numbers without those that are zero: what a layer reads.
///
/// Most of what a network reads is zero: one-hots in its first layer, what the rectifier cut off in
/// the others. What is not is told as two lists, the numbers and which of the row's they are, in the
/// order of the row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    indexes: Vec<u32>,
    values: Vec<f32>,
    /// Numbers of all rows; what lies behind them is memory for more.
    len: usize,
    /// Where the numbers of each row end.
    ends: Vec<usize>,
}

impl Rows {
    /// Forgets all rows and keeps their memory.
    pub(crate) fn clear(&mut self) {
        self.len = 0;
        self.ends.clear();
    }

    /// How many rows there are.
    pub(crate) fn count(&self) -> usize {
        self.ends.len()
    }

    /// Which numbers of a row are not zero, and what they are.
    pub(crate) fn row(&self, row: usize) -> (&[u32], &[f32]) {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        (&self.indexes[start..self.ends[row]], &self.values[start..self.ends[row]])
    }

    /// Blocks of at most `rows` rows.
    pub(crate) fn blocks(&self, rows: usize) -> impl Iterator<Item = Range<usize>> {
        let count = self.count();
        (0..count).step_by(rows).map(move |first| first..count.min(first + rows))
    }

    /// Adds to the row that comes next what another has.
    pub(crate) fn put_row(&mut self, (indexes, values): (&[u32], &[f32])) {
        let free = self.free(indexes.len());
        free.0.copy_from_slice(indexes);
        free.1.copy_from_slice(values);
        self.add(indexes.len());
    }

    /// Memory for so many more numbers of the row that comes next.
    pub(super) fn free(&mut self, count: usize) -> (&mut [u32], &mut [f32]) {
        let len = self.len + count;
        if self.values.len() < len {
            self.indexes.resize(len, 0);
            self.values.resize(len, 0.0);
        }
        (&mut self.indexes[self.len..len], &mut self.values[self.len..len])
    }

    /// Adds to the row that comes next so many of the numbers written to [`Rows::free`].
    pub(super) fn add(&mut self, count: usize) {
        self.len += count;
    }

    /// The row that comes next is whole.
    pub(crate) fn end_row(&mut self) {
        self.ends.push(self.len);
    }
}
