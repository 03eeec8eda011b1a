//! Lines with error bars, a panel each for several subjects, all on the same axes.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::{
    ChartBuilder, Circle, DrawingArea, IntoDrawingArea, IntoFont, LineSeries, PathElement,
    SVGBackend, Text,
};
use plotters::style::{BLACK, Color, FontStyle, RGBColor, ShapeStyle, WHITE};

use super::ChartError;

/// Panels side by side and below each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines {
    /// What the horizontal axis measures.
    pub x: String,
    /// What the vertical axis measures.
    pub y: String,
    /// Panels side by side.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// One subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Its name.
    pub title: String,
    /// Its lines.
    pub lines: Vec<Line>,
}

/// A line of one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What it shows, for the legend.
    pub name: String,
    /// Its colour.
    pub colour: RGBColor,
    /// Its points, from left to right; without any, the line is left out.
    pub points: Vec<Point>,
}

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where.
    pub x: f64,
    /// What was measured.
    pub y: f64,
    /// Half the length of the error bar.
    pub error: f64,
    /// Drawn as a ring, not as a disc.
    pub hollow: bool,
}

/// Pixels of a panel, of the legend's height, and of a name in it.
const PANEL: (u32, u32) = (260, 190);
const LEGEND: u32 = 24;
const NAME: i32 = 130;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Lines {
    /// The chart as an SVG element.
    ///
    /// # Errors
    ///
    /// When there is no point, or one is not finite.
    pub fn svg(&self) -> Result<String, ChartError> {
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|error| ChartError(error.to_string()))?;
        Ok(svg)
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn Error>> {
        let (xs, ys) = self.ranges().ok_or("it has no point, or one that is not finite")?;
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let size = (PANEL.0 * columns as u32, LEGEND + PANEL.1 * rows as u32);
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let (legend, panels) = root.split_vertically(LEGEND);
        self.legend(&legend)?;
        for (area, panel) in panels.split_evenly((rows, columns)).iter().zip(&self.panels) {
            self.panel(area, panel, xs.clone(), ys.clone())?;
        }
        root.present()?;
        Ok(())
    }

    /// The names of the lines that are drawn anywhere, side by side.
    fn legend(&self, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
        let mut lines: Vec<(&str, RGBColor)> = Vec::new();
        for line in self.panels.iter().flat_map(|panel| &panel.lines) {
            let one = (line.name.as_str(), line.colour);
            if !line.points.is_empty() && !lines.contains(&one) {
                lines.push(one);
            }
        }
        for (x, (name, colour)) in (52..).step_by(NAME as usize).zip(lines) {
            area.draw(&PathElement::new([(x, 14), (x + 18, 14)], colour.stroke_width(2)))?;
            area.draw(&Text::new(name, (x + 24, 8), ("sans-serif", 12)))?;
        }
        Ok(())
    }

    fn panel(
        &self,
        area: &Area<'_>,
        panel: &Panel,
        xs: Range<f64>,
        ys: Range<f64>,
    ) -> Result<(), Box<dyn Error>> {
        let bold = ("sans-serif", 14).into_font().style(FontStyle::Bold);
        let mut chart = ChartBuilder::on(area)
            .caption(&panel.title, bold)
            .margin(6)
            .x_label_area_size(32)
            .y_label_area_size(62)
            .build_cartesian_2d(xs, ys)?;
        chart
            .configure_mesh()
            .max_light_lines(0)
            .bold_line_style(BLACK.mix(0.08))
            .axis_style(BLACK.mix(0.5))
            .x_labels(6)
            .y_labels(5)
            .x_label_formatter(&number)
            .y_label_formatter(&number)
            .x_desc(&self.x)
            .y_desc(&self.y)
            .label_style(("sans-serif", 11))
            .draw()?;
        for line in panel.lines.iter().filter(|line| !line.points.is_empty()) {
            let colour = line.colour;
            let points = line.points.iter();
            let path = points.clone().map(|p| (p.x, p.y));
            chart.draw_series(LineSeries::new(path, colour.stroke_width(2)))?;
            chart.draw_series(points.clone().filter(|p| p.error > 0.0).map(|p| {
                PathElement::new(
                    [(p.x, p.y - p.error), (p.x, p.y + p.error)],
                    colour.stroke_width(1),
                )
            }))?;
            chart.draw_series(points.clone().map(|p| disc(p, WHITE.filled())))?;
            chart.draw_series(points.map(|p| {
                disc(p, if p.hollow { colour.stroke_width(2) } else { colour.filled() })
            }))?;
        }
        Ok(())
    }

    /// The ranges of both axes over all panels, with some room; none without a finite point.
    fn ranges(&self) -> Option<(Range<f64>, Range<f64>)> {
        let lines = self.panels.iter().flat_map(|panel| &panel.lines);
        let points: Vec<&Point> = lines.flat_map(|line| &line.points).collect();
        let xs = range(points.iter().map(|p| p.x))?;
        let ys = range(points.iter().flat_map(|p| [p.y - p.error, p.y + p.error]))?;
        Some((xs, ys))
    }
}

/// A number with at most two decimals, and no zeros at its end.
fn number(x: &f64) -> String {
    let text = format!("{x:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}

fn disc(point: &Point, style: ShapeStyle) -> Circle<(f64, f64), i32> {
    Circle::new((point.x, point.y), 3, style)
}

fn range(values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        if x.is_nan() { (f64::NAN, f64::NAN) } else { (low.min(x), high.max(x)) }
    });
    let room = if high > low { 0.06 * (high - low) } else { 1.0 };
    (low.is_finite() && high.is_finite()).then_some(low - room..high + room)
}

#[cfg(test)]
mod tests {
    use super::super::{LEARNER, TEACHER};
    use super::*;

    fn point(x: f64, y: f64) -> Point {
        Point { x, y, error: 0.5, hollow: x > 2.5 }
    }

    fn lines() -> Lines {
        let line = |name: &str, colour, slope: f64| Line {
            name: name.into(),
            colour,
            points: [1.0, 2.0, 3.0].map(|x| point(x, slope * x)).to_vec(),
        };
        let panel = |title: &str| Panel {
            title: title.into(),
            lines: vec![line("P", TEACHER, 1.0), line("DT", LEARNER, 2.0)],
        };
        let panels = vec![panel("oak"), panel("pine"), panel("willow")];
        Lines { x: "age".into(), y: "height".into(), columns: 2, panels }
    }

    /// The vertical places of the discs and rings of a colour.
    fn discs(svg: &str, colour: &str) -> Vec<i32> {
        let circles = svg.split("<circle ").skip(1).filter(|circle| {
            let end = circle.find("/>").unwrap();
            circle[..end].contains(colour)
        });
        circles
            .map(|circle| circle.split("cy=\"").nth(1).unwrap().split('"').next().unwrap())
            .map(|y| y.parse().unwrap())
            .collect()
    }

    #[test]
    fn every_panel_has_its_title_and_its_points_on_a_straight_line() {
        let svg = lines().svg().unwrap();
        for title in ["oak", "pine", "willow", "age", "height"] {
            assert!(svg.contains(title), "{title}");
        }
        let learner = discs(&svg, "#E07B39");
        assert_eq!(learner.len(), 9, "three points in three panels");
        for panel in learner.chunks(3) {
            // Twice as high for twice the x, up to whole pixels.
            assert!(panel[0] > panel[1] && panel[1] > panel[2]);
            assert!((panel[0] - 2 * panel[1] + panel[2]).abs() <= 1, "{panel:?}");
        }
        // All panels have the same axes: the second's points are as high as the first's.
        assert_eq!(learner[..3], learner[3..6]);
    }

    #[test]
    fn numbers_are_written_short() {
        let written = [10.0, 0.3, -0.25, 0.299_999_9, -1e-9, 3500.0].map(|x| number(&x));
        assert_eq!(written, ["10", "0.3", "-0.25", "0.3", "0", "3500"]);
    }

    #[test]
    fn a_line_without_points_is_left_out_and_a_chart_without_any_is_an_error() {
        let mut lines = lines();
        for panel in &mut lines.panels {
            panel.lines[1].points.clear();
        }
        let svg = lines.svg().unwrap();
        assert!(discs(&svg, "#E07B39").is_empty() && discs(&svg, "#4C78A8").len() == 9);
        for panel in &mut lines.panels {
            panel.lines[0].points.clear();
        }
        assert!(lines.svg().is_err());
        lines.panels[0].lines[0].points.push(point(1.0, f64::NAN));
        assert!(lines.svg().is_err());
    }
}
