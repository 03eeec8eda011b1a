//! Chapter 12: trees among obstacles.

mod cost;
mod measure;
mod pictures;

use anyhow::Result;
use deeptree_eval::report::{Cell, Chapter, Tone};
use serde_json::json;

use super::around::{self, CONTROL, LEARNER, Measured, Places, Quantity, TEACHER, UNTOLD};
use super::study::{Study, short};
use cost::Cost;

/// Scenes, each with trees of all species.
const FULL: u32 = 100;
const QUICK: u32 = 4;

/// What is measured, in the order of [`measure::samples`]: the goals are those of the issue.
const QUANTITIES: [Quantity; 6] = [
    Quantity { name: "nodes", in_parts: true, goal: Some(0.1) },
    Quantity { name: "BN", in_parts: true, goal: Some(0.1) },
    Quantity { name: "BL", in_parts: true, goal: Some(0.1) },
    Quantity { name: "offset m", in_parts: false, goal: Some(0.3) },
    Quantity { name: "near an obstacle", in_parts: true, goal: Some(0.1) },
    Quantity { name: "intersections", in_parts: true, goal: None },
];
const OFFSET: usize = 3;
const INTERSECTIONS: usize = 5;

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("environment", "Trees among obstacles");
    let Some(model) = &study.model else {
        chapter.text("Only the growth model was measured.");
        return Ok(chapter);
    };
    let count = study.scale(FULL, QUICK).min(study.trees());
    let (mut all, mut costs) = (Vec::new(), Vec::new());
    for species in &study.species {
        all.push(measure::places(study, model, species, count)?);
    }
    for species in &study.species {
        costs.push(cost::measure(study, model, species)?);
    }
    say(&mut chapter, &all, &costs);
    table(&mut chapter, &all);
    avoided(&mut chapter, &all);
    cost::table(&mut chapter, &costs);
    pictures::walls(study, model, &mut chapter)?;
    pictures::corner(study, model, &mut chapter)?;
    save(study, &all, &costs)?;
    Ok(chapter)
}

fn every(all: &[Places]) -> Vec<&Places> {
    all.iter().collect()
}

fn say(chapter: &mut Chapter, all: &[Places], costs: &[Cost]) {
    let every = every(all);
    let each: Vec<Vec<&Places>> = all.iter().map(|of| vec![of]).collect();
    chapter.text(format!(
        "In {} random scenes that no model has seen, each with a tree of every species, the \
         networks' trees differ from the growth model's on average by: {}. Differences of the \
         mean over species: {}. Of single species: {}.",
        all.first().map_or(0, |of| of.places.len()),
        around::sentence(&every, &QUANTITIES),
        around::goals(std::slice::from_ref(&every), &QUANTITIES),
        around::goals(&each, &QUANTITIES),
    ));
    let misplaced = |side| [0, 1].map(|i| around::sum(&every, side, |tree| tree.misplaced[i]));
    let of = |side| {
        let [nodes, edges] = misplaced(side);
        format!("{nodes} nodes and {edges} edges")
    };
    chapter.text(format!(
        "Inside or through obstacles are {} of the growth model ({} of its control) and {} of \
         the networks; of networks that are not told of the scene {}. The shade of the obstacles \
         moves crowns by {} m away from the nearest in the growth model, and by {} m in the \
         networks; not told, by {} m.",
        of(TEACHER),
        of(CONTROL),
        of(LEARNER),
        of(UNTOLD),
        short(mean(all, TEACHER, OFFSET), 2),
        short(mean(all, LEARNER, OFFSET), 2),
        short(mean(all, UNTOLD, OFFSET), 2),
    ));
    chapter.text(cost::sentence(costs));
}

/// The mean over species of a quantity.
fn mean(all: &[Places], side: usize, quantity: usize) -> f64 {
    all.iter().map(|of| around::mean(of, side, quantity)).sum::<f64>() / all.len() as f64
}

fn table(chapter: &mut Chapter, all: &[Places]) {
    let header = ["species", "trees"].into_iter().chain(QUANTITIES.map(|quantity| quantity.name));
    let mut rows = Vec::new();
    for of in all {
        rows.extend(around::rows(&[&of.species], &[of], &QUANTITIES));
    }
    if all.len() > 1 {
        rows.extend(around::rows(&["mean"], &every(all), &QUANTITIES));
    }
    chapter.table(
        "P: means of the growth model. Below: what the others differ from it, with the standard \
         error of the jackknife over scenes. P2 is a second sample of the growth model in the same \
         scenes, DT the networks, and DT not told the same trees in the open field, measured in the \
         scene: what must be beaten. BN: branches of a tree. BL: length of a branch. Offset: mean \
         horizontal place of a tree's nodes, along the way from the nearest point of the nearest \
         obstacle (in plan) to the foot. Near: share of a tree's nodes within 2 m of an obstacle. \
         Intersections: pairs of internodes of a tree that share space, capsule against capsule, \
         without parent and child and siblings. Coloured: within 10 % (offset 0.3 m), or beyond \
         by more than two standard errors. The paper gives no figures.",
        &header.collect::<Vec<_>>(),
        rows,
    );
}

/// How often the networks ran into something.
fn avoided(chapter: &mut Chapter, all: &[Places]) {
    let rate = |of: &[&Places], side, what: fn(&Measured) -> u64| {
        let nodes = around::sum(of, side, |tree| tree.nodes);
        1000.0 * around::sum(of, side, what) as f64 / nodes.max(1) as f64
    };
    let row = |name: &str, of: &[&Places]| {
        let cell = |side, what| Cell::from(format!("{:.2}", rate(of, side, what)));
        let quiet = |side, what| Cell { tone: Tone::Quiet, ..cell(side, what) };
        let mut cells = vec![
            name.into(),
            cell(LEARNER, |tree| tree.redrawn),
            quiet(UNTOLD, |tree| tree.redrawn),
            cell(LEARNER, |tree| tree.given_up),
            quiet(UNTOLD, |tree| tree.given_up),
        ];
        for side in [TEACHER, LEARNER, UNTOLD] {
            for i in [0, 1] {
                let count = around::sum(of, side, |tree| tree.misplaced[i]);
                let tone = match side {
                    UNTOLD => Tone::Quiet,
                    _ if count == 0 => Tone::Good,
                    _ => Tone::Bad,
                };
                cells.push(Cell::new(count.to_string(), tone));
            }
        }
        let mean = |side| {
            let sum: f64 = of.iter().map(|of| around::mean(of, side, INTERSECTIONS)).sum();
            short(sum / of.len() as f64, 3)
        };
        cells.extend([TEACHER, LEARNER, UNTOLD].map(|side| Cell::from(mean(side))));
        cells
    };
    let mut rows: Vec<Vec<Cell>> = all.iter().map(|of| row(&of.species, &[of])).collect();
    if all.len() > 1 {
        rows.push(row("all", &every(all)));
    }
    chapter.table(
        "A child whose edge would enter an obstacle or the ground is drawn again, and given up \
         after a few times: how often a thousand nodes, in the scenes and in the open field. Then \
         all nodes inside obstacles and edges through them of the growth model, of the networks, and \
         of networks that are not told; and intersections a tree of the three.",
        &[
            "species",
            "drawn again",
            "open field",
            "given up",
            "open field",
            "P nodes inside",
            "P edges through",
            "DT nodes inside",
            "DT edges through",
            "not told nodes inside",
            "not told edges through",
            "P intersections",
            "DT intersections",
            "not told intersections",
        ],
        rows,
    );
}

fn save(study: &Study<'_>, all: &[Places], costs: &[Cost]) -> Result<()> {
    let mut csv = format!("species,{}\n", around::CSV);
    for of in all {
        csv += &around::csv(&of.species, of, &QUANTITIES);
    }
    study.save("environment.csv", csv.as_bytes())?;
    let names = QUANTITIES.map(|quantity| quantity.name);
    let json = json!({ "sides": around::SIDES, "samples": names, "species": all, "cost": costs });
    study.save("environment.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
