//! Charts as SVG.

mod histograms;
mod intervals;
pub mod lines;

pub use histograms::{Panel, Series, histograms};
pub use intervals::{Interval, IntervalRow, intervals};

/// Red, green and blue.
pub use plotters::style::RGBColor as Colour;

use plotters::style::RGBColor;

/// The teacher, in every chart.
pub const TEACHER: RGBColor = RGBColor(0x4c, 0x78, 0xa8);
/// The learner.
pub const LEARNER: RGBColor = RGBColor(0xe0, 0x7b, 0x39);
/// The model of kind `paper`.
pub const PAPER: RGBColor = RGBColor(0x8c, 0x8c, 0x8c);
/// What a chart is read against, such as the line of equality.
pub const GUIDE: RGBColor = RGBColor(0xb4, 0xbc, 0xb4);

/// Text and axes.
const INK: RGBColor = RGBColor(0x1d, 0x26, 0x20);
/// Lines that only guide.
const FAINT: RGBColor = RGBColor(0xd9, 0xde, 0xd9);
/// Family of all letters.
const FONT: &str = "sans-serif";

/// A chart that could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChartError(String);

impl std::fmt::Display for ChartError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the chart could not be drawn: {}", self.0)
    }
}

impl std::error::Error for ChartError {}

type DrawError = plotters::drawing::DrawingAreaErrorKind<std::io::Error>;

impl From<DrawError> for ChartError {
    fn from(error: DrawError) -> Self {
        Self(error.to_string())
    }
}
