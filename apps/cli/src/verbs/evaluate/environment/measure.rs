//! Trees in random scenes.

use anyhow::Result;
use deeptree_eval::intersections;
use deeptree_graph::{BranchGraph, Seed, Vec3};
use deeptree_growth::Species;
use deeptree_infer::Model;
use deeptree_scene::{BoxShape, Cuboid, Environment, Scene};

use crate::verbs::evaluate::around::{Places, Sample, four, of_any_tree};
use crate::verbs::evaluate::study::Study;
use crate::verbs::evaluate::trees;

/// A node this near to an obstacle is beside it, in metres.
const NEAR: f32 = 2.0;

/// The trees of a species in the scenes of as many seeds.
pub(super) fn places(
    study: &Study<'_>,
    model: &Model,
    species: &Species,
    count: u32,
) -> Result<Places> {
    let name = &species.name;
    study.part(&format!("environment-{name}"), || {
        let what = format!("{name} scenes");
        let places = trees::many(study, &what, study.verb.seed, count, |work, seed| {
            let scene = Scene::random(Seed(seed));
            let environment = Environment { scene, volume: None };
            let of_scene = |tree: &BranchGraph| samples(tree, &environment.scene);
            four(study, model, species, seed, &environment, work, of_scene)
        })?;
        Ok(Places { species: name.clone(), places })
    })
}

/// Nodes, branches, their lengths, offset, share of nodes near an obstacle, intersections.
fn samples(tree: &BranchGraph, scene: &Scene) -> Vec<Sample> {
    let nodes = tree.nodes();
    let count = nodes.len() as f64;
    let sum: Vec3 = nodes.iter().map(|node| node.position).sum();
    let offset = away(scene).map_or(0.0, |away| f64::from(sum.dot(away)) / count);
    let is_near = |p: Vec3| scene.boxes().iter().any(|b| b.nearest(p).distance(p) <= NEAR);
    let near = nodes.iter().filter(|node| is_near(node.position)).count() as f64 / count;
    let mut all = of_any_tree(tree).to_vec();
    all.extend([[offset, 1.0], [near, 1.0], [intersections(tree) as f64, 1.0]]);
    all
}

/// The horizontal direction from the nearest point of the nearest box, as seen from above, to the
/// foot; none without boxes. Random scenes have nothing else.
fn away(scene: &Scene) -> Option<Vec3> {
    let nearest = |cuboid: &Cuboid| {
        let height = match cuboid.shape() {
            BoxShape::Aligned { min, .. } => min.y,
            BoxShape::Turned { center, .. } => center.y,
        };
        // At a height that the box has, its nearest point is that of its plan.
        let place = cuboid.nearest(height * Vec3::Y);
        Vec3::new(place.x, 0.0, place.z)
    };
    let places = scene.boxes().iter().map(nearest);
    let nearest = places.min_by(|a, b| a.length().total_cmp(&b.length()))?;
    (-nearest).try_normalize()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use deeptree_graph::{ChildSignature, Quat, TreeInfo};

    use super::*;

    fn scene(text: &str) -> Scene {
        Scene::parse(text, Path::new("")).unwrap()
    }

    const WALL: &str = "[[box]]\nmin = [3.0, 0.0, -10.0]\nmax = [5.0, 12.0, 10.0]\n";

    #[test]
    fn away_is_from_the_nearest_in_plan_whatever_its_height() {
        assert_eq!(away(&scene(WALL)), Some(Vec3::NEG_X));
        assert_eq!(away(&Scene::default()), None);
        // High up, but nearer in plan: its corner is at (1.5, 2).
        let hung = "[[box]]\nmin = [1.5, 20.0, 2.0]\nmax = [9.0, 21.0, 9.0]\n";
        let found = away(&scene(&format!("{WALL}{hung}"))).unwrap();
        assert!(found.distance(Vec3::new(-0.6, 0.0, -0.8)) < 1e-6, "{found}");
    }

    #[test]
    fn a_tree_beside_a_wall_has_the_samples_worked_out_by_hand() {
        // Up 1 m, then 2 m away from the wall, and from the top 0.5 m towards it.
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let upright = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::Y);
        let to = |way| upright.inverse() * Quat::from_rotation_arc(Vec3::NEG_Z, way);
        let edge = |rotation, length| ChildSignature { rotation, thickness: 0.01, length };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(upright, 1.0));
        let (left, right) = (edge(to(Vec3::NEG_X), 2.0), edge(to(Vec3::X), 1.5));
        tree.grow(0, [None, Some(left), Some(right)]);
        let found = samples(&tree, &scene(WALL));
        // Three nodes; three branches of 1, 2 and 1.5 m; x of 0, −2 and 1.5; one is 1.5 m off.
        let expected = [[3.0, 1.0], [3.0, 1.0], [4.5, 3.0], [0.5 / 3.0, 1.0], [1.0 / 3.0, 1.0]];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found[0] - expected[0]).abs() < 1e-6 && found[1] == expected[1], "{found:?}");
        }
        assert_eq!(found[5], [0.0, 1.0]);
    }
}
