//! Chapter 2: the variables of the perceptual metric, teacher beside learner.

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::perceptual::{CONSTANT, Variable};
use deeptree_eval::published;
use deeptree_eval::report::{Cell, Chapter, Tone};
use serde::Serialize;

use super::measure::{Measured, Set};
use super::study::{Study, short};

/// The variables that are furthest, as many as are listed.
const FURTHEST: usize = 10;

/// One variable of one species and set, beside the teacher's.
#[derive(Clone, Debug, Serialize)]
struct Distance {
    species: String,
    set: &'static str,
    variable: &'static str,
    /// The same for all trees: left out of counts.
    constant: bool,
    samples: u64,
    teacher_mean: f64,
    mean: f64,
    ks: f64,
    /// What two sets of the teacher's exceed in 5 % of all cases.
    ks_limit: f64,
    wasserstein: f64,
    wasserstein_limit: f64,
}

impl Distance {
    fn is_beyond(&self) -> bool {
        self.ks > self.ks_limit
    }

    fn times_limit(&self) -> f64 {
        self.ks / self.ks_limit
    }
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("perceptual", "Perceptual variables");
    if !study.compares() {
        chapter.text("Not measured: only one side was asked for.");
        return Ok(chapter);
    }
    let mut sets = vec![Set::Learner, Set::Second];
    if study.has_paper() {
        sets.push(Set::Paper);
    }
    let mut all = Vec::new();
    for species in &study.species {
        let teacher = study.measured(species, Set::Teacher)?;
        for &set in &sets {
            let other = study.measured(species, set)?;
            all.extend(distances(&species.name, &teacher, set, &other));
        }
    }
    study.save("perceptual.csv", csv(&all).as_bytes())?;
    study.save("perceptual.json", serde_json::to_string_pretty(&all)?.as_bytes())?;
    chapter.text(summary(&all, &sets));
    chapter.text(
        "The paper gives a score of ICTreeF, a network trained on what people said of trees. Its \
         weights are not public, so no score is given here; these are the 46 variables it would \
         have seen, all samples of all trees of a set together. KS is the largest gap between two \
         distribution functions, W1 the area between them. The limit is what two sets of the \
         teacher's trees exceed in 5 % of all cases, from halving the teacher's set at random.",
    );
    counts(study, &all, &sets, &mut chapter);
    furthest(&all, &mut chapter);
    every_variable(study, &all, &mut chapter);
    printed(&mut chapter);
    Ok(chapter)
}

/// The variables of a set beside the teacher's; those without samples are left out.
fn distances(species: &str, teacher: &Measured, set: Set, other: &Measured) -> Vec<Distance> {
    let trees = |measured: &Measured| measured.set.trees.len();
    let of = |variable: Variable| {
        let at = variable as usize;
        let (p, x) = (teacher.perceptual.get(at)?, other.perceptual.get(at)?);
        let [ks, wasserstein] = p.distances(x)?;
        let scatter = teacher.scatter.get(at).copied().flatten()?;
        let [ks_limit, wasserstein_limit] = scatter.limits(trees(teacher), trees(other));
        Some(Distance {
            species: species.to_owned(),
            set: set.symbol(),
            variable: variable.name(),
            constant: CONSTANT.contains(&variable),
            samples: x.samples,
            teacher_mean: p.mean,
            mean: x.mean,
            ks,
            ks_limit,
            wasserstein,
            wasserstein_limit,
        })
    };
    Variable::ALL.into_iter().filter_map(of).collect()
}

/// Those of a set, and of a species where one is named, that count.
fn of_set<'a>(
    all: &'a [Distance],
    set: Set,
    species: Option<&'a str>,
) -> impl Iterator<Item = &'a Distance> {
    all.iter().filter(move |one| {
        one.set == set.symbol() && !one.constant && species.is_none_or(|name| one.species == name)
    })
}

fn summary(all: &[Distance], sets: &[Set]) -> String {
    let mut text = "Beyond the limit of the teacher's own scatter (KS):".to_owned();
    for &set in sets {
        let beyond = of_set(all, set, None).filter(|one| one.is_beyond()).count();
        let count = of_set(all, set, None).count();
        let who = match set {
            Set::Learner => "of the learner",
            Set::Second => "of a second sample of the teacher",
            _ => "of the kind paper",
        };
        let _ = write!(text, " {beyond} of {count} variables {who},");
    }
    text.pop();
    text.push('.');
    let furthest =
        of_set(all, Set::Learner, None).max_by(|a, b| a.times_limit().total_cmp(&b.times_limit()));
    if let Some(one) = furthest {
        let _ = write!(
            text,
            " Furthest is {} of {}: KS {}, {} times the limit.",
            one.variable,
            one.species,
            short(one.ks, 3),
            short(one.times_limit(), 3)
        );
    }
    text
}

/// How many variables of each species are beyond the limits.
fn counts(study: &Study<'_>, all: &[Distance], sets: &[Set], chapter: &mut Chapter) {
    let names: Vec<String> = sets
        .iter()
        .flat_map(|s| ["KS", "W1"].map(|kind| format!("{} {kind}", s.symbol())))
        .collect();
    let header: Vec<&str> =
        ["species"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let row = |species: &str| {
        let count = |set: Set| {
            let of = || of_set(all, set, Some(species));
            let ks = of().filter(|one| one.is_beyond()).count();
            let w1 = of().filter(|one| one.wasserstein > one.wasserstein_limit).count();
            let tone = if set == Set::Learner { Tone::Plain } else { Tone::Quiet };
            [ks, w1].map(|beyond| Cell::new(format!("{beyond} of {}", of().count()), tone))
        };
        std::iter::once(Cell::from(species)).chain(sets.iter().copied().flat_map(count)).collect()
    };
    chapter.table(
        "Variables beyond the limit; 5 % are by chance. The four that are constant by construction \
         are left out",
        &header,
        study.species.iter().map(|species| row(&species.name)).collect(),
    );
}

fn furthest(all: &[Distance], chapter: &mut Chapter) {
    let mut order: Vec<&Distance> = of_set(all, Set::Learner, None).collect();
    order.sort_by(|a, b| b.times_limit().total_cmp(&a.times_limit()));
    let row = |one: &&Distance| {
        let of = |set: Set, what: fn(&Distance) -> f64| {
            let found = of_set(all, set, Some(&one.species)).find(|x| x.variable == one.variable);
            Cell::new(found.map_or("–".to_owned(), |x| short(what(x), 3)), Tone::Quiet)
        };
        let tone = if one.is_beyond() { Tone::Bad } else { Tone::Good };
        vec![
            Cell::from(format!("{} {}", one.species, one.variable)),
            Cell::new(short(one.ks, 3), tone),
            Cell::new(short(one.ks_limit, 3), Tone::Quiet),
            of(Set::Second, |x| x.ks),
            of(Set::Paper, |x| x.ks),
            Cell::from(short(one.wasserstein, 3)),
            of(Set::Second, |x| x.wasserstein),
            Cell::from(short(one.teacher_mean, 3)),
            Cell::from(short(one.mean, 3)),
        ]
    };
    chapter.table(
        "The variables furthest beyond the limit",
        &["", "KS", "limit", "KS P2", "KS paper", "W1", "W1 P2", "mean P", "mean DT"],
        order.iter().take(FURTHEST).map(row).collect(),
    );
}

fn every_variable(study: &Study<'_>, all: &[Distance], chapter: &mut Chapter) {
    let names: Vec<&str> = study.species.iter().map(|species| species.name.as_str()).collect();
    let header: Vec<&str> = ["variable"].into_iter().chain(names.iter().copied()).collect();
    let row = |variable: Variable| {
        let cell = |species: &&str| {
            let set = |set: Set| {
                let mut of = all.iter().filter(move |one| one.set == set.symbol());
                of.find(|one| one.species == *species && one.variable == variable.name())
            };
            let (Some(one), Some(control)) = (set(Set::Learner), set(Set::Second)) else {
                return Cell::new("–", Tone::Quiet);
            };
            let tone = match one {
                one if one.constant => Tone::Quiet,
                one if one.is_beyond() => Tone::Bad,
                _ => Tone::Good,
            };
            Cell::new(format!("{:.3} ({:.3})", one.ks, control.ks), tone)
        };
        std::iter::once(Cell::from(variable.name())).chain(names.iter().map(cell)).collect()
    };
    chapter.table(
        "KS distance of the learner to the teacher (of a second sample of the teacher); red beyond \
         the limit, grey constant by construction. Distances W1, means and limits are in \
         perceptual.csv",
        &header,
        Variable::ALL.into_iter().map(row).collect(),
    );
}

fn printed(chapter: &mut Chapter) {
    let pair = |(mean, sd): (f64, f64)| Cell::new(format!("{mean:.2} ± {sd:.2}"), Tone::Quiet);
    let row = |row: &published::PerceptualRow| {
        vec![Cell::new(row.0, Tone::Quiet), pair(row.1), pair(row.2)]
    };
    chapter.table(
        "Published: ICTree scores of the paper's procedural trees and of its networks', for \
         reference",
        &["species", "P", "DT"],
        published::PERCEPTUAL.iter().map(row).collect(),
    );
}

fn csv(all: &[Distance]) -> String {
    let mut out = "species,set,variable,constant,samples,P_mean,mean,ks,ks_limit,wasserstein,\
                   wasserstein_limit\n"
        .to_owned();
    for one in all {
        let Distance { species, set, variable, constant, samples, teacher_mean, mean, .. } = one;
        let Distance { ks, ks_limit, wasserstein, wasserstein_limit, .. } = one;
        let _ = writeln!(
            out,
            "{species},{set},{variable},{constant},{samples},{teacher_mean},{mean},{ks},{ks_limit},\
             {wasserstein},{wasserstein_limit}"
        );
    }
    out
}
