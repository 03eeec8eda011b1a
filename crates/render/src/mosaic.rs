//! Several pictures of one size on one sheet.

use crate::aov::Mark;
use crate::film::Picture;

/// Where pictures of one size lie on a sheet: row by row, with a gap between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mosaic {
    /// Width and height of each picture in pixels.
    pub cell: [u32; 2],
    /// How many there are.
    pub count: u32,
    /// How many stand in a row.
    pub columns: u32,
    /// Pixels between two of them.
    pub gap: u32,
}

impl Mosaic {
    /// Width and height of the sheet in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        let side = |n: u32, cell: u32| n * cell + n.saturating_sub(1) * self.gap;
        [side(self.columns, self.cell[0]), side(self.count.div_ceil(self.columns), self.cell[1])]
    }

    /// Lays pictures out; between them is nothing.
    ///
    /// # Panics
    ///
    /// When there are not as many pictures of the size as was said.
    #[must_use]
    pub fn pictures(&self, pictures: &[Picture]) -> Picture {
        let [width, height] = self.size();
        let pixels: Vec<&[[f32; 4]]> = pictures.iter().map(|one| &one.pixels[..]).collect();
        let shadow: Vec<&[f32]> = pictures.iter().map(|one| &one.shadow[..]).collect();
        let samples = pictures.iter().map(|one| one.samples).sum();
        Picture { width, height, pixels: self.lay(&pixels), shadow: self.lay(&shadow), samples }
    }

    /// Lays marks out; between them is nothing.
    ///
    /// # Panics
    ///
    /// When there are not as many marks as was said.
    #[must_use]
    pub fn marks(&self, marks: &[Vec<Mark>]) -> Vec<Mark> {
        self.lay(&marks.iter().map(|one| &one[..]).collect::<Vec<_>>())
    }

    fn lay<T: Clone + Default>(&self, cells: &[&[T]]) -> Vec<T> {
        let [width, height] = self.size().map(|side| side as usize);
        let [w, h] = self.cell.map(|side| side as usize);
        let mut sheet = vec![T::default(); width * height];
        for (i, cell) in cells.iter().enumerate() {
            let (column, row) = (i % self.columns as usize, i / self.columns as usize);
            let gap = self.gap as usize;
            for y in 0..h {
                let at = (row * (h + gap) + y) * width + column * (w + gap);
                sheet[at..at + w].clone_from_slice(&cell[y * w..(y + 1) * w]);
            }
        }
        sheet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stand_row_by_row_with_gaps() {
        let mosaic = Mosaic { cell: [2, 1], count: 3, columns: 2, gap: 1 };
        assert_eq!(mosaic.size(), [5, 3]);
        let sheet = mosaic.lay(&[&[1, 2], &[3, 4], &[5, 6]]);
        assert_eq!(sheet, [1, 2, 0, 3, 4, 0, 0, 0, 0, 0, 5, 6, 0, 0, 0]);
    }
}
