//! Chapter 13: trees that are kept in a form.

use std::collections::BTreeSet;

use anyhow::Result;
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_graph::BranchGraph;
use deeptree_infer::Model;
use deeptree_scene::{Environment, Scene, Site, Volume};
use serde_json::json;

use super::around::{self, CONTROL, LEARNER, Places, Quantity, Sample, TEACHER, UNTOLD};
use super::study::Study;
use super::trees;

/// The forms of the paper.
const FORMS: [Volume; 3] = [Volume::Cone, Volume::Cube, Volume::Ring];

/// Trees of each species and form.
const FULL: u32 = 100;
const QUICK: u32 = 3;

/// Part of the nodes that shall be inside.
const INSIDE: f64 = 0.995;

/// What is measured, in the order of [`samples`].
const QUANTITIES: [Quantity; 5] = [
    Quantity { name: "nodes", in_parts: true, goal: Some(0.1) },
    Quantity { name: "BN", in_parts: true, goal: Some(0.1) },
    Quantity { name: "BL", in_parts: true, goal: Some(0.1) },
    Quantity { name: "voxels of 2 m", in_parts: true, goal: Some(0.1) },
    Quantity { name: "voxels of 1 m", in_parts: true, goal: Some(0.1) },
];

/// The trees of a species in a form.
struct Kept {
    form: &'static str,
    places: Places,
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("forms", "Trees in forms");
    let Some(model) = &study.model else {
        chapter.text("Only the growth model was measured.");
        return Ok(chapter);
    };
    let mut all = Vec::new();
    for (volume, form) in FORMS.iter().zip(Volume::NAMES) {
        for species in &study.species {
            let environment = environment(volume);
            let name = &species.name;
            let places = study.part(&format!("forms-{form}-{name}"), || {
                let count = study.scale(FULL, QUICK).min(study.trees());
                let what = format!("{name} {form}");
                let places = trees::many(study, &what, study.verb.seed, count, |work, seed| {
                    around::four(study, model, species, seed, &environment, work, samples)
                })?;
                Ok(Places { species: name.clone(), places })
            })?;
            all.push(Kept { form, places });
        }
    }
    say(&mut chapter, &all);
    table(&mut chapter, &all);
    pictures(study, model, &mut chapter)?;
    save(study, &all)?;
    Ok(chapter)
}

fn environment(volume: &Volume) -> Environment {
    Environment { scene: Scene::default(), volume: Some(volume.clone()) }
}

/// Nodes, branches, their lengths, and the voxels of 2 and of 1 m that hold a node.
fn samples(tree: &BranchGraph) -> Vec<Sample> {
    let voxels = |side: f32| {
        let cell = |x: f32| (x / side).floor() as i32;
        let cells = tree.nodes().iter().map(|node| node.position.to_array().map(cell));
        cells.collect::<BTreeSet<[i32; 3]>>().len() as f64
    };
    let mut all = around::of_any_tree(tree).to_vec();
    all.extend([[voxels(2.0), 1.0], [voxels(1.0), 1.0]]);
    all
}

/// Part of all nodes of a side that is inside, stump and stem with it.
fn inside(of: &[&Places], side: usize) -> f64 {
    let out = around::sum(of, side, |tree| tree.misplaced[0]);
    1.0 - out as f64 / around::sum(of, side, |tree| tree.nodes).max(1) as f64
}

/// The trees of a form.
fn of_form<'a>(all: &'a [Kept], form: &str) -> Vec<&'a Places> {
    all.iter().filter(|kept| kept.form == form).map(|kept| &kept.places).collect()
}

fn say(chapter: &mut Chapter, all: &[Kept]) {
    let every: Vec<&Places> = all.iter().map(|kept| &kept.places).collect();
    let each: Vec<Vec<&Places>> = every.iter().map(|&of| vec![of]).collect();
    let percent = |side| 100.0 * inside(&every, side);
    chapter.text(format!(
        "Trees were kept in a cone, a cube and a ring, {} of each species and form. Of the nodes \
         {:.3} % lie inside in the growth model, {:.3} % in the networks, and {:.1} % where they are \
         not told; {:.1} % is the goal. Differences of \
         single species and forms: {}.",
        every.first().map_or(0, |of| of.places.len()),
        percent(TEACHER),
        percent(LEARNER),
        percent(UNTOLD),
        100.0 * INSIDE,
        around::goals(&each, &QUANTITIES),
    ));
    for form in Volume::NAMES {
        let of = of_form(all, form);
        let sentence = around::sentence(&of, &QUANTITIES);
        chapter.text(format!("The {form}, mean difference over species: {sentence}."));
    }
}

fn table(chapter: &mut Chapter, all: &[Kept]) {
    let header = ["form", "species", "trees"];
    let header = header.into_iter().chain(QUANTITIES.map(|quantity| quantity.name));
    let mut rows = Vec::new();
    let mut add = |names: &[&str], of: &[&Places]| {
        let sides = if of.len() == 1 { TEACHER } else { CONTROL }..;
        let made = around::rows(names, of, &QUANTITIES).into_iter();
        rows.extend(made.zip(sides).map(|(row, side)| {
            let part = inside(of, side);
            let tone = match side {
                LEARNER if part >= INSIDE => Tone::Good,
                LEARNER => Tone::Bad,
                _ => Tone::Quiet,
            };
            [row, vec![Cell::new(format!("{:.2} %", 100.0 * part), tone)]].concat()
        }));
    };
    for form in Volume::NAMES {
        for kept in all.iter().filter(|kept| kept.form == form) {
            add(&[form, &kept.places.species], &[&kept.places]);
        }
        let of = of_form(all, form);
        if of.len() > 1 {
            add(&[form, "mean"], &of);
        }
    }
    chapter.table(
        "P: means of the growth model. Below: what the others differ from it, with the standard \
         error of the jackknife over trees. P2 is a second sample of the growth model, DT the \
         networks, DT not told the same trees in the open field. Voxels: how many hold a node, which \
         is how far the form is filled. Inside: part of the nodes, where the stump and the stem that \
         reach the form belong to it. Coloured: within 10 %, or beyond by more than two standard \
         errors; inside 99.5 % or more. The paper gives no figures.",
        &header.chain(["inside"]).collect::<Vec<_>>(),
        rows,
    );
}

/// The paper's figure "Form control": a sheet a form, a column a species.
fn pictures(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let mut work = study.verb.model.workspace()?;
    let names: Vec<&str> = study.species.iter().map(|species| species.name.as_str()).collect();
    let sheet =
        Sheet { columns: names.len(), width: study.scale(1600, 1000), row: study.scale(420, 300) };
    chapter.heading("Cone, cube and ring, growth model above networks");
    for (volume, form) in FORMS.iter().zip(Volume::NAMES) {
        let environment = environment(volume);
        let site = Site::new(environment.clone());
        let (mut grown, mut generated) = (Vec::new(), Vec::new());
        for species in &study.species {
            let seed = study.verb.seed;
            grown.push(around::teacher(study, species, seed, &environment)?.0);
            generated.push(around::learner(model, species, seed, &site, &mut work)?.0);
        }
        let all = grown.iter().chain(&generated);
        let shots: Vec<Shot<'_>> = all.map(|tree| Shot::new(tree, View::FRONT)).collect();
        chapter.picture(
            format!(
                "{form}, from left to right {}: the first tree of each set, not picked. The paper's \
                 figure \"Form control\".",
                names.join(", ")
            ),
            sheet.png(&shots)?,
        );
    }
    Ok(())
}

fn save(study: &Study<'_>, all: &[Kept]) -> Result<()> {
    let mut csv = format!("form,species,{}\n", around::CSV);
    for Kept { form, places } in all {
        csv += &around::csv(&format!("{form},{}", places.species), places, &QUANTITIES);
    }
    study.save("forms.csv", csv.as_bytes())?;
    let names = QUANTITIES.map(|quantity| quantity.name);
    let forms: Vec<_> = all
        .iter()
        .map(|Kept { form, places }| {
            let inside = [0, 1, 2, 3].map(|side| inside(&[places], side));
            json!({ "form": form, "inside": inside, "trees": places })
        })
        .collect();
    let json = json!({ "sides": around::SIDES, "samples": names, "forms": forms });
    study.save("forms.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
