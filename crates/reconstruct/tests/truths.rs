//! What is known of trees before they are reconstructed.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_graph::{BranchGraph, Quat, Seed, Vec3};
use deeptree_growth::{Profile, Species, grow};
use deeptree_infer::Model;
use deeptree_mesh::{WoodOptions, wood};
use deeptree_reconstruct::fit::{SkeletonFit, Surface};
use deeptree_reconstruct::{
    Figures, Fit, Options, ReconstructError, Reconstruction, placed, reconstruct, wood_options,
};

fn model() -> Model {
    Model::from_bytes(include_bytes!("../../../models/situated.safetensors")).unwrap()
}

fn tree(species: &str) -> BranchGraph {
    let preset = Species::named(species).unwrap();
    grow(species, preset.parameters(Profile::Reference), Seed(5)).unwrap().tree
}

/// Points on the surface of a tree.
fn cloud(tree: &BranchGraph, points: usize) -> Vec<Vec3> {
    Surface::new(&wood(tree, &WoodOptions::default())).samples(points)
}

fn made(cloud: &[Vec3]) -> Reconstruction {
    reconstruct(cloud, &Options::default()).unwrap()
}

fn assert_sound(made: &Reconstruction) {
    for node in made.tree.nodes() {
        assert!(node.position.is_finite() && node.orientation.is_finite());
        assert!(node.thickness > 0.0 && node.thickness.is_finite(), "{}", node.thickness);
        if let Some(parent) = node.parent {
            assert!(node.thickness <= made.tree.node(parent).thickness * 1.000_001);
        }
    }
}

#[test]
fn a_tree_whose_whole_surface_is_seen_comes_back() {
    for species in ["oak", "pine"] {
        let truth = tree(species);
        let points = cloud(&truth, 40_000);
        let made = made(&points);
        assert_sound(&made);
        let height = Figures::of(&truth).height;
        let moved = made.tree.clone().moved(made.foot);
        let skeletons = SkeletonFit::new(&moved, &truth, 0.01 * height);
        assert!(skeletons.precision > 0.93 && skeletons.recall > 0.85, "{species}: {skeletons:?}");
        let fit = Fit::new(&points, &wood(&moved, &wood_options()), 20_000);
        assert!(fit.f_score(0.01 * height) > 0.95, "{species}: {}", fit.f_score(0.01 * height));
        let own = Figures::of(&moved);
        assert!((own.height / height - 1.0).abs() < 0.02, "{species}: {} {height}", own.height);
        assert!(made.foot.length() < 0.1, "{species}: {}", made.foot);
    }
}

#[test]
fn one_side_of_a_stem_shows_its_radius_and_its_middle() {
    let at = |i: u16| {
        let (sin, cos) = (f32::from(i % 16) * 0.18).sin_cos();
        Vec3::new(3.0 + 0.2 * cos, f32::from(i / 16) * 0.03, 0.2 * sin - 1.0)
    };
    let made = made(&(0..3200).map(at).collect::<Vec<_>>());
    let figures = Figures::of(&made.tree);
    assert!((figures.dbh.unwrap() - 0.4).abs() < 0.03, "{figures:?}");
    assert!(made.foot.distance(Vec3::new(3.0, 0.0, -1.0)) < 0.03, "{}", made.foot);
    let off = |p: Vec3| p.with_y(0.0).length();
    // What carries little is taken for thin, so that the top of a bare stem is not.
    let stem = made.tree.nodes().iter().filter(|node| node.order == 0 && node.position.y < 3.0);
    assert!(stem.map(|node| off(node.position)).fold(0.0, f32::max) < 0.06);
}

#[test]
fn a_moved_or_larger_cloud_gives_the_moved_or_larger_tree() {
    let points = cloud(&tree("maple"), 8_000);
    let before = made(&points);
    let by = Vec3::new(64.0, 16.0, -32.0);
    let moved = made(&points.iter().map(|p| *p + by).collect::<Vec<_>>());
    assert!((moved.foot - by).distance(before.foot) < 1e-3);
    let larger = made(&points.iter().map(|p| *p * 4.0).collect::<Vec<_>>());
    assert!((larger.foot / 4.0).distance(before.foot) < 1e-3);
    let [a, b, c] = [&before, &moved, &larger].map(|made| Figures::of(&made.tree));
    assert!((b.length / a.length - 1.0).abs() < 0.02, "{a:?} {b:?}");
    assert!((c.length / a.length / 4.0 - 1.0).abs() < 0.02, "{a:?} {c:?}");
    assert!((c.height / a.height / 4.0 - 1.0).abs() < 0.005);
}

#[test]
fn the_same_cloud_gives_the_same_bits_on_any_thread_and_in_any_order_of_asking() {
    let points = cloud(&tree("walnut"), 6_000);
    let model = model();
    let make = |complete| {
        let options = Options { prior: Some(&model), complete, ..Options::default() };
        reconstruct(&points, &options).unwrap()
    };
    let (first, completed) = (make(false), make(true));
    let others: Vec<Reconstruction> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..3).map(|_| scope.spawn(|| make(false))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(others.iter().all(|other| *other == first));
    assert_eq!(make(true), completed);
    assert!(completed.completed > first.completed && completed.tree.len() > first.tree.len());
    assert_sound(&completed);
}

#[test]
fn what_is_grown_hears_the_points() {
    let (points, model) = (cloud(&tree("walnut"), 6_000), model());
    let make = |hear| {
        let options =
            Options { prior: Some(&model as _), complete: true, hear, ..Options::default() };
        reconstruct(&points, &options).unwrap()
    };
    let (heard, deaf) = (make(true), make(false));
    assert!(deeptree_infer::Predictor::hears_points(&model));
    let (with, without) = (heard.completed, deaf.completed);
    assert!(heard.tree != deaf.tree, "{with} nodes with points, {without} without");
    assert_sound(&heard);
}

#[test]
fn networks_name_a_species_they_know_and_refuse_others() {
    let (points, model) = (cloud(&tree("oak"), 4_000), model());
    let prior = Some(&model as _);
    let made = reconstruct(&points, &Options { prior, ..Options::default() }).unwrap();
    assert!(deeptree_growth::SPECIES.contains(&made.tree.info.species.as_str()));
    let species = |name: &str| Options { prior, species: Some(name.into()), ..Options::default() };
    assert_eq!(reconstruct(&points, &species("willow")).unwrap().tree.info.species, "willow");
    let error = reconstruct(&points, &species("ash")).unwrap_err();
    assert!(matches!(error, ReconstructError::UnknownSpecies { .. }));
}

#[test]
fn ground_below_a_tree_is_left_out() {
    let mut points = cloud(&tree("oak"), 20_000);
    let height = points.iter().map(|p| p.y).fold(0.0, f32::max);
    let wild = |i: u32, step: f32| (i as f32 * step).fract() * 40.0 - 20.0;
    points.extend((0..20_000).map(|i| {
        let (x, z) = (wild(i, 0.618_034), wild(i, 0.754_878));
        Vec3::new(x, 0.1 * (x * 0.3).sin() + 0.02 * wild(i, 0.57).fract(), z)
    }));
    let made = made(&points);
    assert!(made.ground > 5_000, "{}", made.ground);
    let own = Figures::of(&made.tree).height;
    assert!((own / height - 1.0).abs() < 0.05, "{own} of {height}");
    assert!(made.foot.with_y(0.0).length() < 0.5, "{}", made.foot);
}

#[test]
fn a_given_root_is_where_the_tree_stands_and_one_far_off_is_refused() {
    let tree = tree("beech");
    let mut points = cloud(&tree, 6_000);
    let second: Vec<Vec3> = points.iter().map(|p| *p + Vec3::X * 40.0).collect();
    points.extend(second);
    let at = |root: Vec3| reconstruct(&points, &Options { root: Some(root), ..Options::default() });
    let foot = at(Vec3::X * 40.0).unwrap().foot;
    assert!(foot.distance(Vec3::X * 40.0) < 0.5, "{foot}");
    // The other tree is left out.
    let made = at(Vec3::ZERO).unwrap();
    assert!(made.left_out > made.points / 3, "{}", made.left_out);
    assert!(Figures::of(&made.tree).crown_radius < 25.0);
    assert!(matches!(at(Vec3::X * 900.0), Err(ReconstructError::FarRoot { .. })));
    assert!(matches!(at(Vec3::NAN), Err(ReconstructError::Root { .. })));
}

#[test]
fn clouds_that_are_hardly_any_give_a_tree_or_a_reason() {
    let nan = Vec3::new(f32::NAN, 1.0, 2.0);
    let line: Vec<Vec3> = (0..50).map(|i| Vec3::new(0.1, 0.2, 0.3) * i as f32).collect();
    let level: Vec<Vec3> =
        (0..400).map(|i| Vec3::new((i % 20) as f32, 0.0, (i / 20) as f32)).collect();
    let upside: Vec<Vec3> = cloud(&tree("pine"), 3_000).iter().map(|p| -*p).collect();
    let pair = vec![Vec3::ZERO, Vec3::Y];
    let twice = vec![Vec3::ONE; 100_000].into_iter().chain(pair.clone()).collect();
    let far = pair.iter().map(|p| *p + Vec3::splat(1e6)).collect();
    let huge = vec![Vec3::splat(1e14), Vec3::splat(-1e14)];
    let tiny = line.iter().map(|p| *p * 1e-12).collect();
    let mixed = [&line[..], &[nan]].concat();
    for points in [line.clone(), level, upside, pair, twice, far, huge, tiny, mixed] {
        assert_sound(&made(&points));
    }
    let error = |points: &[Vec3]| reconstruct(points, &Options::default()).unwrap_err();
    assert_eq!(error(&[]), ReconstructError::NoPoints { given: 0 });
    assert_eq!(error(&[nan]), ReconstructError::NoPoints { given: 1 });
    assert_eq!(error(&[Vec3::ONE; 9]), ReconstructError::OnePlace);
    let cover = |cover| reconstruct(&line, &Options { cover: Some(cover), ..Options::default() });
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(cover(bad), Err(ReconstructError::NotPositive { .. })));
    }
}

#[test]
fn a_tree_placed_elsewhere_is_the_same_tree() {
    let tree = tree("tulip");
    let turn = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let there = placed(&tree, turn, Vec3::new(3.0, -4.0, 5.0));
    assert_eq!(there.len(), tree.len());
    for (a, b) in tree.nodes().iter().zip(there.nodes()) {
        let expected = Vec3::new(a.position.x + 3.0, -a.position.z - 4.0, a.position.y + 5.0);
        assert!(b.position.distance(expected) < 1e-3, "{} {expected}", b.position);
        assert_eq!((a.thickness, a.order), (b.thickness, b.order));
    }
}
