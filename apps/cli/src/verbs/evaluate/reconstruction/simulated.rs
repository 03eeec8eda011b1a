//! Scans of grown trees, as the paper makes them: the true tree is known.

use anyhow::Result;
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_graph::Seed;
use deeptree_growth::Species;
use deeptree_infer::Model;
use deeptree_mesh::{WoodOptions, wood};
use deeptree_reconstruct::fit::{ORDERS, SkeletonFit};
use deeptree_reconstruct::{Figures, reconstruct};
use deeptree_scan::{Pattern, Target, scan};
use serde::{Deserialize, Serialize};

use super::{Study, WAYS, cell, options};
use crate::verbs::evaluate::trees;

/// Trees of each species.
const FULL: u32 = 20;
const QUICK: u32 = 1;

/// What is measured of one scan and one way; errors as parts of the truth.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Measured {
    precision: f64,
    recall: f64,
    recall_of_order: [Option<f64>; ORDERS],
    same_way: f64,
    same_order: f64,
    length: f64,
    height: f64,
    dbh: Option<f64>,
    volume: f64,
    is_species: bool,
}

impl Measured {
    fn f_score(&self) -> f64 {
        let sum = self.precision + self.recall;
        if sum > 0.0 { 2.0 * self.precision * self.recall / sum } else { 0.0 }
    }
}

/// All scans of a species.
#[derive(Serialize, Deserialize)]
struct OfSpecies {
    species: String,
    /// By scan and way.
    scans: Vec<[Measured; WAYS.len()]>,
}

/// Tells how near the trees are to the true ones.
pub(super) fn say(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let count = study.scale(FULL, QUICK).min(study.trees());
    let mut all = Vec::new();
    for species in &study.species {
        all.push(study.part(&format!("reconstruction-{}", species.name), || {
            let what = format!("{} scans", species.name);
            let scans = trees::many(study, &what, study.verb.seed, count, |_, seed| {
                measure(study, model, species, seed)
            })?;
            Ok(OfSpecies { species: species.name.clone(), scans })
        })?);
    }
    table(chapter, &all, count);
    study.save("reconstruction-scans.json", serde_json::to_string_pretty(&all)?.as_bytes())
}

fn measure(
    study: &Study<'_>,
    model: &Model,
    species: &Species,
    seed: u64,
) -> Result<[Measured; WAYS.len()]> {
    let truth = trees::grown(study, species, seed)?.tree;
    let surface = wood(&truth, &WoodOptions::default());
    let cloud = scan(&Target::new(&truth, &surface, &[]), &Pattern::paper(), Seed(seed));
    // The cloud's origin is whole metres beside the tree's foot.
    let [x, y, z] = cloud.origin.map(|c| c as f32);
    let origin = deeptree_graph::Vec3::new(x, y, z);
    let of_truth = Figures::of(&truth);
    let mut measured: [Measured; WAYS.len()] = Default::default();
    for (way, out) in measured.iter_mut().enumerate() {
        let made = reconstruct(&cloud.points, &options(way, model))?;
        let moved = made.tree.clone().moved(made.foot + origin);
        let fit = SkeletonFit::new(&moved, &truth, 0.01 * of_truth.height);
        let figures = Figures::of(&moved);
        let part = |own: f64, of: f64| own / of - 1.0;
        let dbh = figures.dbh.zip(of_truth.dbh);
        *out = Measured {
            precision: fit.precision,
            recall: fit.recall,
            recall_of_order: fit.recall_of_order,
            same_way: fit.same_way,
            same_order: fit.same_order,
            length: part(figures.length, of_truth.length),
            height: part(f64::from(figures.height), f64::from(of_truth.height)),
            dbh: dbh.map(|(own, of)| part(f64::from(own), f64::from(of))),
            volume: part(figures.volume, of_truth.volume),
            is_species: made.tree.info.species == species.name,
        };
    }
    Ok(measured)
}

/// The mean over scans of what some have.
fn mean<'a>(
    scans: impl Iterator<Item = &'a Measured>,
    of: impl Fn(&Measured) -> Option<f64>,
) -> Option<f64> {
    let values: Vec<f64> = scans.filter_map(of).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn table(chapter: &mut Chapter, all: &[OfSpecies], count: u32) {
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut add = |name: &str, of: &[&OfSpecies]| {
        for (way, way_name) in WAYS.iter().enumerate() {
            let scans = || of.iter().flat_map(|of| of.scans.iter().map(move |scan| &scan[way]));
            let share = |of: &dyn Fn(&Measured) -> Option<f64>| {
                cell(mean(scans(), of).map_or("–".to_owned(), |value| format!("{value:.3}")))
            };
            let percent = |of: &dyn Fn(&Measured) -> Option<f64>| {
                let text = |value: f64| format!("{:+.1} %", 100.0 * value);
                cell(mean(scans(), of).map_or("–".to_owned(), text))
            };
            let mut row = vec![cell(name.to_owned()), Cell::new(*way_name, Tone::Quiet)];
            row.push(share(&|m| Some(m.f_score())));
            row.push(share(&|m| Some(m.precision)));
            row.push(share(&|m| Some(m.recall)));
            row.extend((0..ORDERS).map(|order| share(&|m| m.recall_of_order[order])));
            row.push(share(&|m| Some(m.same_way)));
            row.push(share(&|m| Some(m.same_order)));
            row.push(percent(&|m| Some(m.length)));
            row.push(percent(&|m| Some(m.height)));
            row.push(percent(&|m| Some(m.height.abs())));
            row.push(percent(&|m| m.dbh.map(f64::abs)));
            row.push(percent(&|m| Some(m.volume)));
            row.push(percent(&|m| Some(m.volume.abs())));
            row.push(share(&|m| (way > 0).then_some(f64::from(u8::from(m.is_species)))));
            rows.push(row);
        }
    };
    for of in all {
        add(&of.species, &[of]);
    }
    if all.len() > 1 {
        add("all", &all.iter().collect::<Vec<_>>());
    }
    let header = [
        "species",
        "way",
        "F",
        "precision",
        "recall",
        "order 0",
        "1",
        "2",
        "3",
        "4 and more",
        "same way",
        "same order",
        "length",
        "height",
        "|height|",
        "|DBH|",
        "wood",
        "|wood|",
        "recognised",
    ];
    chapter.table(
        format!(
            "Scans of {count} grown trees of each species, each from one place, as the paper makes \
             them. Skeletons are compared by metres of branch within 1 % of the height of one \
             another; recall also by the order of the true branches. Same way, same order: of what \
             is recalled, the share whose way to the foot is as long to within 5 %, and whose order \
             is the same. Then mean errors, and means of their sizes. Recognised: how often the \
             networks chose the true species."
        ),
        &header,
        rows,
    );
}
