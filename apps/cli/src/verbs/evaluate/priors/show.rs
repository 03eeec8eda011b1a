//! The figures of the chapter in words, charts, pictures and tables.

use std::f64::consts::FRAC_2_PI;

use anyhow::Result;
use deeptree_eval::report::chart::lines::{Line, Lines, Panel, Point};
use deeptree_eval::report::chart::{LEARNER, TEACHER};
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_generate::germ;
use deeptree_graph::BranchGraph;
use deeptree_growth::Species;
use serde_json::json;

use super::gaps::Seen;
use super::{Axis, Learner, Measured, Setting, learner_tree, parameters, request, teacher_tree};
use crate::verbs::evaluate::estimate::Difference;
use crate::verbs::evaluate::study::Study;

/// How far nodes and height may be from the teacher's.
const GOAL: f64 = 0.05;

/// A number of a tree: its name, its unit, and the decimals it is written with.
struct Number {
    name: &'static str,
    unit: &'static str,
    decimals: usize,
    /// Compared as a part of the teacher's; a direction, which can be 0, is not.
    relative: bool,
}

const NUMBERS: [Number; 4] = [
    Number { name: "nodes", unit: "", decimals: 0, relative: true },
    Number { name: "height", unit: "m", decimals: 1, relative: true },
    Number { name: "crown radius", unit: "m", decimals: 1, relative: true },
    Number { name: "mean rise", unit: "", decimals: 3, relative: false },
];

impl Setting {
    /// The learner's trees, and whether it was trained near them.
    const fn learner(&self) -> Option<(&Measured, bool)> {
        match &self.dt {
            Learner::Grown { trees, trained } => Some((trees, *trained)),
            _ => None,
        }
    }

    /// How far the learner is from its teacher in number `i`.
    fn difference(&self, i: usize) -> Option<Difference> {
        let (dt, p) = (&self.learner()?.0.numbers[i], &self.p.numbers[i]);
        if p.count == 0 {
            return None;
        }
        Some(if NUMBERS[i].relative { dt.relative_to(p) } else { dt.beside(p) })
    }

    fn place(&self) -> String {
        format!("{}, {} {}", self.species, self.axis.name(), self.axis.write(self.value))
    }
}

/// What came out, in sentences made from the numbers.
pub(super) fn text(chapter: &mut Chapter, settings: &[Setting], seen: Option<&Seen>) {
    let (trained, unseen): (Vec<&Setting>, Vec<&Setting>) = settings
        .iter()
        .filter(|setting| setting.learner().is_some())
        .partition(|setting| setting.learner().is_some_and(|(_, trained)| trained));
    let groups = [
        (&trained, "that training trees had"),
        (&unseen, "that the training never saw (rings in the charts, ° in the tables)"),
    ];
    for (group, what) in groups {
        if group.is_empty() {
            continue;
        }
        let shares: Vec<String> = (0..NUMBERS.len()).map(|i| share(group, i)).collect();
        chapter.text(format!(
            "Over {} settings of species, age and gravitropism {what}, the networks differ from \
             the growth model by {}.",
            group.len(),
            shares.join("; ")
        ));
    }
    if let Some(seen) = seen {
        held_out(chapter, seen);
    }
    refused(chapter, settings);
    let cut = |of: fn(&Setting) -> u32| settings.iter().map(of).sum::<u32>();
    let lost = [
        (cut(|s| s.p.nothing), "trees of the growth model had not begun to grow, and are left out"),
        (cut(|s| s.p.cut), "trees of the growth model were cut short by their budget"),
        (cut(|s| s.learner().map_or(0, |l| l.0.cut)), "generated trees ran into their node budget"),
    ];
    for (count, what) in lost.into_iter().filter(|(count, _)| *count > 0) {
        chapter.text(format!("{count} {what}."));
    }
    chapter.text(format!(
        "Each setting has {} trees a side; the number that is not varied is the species' own, on \
         both sides. The mean rise is the vertical part of the direction of growth, weighted by \
         length: 1 is straight up, 0 level. ± and bars: one standard error of a difference, two of \
         a mean. Coloured: nodes and height within {:.0} %, or beyond it by more than two standard \
         errors.",
        settings.first().map_or(0, |setting| setting.p.numbers[0].count + setting.p.nothing),
        100.0 * GOAL,
    ));
}

/// Says what the training has left out.
fn held_out(chapter: &mut Chapter, seen: &Seen) {
    let list = |gaps: Vec<(f32, f32)>, axis: Axis| -> String {
        let write = |&(low, high): &(f32, f32)| match axis {
            Axis::Age if low < high => format!("{} to {}", axis.write(low), axis.write(high)),
            Axis::Age => axis.write(low),
            Axis::Gravitropism => format!("{low:+.2} to {high:+.2}"),
        };
        gaps.iter().map(write).collect::<Vec<_>>().join(", ")
    };
    let between = |gaps: Vec<(f32, f32)>, [low, high]: [f32; 2]| {
        gaps.into_iter().filter(|gap| gap.0 >= low && gap.1 <= high).collect()
    };
    let ages = list(between(seen.age_gaps(), Axis::Age.range()), Axis::Age);
    let gravitropisms = between(seen.gravitropism_gaps(), Axis::Gravitropism.range());
    let gravitropisms = list(gravitropisms, Axis::Gravitropism);
    let or_none = |list: String| if list.is_empty() { "nothing".to_owned() } else { list };
    chapter.text(format!(
        "Left out of training within the range of the figures, as the roots kept in the model's file \
         tell: of the ages {}; of gravitropism {}.",
        or_none(ages),
        or_none(gravitropisms)
    ));
}

/// Mean and worst difference of number `i` over settings.
fn share(group: &[&Setting], i: usize) -> String {
    let Number { name, relative, .. } = NUMBERS[i];
    let all: Vec<(&&Setting, Difference)> =
        group.iter().filter_map(|s| Some((s, s.difference(i)?))).collect();
    let mean = |of: fn(&Difference) -> f64| {
        all.iter().map(|(_, difference)| of(difference)).sum::<f64>() / all.len().max(1) as f64
    };
    // The mean size of a normal error is √(2/π) of its standard deviation.
    let (found, chance) = (mean(|d| d.by.abs()), mean(|d| d.error) * FRAC_2_PI.sqrt());
    let beyond = all.iter().filter(|(_, d)| d.by.abs() > 2.0 * d.error).count();
    let write = |x: f64| if relative { format!("{:.1} %", 100.0 * x) } else { format!("{x:.3}") };
    let worst = all.iter().max_by(|a, b| a.1.by.abs().total_cmp(&b.1.by.abs()));
    let worst = worst.map_or(String::new(), |(setting, difference)| {
        format!(", at worst {} ({})", write(difference.by.abs()), setting.place())
    });
    format!(
        "{} in {name}, where sampling alone makes {}{worst}, {beyond} beyond two standard errors",
        write(found),
        write(chance),
    )
}

/// Says which settings the model has not seen.
fn refused(chapter: &mut Chapter, settings: &[Setting]) {
    let ranges: Vec<String> = settings
        .iter()
        .filter_map(|setting| match &setting.dt {
            Learner::NotSeen { what, low, high } => {
                Some(format!("{} of {}", setting.species, range(what, *low, *high)))
            }
            _ => None,
        })
        .collect();
    if ranges.is_empty() {
        return;
    }
    let (count, mut distinct) = (ranges.len(), Vec::new());
    for range in ranges {
        if !distinct.contains(&range) {
            distinct.push(range);
        }
    }
    chapter.text(format!(
        "The model refused {count} of {} settings, which its training corpus does not reach; they \
         are not measured. It has seen {} only.",
        settings.len(),
        distinct.join(", ")
    ));
}

fn range(what: &str, low: f32, high: f32) -> String {
    if low.to_bits() == high.to_bits() {
        format!("{what} {low}")
    } else {
        format!("{what} {low} to {high}")
    }
}

/// One chart a number: growth model and networks along the axis, a panel a species.
pub(super) fn charts(chapter: &mut Chapter, axis: Axis, settings: &[&Setting]) -> Result<()> {
    let mut species: Vec<&str> = settings.iter().map(|s| s.species.as_str()).collect();
    species.dedup();
    for (i, number) in NUMBERS.iter().enumerate() {
        let panel = |name: &&str| {
            let own = || settings.iter().filter(|setting| setting.species == **name);
            let point = |setting: &Setting, of: &Measured, hollow| {
                let number = &of.numbers[i];
                (number.count > 0).then(|| Point {
                    x: f64::from(setting.value),
                    y: number.mean,
                    error: 2.0 * number.error(),
                    hollow,
                })
            };
            let p = own().filter_map(|setting| point(setting, &setting.p, false)).collect();
            let dt = own().filter_map(|setting| {
                let (trees, trained) = setting.learner()?;
                point(setting, trees, !trained)
            });
            let lines = vec![
                Line { name: "growth model".into(), colour: TEACHER, points: p },
                Line { name: "networks".into(), colour: LEARNER, points: dt.collect() },
            ];
            Panel { title: (*name).to_owned(), lines }
        };
        let unit = if number.unit.is_empty() { "" } else { ", m" };
        let lines = Lines {
            x: axis.name().to_owned(),
            y: format!("{}{unit}", number.name),
            columns: 4,
            panels: species.iter().map(panel).collect(),
        };
        let caption = format!("{} over {}, mean of the trees.", capital(number.name), axis.name());
        chapter.chart(caption, lines.svg()?);
    }
    Ok(())
}

fn capital(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// The paper's figure: one tree along the axis, growth model above networks.
pub(super) fn pictures(
    study: &Study<'_>,
    chapter: &mut Chapter,
    axis: Axis,
    species: &Species,
) -> Result<()> {
    let values = axis.figure(study);
    let mut work = study.verb.model.workspace()?;
    let (mut teacher, mut learner): (Vec<Option<BranchGraph>>, _) = (Vec::new(), Vec::new());
    for &value in &values {
        let parameters = parameters(study, axis, species, value);
        let seed = study.verb.seed;
        teacher.push(teacher_tree(species, &parameters, seed)?.map(|(tree, _)| tree));
        let model = study.model.as_ref();
        let model =
            model.filter(|model| germ(*model, &request(species, &parameters, seed)).is_ok());
        learner.push(match model {
            Some(model) => Some(learner_tree(model, species, &parameters, seed, &mut work)?.0),
            None => None,
        });
    }
    let shots: Vec<Shot<'_>> = teacher
        .iter()
        .chain(&learner)
        .map(|tree| tree.as_ref().map_or(Shot::empty(View::FRONT), |t| Shot::new(t, View::FRONT)))
        .collect();
    let sheet =
        Sheet { columns: values.len(), width: study.scale(1600, 900), row: study.scale(420, 300) };
    let list: Vec<String> = values.iter().map(|&value| axis.write(value)).collect();
    let empty = if learner.iter().any(Option::is_none) {
        " An empty place: the model has not seen that setting."
    } else {
        ""
    };
    let caption = format!(
        "{}, {} {}: the growth model above, the networks below, the first tree of each set, on one \
         scale.{empty} The paper's figure of age and gravitropism.",
        species.name,
        axis.name(),
        list.join(", "),
    );
    chapter.picture(caption, sheet.png(&shots)?);
    Ok(())
}

/// All settings along an axis.
pub(super) fn table(chapter: &mut Chapter, axis: Axis, settings: &[&Setting]) {
    let mut header = vec!["species".to_owned(), axis.name().to_owned()];
    for Number { name, .. } in &NUMBERS {
        header.extend([format!("{name} P"), "DT".to_owned(), "Δ".to_owned()]);
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows = settings.iter().map(|setting| {
        let unseen = setting.learner().is_some_and(|(_, trained)| !trained);
        let mark = if unseen { "°" } else { "" };
        let value = format!("{}{mark}", axis.write(setting.value));
        let mut cells: Vec<Cell> = vec![setting.species.as_str().into(), value.into()];
        for (i, Number { decimals, .. }) in NUMBERS.iter().enumerate() {
            let p = &setting.p.numbers[i];
            let write = |mean: f64| format!("{mean:.decimals$}");
            let teacher = if p.count > 0 { write(p.mean) } else { "none".into() };
            cells.push(Cell::new(teacher, Tone::Quiet));
            cells.extend(match (&setting.dt, setting.learner()) {
                (_, Some((trees, _))) => {
                    [write(trees.numbers[i].mean).into(), difference(setting, i)]
                }
                (Learner::NotSeen { .. }, _) if i == 0 => ["not seen".into(), "–".into()],
                _ => ["–".into(), "–".into()],
            });
        }
        cells
    });
    let caption = format!(
        "Along {}: growth model (P, grey), networks (DT), and how far these are from it (Δ): nodes, \
         height and crown radius in percent, the mean rise as it is. Heights and radii in metres.",
        axis.name()
    );
    chapter.table(caption, &header, rows.collect());
}

fn difference(setting: &Setting, i: usize) -> Cell {
    let Some(found) = setting.difference(i) else { return "–".into() };
    let Number { name, relative, decimals, .. } = NUMBERS[i];
    if !relative {
        return found.plain(decimals).into();
    }
    let beyond = found.by.abs() - GOAL;
    let tone = match name {
        "nodes" | "height" if beyond <= 0.0 => Tone::Good,
        "nodes" | "height" if beyond > 2.0 * found.error => Tone::Bad,
        _ => Tone::Plain,
    };
    Cell::new(found.percent(), tone)
}

/// The chapter as CSV and JSON.
pub(super) fn save(study: &Study<'_>, settings: &[Setting]) -> Result<()> {
    let mut csv = String::from("axis,species,value,set,trained,trees,quantity,mean,sd\n");
    for setting in settings {
        let teacher = Some(("P", &setting.p, true));
        let learner = setting.learner().map(|(trees, trained)| ("DT", trees, trained));
        for (set, measured, trained) in [teacher, learner].into_iter().flatten() {
            for (number, estimate) in NUMBERS.iter().zip(&measured.numbers) {
                let Setting { axis, species, value, .. } = setting;
                let (axis, count) = (axis.name(), estimate.count);
                csv += &format!(
                    "{axis},{species},{value},{set},{trained},{count},{},{},{}\n",
                    number.name, estimate.mean, estimate.sd
                );
            }
        }
    }
    study.save("priors.csv", csv.as_bytes())?;
    let json = json!({ "settings": settings });
    study.save("priors.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
