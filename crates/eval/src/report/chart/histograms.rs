//! Small multiples: one little histogram a panel, sets over each other.

use plotters::prelude::*;

use super::{ChartError, FAINT, FONT, INK};

/// Width of a panel.
const WIDTH: u32 = 170;
/// Height of a panel.
const HEIGHT: u32 = 105;

/// Height of a panel in highest bars of its first set, at most.
const MOST_OF_FIRST: f64 = 1.5;

/// One histogram.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What it is of.
    pub title: String,
    /// Where the first bin starts.
    pub low: f64,
    /// Where the last bin ends.
    pub high: f64,
    /// The sets; the first is filled, the others are outlines over it.
    pub series: Vec<Series>,
}

/// A set in a histogram.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its colour.
    pub colour: RGBColor,
    /// Share of the samples in each bin, all of the same width.
    pub shares: Vec<f64>,
}

/// Draws panels, `columns` in a row.
///
/// # Errors
///
/// When the drawing library refuses.
pub fn histograms(panels: &[Panel], columns: usize) -> Result<String, ChartError> {
    let columns = columns.max(1);
    let rows = panels.len().div_ceil(columns);
    let size = (WIDTH * columns as u32, HEIGHT * rows as u32);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        for (panel, area) in panels.iter().zip(root.split_evenly((rows, columns))) {
            draw(panel, &area)?;
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw(
    panel: &Panel,
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
) -> Result<(), ChartError> {
    let top = top(panel);
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, (FONT, 12).into_font().color(&INK))
        .margin(3)
        .margin_left(8)
        .margin_right(8)
        .x_label_area_size(16)
        .build_cartesian_2d(panel.low..panel.high, 0.0..top)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_y_axis()
        .x_labels(4)
        .x_label_formatter(&|x| label(*x))
        .label_style((FONT, 10).into_font().color(&INK))
        .axis_style(FAINT)
        .draw()?;
    for (number, series) in panel.series.iter().enumerate() {
        let steps = steps(panel, series, top);
        if number == 0 {
            let fill = series.colour.mix(0.45).filled();
            chart.draw_series([Polygon::new(steps, fill)])?;
        } else {
            chart.draw_series(LineSeries::new(steps, series.colour.stroke_width(1)))?;
        }
    }
    Ok(())
}

/// The largest share that is shown: a set far off the first is cut rather than flattening it.
fn top(panel: &Panel) -> f64 {
    let highest =
        |series: &[Series]| series.iter().flat_map(|one| &one.shares).copied().fold(0.0, f64::max);
    let first = highest(&panel.series[..panel.series.len().min(1)]);
    let all = highest(&panel.series);
    match if first > 0.0 { all.min(MOST_OF_FIRST * first) } else { all } {
        top if top > 0.0 => 1.05 * top,
        _ => 1.0,
    }
}

/// The outline of a histogram, from the ground to the ground.
fn steps(panel: &Panel, series: &Series, top: f64) -> Vec<(f64, f64)> {
    let width = (panel.high - panel.low) / series.shares.len().max(1) as f64;
    let bars = series.shares.iter().enumerate().flat_map(|(bin, &share)| {
        let start = panel.low + width * bin as f64;
        [(start, share.min(top)), (start + width, share.min(top))]
    });
    let ends = |x| std::iter::once((x, 0.0));
    ends(panel.low).chain(bars).chain(ends(panel.high)).collect()
}

/// A number of an axis, no longer than it must be.
fn label(x: f64) -> String {
    let text = format!("{x:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::chart::{LEARNER, TEACHER};

    #[test]
    fn a_panel_has_its_title_its_bars_and_its_outline() {
        let series = |colour, shares: [f64; 2]| Series { colour, shares: shares.to_vec() };
        let panel = Panel {
            title: "oak BL".into(),
            low: 0.0,
            high: 2.0,
            series: vec![series(TEACHER, [0.5, 0.25]), series(LEARNER, [0.25, 0.5])],
        };
        let outline = steps(&panel, &panel.series[0], 1.0);
        let corners = [(0.0, 0.0), (0.0, 0.5), (1.0, 0.5), (1.0, 0.25), (2.0, 0.25), (2.0, 0.0)];
        assert_eq!(outline, corners);
        assert!((top(&panel) - 0.525).abs() < 1e-12);
        let sets = vec![panel.series[0].clone(), series(LEARNER, [1.0, 0.0])];
        let far = Panel { series: sets, ..panel.clone() };
        assert!((top(&far) - 0.5 * 1.5 * 1.05).abs() < 1e-12, "one that is far off is cut");
        let svg = histograms(&[panel.clone(), panel], 2).unwrap();
        assert_eq!(svg.matches("oak BL").count(), 2);
        assert_eq!(svg.matches("<polygon").count(), 2, "the teacher is filled");
        assert!(svg.to_lowercase().contains("#e07b39"), "the learner is drawn");
    }

    #[test]
    fn numbers_of_axes_are_short() {
        let labels = [0.0, 0.25, 10.0, 100.0, -1e-9].map(label);
        assert_eq!(labels, ["0", "0.25", "10", "100", "0"]);
    }
}
