//! Stands of both sides, seen from the front and from above.

use anyhow::{Context, Result};
use deeptree_eval::report::Chapter;
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_graph::BranchGraph;
use deeptree_infer::Model;

use super::measure::{self, SPACINGS};
use crate::verbs::evaluate::study::Study;

/// The stand of 5 m, of the first species and of all.
const NUMBER: u64 = 1;

/// From the front, a little from above.
const OVER: View = View { azimuth: 20.0, elevation: 25.0 };

pub(super) fn stands(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let mut work = study.verb.model.workspace()?;
    chapter.heading("Stands: growth model, networks, and networks that are not told");
    let every: Vec<_> = study.species.iter().collect();
    let mut kinds = vec![(study.species[0].name.as_str(), &every[..1])];
    if every.len() > 1 {
        kinds.push(("all species", &every[..]));
    }
    for (name, species) in kinds {
        let plan = measure::plan(species, study.verb.seed, NUMBER);
        let sides: [Vec<BranchGraph>; 3] = [
            measure::teacher(study, &plan, 0)?,
            measure::learner(model, &plan, &work)?.0,
            measure::untold(model, &plan, &mut work)?,
        ];
        let row = |view| {
            sides.iter().map(move |trees| {
                let (first, beside) = trees.split_first().context("a stand without trees")?;
                Ok(Shot::new(first, view).beside(beside))
            })
        };
        let shots: Vec<Shot<'_>> = row(OVER).chain(row(View::TOP)).collect::<Result<_>>()?;
        let sheet =
            Sheet { columns: 3, width: study.scale(1800, 1200), row: study.scale(640, 420) };
        let caption = format!(
            "{} trees of {name}, {} m apart: the growth model, the networks, and the networks' trees \
             in the open field set side by side; below the same from above.",
            measure::TREES,
            SPACINGS[NUMBER as usize],
        );
        chapter.picture(caption, sheet.png(&shots)?);
    }
    Ok(())
}
