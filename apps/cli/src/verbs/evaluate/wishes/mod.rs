//! Chapter: what comes of a wish, and of a species between species.

mod blends;
mod controls;
mod show;

use anyhow::Result;
use deeptree_eval::report::Chapter;
use deeptree_infer::ModelKind;
use serde_json::json;

use super::study::Study;

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("wishes", "Wishes and blends");
    let Some(model) = &study.model else {
        chapter.text("Not measured: only the growth model was asked for, which grants no wishes.");
        return Ok(chapter);
    };
    if model.kind() != ModelKind::Situated {
        chapter.text(format!(
            "Not measured: the networks of kind {} read nothing of the whole tree that could be \
             asked for, and cannot be blended.",
            model.kind()
        ));
        return Ok(chapter);
    }
    let mut species = Vec::new();
    for one in &study.species {
        species.push(controls::measure(study, model, &one.name)?);
    }
    show::controls(study, model, &mut chapter, &species)?;
    let blends = blends::measure(study)?;
    show::blends(study, &mut chapter, &blends)?;
    study.save("wishes.csv", show::csv(&species, &blends).as_bytes())?;
    let json = json!({ "species": species, "blends": blends });
    study.save("wishes.json", serde_json::to_string_pretty(&json)?.as_bytes())?;
    Ok(chapter)
}
