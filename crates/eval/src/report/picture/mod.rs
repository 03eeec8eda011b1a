//! Pictures of branch graphs: orthographic views of many trees on one scale, in one PNG.

mod ink;
mod solid;
mod stroke;
mod view;

use deeptree_graph::{BranchGraph, Vec3};
use tiny_skia::Pixmap;

use view::Frame;
pub use view::View;

/// Rows of trees on a common scale.
///
/// In each row all feet stand on one line. A row is as high, and a column as wide, as its largest
/// tree needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sheet {
    /// Trees side by side.
    pub columns: usize,
    /// Most pixels that all columns together take, without margins.
    pub width: u32,
    /// Most pixels that a row takes, without margins.
    pub row: u32,
}

/// A tree, seen from somewhere; a cell without a tree stays empty.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// The tree.
    pub tree: Option<&'a BranchGraph>,
    /// Where it is seen from.
    pub view: View,
    /// Corners of boxes that stand around the tree, in metres; drawn behind it.
    pub boxes: &'a [[Vec3; 8]],
    /// Other trees, at their places.
    pub beside: &'a [BranchGraph],
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum PictureError {
    #[error("a sheet without a tree; give it at least one")]
    NoTree,
    #[error("a sheet of {width} × {height} pixels; each side must be from 1 to {limit}")]
    Size { width: u64, height: u64, limit: u32 },
    #[error("the picture cannot be written as PNG: {0}")]
    Encode(String),
}

/// Pixels around each cell.
const MARGIN: u32 = 8;

/// Most pixels a side: what one pass of the rasterizer takes.
const MAX_SIDE: u32 = 8000;

impl<'a> Shot<'a> {
    /// A tree seen from somewhere.
    #[must_use]
    pub const fn new(tree: &'a BranchGraph, view: View) -> Self {
        Self { tree: Some(tree), view, boxes: &[], beside: &[] }
    }

    /// The same among boxes.
    #[must_use]
    pub const fn among(self, boxes: &'a [[Vec3; 8]]) -> Self {
        Self { boxes, ..self }
    }

    /// The same among other trees, which stand at their places.
    #[must_use]
    pub const fn beside(self, beside: &'a [BranchGraph]) -> Self {
        Self { beside, ..self }
    }

    /// A cell that stays empty.
    #[must_use]
    pub const fn empty(view: View) -> Self {
        Self { tree: None, view, boxes: &[], beside: &[] }
    }
}

impl Sheet {
    /// Draws the shots row by row, as a PNG file. The same shots give the same bytes.
    ///
    /// # Errors
    ///
    /// When there is no tree, or the sheet would have no or too many pixels.
    pub fn png(&self, shots: &[Shot<'_>]) -> Result<Vec<u8>, PictureError> {
        let pixmap = self.draw(shots)?;
        ink::encode(&pixmap).map_err(|error| PictureError::Encode(error.to_string()))
    }

    fn draw(&self, shots: &[Shot<'_>]) -> Result<Pixmap, PictureError> {
        let columns = self.columns.clamp(1, shots.len().max(1));
        let rows: Vec<&[Shot<'_>]> = shots.chunks(columns).collect();
        let frames: Vec<Vec<Option<Frame>>> = rows.iter().map(|row| frames(row)).collect();
        let (widths, heights) = (widths(&frames, columns), heights(&frames));
        let scale = self.scale(&widths, &heights).ok_or(PictureError::NoTree)?;

        let pixels = |metres: f32| (scale * metres).round() as u64;
        let margins = 2 * u64::from(MARGIN);
        let widths: Vec<u64> = widths.into_iter().map(|width| pixels(width) + margins).collect();
        let heights: Vec<(u64, u64)> = heights
            .into_iter()
            .map(|(above, below)| (pixels(above), pixels(above) + pixels(below) + margins))
            .collect();
        let height = heights.iter().map(|(_, height)| height).sum();
        let mut pixmap = pixmap(widths.iter().sum(), height)?;

        let mut top = 0;
        for ((row, frames), (above, height)) in rows.iter().zip(&frames).zip(heights) {
            let foot = (top + u64::from(MARGIN) + above) as f32;
            if row.iter().any(|shot| shot.tree.is_some() && shot.view.shows_ground()) {
                ink::ground(&mut pixmap, foot);
            }
            let mut left = 0;
            for ((shot, frame), width) in row.iter().zip(frames).zip(&widths) {
                let middle = left as f32 + 0.5 * *width as f32;
                left += width;
                let (Some(tree), Some(frame)) = (shot.tree, frame) else { continue };
                let origin = (middle - scale * 0.5 * (frame.left + frame.right), foot);
                for corners in shot.boxes {
                    solid::draw(&mut pixmap, tree, corners, shot.view, scale, origin);
                }
                stroke::trees(&mut pixmap, tree, shot.beside, shot.view, scale, origin);
            }
            top += height;
        }
        Ok(pixmap)
    }

    /// Pixels a metre, such that all columns and the highest row fit; none without a tree.
    fn scale(&self, widths: &[f32], heights: &[(f32, f32)]) -> Option<f32> {
        let width: f32 = widths.iter().sum();
        let height = heights.iter().map(|(above, below)| above + below).fold(0.0, f32::max);
        let fit = |pixels: u32, metres: f32| pixels as f32 / metres;
        (width > 0.0 && height > 0.0).then(|| fit(self.width, width).min(fit(self.row, height)))
    }
}

/// How wide each column is, in metres; one without a tree is as wide as the others on average.
fn widths(frames: &[Vec<Option<Frame>>], columns: usize) -> Vec<f32> {
    let width = |column: usize| {
        let frames = frames.iter().filter_map(|row| *row.get(column)?);
        frames.map(|frame| frame.right - frame.left).reduce(f32::max)
    };
    let widths: Vec<Option<f32>> = (0..columns).map(width).collect();
    let known: Vec<f32> = widths.iter().copied().flatten().collect();
    let mean = known.iter().sum::<f32>() / known.len().max(1) as f32;
    widths.into_iter().map(|width| width.unwrap_or(mean)).collect()
}

/// How far each row reaches above and below its feet, in metres.
fn heights(frames: &[Vec<Option<Frame>>]) -> Vec<(f32, f32)> {
    let reach = |row: &Vec<Option<Frame>>| {
        row.iter().flatten().fold((0.0, 0.0), |(above, below), frame| {
            (frame.top.max(above), (-frame.bottom).max(below))
        })
    };
    frames.iter().map(reach).collect()
}

fn frames(row: &[Shot<'_>]) -> Vec<Option<Frame>> {
    row.iter()
        .map(|shot| shot.tree.map(|tree| shot.view.frame(tree, shot.beside, shot.boxes)))
        .collect()
}

fn pixmap(width: u64, height: u64) -> Result<Pixmap, PictureError> {
    let side = |pixels| u32::try_from(pixels).ok().filter(|side| *side <= MAX_SIDE);
    let mut pixmap = side(width)
        .zip(side(height))
        .and_then(|(width, height)| Pixmap::new(width, height))
        .ok_or(PictureError::Size { width, height, limit: MAX_SIDE })?;
    ink::clear(&mut pixmap);
    Ok(pixmap)
}

#[cfg(test)]
mod tests;
