//! Values with their intervals, row by row.

use plotters::prelude::*;

use super::{ChartError, FAINT, FONT, INK};

const WIDTH: u32 = 760;
const ROW: u32 = 44;
const AXIS: u32 = 30;

/// A value with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Whose it is.
    pub colour: RGBColor,
    /// The value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The values of a row, drawn below each other.
#[derive(Clone, Debug, PartialEq)]
pub struct IntervalRow {
    /// What the row is of.
    pub name: String,
    /// Its values.
    pub intervals: Vec<Interval>,
}

/// Draws rows over the range `low..high`, with a line at `mark`.
///
/// # Errors
///
/// When the drawing library refuses.
pub fn intervals(
    rows: &[IntervalRow],
    low: f64,
    high: f64,
    mark: f64,
) -> Result<String, ChartError> {
    let mut svg = String::new();
    {
        let size = (WIDTH, ROW * rows.len() as u32 + AXIS);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let count = rows.len() as f64;
        let mut chart = ChartBuilder::on(&root)
            .margin_left(90)
            .margin_right(12)
            .margin_top(4)
            .x_label_area_size(AXIS - 4)
            .build_cartesian_2d(low..high, count..0.0)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .disable_y_axis()
            .x_labels(11)
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .axis_style(FAINT)
            .label_style((FONT, 12).into_font().color(&INK))
            .draw()?;
        let guide = [(mark, 0.0), (mark, count)];
        chart.draw_series(LineSeries::new(guide, INK.mix(0.5).stroke_width(1)))?;
        for (number, row) in rows.iter().enumerate() {
            let step = 1.0 / (row.intervals.len() + 1) as f64;
            for (place, interval) in row.intervals.iter().enumerate() {
                let y = number as f64 + step * (place + 1) as f64;
                let Interval { colour, value, low, high } = *interval;
                let line = [(low, y), (high, y)];
                chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
                chart.draw_series([Circle::new((value, y), 4, colour.filled())])?;
            }
            let at = (6, (ROW * number as u32 + ROW / 2) as i32);
            root.draw_text(&row.name, &(FONT, 13).into_font().color(&INK), at)?;
        }
        root.present()?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::chart::LEARNER;

    #[test]
    fn every_value_is_a_dot_in_its_row() {
        let at = |value| Interval { colour: LEARNER, value, low: value - 0.1, high: value + 0.1 };
        let row = |name: &str, values: &[f64]| IntervalRow {
            name: name.into(),
            intervals: values.iter().map(|&value| at(value)).collect(),
        };
        let svg =
            intervals(&[row("oak", &[0.5, 0.6]), row("pine", &[0.9])], 0.4, 1.0, 0.5).unwrap();
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains("oak") && svg.contains("pine"));
    }
}
