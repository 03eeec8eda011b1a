//! Chapter `reconstruction`: trees made of point clouds, with the networks and without.

mod real;
mod simulated;

use anyhow::Result;
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_infer::Model;
use deeptree_reconstruct::Options;

use super::study::Study;

/// The ways to reconstruct that are compared.
const WAYS: [&str; 4] = ["geometry", "networks", "completed", "hearing points"];

/// How each of them reads a cloud.
fn options(way: usize, model: &Model) -> Options<'_> {
    let prior = (way > 0).then_some(model as _);
    Options { prior, complete: way >= 2, hear: way == 3, ..Options::default() }
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("reconstruction", "From points to trees");
    let Some(model) = &study.model else {
        chapter.text("Only the growth model was measured.");
        return Ok(chapter);
    };
    chapter.text(
        "geometry: without networks (--no-prior). networks: the networks say of which species the \
         tree is, which twigs go on where their points end, and which child of a fork its branch goes \
         on with. hearing points: they also grow branches of which the scanner saw nothing \
         (--complete), and hear the points around each node. completed: the same by networks that \
         hear nothing.",
    );
    real::say(study, model, &mut chapter)?;
    simulated::say(study, model, &mut chapter)?;
    Ok(chapter)
}

/// A number of a table.
fn cell(text: String) -> Cell {
    Cell::new(text, Tone::Plain)
}
