//! Charts as SVG.

pub mod lines;

use plotters::style::RGBColor;

/// The growth model.
pub const TEACHER: RGBColor = RGBColor(0x4c, 0x78, 0xa8);
/// The networks that are judged.
pub const LEARNER: RGBColor = RGBColor(0xe0, 0x7b, 0x39);

/// A chart that could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the chart cannot be drawn: {0}")]
pub struct ChartError(String);
