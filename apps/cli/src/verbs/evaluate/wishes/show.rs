//! The figures of the chapter in words, charts, pictures and tables.

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::report::chart::lines::{Line, Lines, Panel, Point};
use deeptree_eval::report::chart::{GUIDE, LEARNER};
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_infer::{Model, Predictor};

use super::blends::{self, Blend, DECIMALS, Figures, QUANTITIES};
use super::controls::{self, Control, Controlled, Outside, Setting, SpeciesControls};
use crate::verbs::evaluate::study::Study;

/// How far the mean may be from what was asked for.
const GOAL: f64 = 0.05;

/// Panels side by side.
const COLUMNS: usize = 4;

/// A setting with where it is from.
struct Place<'a> {
    species: &'a str,
    control: Control,
    setting: &'a Setting,
}

impl Place<'_> {
    fn is_met(&self) -> bool {
        self.setting.deviation().abs() <= GOAL
    }
}

fn places(all: &[SpeciesControls]) -> Vec<Place<'_>> {
    all.iter().flat_map(own).collect()
}

fn own(one: &SpeciesControls) -> impl Iterator<Item = Place<'_>> {
    one.controls.iter().flat_map(|Controlled { control, settings, .. }| {
        settings.iter().map(|setting| Place { species: &one.species, control: *control, setting })
    })
}

/// Wishes one at a time.
pub(super) fn controls(
    study: &Study<'_>,
    model: &Model,
    chapter: &mut Chapter,
    all: &[SpeciesControls],
) -> Result<()> {
    let places = places(all);
    chapter.text(summary(&places, all));
    let trees = places.first().map_or(0, |place| place.setting.came.count);
    chapter.text(format!(
        "Each setting asks for one number of the whole tree and leaves the rest open, and has \
         {trees} trees, none of them picked. The goal is a mean within {:.0} % of what was asked \
         for (green); red is further off by more than two standard errors. A wish that is seldom \
         at the species' own age moves the age, which is printed. The crown radius is the \
         distance of the outermost node from the axis, a branch what starts at the root or at a \
         lateral, the trunk the branch of order 0. The kind paper reads nothing that could be \
         asked for and has no such settings; the paper has no figures of such controls.",
        100.0 * GOAL
    ));
    chapter.heading("Asked for and grown");
    let header: Vec<&str> =
        ["species"].into_iter().chain(Control::ALL.map(Control::name)).chain(["all"]).collect();
    chapter.table(
        "Settings whose mean is within the goal",
        &header,
        all.iter().map(shares).collect(),
    );
    for control in Control::ALL {
        chart(chapter, control, all)?;
    }
    picture(study, model, chapter, all)?;
    for control in Control::ALL {
        table(chapter, control, all);
    }
    outside(chapter, all);
    Ok(())
}

fn summary(places: &[Place<'_>], all: &[SpeciesControls]) -> String {
    let share = |of: &dyn Fn(&Place<'_>) -> bool| {
        let of: Vec<&Place<'_>> = places.iter().filter(|place| of(place)).collect();
        format!("{} of {}", of.iter().filter(|place| place.is_met()).count(), of.len())
    };
    let by_control: Vec<String> = Control::ALL
        .iter()
        .map(|control| {
            let own = |place: &Place<'_>| place.control == *control;
            format!("{} {}", control.name(), share(&own))
        })
        .collect();
    let mean = |of: fn(&Setting) -> f64| {
        places.iter().map(|place| of(place.setting)).sum::<f64>() / places.len().max(1) as f64
    };
    let mut text = format!(
        "In {} settings the mean of the generated trees is within {:.0} % of what was asked for: \
         {}. On average it is {:.1} % off, and single trees scatter by {:.1} % about it.",
        share(&|_| true),
        100.0 * GOAL,
        by_control.join(", "),
        100.0 * mean(|setting| setting.deviation().abs()),
        100.0 * mean(Setting::scatter),
    );
    let worst = places
        .iter()
        .max_by(|a, b| a.setting.deviation().abs().total_cmp(&b.setting.deviation().abs()));
    if let Some(Place { species, control, setting }) = worst {
        let _ = write!(
            text,
            " The furthest is {species} asked for a {} of {}: {}.",
            control.name(),
            control.write(f64::from(setting.asked)),
            deviation(setting)
        );
    }
    let outside: Vec<&Outside> = each_outside(all).map(|(.., outside)| outside).collect();
    let refused = outside.iter().filter(|outside| outside.refusal.is_some()).count();
    let _ = write!(
        text,
        " Of {} requests outside of the range, {refused} were refused.",
        outside.len()
    );
    let cut: u32 = places.iter().map(|place| place.setting.cut).sum();
    if cut > 0 {
        let _ = write!(text, " {cut} trees ran into their node budget.");
    }
    text
}

fn deviation(setting: &Setting) -> String {
    format!("{:+.1} ± {:.1} %", 100.0 * setting.deviation(), 100.0 * setting.error())
}

fn toned(setting: &Setting) -> Cell {
    let beyond = setting.deviation().abs() - GOAL;
    let tone = match beyond {
        x if x <= 0.0 => Tone::Good,
        x if x > 2.0 * setting.error() => Tone::Bad,
        _ => Tone::Plain,
    };
    Cell::new(deviation(setting), tone)
}

/// How many settings of a species are within the goal.
fn shares(one: &SpeciesControls) -> Vec<Cell> {
    let cell = |of: Vec<Place<'_>>| {
        let met = of.iter().filter(|place| place.is_met()).count();
        let tone = if met == of.len() { Tone::Good } else { Tone::Plain };
        Cell::new(format!("{met} of {}", of.len()), tone)
    };
    let of_control =
        |control: &Control| cell(own(one).filter(|place| place.control == *control).collect());
    let mut cells = vec![Cell::from(one.species.as_str())];
    cells.extend(Control::ALL.iter().map(of_control));
    cells.push(cell(own(one).collect()));
    cells
}

fn of_control(
    all: &[SpeciesControls],
    control: Control,
) -> impl Iterator<Item = (&str, &Controlled)> {
    all.iter().flat_map(move |one| {
        let own = one.controls.iter().filter(move |own| own.control == control);
        own.map(|own| (one.species.as_str(), own))
    })
}

fn chart(chapter: &mut Chapter, control: Control, all: &[SpeciesControls]) -> Result<()> {
    let panel = |(species, own): (&str, &Controlled)| {
        let asked = |setting: &Setting| f64::from(setting.asked);
        let right = |setting: &Setting| (asked(setting), asked(setting), 0.0);
        let came = |setting: &Setting| (asked(setting), setting.came.mean, setting.came.sd);
        let points = |of: &dyn Fn(&Setting) -> (f64, f64, f64)| {
            let point = |(x, y, error)| Point { x, y, error, hollow: false };
            own.settings.iter().map(|setting| point(of(setting))).collect()
        };
        let lines = vec![
            Line { name: "as asked for".into(), colour: GUIDE, points: points(&right) },
            Line { name: "networks".into(), colour: LEARNER, points: points(&came) },
        ];
        Panel { title: species.to_owned(), lines }
    };
    let unit = if control == Control::Branches { "" } else { ", m" };
    let name = control.name();
    let lines = Lines {
        x: format!("{name} asked for{unit}"),
        y: format!("{name}{unit}"),
        columns: COLUMNS,
        panels: of_control(all, control).map(panel).collect(),
    };
    if lines.panels.iter().flat_map(|panel| &panel.lines).any(|line| !line.points.is_empty()) {
        let caption = format!("Asked for by {name}; bars: one standard deviation of the trees.");
        chapter.chart(caption, lines.svg()?);
    }
    Ok(())
}

/// One tree a height, of oak or else of the first species.
fn picture(
    study: &Study<'_>,
    model: &Model,
    chapter: &mut Chapter,
    all: &[SpeciesControls],
) -> Result<()> {
    let heights = || of_control(all, Control::Height).filter(|(_, own)| !own.settings.is_empty());
    let Some((species, own)) =
        heights().find(|(species, _)| *species == "oak").or_else(|| heights().next())
    else {
        return Ok(());
    };
    let mut work = study.verb.model.workspace()?;
    let (mut trees, mut list) = (Vec::new(), Vec::new());
    for Setting { asked, .. } in &own.settings {
        let wish = (Control::Height, *asked);
        trees.push(controls::tree(model, species, wish, study.verb.seed, &mut work)?);
        list.push(asked.to_string());
    }
    let shots: Vec<Shot<'_>> = trees.iter().map(|tree| Shot::new(tree, View::FRONT)).collect();
    let caption = format!(
        "{species} asked to be {} m high, the first tree of each setting, on one scale.",
        list.join(", ")
    );
    chapter.picture(caption, sheet(study, shots.len()).png(&shots)?);
    Ok(())
}

fn sheet(study: &Study<'_>, columns: usize) -> Sheet {
    Sheet { columns, width: study.scale(1600, 900), row: study.scale(420, 300) }
}

fn table(chapter: &mut Chapter, control: Control, all: &[SpeciesControls]) {
    let row = |species: &str, setting: &Setting| {
        let Setting { asked, came, age, .. } = setting;
        vec![
            Cell::from(species),
            control.write(f64::from(*asked)).into(),
            control.write(came.mean).into(),
            control.write(came.sd).into(),
            toned(setting),
            format!("{age:.0}").into(),
        ]
    };
    let rows = of_control(all, control)
        .flat_map(|(species, own)| own.settings.iter().map(move |setting| row(species, setting)));
    chapter.table(
        format!("Asked for by {}", control.name()),
        &["species", "asked", "mean", "sd of the trees", "deviation", "age"],
        rows.collect(),
    );
}

fn each_outside(all: &[SpeciesControls]) -> impl Iterator<Item = (&str, &Controlled, &Outside)> {
    let controls = all
        .iter()
        .flat_map(|one| one.controls.iter().map(|controlled| (one.species.as_str(), controlled)));
    controls.flat_map(|(species, controlled)| {
        controlled.outside.iter().map(move |outside| (species, controlled, outside))
    })
}

fn outside(chapter: &mut Chapter, all: &[SpeciesControls]) {
    chapter.heading("Asked for what was never seen");
    let example = each_outside(all).find_map(|(.., outside)| outside.refusal.as_deref());
    if let Some(refusal) = example {
        chapter
            .text(format!("A request outside of the range ends with its reason: \"{refusal}\"."));
    }
    chapter.text(
        "With --force it is moved to the nearest end of the range, and a warning says so. At the \
         ends no tree was ever far beyond, so that the mean may fall short of the end.",
    );
    let row = |(species, controlled, outside): (&str, &Controlled, &Outside)| {
        let Controlled { control, range, .. } = controlled;
        let write = |x: f32| control.write(f64::from(x));
        let refused = match outside.refusal {
            Some(_) => Cell::new("refused", Tone::Good),
            None => Cell::new("granted", Tone::Bad),
        };
        let Setting { asked, came, .. } = &outside.forced;
        vec![
            species.into(),
            control.name().into(),
            format!("{} to {}", write(range.0), write(range.1)).into(),
            write(outside.asked).into(),
            refused,
            write(*asked).into(),
            control.write(came.mean).into(),
            deviation(&outside.forced).into(),
        ]
    };
    chapter.table(
        "Requests of half the least and one and a half times the most that is granted",
        &["species", "control", "range", "asked", "", "with --force", "mean", "deviation"],
        each_outside(all).map(row).collect(),
    );
}

/// Species between species.
pub(super) fn blends(study: &Study<'_>, chapter: &mut Chapter, all: &[Blend]) -> Result<()> {
    chapter.heading("Blends");
    if all.is_empty() {
        chapter.text("Not measured: no two species of a blend are in this run.");
        return Ok(());
    }
    let places: Vec<_> = all
        .iter()
        .flat_map(|blend| (0..QUANTITIES.len()).filter_map(|quantity| blend.between(quantity)))
        .collect();
    let inside = places.iter().filter(|place| place.is_between()).count();
    let trees = all.first().map_or(0, |blend| blend.own[0].trees);
    chapter.text(format!(
        "A blend is an interpolation of what the networks learned of its species. Nothing of the \
         kind was ever grown, so there is no teacher to compare it with: what can be asked is \
         whether it lies between its parents. Of {} quantities of {} blends in which the parents \
         differ, it does in {inside}, within two standard errors.",
        places.len(),
        all.len(),
    ));
    let header: Vec<&str> = ["", "weight"].into_iter().chain(QUANTITIES).collect();
    for pair in all.chunk_by(|a, b| a.parents == b.parents) {
        let mut rows = vec![values(&pair[0].parents[0], &pair[0].of_parents[0])];
        for blend in pair {
            rows.push(values(&blend.name, &blend.own));
            rows.push(betweens(blend));
        }
        rows.push(values(&pair[0].parents[1], &pair[0].of_parents[1]));
        chapter.table(
            format!(
                "{} and {}, {trees} trees each, all of the networks. Second line: where the blend \
                 lies, 0 the first parent, 1 the second; \u{2013} where these are alike; green \
                 between them, red outside by more than two standard errors",
                pair[0].parents[0], pair[0].parents[1]
            ),
            &header,
            rows,
        );
    }
    blend_picture(study, chapter, all)
}

fn values(name: &str, figures: &Figures) -> Vec<Cell> {
    let mut cells = vec![Cell::from(name), Cell::from("")];
    for (found, decimals) in figures.iter().zip(DECIMALS) {
        cells.push(format!("{:.decimals$} ± {:.decimals$}", found.mean, found.mean_error).into());
    }
    cells
}

fn betweens(blend: &Blend) -> Vec<Cell> {
    let mut cells = vec![Cell::from("lies at"), format!("{:.1}", blend.weight).into()];
    cells.extend((0..QUANTITIES.len()).map(|quantity| match blend.between(quantity) {
        None => Cell::new("–", Tone::Quiet),
        Some(place) => {
            let tone = match place.at {
                _ if !place.is_between() => Tone::Bad,
                at if (0.0..=1.0).contains(&at) => Tone::Good,
                _ => Tone::Plain,
            };
            Cell::new(format!("{:.2} ± {:.2}", place.at, place.error), tone)
        }
    }));
    cells
}

/// The first parents with their blends.
fn blend_picture(study: &Study<'_>, chapter: &mut Chapter, all: &[Blend]) -> Result<()> {
    let (Some(model), Some(pair)) =
        (&study.model, all.chunk_by(|a, b| a.parents == b.parents).next())
    else {
        return Ok(());
    };
    let (seed, mut work) = (study.verb.seed, study.verb.model.workspace()?);
    let [first, second] = &pair[0].parents;
    let mut trees = vec![blends::tree(model, first, seed, &mut work)?];
    for blend in pair {
        let between = blends::model(study, &blend.name)?;
        trees.push(blends::tree(&between, &between.species()[0], seed, &mut work)?);
    }
    trees.push(blends::tree(model, second, seed, &mut work)?);
    let shots: Vec<Shot<'_>> = trees.iter().map(|tree| Shot::new(tree, View::FRONT)).collect();
    let names: Vec<&str> = pair.iter().map(|blend| blend.name.as_str()).collect();
    let caption =
        format!("{first}, {}, {second}, the first tree of each, on one scale.", names.join("; "));
    chapter.picture(caption, sheet(study, shots.len()).png(&shots)?);
    Ok(())
}

/// The chapter as CSV.
pub(super) fn csv(species: &[SpeciesControls], blends: &[Blend]) -> String {
    let mut out = "what,species,asked,quantity,trees,mean,sd,age\n".to_owned();
    for Place { species, control, setting } in places(species) {
        let Setting { asked, came, age, .. } = setting;
        let _ = writeln!(
            out,
            "wish,{species},{asked},{},{},{},{},{age}",
            control.name(),
            came.count,
            came.mean,
            came.sd
        );
    }
    for (species, controlled, outside) in each_outside(species) {
        let Setting { asked, came, age, .. } = &outside.forced;
        let name = controlled.control.name();
        let (count, mean, sd) = (came.count, came.mean, came.sd);
        let _ = writeln!(out, "forced,{species},{asked},{name},{count},{mean},{sd},{age}");
    }
    for blend in blends {
        let [first, second] = &blend.parents;
        let own = blend.name.replace(',', " ");
        let [of_first, of_second] = &blend.of_parents;
        for (name, figures) in [(&own, &blend.own), (first, of_first), (second, of_second)] {
            for (quantity, found) in QUANTITIES.iter().zip(figures) {
                let quantity = quantity.split(',').next().unwrap_or(quantity);
                let (trees, mean, sd) = (found.trees, found.mean, found.sd);
                let _ = writeln!(out, "blend,{name},,{quantity},{trees},{mean},{sd},");
            }
        }
    }
    out
}
