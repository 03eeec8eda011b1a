//! Clouds that are given: nothing is known of their trees but the points.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use deeptree_cloud::{ReadOptions, Up};
use deeptree_eval::report::Chapter;
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_graph::{BranchGraph, Vec3};
use deeptree_infer::Model;
use deeptree_mesh::wood;
use deeptree_reconstruct::fit::SAMPLES;
use deeptree_reconstruct::{Figures, Fit, reconstruct, wood_options};
use serde::{Deserialize, Serialize};

use super::{Study, WAYS, cell, options};
use crate::args::UsageError;
use crate::clouds;

/// What is measured of a cloud and one way.
#[derive(Serialize, Deserialize)]
struct Measured {
    cloud: String,
    points: usize,
    way: usize,
    species: String,
    f_1_percent: f64,
    f_5_cm: f64,
    recall: [f64; 2],
    precision: [f64; 2],
    length: f64,
    height: f32,
    dbh: Option<f32>,
    volume: f64,
    seconds: f64,
}

/// Tells how well the trees of the clouds fit.
pub(super) fn say(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let files = files(&study.verb.clouds)?;
    if files.is_empty() {
        chapter.text("No clouds were given (--clouds).");
        return Ok(());
    }
    let (mut all, mut trees) = (Vec::new(), Vec::new());
    for file in &files {
        let cloud = clouds::read(study.args, file, &ReadOptions::default())?.with_up(Up::Y);
        let points: Vec<Vec3> = cloud.points.into_iter().filter(|p| p.is_finite()).collect();
        for way in 0..WAYS.len() {
            let (measured, tree) = measure(file, &points, way, model)?;
            all.push(measured);
            if way == 1 {
                trees.push(tree);
            }
        }
    }
    table(chapter, &all);
    let names: Vec<String> = files.iter().map(|file| name(file)).collect();
    let sheet = Sheet { columns: trees.len().min(4), width: 1200, row: 500 };
    let shots: Vec<Shot<'_>> = trees.iter().map(|tree| Shot::new(tree, View::FRONT)).collect();
    chapter.picture(format!("Made with the networks: {}.", names.join(", ")), sheet.png(&shots)?);
    study.save("reconstruction-clouds.json", serde_json::to_string_pretty(&all)?.as_bytes())
}

fn measure(
    file: &Path,
    points: &[Vec3],
    way: usize,
    model: &Model,
) -> Result<(Measured, BranchGraph)> {
    let start = Instant::now();
    let made = reconstruct(points, &options(way, model))
        .with_context(|| format!("no tree can be made of {}", file.display()))?;
    let seconds = start.elapsed().as_secs_f64();
    let local: Vec<Vec3> = points.iter().map(|&p| p - made.foot).collect();
    let fit = Fit::new(&local, &wood(&made.tree, &wood_options()), SAMPLES);
    let Figures { height, dbh, volume, length, .. } = Figures::of(&made.tree);
    let tolerances = [0.01 * height, 0.05];
    let measured = Measured {
        cloud: name(file),
        points: points.len(),
        way,
        species: made.tree.info.species.clone(),
        f_1_percent: fit.f_score(tolerances[0]),
        f_5_cm: fit.f_score(tolerances[1]),
        recall: tolerances.map(|t| fit.cloud_to_tree.share_within(t)),
        precision: tolerances.map(|t| fit.tree_to_cloud.share_within(t)),
        length,
        height,
        dbh,
        volume,
        seconds,
    };
    Ok((measured, made.tree))
}

fn table(chapter: &mut Chapter, all: &[Measured]) {
    let rows = all.iter().map(|m| {
        let pair = |[a, b]: [f64; 2]| format!("{a:.3}, {b:.3}");
        let texts = [
            m.cloud.clone(),
            m.points.to_string(),
            WAYS[m.way].to_owned(),
            format!("{:.3}", m.f_1_percent),
            format!("{:.3}", m.f_5_cm),
            pair(m.recall),
            pair(m.precision),
            format!("{:.0}", m.length),
            format!("{:.2}", m.height),
            m.dbh.map_or("–".to_owned(), |dbh| format!("{dbh:.3}")),
            format!("{:.3}", m.volume),
            format!("{:.2}", m.seconds),
            m.species.clone(),
        ];
        texts.map(cell).to_vec()
    });
    let header = [
        "cloud",
        "points",
        "way",
        "F 1 %",
        "F 5 cm",
        "recall",
        "precision",
        "length m",
        "height m",
        "DBH m",
        "wood m³",
        "s",
        "like",
    ];
    chapter.table(
        "Clouds that were given. Recall: share of the points within 1 % of the height, and within \
         5 cm, of the surface. Precision: share of the surface, by area, within that of a point. F: \
         their harmonic mean. Seconds are of one thread.",
        &header,
        rows.collect(),
    );
}

fn name(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The files named, and the clouds in the folders named, in the order of their names.
fn files(named: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in named {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let entries = std::fs::read_dir(path)
            .with_context(|| format!("cannot read the folder {}", path.display()))?;
        let mut inside: Vec<PathBuf> =
            entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
        inside.retain(|path| clouds::holds_points(path));
        inside.sort();
        if inside.is_empty() {
            let text = format!("there are no point clouds in the folder {}", path.display());
            return Err(UsageError(text).into());
        }
        files.append(&mut inside);
    }
    Ok(files)
}
