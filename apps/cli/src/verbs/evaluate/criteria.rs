//! What a learner must show: means and standard deviations beyond the sampling error.

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::criteria::{Comparison, MEAN_GOAL, Quantity, SD_GOAL, compare};
use deeptree_eval::jackknife::{CHANCE, Difference};
use deeptree_eval::report::{Cell, Chapter, Tone};

use super::measure::Set;
use super::study::Study;
use super::table::Sets;

/// A statistic of a comparison: its name, its difference, its goal.
type Statistic = (&'static str, fn(&Comparison) -> Difference, f64);

const STATISTICS: [Statistic; 2] =
    [("mean", |one| one.mean, MEAN_GOAL), ("standard deviation", |one| one.sd, SD_GOAL)];

/// All comparisons of a set with the teacher, species by species.
struct Compared {
    set: Set,
    all: Vec<Comparison>,
}

impl Compared {
    fn of(sets: &[Sets], set: Set) -> Self {
        let one = |sets: &Sets| {
            let teacher = sets.get(Set::Teacher)?;
            Some(compare(&sets.species, &teacher.set, &sets.get(set)?.set))
        };
        Self { set, all: sets.iter().filter_map(one).flatten().collect() }
    }

    fn met(&self, of: fn(&Comparison) -> Difference) -> usize {
        self.all.iter().filter(|one| of(one).is_met()).count()
    }

    /// The comparison that is furthest beyond chance.
    fn worst(&self, of: fn(&Comparison) -> Difference) -> Option<&Comparison> {
        let beyond = |one: &&Comparison| of(one).beyond_chance();
        self.all.iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b)))
    }

    fn in_words(&self, (name, of, goal): Statistic) -> String {
        let goal = percent(goal);
        format!("{} of {} {name}s within {goal} %", self.met(of), self.all.len())
    }

    fn table(&self, chapter: &mut Chapter, (name, of, goal): Statistic) {
        let header: Vec<&str> =
            ["species"].into_iter().chain(Quantity::ALL.map(Quantity::symbol)).collect();
        let cell = |one: &Comparison| {
            let difference = of(one);
            let error = percent(difference.error);
            let tone = if difference.is_met() { Tone::Good } else { Tone::Bad };
            Cell::new(format!("{} ({error})", signed_percent(difference.relative)), tone)
        };
        let row = |of_species: &[Comparison]| {
            let species = Cell::from(of_species[0].species.as_str());
            std::iter::once(species).chain(of_species.iter().map(cell)).collect()
        };
        let caption = format!(
            "{} against P, {name}: difference in % (its sampling error, teacher against teacher); \
             green within {} % beyond {CHANCE} errors",
            self.set.symbol(),
            percent(goal)
        );
        chapter.table(caption, &header, self.all.chunks(Quantity::ALL.len()).map(row).collect());
    }
}

/// Writes the part of the chapter, and its files.
pub(super) fn write(study: &Study<'_>, sets: &[Sets], chapter: &mut Chapter) -> Result<()> {
    let learner = Compared::of(sets, Set::Learner);
    let mut others = vec![Compared::of(sets, Set::Second)];
    if study.has_paper() {
        others.push(Compared::of(sets, Set::Paper));
    }
    chapter.text(summary(&learner, &others));
    chapter.heading("Beyond the sampling error");
    chapter.text(
        "Errors are those of leaving out tree after tree (jackknife), of the teacher's trees: nodes \
         of one tree are alike, trees are not. P2 is a second sample of the teacher: it shows how \
         often equal sets pass. NN is children of each node that has any.",
    );
    for compared in std::iter::once(&learner).chain(&others) {
        STATISTICS.into_iter().for_each(|statistic| compared.table(chapter, statistic));
    }
    let all: Vec<&Compared> = std::iter::once(&learner).chain(&others).collect();
    study.save("criteria.csv", csv(&all).as_bytes())?;
    let json: serde_json::Map<String, serde_json::Value> = all
        .iter()
        .map(|one| Ok((one.set.symbol().to_owned(), serde_json::to_value(&one.all)?)))
        .collect::<Result<_>>()?;
    study.save("criteria.json", serde_json::to_string_pretty(&json)?.as_bytes())
}

fn summary(learner: &Compared, others: &[Compared]) -> String {
    let counts = |compared: &Compared| STATISTICS.map(|one| compared.in_words(one)).join(", ");
    let mut text = format!("Beyond the sampling error the learner has {}.", counts(learner));
    for compared in others {
        let who = match compared.set {
            Set::Second => "A second sample of the teacher",
            _ => "The kind paper",
        };
        let _ = write!(text, " {who} has {}.", counts(compared));
    }
    for (name, of, _) in STATISTICS {
        if let Some(worst) = learner.worst(of) {
            let difference = of(worst);
            let _ = write!(
                text,
                " The {name} furthest off is that of {} of {}: {} %, with a sampling error of {} %.",
                worst.quantity,
                worst.species,
                signed_percent(difference.relative),
                percent(difference.error)
            );
        }
    }
    text
}

fn csv(all: &[&Compared]) -> String {
    let mut out = "species,set,quantity,statistic,P,P_error,value,value_error,relative_difference,\
                   error,goal,met\n"
        .to_owned();
    for compared in all {
        for one in &compared.all {
            let (p, x) = (&one.teacher, &one.other);
            let rows = [
                ("mean", p.mean, p.mean_error, x.mean, x.mean_error, one.mean),
                ("sd", p.sd, p.sd_error, x.sd, x.sd_error, one.sd),
            ];
            for (name, p, p_error, x, x_error, difference) in rows {
                let Difference { relative, error, goal } = difference;
                let _ = writeln!(
                    out,
                    "{},{},{},{name},{p},{p_error},{x},{x_error},{relative},{error},{goal},{}",
                    one.species,
                    compared.set.symbol(),
                    one.quantity,
                    difference.is_met()
                );
            }
        }
    }
    out
}

/// A share in per cent, to a digit that tells; a dash where there is none.
fn percent(share: f64) -> String {
    if share.is_finite() { super::study::short(100.0 * share, 2) } else { "–".to_owned() }
}

fn signed_percent(share: f64) -> String {
    if share.is_finite() { format!("{:+.1}", 100.0 * share) } else { "–".to_owned() }
}
