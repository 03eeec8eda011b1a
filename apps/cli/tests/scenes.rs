//! Obstacles, forms and stands from the command line.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use std::path::Path;

use common::Desk;
use deeptree_dataset::{Corpus, Split, Stands};
use deeptree_graph::{Seed, TreeInfo, Vec3, codec::csv};
use deeptree_growth::{Profile, Species};
use deeptree_scene::{Scene, Volume};

const FAILED: i32 = 1;
const USAGE: i32 = 2;

/// A wall at x from 3 to 5, 12 m high and 20 m wide.
const WALL: &str = "[[box]]\nmin = [3.0, 0.0, -10.0]\nmax = [5.0, 12.0, 10.0]\n";

/// The nodes of a table, by tree.
fn nodes(desk: &Desk, name: &str) -> Vec<Vec<Vec3>> {
    let info = TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: 0 };
    let trees = csv::read(&desk.read(name), &info).unwrap();
    trees.iter().map(|(_, tree)| tree.nodes().iter().map(|node| node.position).collect()).collect()
}

fn write(desk: &Desk, name: &str, text: &str) {
    std::fs::write(desk.path(name), text).unwrap();
}

#[test]
fn trees_grow_beside_a_wall_and_the_scene_says_what_is_in_it() {
    let desk = Desk::new();
    write(&desk, "scene.toml", WALL);
    let said: serde_json::Value =
        serde_json::from_str(&desk.ok(&["info", "scene.toml", "--json"])).unwrap();
    // x from 3 to 5 lies in two voxels, 12 m of height in six, 20 m of width in ten.
    assert_eq!(said["occupied_voxels"], 120);
    assert_eq!(said["boxes"].as_array().unwrap().len(), 1);
    assert_eq!(said["max"], serde_json::json!([5.0, 12.0, 10.0]));
    assert!(desk.ok(&["info", "scene.toml"]).contains("1 box and 0 meshes: 120 of 32768"));

    let grow = ["grow", "maple", "--age", "22", "--count", "3"];
    desk.ok(&[&grow[..], &["--obstacles", "scene.toml", "-o", "wall.csv"]].concat());
    desk.ok(&[&grow[..], &["-o", "open.csv"]].concat());
    let scene = Scene::parse(WALL, Path::new("")).unwrap();
    let inside = |name| nodes(&desk, name).concat().iter().filter(|&&p| scene.contains(p)).count();
    assert_eq!(inside("wall.csv"), 0);
    assert!(inside("open.csv") > 0, "the wall stands in nobody's way");
}

#[test]
fn trees_are_kept_in_a_form() {
    let desk = Desk::new();
    for (form, volume) in [("cone", Volume::Cone), ("ring", Volume::Ring)] {
        desk.ok(&["grow", "maple", "--age", "22", "--form", form, "-o", "tree.csv"]);
        assert!(nodes(&desk, "tree.csv").concat().iter().all(|&p| volume.admits(p)));
    }
    // Half of a tetrahedron's faces, and all of them.
    let corners = "v -8 0 -8\nv 8 0 -8\nv 0 0 8\nv 0 20 0\n";
    write(&desk, "open.obj", &format!("{corners}f 1 2 3\nf 1 4 2\n"));
    write(&desk, "closed.obj", &format!("{corners}f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n"));
    desk.fails(&["grow", "oak", "--form", "open.obj", "-o", "a.csv"], FAILED, "not closed");
    desk.ok(&["grow", "maple", "--age", "22", "--form", "closed.obj", "-o", "tree.csv"]);
    let tree = nodes(&desk, "tree.csv").concat();
    assert!(tree.len() > 50 && tree.iter().all(|p| p.z < 8.0 && p.y < 20.0));
}

#[test]
fn trees_of_a_stand_grow_at_their_places() {
    let desk = Desk::new();
    write(&desk, "plan.csv", "x,z,species,seed\n0,0,oak,1\n5,0,maple,2\n");
    desk.ok(&["grow", "--stand", "plan.csv", "--age", "20", "-o", "stand.csv"]);
    let stand = nodes(&desk, "stand.csv");
    assert_eq!(stand.len(), 2);
    assert!(stand[0][0].distance(Vec3::Y) < 0.1);
    assert!(stand[1][0].distance(Vec3::new(5.0, 1.0, 0.0)) < 0.1);
    desk.ok(&["grow", "oak", "--seed", "1", "--age", "20", "-o", "oak.csv"]);
    assert!(stand[0].len() < nodes(&desk, "oak.csv")[0].len(), "the maple takes no room");
    // The other way round it is the same stand, in another order.
    write(&desk, "back.csv", "5,0,maple,2\n0,0,oak,1\n");
    desk.ok(&["grow", "--stand", "back.csv", "--age", "20", "-o", "again.csv"]);
    let again = nodes(&desk, "again.csv");
    assert!(again[0] == stand[1] && again[1] == stand[0]);
    desk.ok(&["grow", "--stand", "plan.csv", "--age", "12", "-o", "folder"]);
    assert!(desk.path("folder/oak-1.glb").exists() && desk.path("folder/maple-2.glb").exists());
}

#[test]
fn trees_of_the_networks_crowd_each_other_at_their_places() {
    let desk = Desk::new();
    write(&desk, "plan.csv", "x,z,species,seed\n0,0,,1\n4,0,tulip,2,12\n900,0,,3\n");
    let stand = ["generate", "maple", "--stand", "plan.csv", "--age", "20"];
    desk.ok(&[&stand[..], &["-o", "stand.csv"]].concat());
    let trees = nodes(&desk, "stand.csv");
    assert_eq!(trees.len(), 3);
    assert!(trees[0][0].distance(Vec3::Y) < 0.1);
    assert!(trees[1][0].distance(Vec3::new(4.0, 1.0, 0.0)) < 0.1);
    // The third is out of reach: the tree that its seed is by itself.
    desk.ok(&["generate", "maple", "--seed", "3", "--age", "20", "-o", "alone.csv"]);
    let alone = &nodes(&desk, "alone.csv")[0];
    assert_eq!(trees[2].len(), alone.len());
    let moved = |p: &Vec3| *p + Vec3::new(900.0, 0.0, 0.0);
    assert!(trees[2].iter().zip(alone).all(|(a, b)| a.distance(moved(b)) < 1e-3));
    desk.ok(&["generate", "maple", "--seed", "1", "--age", "20", "-o", "first.csv"]);
    assert!(trees[0].len() < nodes(&desk, "first.csv")[0].len(), "the tulip takes no room");
    // Nor threads nor batches nor the order of the rows.
    let other = ["--threads", "1", "--batch", "9", "-o", "again.csv"];
    desk.ok(&[&stand[..], &other].concat());
    assert!(desk.read("again.csv") == desk.read("stand.csv"));
    write(&desk, "plan.csv", "900,0,,3\n4,0,tulip,2,12\n0,0,,1\n");
    desk.ok(&[&stand[..], &["-o", "back.csv"]].concat());
    let back: Vec<_> = nodes(&desk, "back.csv").into_iter().rev().collect();
    assert!(back == trees);
    desk.ok(&[&stand[..], &["-o", "folder"]].concat());
    assert!(desk.path("folder/maple-1.glb").exists() && desk.path("folder/tulip-2.glb").exists());

    let fails = |more: &[&str], code, part| {
        desk.fails(&[&["generate", "--stand", "plan.csv"][..], more].concat(), code, part);
    };
    fails(&["-o", "a.csv"], FAILED, "line 1: it names no species");
    fails(&["maple", "-o", "trees", "--format", "dtree"], USAGE, "a .dtree holds a tree by itself");
    fails(&["maple", "-o", "a.obj"], USAGE, "a stand as one file is .glb or .gltf");
    fails(&["maple", "--count", "2", "-o", "a.csv"], USAGE, "cannot be used with");
    fails(&["maple", "--age", "90", "-o", "a.csv"], USAGE, "not 90");
    fails(&["elm", "-o", "a.csv"], USAGE, "elm");
}

#[test]
fn corpora_of_stands_grow_from_the_command_line() {
    let desk = Desk::new();
    let words = ["dataset", "--species", "maple,tulip", "--stands", "2", "--seed", "7"];
    assert!(desk.ok(&[&words[..], &["-o", "stands"]].concat()).contains("2 stands of"));
    let corpus = Stands::open(&desk.path("stands")).unwrap();
    let stands = corpus.stands(true).unwrap();
    for tree in stands.iter().flatten() {
        let traits = tree.alone.traits();
        assert!(traits.nodes >= 1.0 && traits.is_sound());
        // Of its species' own age, or of the 12 to 35 growth cycles of a stand of many ages.
        let name = ["maple", "tulip"][tree.plant.species];
        let own = Species::named(name).unwrap().parameters(Profile::Reference).age as u32;
        assert!(tree.plant.age.is_none_or(|age| (12..36).contains(&age)));
        assert_eq!(tree.tree.info.age, tree.plant.age.unwrap_or(own));
        assert_eq!(tree.tree.info.species, name);
    }
    let other = ["dataset", "--species", "maple", "--stands", "2", "-o", "stands"];
    desk.fails(&other, FAILED, "another corpus");
    desk.fails(&[&words[..], &["--trees", "3", "-o", "x"]].concat(), USAGE, "cannot be used with");
}

#[test]
fn corpora_hold_the_scene_or_form_of_each_tree() {
    let desk = Desk::new();
    let common = ["dataset", "--species", "maple", "--ages", "8..12"];
    desk.ok(&[&common[..], &["--scenes", "5", "--seed", "40", "-o", "scenes"]].concat());
    desk.ok(&[&common[..], &["--trees", "2", "--form", "cone,ring", "-o", "forms"]].concat());
    let read = |name: &str| {
        let corpus = Corpus::open(&desk.path(name)).unwrap();
        let trees: Vec<_> = corpus.trees(Split::All).map(|tree| tree.unwrap()).collect();
        trees
    };
    let scenes = read("scenes");
    assert_eq!(scenes.len(), 5);
    for (tree, seed) in scenes.iter().zip(40..) {
        assert_eq!(tree.environment.scene, Scene::random(Seed(seed)));
        assert!((8..=12).contains(&tree.tree.info.age));
        let scene = &tree.environment.scene;
        assert!(tree.tree.nodes().iter().all(|n| !scene.crosses(n.base(), n.position)));
    }
    let forms: Vec<_> = read("forms").into_iter().map(|tree| tree.environment.volume).collect();
    let (cone, ring) = (Some(Volume::Cone), Some(Volume::Ring));
    assert_eq!(forms, [cone.clone(), ring.clone(), cone, ring]);
    assert!(desk.ok(&["info", "scenes"]).contains("each in a scene of its own"));
    let twice = ["dataset", "--trees", "3", "--scenes", "3", "-o", "x"];
    desk.fails(&twice, USAGE, "cannot be used with");
    desk.fails(&["dataset", "--form", "cone,ball", "-o", "x"], USAGE, "`ball` is not one of");
    desk.fails(&["dataset", "--scenes", "0", "-o", "x"], USAGE, "--scenes");
}

#[test]
fn scenes_and_plans_that_cannot_be_are_told_in_one_line() {
    let desk = Desk::new();
    for (text, part) in [
        ("[[box]]\nmin = [3, 0, nan]\nmax = [5, 1, 1]\n", "box 1: its numbers must be finite"),
        (
            "[[box]]\nmin = [5, 0, 0]\nmax = [3, 1, 1]\n",
            "box 1: `min` must lie below `max` along x",
        ),
        ("[[box]]\nmin = [-1, 0, -1]\nmax = [1, 3, 1]\n", "stands on the tree's foot"),
        ("[[box]]\nmin = [3, 0, 0]\n", "give either"),
        ("[[tower]]\n", "line 1: unknown field `tower`"),
        ("[[mesh]]\nfile = \"absent.glb\"\n", "absent.glb"),
        ("\u{0}", "line 1"),
    ] {
        write(&desk, "scene.toml", text);
        desk.fails(&["grow", "oak", "--obstacles", "scene.toml", "-o", "a.csv"], FAILED, part);
        desk.fails(&["info", "scene.toml"], FAILED, part);
    }
    // A wall of a million faces and one, none with any area.
    let faces = "f 1 2 3\n".repeat(1_000_001);
    write(&desk, "many.obj", &format!("v 9 0 0\nv 9 1 0\nv 9 0 1\n{faces}"));
    write(&desk, "scene.toml", "[[mesh]]\nfile = \"many.obj\"\n");
    desk.fails(&["info", "scene.toml"], FAILED, "more than 1000000 faces");

    for (text, part) in [
        ("0,0,oak\n", "line 1: it has 3 fields"),
        ("0,zero,oak,1\n", "`zero` is no distance"),
        ("0,0,oak,1\n0,0,oak,2\n", "line 2: another tree stands there"),
        ("", "it has no rows"),
    ] {
        write(&desk, "plan.csv", text);
        desk.fails(&["grow", "--stand", "plan.csv", "-o", "a.csv"], FAILED, part);
    }
    write(&desk, "plan.csv", "0,0,oka,1\n");
    desk.fails(&["grow", "--stand", "plan.csv", "-o", "a.csv"], USAGE, "did you mean oak?");
    write(&desk, "plan.csv", "0,0,oak,1\n9,0,oak,1\n");
    desk.fails(&["grow", "--stand", "plan.csv", "-o", "trees"], USAGE, "have the seed 1");
    let many: String = (0..10_000).map(|i| format!("{i},0,oak,{i}\n")).collect();
    write(&desk, "plan.csv", &many);
    for verb in ["grow", "generate"] {
        desk.fails(&[verb, "--stand", "plan.csv", "-o", "a.csv"], FAILED, "more than 2000 rows");
    }
    desk.fails(&["grow", "oak", "--form", "ball", "-o", "a.csv"], USAGE, "no form `ball`");
    desk.fails(&["grow", "oak", "--form", "ball.obj", "-o", "a.csv"], FAILED, "ball.obj");
}
