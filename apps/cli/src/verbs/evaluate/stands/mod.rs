//! Chapter 14: trees that crowd each other.

mod measure;
mod pictures;

use anyhow::Result;
use deeptree_eval::report::Chapter;
use serde_json::json;

use super::around::{self, LEARNER, Places, Quantity, TEACHER, UNTOLD};
use super::study::{Study, short};

/// Stands of each species, and of all species mixed.
const FULL: u32 = 20;
const QUICK: u32 = 4;

/// What a stand of all species is called.
const MIXED: &str = "mixed";

/// What is measured, in the order of [`measure::samples`].
const QUANTITIES: [Quantity; 7] = [
    Quantity { name: "nodes", in_parts: true, goal: Some(0.1) },
    Quantity { name: "spread of nodes", in_parts: true, goal: None },
    Quantity { name: "height m", in_parts: true, goal: Some(0.05) },
    Quantity { name: "crown radius m", in_parts: true, goal: Some(0.1) },
    Quantity { name: "lean outwards m", in_parts: false, goal: Some(0.3) },
    Quantity { name: "in others' cells", in_parts: true, goal: None },
    Quantity { name: "intersections", in_parts: true, goal: None },
];
const NODES: usize = 0;
const SHARED: usize = 5;
const INTERSECTIONS: usize = 6;

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("stands", "Trees that crowd each other");
    let Some(model) = &study.model else {
        chapter.text("Only the growth model was measured.");
        return Ok(chapter);
    };
    let count = study.scale(FULL, QUICK).min(study.trees());
    let mut all = Vec::new();
    for species in &study.species {
        all.push(measure::places(study, model, &species.name, &[species], count)?);
    }
    if study.species.len() > 1 {
        let every: Vec<_> = study.species.iter().collect();
        all.push(measure::places(study, model, MIXED, &every, count)?);
    }
    say(&mut chapter, &all);
    table(&mut chapter, &all);
    by_spacing(&mut chapter, &all);
    pictures::stands(study, model, &mut chapter)?;
    save(study, &all)?;
    Ok(chapter)
}

fn say(chapter: &mut Chapter, all: &[Places]) {
    let every: Vec<&Places> = all.iter().collect();
    let each: Vec<Vec<&Places>> = every.iter().map(|&of| vec![of]).collect();
    let mean = |side, quantity| {
        let of_one = |of: &&Places| around::mean(of, side, quantity);
        every.iter().map(of_one).sum::<f64>() / every.len() as f64
    };
    let three = |quantity| {
        let [p, told, untold] = [TEACHER, LEARNER, UNTOLD].map(|side| mean(side, quantity));
        [short(p, 3), short(told, 3), short(untold, 3)]
    };
    chapter.text(format!(
        "In {} stands of {} trees of each species and of all mixed, {} m apart, which no model has \
         seen, the networks' trees differ from the growth model's on average by: {}. Of single \
         species: {}.",
        every.first().map_or(0, |of| of.places.len()),
        measure::TREES,
        measure::SPACINGS.map(|spacing| spacing.to_string()).join(", "),
        around::sentence(&every, &QUANTITIES),
        around::goals(&each, &QUANTITIES),
    ));
    let (
        [nodes, told, untold],
        [shared, shared_told, shared_untold],
        [pairs, pairs_told, pairs_untold],
    ) = (three(NODES), three(SHARED), three(INTERSECTIONS));
    chapter.text(format!(
        "A tree has {nodes} nodes in the growth model, {told} in the networks, and {untold} in \
         networks that are not told of the others. The share of its nodes in cells of 2 m where \
         others have nodes, too, is {shared}, {shared_told} and {shared_untold}; pairs of internodes \
         of different trees share space {pairs}, {pairs_told} and {pairs_untold} times a stand."
    ));
}

fn table(chapter: &mut Chapter, all: &[Places]) {
    let header = ["species", "stands"].into_iter().chain(QUANTITIES.map(|quantity| quantity.name));
    let mut rows = Vec::new();
    for of in all {
        rows.extend(around::rows(&[&of.species], &[of], &QUANTITIES));
    }
    if all.len() > 1 {
        rows.extend(around::rows(&["mean"], &all.iter().collect::<Vec<_>>(), &QUANTITIES));
    }
    chapter.table(
        "P: means of the growth model over trees. Below: what the others differ from it, with the \
         standard error of the jackknife over stands. P2 is a second sample of the growth model in \
         stands of the same plan, DT the networks, and DT not told the same trees in the open field, \
         set side by side: what must be beaten. Spread: standard deviation of ln nodes in a stand. \
         Lean: mean horizontal place of a tree's nodes, away from the middle of the stand. In \
         others' cells: share of the nodes in cells of 2 m where another tree has nodes, too. \
         Intersections: pairs of internodes of different trees that share space, capsule against \
         capsule, a stand. Coloured: within the goal, or beyond by more than two standard errors. \
         The paper has no stands.",
        &header.collect::<Vec<_>>(),
        rows,
    );
}

/// How nodes fall as trees stand closer.
fn by_spacing(chapter: &mut Chapter, all: &[Places]) {
    let rows = measure::SPACINGS.iter().enumerate().map(|(k, spacing)| {
        let nodes = |side: usize| {
            let stands = all.iter().flat_map(|of| of.places.iter().enumerate());
            let of_spacing = stands.filter(|(i, _)| i % measure::SPACINGS.len() == k);
            let sums = of_spacing.map(|(_, sides)| sides[side].samples[NODES]);
            let [sum, count] = sums.fold([0.0; 2], |[a, b], [x, n]| [a + x, b + n]);
            if count == 0.0 { "–".into() } else { format!("{:.0}", sum / count).into() }
        };
        vec![spacing.to_string().into(), nodes(TEACHER), nodes(LEARNER), nodes(UNTOLD)]
    });
    chapter.table(
        "Nodes of a tree by the distance of neighbours, over all species and the mixtures.",
        &["spacing m", "P", "DT", "DT not told"],
        rows.collect(),
    );
}

fn save(study: &Study<'_>, all: &[Places]) -> Result<()> {
    let mut csv = format!("species,{}\n", around::CSV);
    for of in all {
        csv += &around::csv(&of.species, of, &QUANTITIES);
    }
    study.save("stands.csv", csv.as_bytes())?;
    let names = QUANTITIES.map(|quantity| quantity.name);
    let json = json!({ "sides": around::SIDES, "samples": names, "species": all });
    study.save("stands.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
