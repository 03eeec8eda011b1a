//! The paper's figure of environmental response: walls, growth model above networks.

use anyhow::Result;
use deeptree_eval::report::Chapter;
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_graph::{BranchGraph, Vec3};
use deeptree_growth::Species;
use deeptree_infer::{Model, Workspace};
use deeptree_scene::{BoxShape, Cuboid, Environment, Scene, Site};

use crate::verbs::evaluate::around::{learner, teacher};
use crate::verbs::evaluate::study::Study;

/// How far the walls stand from the foot, in metres.
const DISTANCES: [f32; 4] = [2.0, 4.0, 6.0, 10.0];

/// Distance of the two walls of an L, in metres.
const CORNER: f32 = 3.0;

/// Thickness, height and half of the width of a wall, in metres.
const WALL: [f32; 3] = [2.0, 16.0, 8.0];

/// A wall on the right of the tree.
fn right(distance: f32) -> BoxShape {
    let [thickness, height, half] = WALL;
    let min = Vec3::new(distance, 0.0, -half);
    BoxShape::Aligned { min, max: Vec3::new(distance + thickness, height, half) }
}

/// A wall on the right and one behind, which meet behind on the right.
fn two_walls() -> [BoxShape; 2] {
    let ([thickness, height, half], near) = (WALL, CORNER);
    let far = near + thickness;
    let behind = [Vec3::new(-half, 0.0, -far), Vec3::new(far, height, -near)];
    let right = [Vec3::new(near, 0.0, -near), Vec3::new(far, height, half)];
    [behind, right].map(|[min, max]| BoxShape::Aligned { min, max })
}

fn environment(shapes: &[BoxShape]) -> Result<Environment> {
    let boxes = shapes.iter().map(|&shape| Cuboid::new(shape)).collect::<Result<_, _>>()?;
    Ok(Environment { scene: Scene::new(boxes, Vec::new())?, volume: None })
}

/// Both sides' tree of the first seed.
fn both(
    study: &Study<'_>,
    model: &Model,
    species: &Species,
    environment: &Environment,
    work: &mut Workspace,
) -> Result<[BranchGraph; 2]> {
    let seed = study.verb.seed;
    let (grown, _) = teacher(study, species, seed, environment)?;
    let (generated, ..) = learner(model, species, seed, &Site::new(environment.clone()), work)?;
    Ok([grown, generated])
}

fn corners(environment: &Environment) -> Vec<[Vec3; 8]> {
    environment.scene.boxes().iter().map(Cuboid::corners).collect()
}

/// Walls at several distances, a sheet a species.
pub(super) fn walls(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let mut work = study.verb.model.workspace()?;
    chapter.heading("A wall at several distances, growth model above networks");
    let mut places = vec![environment(&[])?];
    for distance in DISTANCES.into_iter().rev() {
        places.push(environment(&[right(distance)])?);
    }
    let boxes: Vec<Vec<[Vec3; 8]>> = places.iter().map(corners).collect();
    let sheet = sheet(study, places.len());
    for species in study.species.iter().take(study.scale(u32::MAX, 1) as usize) {
        let trees = places
            .iter()
            .map(|place| both(study, model, species, place, &mut work))
            .collect::<Result<Vec<_>>>()?;
        let row = |side: usize| {
            trees
                .iter()
                .zip(&boxes)
                .map(move |(trees, boxes)| Shot::new(&trees[side], View::FRONT).among(boxes))
        };
        let shots: Vec<Shot<'_>> = row(0).chain(row(1)).collect();
        let caption = format!(
            "{}, the first tree of the set, not picked: in the open field, and beside a wall {} m \
             away. The paper's figure \"Modeling with environmental sensitivity\".",
            species.name,
            DISTANCES
                .map(|distance| distance.to_string())
                .into_iter()
                .rev()
                .collect::<Vec<_>>()
                .join(", "),
        );
        chapter.picture(caption, sheet.png(&shots)?);
    }
    Ok(())
}

/// An L of two walls, from the front and from above, a column a species.
pub(super) fn corner(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let mut work = study.verb.model.workspace()?;
    let place = environment(&two_walls())?;
    let boxes = corners(&place);
    let trees = study
        .species
        .iter()
        .map(|species| both(study, model, species, &place, &mut work))
        .collect::<Result<Vec<_>>>()?;
    let rows = [(0, View::FRONT), (1, View::FRONT), (0, View::TOP), (1, View::TOP)];
    let row = |(side, view): (usize, View)| {
        trees.iter().map(move |trees| (&trees[side], view)).collect::<Vec<_>>()
    };
    let shots: Vec<Shot<'_>> = rows
        .into_iter()
        .flat_map(row)
        .map(|(tree, view)| Shot::new(tree, view).among(&boxes))
        .collect();
    let names: Vec<&str> = study.species.iter().map(|species| species.name.as_str()).collect();
    chapter.heading("Walls on two sides");
    chapter.picture(
        format!(
            "From left to right {}, with walls {CORNER} m behind and {CORNER} m on the right: the \
             growth model and the networks from the front, and both from above.",
            names.join(", ")
        ),
        sheet(study, trees.len()).png(&shots)?,
    );
    Ok(())
}

fn sheet(study: &Study<'_>, columns: usize) -> Sheet {
    Sheet { columns, width: study.scale(1600, 1000), row: study.scale(420, 300) }
}
