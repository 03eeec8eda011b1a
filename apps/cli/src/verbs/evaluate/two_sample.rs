//! Chapter 3: can a classifier tell the learner's trees from the teacher's?

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::report::chart::{
    Colour, Interval, IntervalRow, LEARNER, PAPER, TEACHER, intervals,
};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_eval::tree_features::names;
use deeptree_eval::two_sample::{Options, TwoSample, two_sample};
use deeptree_graph::Seed;
use deeptree_growth::{SPECIES, Species};

use super::measure::Set;
use super::study::{Study, places, short};
use crate::verbs::preset;

/// Trees of each set in a full run.
const TREES: usize = 400;

/// The area that is the first step; the goal is the interval of the teacher against itself.
const FIRST_STEP: f64 = 0.60;

/// Another species, in the charts.
const OTHER: Colour = Colour(0x54, 0xa2, 0x4b);

/// What stands against the teacher's trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Against {
    /// A second sample of the teacher: what no classifier can tell.
    Second,
    /// The learner.
    Learner,
    /// The next species of the teacher: what every classifier can tell.
    Other,
    /// The model of kind `paper`.
    Paper,
}

impl Against {
    const fn symbol(self) -> &'static str {
        match self {
            Self::Second => "P2",
            Self::Learner => "DT",
            Self::Other => "other",
            Self::Paper => "paper",
        }
    }

    const fn colour(self) -> Colour {
        match self {
            Self::Second => TEACHER,
            Self::Learner => LEARNER,
            Self::Other => OTHER,
            Self::Paper => PAPER,
        }
    }
}

/// The tests of one species.
struct Tested {
    species: String,
    /// The species of [`Against::Other`].
    other: String,
    tests: Vec<(Against, TwoSample)>,
}

impl Tested {
    fn get(&self, against: Against) -> Option<&TwoSample> {
        self.tests.iter().find(|(one, _)| *one == against).map(|(_, test)| test)
    }

    /// Is the learner's area within the interval of the teacher against itself?
    fn is_met(&self) -> bool {
        let (learner, second) = (self.get(Against::Learner), self.get(Against::Second));
        learner.zip(second).is_some_and(|(learner, second)| learner.auc.value <= second.auc.high)
    }
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("two-sample", "Two-sample test");
    if !study.compares() {
        chapter.text("Not measured: only one side was asked for.");
        return Ok(chapter);
    }
    let all: Result<Vec<Tested>> = study.species.iter().map(|one| test_all(study, one)).collect();
    let all: Vec<Tested> = all?.into_iter().filter(|one| !one.tests.is_empty()).collect();
    study.save("two-sample.csv", csv(&all).as_bytes())?;
    study.save("two-sample.json", serde_json::to_string_pretty(&json(&all)?)?.as_bytes())?;
    if all.is_empty() {
        chapter.text("Not measured: a fold needs two trees of each set, and there must be two.");
        return Ok(chapter);
    }
    chapter.text(summary(&all));
    chapter.text(format!(
        "A random forest learns from {} features of whole trees which set a tree is of, and scores \
         trees that it has not seen. AUC is the chance that it scores a tree of the one set above \
         one of the other: 0.5 when it cannot tell, 1 when it always can. The first control is a \
         second sample of the teacher, the second the next species. {}",
        names().len(),
        how(&all)
    ));
    chapter.chart(
        "AUC against the teacher's trees with its 95 % interval. Blue: a second sample of the \
         teacher; orange: the learner; green: another species; grey: the kind paper",
        chart(&all)?,
    );
    areas(&all, &mut chapter);
    telltales(&all, &mut chapter);
    Ok(chapter)
}

/// The tests of a species; one with too few trees is left out.
fn test_all(study: &Study<'_>, species: &Species) -> Result<Tested> {
    let next = SPECIES.iter().position(|name| *name == species.name).map_or(0, |at| at + 1);
    let other = preset(SPECIES[next % SPECIES.len()])?;
    let mut list = vec![
        (Against::Second, species, Set::Second),
        (Against::Learner, species, Set::Learner),
        (Against::Other, &other, Set::Teacher),
    ];
    if study.has_paper() {
        list.push((Against::Paper, species, Set::Paper));
    }
    let mut tests = Vec::new();
    for (against, of, set) in list {
        let name =
            format!("two-sample-{}-{}-{}", species.name, against.symbol(), study.verb.refits);
        let test = || test(study, against, species, of, set);
        if let Some(test) = study.part(&name, test)? {
            tests.push((against, test));
        }
    }
    Ok(Tested { species: species.name.clone(), other: other.name, tests })
}

/// The teacher's trees of `species` against a set of `of`; none where there are too few.
fn test(
    study: &Study<'_>,
    against: Against,
    species: &Species,
    of: &Species,
    set: Set,
) -> Result<Option<TwoSample>> {
    let rows = |species, set| -> Result<Vec<Vec<f64>>> {
        let mut rows = study.measured(species, set)?.set.rows();
        rows.truncate(TREES);
        Ok(rows)
    };
    let (teacher, other) = (rows(species, Set::Teacher)?, rows(of, set)?);
    let full = Options::new(Seed(study.verb.seed));
    let folds = full.folds.min(teacher.len().min(other.len()) / 2);
    if folds < 2 {
        return Ok(None);
    }
    let refits = match against {
        Against::Second | Against::Learner => study.verb.refits,
        Against::Other | Against::Paper => 0,
    };
    let options = if study.verb.quick {
        Options { folds, forest_trees: 60, refits: 0, permutations: 199, ..full }
    } else {
        Options { folds, refits, ..full }
    };
    let bar = crate::report::bar(study.args, 2, &format!("{} {}", species.name, against.symbol()));
    bar.set_message("forests");
    let test = two_sample(&teacher, &other, names(), options)?;
    bar.finish_and_clear();
    Ok(Some(test))
}

fn summary(all: &[Tested]) -> String {
    let of = |against| all.iter().filter_map(move |one| one.get(against));
    let range = |against| {
        let areas = || of(against).map(|test| test.auc.value);
        let low = areas().fold(f64::INFINITY, f64::min);
        let high = areas().fold(f64::NEG_INFINITY, f64::max);
        (low, high)
    };
    let (low, high) = range(Against::Learner);
    let (control_low, control_high) = range(Against::Second);
    let below = of(Against::Learner).filter(|test| test.auc.value <= FIRST_STEP).count();
    let met = all.iter().filter(|one| one.is_met()).count();
    let mut text = format!(
        "The AUC of the learner against the teacher is {low:.3} to {high:.3}; of the teacher against \
         itself {control_low:.3} to {control_high:.3}. {met} of {} species are within the interval \
         of the teacher against itself, {below} at {FIRST_STEP:.2} or below.",
        all.len()
    );
    let area = |one: &&Tested| one.get(Against::Learner).map_or(0.0, |test| test.auc.value);
    if let Some(worst) = all.iter().max_by(|a, b| area(a).total_cmp(&area(b)))
        && let Some(telltale) = worst.get(Against::Learner).and_then(|test| test.telltales.first())
    {
        let (species, name) = (&worst.species, &telltale.name);
        let _ = write!(text, " Furthest is {species}, whose first telltale is {name}.");
    }
    text
}

/// How the tests were run, in words.
fn how(all: &[Tested]) -> String {
    let Some(test) = all.iter().find_map(|one| one.get(Against::Learner)) else {
        return String::new();
    };
    let Options { folds, forest_trees, refits, permutations, .. } = test.options;
    let p = if refits > 0 {
        format!(
            "p is the chance of such an area between sets of one law, from {refits} forests fitted \
             to permuted labels, which give the interval its width too"
        )
    } else {
        format!(
            "p is from {permutations} permutations of held-out labels; it takes folds as \
             independent and is somewhat too small"
        )
    };
    format!(
        "{} and {} trees, {folds} folds, {forest_trees} trees a forest; {p}.",
        test.trees[0], test.trees[1]
    )
}

fn chart(all: &[Tested]) -> Result<String> {
    let row = |one: &Tested| IntervalRow {
        name: one.species.clone(),
        intervals: one
            .tests
            .iter()
            .map(|(against, test)| Interval {
                colour: against.colour(),
                value: test.auc.value,
                low: test.auc.low,
                high: test.auc.high,
            })
            .collect(),
    };
    let rows: Vec<IntervalRow> = all.iter().map(row).collect();
    let ends = rows.iter().flat_map(|row| &row.intervals).map(|one| one.low);
    let low = ends.fold(0.4, f64::min);
    Ok(intervals(&rows, (low * 10.0).floor() / 10.0, 1.0, 0.5)?)
}

fn areas(all: &[Tested], chapter: &mut Chapter) {
    let row = |one: &Tested| {
        let area = |against: Against| {
            let Some(test) = one.get(against) else {
                return vec![Cell::new("–", Tone::Quiet); 2];
            };
            let tone = match against {
                Against::Learner if one.is_met() => Tone::Good,
                Against::Learner => Tone::Bad,
                _ => Tone::Quiet,
            };
            let auc = &test.auc;
            let text = format!("{:.3} [{:.3}, {:.3}]", auc.value, auc.low, auc.high);
            let p = test.p_value.unwrap_or(test.held_out_p_value);
            vec![Cell::new(text, tone), Cell::new(chance(p), Tone::Quiet)]
        };
        let species = Cell::from(one.species.as_str());
        let other = Cell::new(one.other.as_str(), Tone::Quiet);
        let mut cells = vec![species];
        cells.extend(area(Against::Second));
        cells.extend(area(Against::Learner));
        cells.extend(area(Against::Other));
        cells.push(other);
        cells.extend(area(Against::Paper));
        cells
    };
    chapter.table(
        "AUC with its 95 % interval; green where the learner is within the interval of the teacher \
         against itself",
        &["species", "P2", "p", "DT", "p", "other", "p", "which", "paper", "p"],
        all.iter().map(row).collect(),
    );
}

fn telltales(all: &[Tested], chapter: &mut Chapter) {
    chapter.heading("What gives the learner away");
    let tests = all.iter().filter_map(|one| Some((&one.species, one.get(Against::Learner)?)));
    for (species, test) in tests {
        let row = |one: &deeptree_eval::two_sample::Telltale| {
            // As many places as the smaller spread that is one needs; features have five.
            let spread = [one.sd_a, one.sd_b].into_iter().filter(|sd| *sd > 1e-9);
            let digits = places(spread.fold(f64::INFINITY, f64::min).min(1e3), 2).min(5);
            let moments = |mean, sd| Cell::from(format!("{mean:.digits$} ± {sd:.digits$}"));
            vec![
                Cell::from(one.name.as_str()),
                Cell::from(format!("{:.1} %", 100.0 * one.importance)),
                moments(one.mean_a, one.sd_a),
                moments(one.mean_b, one.sd_b),
                Cell::from(format!("{:.3}", one.distances.ks)),
                Cell::new(chance(one.distances.ks_p), Tone::Quiet),
            ]
        };
        chapter.table(
            format!(
                "{species}: the features that forests split on most, AUC {:.3}",
                test.auc.value
            ),
            &["feature", "importance", "P", "DT", "KS", "p of KS"],
            test.telltales.iter().map(row).collect(),
        );
    }
}

/// A p-value in words of a table.
fn chance(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { short(p, 2) }
}

fn json(all: &[Tested]) -> Result<serde_json::Value> {
    let mut species = serde_json::Map::new();
    for one in all {
        let mut tests = serde_json::Map::new();
        tests.insert("other_species".to_owned(), one.other.as_str().into());
        for (against, test) in &one.tests {
            tests.insert(against.symbol().to_owned(), serde_json::to_value(test)?);
        }
        species.insert(one.species.clone(), tests.into());
    }
    Ok(species.into())
}

fn csv(all: &[Tested]) -> String {
    let mut out =
        "species,set,trees_P,trees,auc,low,high,p,held_out_p,refits,telltales\n".to_owned();
    for one in all {
        for (against, test) in &one.tests {
            let names: Vec<&str> = test.telltales.iter().map(|one| one.name.as_str()).collect();
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{},{}",
                one.species,
                against.symbol(),
                test.trees[0],
                test.trees[1],
                test.auc.value,
                test.auc.low,
                test.auc.high,
                test.p_value.map_or(String::new(), |p| p.to_string()),
                test.held_out_p_value,
                test.options.refits,
                names.join(" ")
            );
        }
    }
    out
}
