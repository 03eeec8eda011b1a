//! Chapter 4: does the learner repeat the trees it was trained on?

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::histogram::Histogram;
use deeptree_eval::memorisation::{Memorisation, Nearest};
use deeptree_eval::report::chart::{LEARNER, PAPER, Panel, Series, TEACHER, histograms};
use deeptree_eval::report::{Cell, Chapter, Tone};

use super::measure::Set;
use super::study::Study;

/// Panels in a row of the chart.
const COLUMNS: usize = 4;

/// Bins of a panel.
const BINS: usize = 24;

/// Standard errors that a share may be above that of the teacher's fresh trees.
const CHANCE: f64 = 3.0;

/// The distances of one species.
struct Found {
    species: String,
    learner: Memorisation,
    paper: Option<Memorisation>,
}

impl Found {
    /// Are no more of the learner's trees near to training trees than fresh trees are?
    ///
    /// The share of 5 % and its limit come from samples of both sets: their errors add up.
    fn is_met(&self) -> bool {
        let [n, m] = [&self.learner.generated, &self.learner.teacher].map(|set| set.trees as f64);
        let error = (0.05 * 0.95 * (1.0 / n + 1.0 / m)).sqrt();
        self.learner.share_below_q05 <= 0.05 + CHANCE * error
    }
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("memorisation", "Memorisation");
    if !study.compares() {
        chapter.text("Not measured: only one side was asked for.");
        return Ok(chapter);
    }
    let mut all = Vec::new();
    for species in &study.species {
        let rows = |set| Ok::<_, anyhow::Error>(study.measured(species, set)?.set.rows());
        let (training, teacher) = (rows(Set::Training)?, rows(Set::Teacher)?);
        let of = |set| Ok::<_, anyhow::Error>(Memorisation::of(&training, &rows(set)?, &teacher));
        let paper = if study.has_paper() { of(Set::Paper)? } else { None };
        let Some(learner) = of(Set::Learner)? else { continue };
        all.push(Found { species: species.name.clone(), learner, paper });
    }
    study.save("memorisation.csv", csv(&all).as_bytes())?;
    study.save("memorisation.json", serde_json::to_string_pretty(&json(&all))?.as_bytes())?;
    chapter.text(summary(&all));
    let trees = Set::Training.trees(study);
    chapter.text(format!(
        "The distance of two trees is the root of the mean square difference of their features, each \
         in standard deviations of the training trees. The training trees are the {trees} of each \
         species with the seeds from 0 on, as in the corpus of the models that ship; a model trained \
         on other trees has to be judged by those. A model that copies is nearer to them than fresh \
         trees of the teacher are; one whose trees are of another kind is further off."
    ));
    if overlaps(study) {
        chapter.text(
            "The seeds of this run are among those of the corpus: the chapter means nothing.",
        );
    }
    if !all.is_empty() {
        chapter.chart(
            "Distance to the nearest training tree. Filled: fresh trees of the teacher; orange: the \
             learner; grey: the kind paper",
            histograms(&all.iter().map(panel).collect::<Vec<_>>(), COLUMNS)?,
        );
    }
    table(&all, &mut chapter);
    Ok(chapter)
}

/// Are trees that should be fresh those of the corpus?
fn overlaps(study: &Study<'_>) -> bool {
    Set::Teacher.first_seed(study) < u64::from(Set::Training.trees(study))
}

fn summary(all: &[Found]) -> String {
    let met = all.iter().filter(|one| one.is_met()).count();
    let (mut near, mut trees) = (0.0, 0.0);
    for Found { learner, .. } in all {
        near += learner.share_below_q05 * learner.generated.trees as f64;
        trees += learner.generated.trees as f64;
    }
    let mut text = format!(
        "{:.1} % of the generated trees are nearer to a training tree than 95 % of the teacher's \
         fresh trees are (5 % if alike); in {met} of {} species no more than chance allows.",
        100.0 * near / trees,
        all.len()
    );
    let closest = all.iter().min_by(|a, b| {
        let min = |one: &Found| one.learner.generated.min;
        min(a).total_cmp(&min(b))
    });
    if let Some(Found { species, learner, .. }) = closest {
        let _ = write!(
            text,
            " The nearest of all is a {species} at {:.2} standard deviations of its training tree; of \
             the teacher's fresh trees of that species the nearest is at {:.2}.",
            learner.generated.min, learner.teacher.min
        );
    }
    text
}

fn panel(found: &Found) -> Panel {
    let Memorisation { teacher_distances, generated_distances, teacher, generated, .. } =
        &found.learner;
    let low = teacher.min.min(generated.min);
    let high = 1.15 * teacher.q95.max(generated.q95);
    let width = (high - low).max(1e-9) / BINS as f64;
    let series = |colour, distances: &[f64]| {
        let mut histogram = Histogram::new(width);
        distances.iter().filter(|x| **x >= low).for_each(|x| histogram.add(x - low));
        Series { colour, shares: histogram.shares(0, 1, BINS) }
    };
    let mut all = vec![series(TEACHER, teacher_distances)];
    if let Some(paper) = &found.paper {
        all.push(series(PAPER, &paper.generated_distances));
    }
    all.push(series(LEARNER, generated_distances));
    Panel { title: found.species.clone(), low, high, series: all }
}

fn table(all: &[Found], chapter: &mut Chapter) {
    let row = |found: &Found| {
        let Memorisation {
            generated, teacher, training, share_below_q05, share_below_median, ..
        } = &found.learner;
        let tone = if found.is_met() { Tone::Good } else { Tone::Bad };
        let number = |x: f64| Cell::from(format!("{x:.2}"));
        let share = |x: f64| format!("{:.1} %", 100.0 * x);
        let quiet = |x: f64| Cell::new(format!("{x:.2}"), Tone::Quiet);
        let paper = found.paper.as_ref();
        vec![
            Cell::from(found.species.as_str()),
            number(generated.min),
            number(teacher.min),
            number(generated.median),
            number(teacher.median),
            quiet(training.median),
            Cell::new(share(*share_below_q05), tone),
            Cell::from(share(*share_below_median)),
            paper.map_or(Cell::new("–", Tone::Quiet), |paper| quiet(paper.generated.median)),
        ]
    };
    chapter.table(
        "Distance to the nearest training tree; the shares are of generated trees nearer than 5 % and \
         than 50 % of the teacher's fresh trees",
        &[
            "species",
            "DT nearest",
            "P nearest",
            "DT median",
            "P median",
            "training median",
            "below 5 %",
            "below 50 %",
            "paper median",
        ],
        all.iter().map(row).collect(),
    );
}

fn json(all: &[Found]) -> serde_json::Value {
    let of = |one: &Found| serde_json::json!({ "species": one.species, "DT": one.learner, "paper": one.paper });
    all.iter().map(of).collect()
}

fn csv(all: &[Found]) -> String {
    let mut out = "species,set,trees,min,q05,q25,median,q75,q95\n".to_owned();
    for Found { species, learner, paper } in all {
        let of = &learner;
        let mut sets = vec![("DT", &of.generated), ("P", &of.teacher), ("train", &of.training)];
        sets.extend(paper.as_ref().map(|paper| ("paper", &paper.generated)));
        for (set, Nearest { trees, min, q05, q25, median, q75, q95 }) in sets {
            let _ = writeln!(out, "{species},{set},{trees},{min},{q05},{q25},{median},{q75},{q95}");
        }
    }
    out
}
