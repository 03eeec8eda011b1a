//! The paper's histograms of geometric metrics: teacher under learner, by species and by order.

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::histogram::Histogram;
use deeptree_eval::report::Chapter;
use deeptree_eval::report::chart::{LEARNER, PAPER, Panel, Series, TEACHER, histograms};
use deeptree_eval::{Metric, ORDERS, TreeSet};

use super::measure::Set;
use super::study::Study;
use super::table::Sets;

/// The metrics of the figure.
const SHOWN: [Metric; 7] = [
    Metric::BranchNumber,
    Metric::BranchLength,
    Metric::BranchingDistance,
    Metric::NodeNumber,
    Metric::AngleChild1,
    Metric::AngleChild2,
    Metric::AngleChild3,
];

/// Bins of a panel, at most.
const BINS: usize = 32;

/// Shares of the samples that a panel leaves out on its left and on its right.
const LEFT_OUT: (f64, f64) = (0.002, 0.005);

/// The sets of a panel, the teacher's first.
const SETS: [(Set, deeptree_eval::report::chart::Colour); 3] =
    [(Set::Teacher, TEACHER), (Set::Paper, PAPER), (Set::Learner, LEARNER)];

/// A panel with where it stands.
struct Figure {
    species: String,
    metric: Metric,
    order: Option<usize>,
    sets: Vec<Set>,
    panel: Panel,
}

/// Writes the charts of the chapter, and the histograms as CSV.
pub(super) fn write(study: &Study<'_>, sets: &[Sets], chapter: &mut Chapter) -> Result<()> {
    chapter.heading("Histograms");
    chapter.text(
        "Filled: the teacher (P). Orange line: the learner (DT). Grey line: the kind paper. BL and \
         BD in metres, angles in radians, BN branches a tree; each panel has its own scale and \
         leaves out the outermost 0.7 % of the samples.",
    );
    let mut all = Vec::new();
    let by_metric = |sets: &Sets| SHOWN.map(|metric| figure(sets, metric, None));
    let figures: Vec<Figure> = sets.iter().flat_map(by_metric).flatten().collect();
    draw(chapter, "All branches: rows are species, columns are metrics", &figures, SHOWN.len())?;
    all.extend(figures);
    for metric in SHOWN.into_iter().skip(1) {
        let of = |sets: &Sets| (0..ORDERS).filter_map(|o| figure(sets, metric, Some(o))).collect();
        let figures: Vec<Figure> = sets.iter().flat_map::<Vec<Figure>, _>(of).collect();
        let caption = format!(
            "{} by branch order: the trunk has 0; the last column is order {} and above",
            metric.symbol(),
            ORDERS - 1
        );
        draw(chapter, &caption, &figures, ORDERS)?;
        all.extend(figures);
    }
    study.save("histograms.csv", csv(&all).as_bytes())
}

fn draw(chapter: &mut Chapter, caption: &str, figures: &[Figure], columns: usize) -> Result<()> {
    let panels: Vec<Panel> = figures.iter().map(|figure| figure.panel.clone()).collect();
    if !panels.is_empty() {
        chapter.chart(caption, histograms(&panels, columns)?);
    }
    Ok(())
}

/// The panel of a metric; none without the teacher's trees.
fn figure(sets: &Sets, metric: Metric, order: Option<usize>) -> Option<Figure> {
    let of = |set: &TreeSet| match order {
        Some(order) => set.at_order(metric, order).histogram.clone(),
        None => set.histogram(metric),
    };
    let measured = |set| sets.get(set).map(|measured| of(&measured.set));
    let (teacher, learner) = (measured(Set::Teacher)?, measured(Set::Learner));
    let seen: Vec<&Histogram> = std::iter::once(&teacher).chain(&learner).collect();
    let first = seen.iter().map(|one| one.quantile_bin(LEFT_OUT.0)).min()?;
    let last = seen.iter().map(|one| one.quantile_bin(1.0 - LEFT_OUT.1)).max()?;
    let merged = (last + 1 - first).div_ceil(BINS);
    let bins = (last + 1 - first).div_ceil(merged);
    let at = |bin: usize| teacher.width * bin as f64;
    let series = |(set, colour)| {
        let shares = measured(set)?.shares(first, merged, bins);
        Some((set, Series { colour, shares }))
    };
    let (shown, series) = SETS.into_iter().filter_map(series).unzip();
    let suffix = order.map_or(String::new(), |order| format!(", order {order}"));
    let title = format!("{} {}{suffix}", sets.species, metric.symbol());
    let panel = Panel { title, low: at(first), high: at(first + merged * bins), series };
    Some(Figure { species: sets.species.clone(), metric, order, sets: shown, panel })
}

fn csv(figures: &[Figure]) -> String {
    let mut out = "species,metric,order,set,low,high,share\n".to_owned();
    for Figure { species, metric, order, sets, panel } in figures {
        let order = order.map_or("all".to_owned(), |order| order.to_string());
        for (set, series) in sets.iter().zip(&panel.series) {
            let width = (panel.high - panel.low) / series.shares.len() as f64;
            for (bin, share) in series.shares.iter().enumerate() {
                let low = panel.low + width * bin as f64;
                let _ = writeln!(
                    out,
                    "{species},{},{order},{},{low},{},{share}",
                    metric.symbol(),
                    set.symbol(),
                    low + width
                );
            }
        }
    }
    out
}
