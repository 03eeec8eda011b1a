//! Chapter 10: how different the trees of a species are, in pictures and in a number.

use anyhow::Result;
use deeptree_eval::diversity::{Spread, Yardstick};
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_eval::tree_features::{self, tree_features};
use deeptree_graph::BranchGraph;
use deeptree_growth::Species;
use deeptree_infer::Model;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::measure::Set;
use super::study::Study;
use super::trees;

/// Trees of the sets whose spread is measured.
const FULL: u32 = 200;
const QUICK: u32 = 12;

/// The sides of a tree, in degrees around it.
const SIDES: [f32; 4] = [0.0, 90.0, 180.0, 270.0];

/// How far apart two trees of a species are on average.
#[derive(Serialize, Deserialize)]
struct Diversity {
    species: String,
    trees: u32,
    p: Spread,
    dt: Option<Spread>,
    /// Of the shipped model of kind `paper`, where it is not the one that is judged.
    paper: Option<Paper>,
}

/// How far apart trees of kind `paper` are.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Paper {
    trees: u32,
    /// Those that their budget cut short.
    cut: u32,
    spread: Spread,
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("diversity", "Diversity");
    let rows: Vec<Diversity> =
        study.species.iter().map(|species| measure(study, species)).collect::<Result<_>>()?;
    say(&mut chapter, &rows);
    save(study, &rows)?;
    eight_species(study, &mut chapter)?;
    if let Some(model) = &study.model {
        random_sampling(study, model, &mut chapter)?;
        viewpoints(study, model, &mut chapter)?;
    }
    Ok(chapter)
}

/// The mean distance between two trees, of the growth model and of the networks, on a yardstick of
/// grown trees that are in neither set.
fn measure(study: &Study<'_>, species: &Species) -> Result<Diversity> {
    let name = &species.name;
    study.part(&format!("diversity-{name}"), || {
        let count = study.scale(FULL, QUICK).min(study.trees()).max(2);
        let first = study.verb.seed;
        let apart = first.wrapping_add(u64::from(study.trees().max(count)));
        let grown = |first| {
            trees::many(study, &format!("{name} P"), first, count, |_, seed| {
                Ok(tree_features(&trees::grown(study, species, seed)?.tree))
            })
        };
        let yardstick = Yardstick::of(&grown(apart)?);
        let p = yardstick.spread(&grown(first)?);
        let mut dt = None;
        if let Some(model) = &study.model {
            let rows = trees::many(study, &format!("{name} DT"), first, count, |work, seed| {
                Ok(tree_features(&trees::generated(model, name, seed, work)?.tree))
            })?;
            dt = Some(yardstick.spread(&rows));
        }
        let mut paper = None;
        if let Some(model) = &study.paper {
            let count = Set::Paper.trees(study).min(count).max(2);
            let rows = trees::many(study, &format!("{name} paper"), first, count, |work, seed| {
                let grown = trees::generated(model, name, seed, work)?;
                Ok((tree_features(&grown.tree), grown.hit_budget))
            })?;
            let cut = rows.iter().filter(|row| row.1).count() as u32;
            let rows: Vec<_> = rows.into_iter().map(|row| row.0).collect();
            paper = Some(Paper { trees: count, cut, spread: yardstick.spread(&rows) });
        }
        Ok(Diversity { species: name.clone(), trees: count, p, dt, paper })
    })
}

fn say(chapter: &mut Chapter, rows: &[Diversity]) {
    let ratio = |row: &Diversity| row.dt.map(|dt| dt.mean / row.p.mean);
    let mut ratios: Vec<(&str, f64)> =
        rows.iter().filter_map(|row| Some((row.species.as_str(), ratio(row)?))).collect();
    ratios.sort_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some(least), Some(most)) = (ratios.first(), ratios.last()) {
        let mean = ratios.iter().map(|(_, ratio)| ratio).sum::<f64>() / ratios.len() as f64;
        chapter.text(format!(
            "Two generated trees of a species are {mean:.2} times as far apart as two grown ones \
             (mean of {} species; {} {:.2} to {} {:.2}): below 1 the networks would repeat \
             themselves, above 1 they scatter more than their teacher.",
            ratios.len(),
            least.0,
            least.1,
            most.0,
            most.1,
        ));
    } else {
        chapter.text("Only the growth model was measured.");
    }
    let cells = |row: &Diversity| {
        let spread = |spread: Spread| format!("{:.3} ± {:.3}", spread.mean, spread.error);
        let (mut dt, mut by) = (Cell::from("–"), Cell::from("–"));
        if let Some(found) = row.dt {
            dt = spread(found).into();
            let ratio = found.mean / row.p.mean;
            let error = (found.error / found.mean).hypot(row.p.error / row.p.mean) * ratio;
            let tone = if (ratio - 1.0).abs() <= 2.0 * error { Tone::Good } else { Tone::Bad };
            by = Cell::new(format!("{ratio:.3} ± {error:.3}"), tone);
        }
        let p = Cell::new(spread(row.p), Tone::Quiet);
        let paper = row.paper.map_or("–".to_owned(), |paper| spread(paper.spread));
        let paper = Cell::new(paper, Tone::Quiet);
        vec![row.species.as_str().into(), row.trees.to_string().into(), p, dt, by, paper]
    };
    chapter.table(
        format!(
            "Mean distance between two trees of a set: {} features of each tree in standard \
             deviations of grown trees that are in neither set, root mean square over √2, so that \
             1 is what the growth model has by itself; ± is a standard error. Coloured: the ratio \
             is within two standard errors of 1, or not.{}",
            tree_features::names().len(),
            kind_paper(rows),
        ),
        &["species", "trees", "growth model", "networks", "ratio", "kind paper"],
        rows.iter().map(cells).collect(),
    );
}

/// What the caption says of kind `paper`.
fn kind_paper(rows: &[Diversity]) -> String {
    let all: Vec<Paper> = rows.iter().filter_map(|row| row.paper).collect();
    let sum = |of: fn(&Paper) -> u32| all.iter().map(of).sum::<u32>();
    if all.is_empty() {
        return String::new();
    }
    let (cut, trees) = (sum(|paper| paper.cut), sum(|paper| paper.trees));
    format!(" Of the kind paper {cut} of {trees} trees were cut short by their node budget.")
}

fn save(study: &Study<'_>, rows: &[Diversity]) -> Result<()> {
    let mut csv = String::from("species,set,trees,mean_distance,standard_error\n");
    for row in rows {
        let of = |spread: Option<Spread>| spread.map(|spread| (row.trees, spread));
        let paper = row.paper.map(|paper| (paper.trees, paper.spread));
        for (set, found) in [("P", of(Some(row.p))), ("DT", of(row.dt)), ("paper", paper)] {
            let Some((trees, Spread { mean, error })) = found else { continue };
            csv += &format!("{},{set},{trees},{mean},{error}\n", row.species);
        }
    }
    study.save("diversity.csv", csv.as_bytes())?;
    study.save("diversity.json", serde_json::to_string_pretty(&json!({ "rows": rows }))?.as_bytes())
}

/// The figure of the eight species: growth model above, networks below.
fn eight_species(study: &Study<'_>, chapter: &mut Chapter) -> Result<()> {
    let seed = study.verb.seed;
    let mut work = study.verb.model.workspace()?;
    let mut all: Vec<BranchGraph> = Vec::new();
    for species in &study.species {
        all.push(trees::grown(study, species, seed)?.tree);
    }
    for species in study.species.iter().filter(|_| study.model.is_some()) {
        if let Some(model) = &study.model {
            all.push(trees::generated(model, &species.name, seed, &mut work)?.tree);
        }
    }
    let shots: Vec<Shot<'_>> = all.iter().map(|tree| Shot::new(tree, View::FRONT)).collect();
    chapter.heading("Tree species, growth model above networks");
    chapter.picture(
        format!(
            "From left to right {}; the first tree of each set, not picked, all on one scale. The \
             paper's figure \"Eight different tree species\".",
            names(study)
        ),
        sheet(study, study.species.len()).png(&shots)?,
    );
    Ok(())
}

/// The figure of random sampling, a sheet for each species.
fn random_sampling(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let count = study.scale(8, 5);
    chapter.heading("Random sampling");
    for species in &study.species {
        let name = &species.name;
        let sample = trees::many(study, name, study.verb.seed, count, |work, seed| {
            Ok(trees::generated(model, name, seed, work)?.tree)
        })?;
        let row = |view| sample.iter().map(move |tree| Shot::new(tree, view));
        let shots: Vec<Shot<'_>> = row(View::FRONT).chain(row(View::TOP)).collect();
        let caption = format!(
            "{name}: the first {count} trees of the networks, from the front and from above."
        );
        chapter.picture(caption, sheet(study, sample.len()).png(&shots)?);
    }
    Ok(())
}

/// The figure of different viewpoints: a column a species, a row a side.
fn viewpoints(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let mut work = study.verb.model.workspace()?;
    let mut all = Vec::new();
    for species in &study.species {
        // Not the tree of the figure of the species.
        let seed = study.verb.seed.wrapping_add(1);
        all.push(trees::generated(model, &species.name, seed, &mut work)?.tree);
    }
    let views = SIDES.map(|azimuth| View { azimuth, elevation: 0.0 });
    let shots: Vec<Shot<'_>> =
        views.iter().flat_map(|&view| all.iter().map(move |tree| Shot::new(tree, view))).collect();
    chapter.heading("Different viewpoints");
    chapter.picture(
        format!(
            "One tree of the networks a species ({}), a column each, from four sides: the front, \
             the right, the back and the left.",
            names(study)
        ),
        sheet(study, study.species.len()).png(&shots)?,
    );
    Ok(())
}

fn sheet(study: &Study<'_>, columns: usize) -> Sheet {
    Sheet { columns, width: study.scale(1600, 1000), row: study.scale(420, 300) }
}

fn names(study: &Study<'_>) -> String {
    let names: Vec<&str> = study.species.iter().map(|species| species.name.as_str()).collect();
    names.join(", ")
}
