//! Do the trees end by themselves?

use anyhow::Result;
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_generate::DEFAULT_BUDGET;
use deeptree_growth::Species;
use deeptree_infer::Model;
use serde::{Deserialize, Serialize};

use super::measure::{Set, generated};
use super::study::Study;
use super::table::Sets;
use crate::{batch, report};

/// Trees of a species that were asked to end.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Ends {
    trees: u64,
    hit_budget: u64,
}

/// Writes the part of the chapter.
pub(super) fn write(study: &Study<'_>, sets: &[Sets], chapter: &mut Chapter) -> Result<()> {
    let Some(model) = &study.model else { return Ok(()) };
    chapter.heading("Termination");
    let mut rows = Vec::new();
    let mut sum = Ends { trees: 0, hit_budget: 0 };
    for (species, sets) in study.species.iter().zip(sets) {
        // Where kind paper itself is judged, its set says enough: most trees run into the budget.
        let fresh = if study.has_paper() { Some(fresh(study, model, species)?) } else { None };
        let of_set = |set| {
            let trees = &sets.get(set)?.set;
            Some(Ends { trees: trees.trees.len() as u64, hit_budget: trees.hit_budget() as u64 })
        };
        let paper = of_set(Set::Paper);
        let Some(learner) = of_set(Set::Learner) else { continue };
        let add = |a: Ends, b: Ends| Ends {
            trees: a.trees + b.trees,
            hit_budget: a.hit_budget + b.hit_budget,
        };
        let learner = fresh.into_iter().fold(learner, add);
        sum = add(sum, learner);
        let goal = if learner.hit_budget == 0 { Tone::Good } else { Tone::Bad };
        let ended = |ends: Ends| format!("{} of {}", ends.trees - ends.hit_budget, ends.trees);
        rows.push(vec![
            Cell::from(species.name.as_str()),
            Cell::new(ended(learner), goal),
            paper.map_or(Cell::new("–", Tone::Quiet), |paper| Cell::from(ended(paper))),
        ]);
    }
    chapter.text(format!(
        "{} of {} trees of the learner ended by themselves, {} were cut off at {DEFAULT_BUDGET} nodes.",
        sum.trees - sum.hit_budget,
        sum.trees,
        sum.hit_budget
    ));
    chapter.table("Trees that ended by themselves", &["species", "DT", "paper"], rows);
    Ok(())
}

/// Trees of seeds after those of the sets.
fn fresh(study: &Study<'_>, model: &Model, species: &Species) -> Result<Ends> {
    let trees = u64::from(study.scale(1000, study.trees()));
    study.part(&format!("ends-{}", species.name), || {
        let mut ends = Ends { trees, hit_budget: 0 };
        let bar = report::bar(study.args, trees, &format!("{} ends", species.name));
        batch::make(
            study.verb.seed.wrapping_add(u64::from(study.trees())),
            trees,
            || study.verb.model.workspace(),
            |work, seed| Ok(generated(model, &species.name, seed, work)?.1),
            |_, hit_budget, _| {
                ends.hit_budget += u64::from(hit_budget);
                bar.inc(1);
                Ok(())
            },
        )?;
        bar.finish_and_clear();
        Ok(ends)
    })
}
