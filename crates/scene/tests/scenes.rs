//! Truths about scenes: what stands where, what a point sees, which voxels are taken.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use std::fs;
use std::path::Path;

use deeptree_graph::{Occupancy, Vec3, Voxel};
use deeptree_scene::{
    BoxShape, Cuboid, Environment, Scene, SceneError, SceneMesh, TriangleMesh, Volume,
};
use proptest::prelude::*;

fn aligned(min: [f32; 3], max: [f32; 3]) -> Cuboid {
    Cuboid::new(BoxShape::Aligned { min: min.into(), max: max.into() }).unwrap()
}

fn scene(boxes: Vec<Cuboid>) -> Scene {
    Scene::new(boxes, Vec::new()).unwrap()
}

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, Path::new(""))
}

/// The faces of a box as the text of an OBJ file.
fn obj_of_box(low: [f32; 3], high: [f32; 3]) -> String {
    let mut text = String::new();
    for i in 0..8 {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        text += &format!("v {} {} {}\n", pick(0), pick(1), pick(2));
    }
    text + "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n"
}

fn mesh_of_box(low: [f32; 3], high: [f32; 3]) -> SceneMesh {
    let mesh = TriangleMesh::from_bytes("box.obj", obj_of_box(low, high).as_bytes()).unwrap();
    SceneMesh { file: "box.obj".to_owned(), mesh }
}

#[test]
fn a_scene_file_says_boxes_and_meshes() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("shed.obj"), obj_of_box([8.0, 0.0, 0.0], [9.0, 1.0, 1.0]))
        .unwrap();
    let text = "
        [[box]]                       # axis-aligned …
        min = [3.0, 0.0, -10.0]
        max = [5, 12, 10]
        [[box]]                       # … or oriented
        center = [-6.0, 5.0, 0.0]
        half = [1.0, 5.0, 8.0]
        yaw = 30.0
        [[mesh]]
        file = \"shed.obj\"";
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    let read = Scene::read(&path).unwrap();
    assert_eq!((read.boxes().len(), read.meshes().len()), (2, 1));
    assert_eq!(read.boxes()[0], aligned([3.0, 0.0, -10.0], [5.0, 12.0, 10.0]));
    assert!(read.contains(Vec3::new(4.0, 1.0, 0.0)) && read.contains(Vec3::new(8.5, 0.5, 0.5)));
    assert!(read.contains(Vec3::new(-6.0, 5.0, 0.0)) && !read.contains(Vec3::new(0.0, 5.0, 0.0)));
    assert_eq!(read.bounds().unwrap()[1], Vec3::new(9.0, 12.0, 10.0));
    assert_eq!(Scene::parse(&read.to_toml(), folder.path()).unwrap(), read);
}

#[test]
fn scenes_that_cannot_be_are_told_in_one_line() {
    for (text, part) in [
        (
            "[[box]]\nmin = [3.0, 0.0, nan]\nmax = [5.0, 1.0, 1.0]",
            "box 1: its numbers must be finite",
        ),
        ("[[box]]\nmin = [3, 0, 0]\nmax = [5, 1, -1]", "box 1: `min` must lie below `max` along z"),
        ("[[box]]\nmin = [3, 0, 0]\nmax = [3, 1, 1]", "along x"),
        ("[[box]]\ncenter = [9, 1, 0]\nhalf = [1, 0, 1]", "`half` must be above 0 along y"),
        ("[[box]]\nmin = [3, 0, 0]\nhalf = [1, 1, 1]", "give either `min` and `max`"),
        ("[[box]]\nmin = [3, 0, 0]\nmax = [4, 1, 1]\nyaw = 5", "give either"),
        ("[[box]]\nmin = [3, 0]\nmax = [4, 1, 1]", "line 2"),
        ("[[box]]\nmin = [-1, 0, -1]\nmax = [1, 1, 1]", "stands on the tree's foot"),
        ("[[box]]\nmin = [-1, 0.5, -1]\nmax = [1, 9, 1]", "stands on the tree's foot"),
        ("[[ball]]\nradius = 3", "unknown field"),
        ("[[box]]\nmin = [3, 0, 0]\nmax = [4, 1, 1]\ncolour = 1", "unknown field"),
        ("form = \"cone\"", "unknown field"),
        ("[[box", "line 1"),
        ("[[mesh]]\nfile = \"absent.obj\"", "cannot read absent.obj"),
    ] {
        let error = parse(text).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
    // A slab overhead is an obstacle as any other.
    assert!(parse("[[box]]\nmin = [-9, 3, -9]\nmax = [9, 4, 9]").is_ok());
    assert_eq!(parse("").unwrap(), Scene::default());
}

#[test]
fn meshes_that_cannot_be_name_their_file() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, part) in [
        ("a.stl", &b"solid"[..], "mesh a.stl: meshes are read from .obj and .glb"),
        ("b.glb", b"glTF\x02\0\0\0", "mesh b.glb: this is no GLB file"),
        ("c.obj", b"v 0 0 0\nf 1 2 3\n", "mesh c.obj: this is no OBJ file"),
        ("d.obj", b"v 0 0 0\n", "it has no faces"),
        (
            "e.obj",
            b"v 0 0 inf\nv 0 1 0\nv 1 0 0\nf 1 2 3\n",
            "face 1 has a corner that is no number",
        ),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
        let text = format!("[[mesh]]\nfile = \"{name}\"");
        let error = Scene::parse(&text, folder.path()).unwrap_err().to_string();
        assert!(error.contains(part) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn a_segment_that_enters_an_obstacle_crosses_it() {
    let wall = ([3.0, 0.0, -10.0], [5.0, 12.0, 10.0]);
    for scene in [
        scene(vec![aligned(wall.0, wall.1)]),
        Scene::new(Vec::new(), vec![mesh_of_box(wall.0, wall.1)]).unwrap(),
    ] {
        let crosses = |a: [f32; 3], b: [f32; 3]| scene.crosses(a.into(), b.into());
        assert!(crosses([2.5, 1.0, 0.0], [3.5, 1.0, 0.3]));
        assert!(crosses([2.0, 1.0, 0.0], [9.0, 1.0, 0.0]), "right through");
        assert!(crosses([3.9, 1.0, 0.0], [4.1, 1.0, 0.0]), "wholly inside");
        assert!(crosses([4.0, 1.0, 0.0], [4.0, 1.0, 0.0]), "a point inside");
        assert!(!crosses([2.0, 1.0, 0.0], [2.9, 1.0, 0.0]));
        assert!(!crosses([2.9, 13.0, 0.0], [5.1, 13.0, 0.0]), "over it");
        assert!(!crosses([2.0, 1.0, 0.0], [2.0, 1.0, 0.0]));
    }
}

#[test]
fn beside_an_endless_wall_half_of_the_sky_is_free() {
    let wall = scene(vec![aligned([3.0, 0.0, -9000.0], [4.0, 9000.0, 9000.0])]);
    let sky = wall.sky(Vec3::new(0.0, 1.0, 0.0));
    assert_eq!(sky.free, 0.5);
    assert!(sky.toward.unwrap().x < -0.99);
}

#[test]
fn under_a_round_hole_the_sky_is_the_hole() {
    // An endless slab at height 10 hides all that it covers: nothing is free.
    let slab = scene(vec![aligned([-9000.0, 10.0, -9000.0], [9000.0, 11.0, 9000.0])]);
    let below = slab.sky(Vec3::ZERO);
    // Seen from its middle it ends half a degree above the horizon, below the lowest ray.
    assert_eq!((below.free, below.toward), (0.0, None));
    assert_eq!(slab.sky(Vec3::new(0.0, 12.0, 0.0)).free, 1.0);

    // A square roof of half side 10 at height 10, seen from the middle of its floor: it covers
    // two thirds of the hemisphere less what is below it. The solid angle of a square of half side
    // a at height h is 4 asin(a² / (a² + h²)) = 4 asin(1/2) = 2π/3, a third of the hemisphere.
    let roof = scene(vec![aligned([-10.0, 10.0, -10.0], [10.0, 10.5, 10.0])]);
    let found = roof.sky(Vec3::ZERO);
    assert!((found.free - 2.0 / 3.0).abs() < 0.05, "{}", found.free);
    // The rays are symmetric to quarter turns, and so is the roof.
    assert_eq!(found.toward, None);
}

#[test]
fn a_scene_that_is_turned_by_a_quarter_has_the_sky_turned_by_a_quarter() {
    let of = |yaw: f32, center: [f32; 3]| {
        let shape = BoxShape::Turned { center: center.into(), half: [1.0, 6.0, 8.0].into(), yaw };
        scene(vec![Cuboid::new(shape).unwrap()])
    };
    for (x, y, z) in [(0.0, 2.0, 0.0), (1.0, 7.0, -2.0), (-3.0, 1.0, 6.0)] {
        let before = of(20.0, [6.0, 6.0, 1.0]).sky(Vec3::new(x, y, z));
        // A quarter turn about +y takes (x, z) to (z, −x).
        let after = of(110.0, [1.0, 6.0, -6.0]).sky(Vec3::new(z, y, -x));
        assert_eq!(before.free, after.free);
        let (a, b) = (before.toward.unwrap(), after.toward.unwrap());
        assert!((Vec3::new(a.z, a.y, -a.x) - b).length() < 1e-6, "{a} {b}");
    }
}

#[test]
fn a_box_takes_the_voxels_it_reaches_into_and_none_that_it_touches() {
    // x: 2 to 5 are the voxels 17 and 18; y: 0 to 12 are 0 to 5; z: −4 to 4 are 14 to 17.
    let grid = scene(vec![aligned([2.0, 0.0, -4.0], [5.0, 12.0, 4.0])]).occupancy();
    let expected: Vec<Voxel> = (14..18)
        .flat_map(|z| (0..6).flat_map(move |y| (17..19).map(move |x| Voxel { x, y, z })))
        .collect();
    assert_eq!(grid.iter().collect::<Vec<_>>(), expected);
}

#[test]
fn a_closed_mesh_takes_the_voxels_of_the_same_box() {
    for (low, high) in [
        ([2.0, 0.0, -4.0], [4.0, 12.0, 4.0]),
        ([2.3, 0.1, -9.7], [11.9, 12.4, 4.2]),
        ([-31.0, 5.0, 20.0], [-20.5, 70.0, 40.0]),
    ] {
        let of_box = scene(vec![aligned(low, high)]).occupancy();
        let of_mesh = Scene::new(Vec::new(), vec![mesh_of_box(low, high)]).unwrap().occupancy();
        assert!(!of_box.is_empty());
        assert_eq!(of_box, of_mesh, "{low:?}: {of_box:?} {of_mesh:?}");
    }
}

#[test]
fn a_sheet_takes_the_voxels_it_lies_in() {
    let text = "v 4 0 -4\nv 4 0 4\nv 4 8 4\nv 4 8 -4\nf 1 2 3 4\n";
    let mesh = TriangleMesh::from_bytes("sheet.obj", text.as_bytes()).unwrap();
    let file = "sheet.obj".to_owned();
    let grid = Scene::new(Vec::new(), vec![SceneMesh { file, mesh }]).unwrap().occupancy();
    // It lies at x = 4, where voxel 18 begins.
    assert!(grid.at(Vec3::new(4.5, 1.0, 0.0)) && !grid.at(Vec3::new(3.5, 1.0, 0.0)));
    assert!(grid.iter().all(|voxel| voxel.x == 18));
    assert!((4 * 4..=5 * 6).contains(&grid.count()), "{grid:?}");
}

#[test]
fn an_environment_reads_back_from_its_text() {
    let scene = Scene::random(deeptree_graph::Seed(7));
    for volume in [None, Some(Volume::Cone), Some(Volume::Ring)] {
        let environment = Environment { scene: scene.clone(), volume };
        let read = Environment::parse(&environment.to_toml(), Path::new("")).unwrap();
        assert_eq!(read, environment);
        let both = environment.occupancy();
        assert!(environment.scene.occupancy().iter().all(|voxel| both.holds(voxel)));
    }
    assert!(Environment::default().is_open());
    assert_eq!(Environment::default().occupancy(), Occupancy::EMPTY);
    assert_eq!(Environment::default().to_toml(), "");
}

#[test]
fn a_form_is_a_closed_mesh_within_the_growth_space() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let whole = obj_of_box([-5.0, 4.0, -5.0], [5.0, 14.0, 5.0]);
    write("ball.obj", &whole);
    write("open.obj", whole.rsplit_once('f').unwrap().0);
    write("far.obj", &obj_of_box([100.0, 0.0, 0.0], [110.0, 9.0, 9.0]));
    let ball = Volume::named("ball.obj", folder.path()).unwrap();
    assert!(ball.admits(Vec3::new(3.0, 5.0, -3.0)) && !ball.admits(Vec3::new(6.0, 5.0, 0.0)));
    assert!(ball.admits(Vec3::new(0.5, 3.0, 0.0)), "the stem leads up to it");
    assert!(!ball.admits(Vec3::new(1.5, 3.0, 0.0)));
    // From −5 to 5 are four voxels and two halves, and of a half the greater part is not outside;
    // so there are six by six less the corners, five layers of them, and the stump's four below.
    let free = Occupancy::SIDE.pow(3) - ball.occupancy().count();
    assert_eq!(free, 5 * (6 * 6 - 4) + 4);
    let error = |name| Volume::named(name, folder.path()).unwrap_err();
    assert!(matches!(error("open.obj"), SceneError::OpenForm { open_edges: 4, .. }));
    assert!(matches!(error("far.obj"), SceneError::EmptyForm { .. }));
}

#[test]
fn obstacles_are_seen_from_another_place_where_they_are() {
    let scene = scene(vec![aligned([3.0, 0.0, -1.0], [5.0, 2.0, 1.0])]);
    let place = Vec3::new(-4.0, 0.0, 2.0);
    let moved = scene.seen_from(place).unwrap();
    assert!(moved.contains(Vec3::new(8.0, 1.0, -2.0)));
    assert!(matches!(scene.seen_from(Vec3::new(4.0, 0.0, 0.0)), Err(SceneError::OverRoot)));
}

proptest! {
    /// Points of a box are in taken voxels; a segment between points of it crosses it; and what a
    /// turned box contains, the box contains that is turned back.
    #[test]
    fn queries_agree_with_one_another(
        center in prop::array::uniform3(-20.0f32..20.0),
        half in prop::array::uniform3(0.1f32..6.0),
        yaw in -400.0f32..400.0,
        part in prop::array::uniform3(-0.999f32..0.999),
        other in prop::array::uniform3(-30.0f32..30.0),
    ) {
        let center = Vec3::from(center) + Vec3::Y * 28.0;
        let half = Vec3::from(half);
        let shape = BoxShape::Turned { center, half, yaw };
        let Ok(scene) = Scene::new(vec![Cuboid::new(shape).unwrap()], Vec::new()) else {
            return Ok(());
        };
        let (sin, cos) = f64::from(yaw).to_radians().sin_cos();
        let local = Vec3::from(part) * half;
        let turned = Vec3::new(
            (f64::from(local.x) * cos + f64::from(local.z) * sin) as f32,
            local.y,
            (f64::from(local.z) * cos - f64::from(local.x) * sin) as f32,
        );
        let point = center + turned;
        prop_assert!(scene.contains(point));
        let grid = scene.occupancy();
        prop_assert!(grid.at(point) || Voxel::holding(point).is_none());
        let other = Vec3::from(other);
        prop_assert!(scene.crosses(point, other) && scene.crosses(other, point));
        if !scene.contains(other) && !scene.crosses(other, other + Vec3::Y * 0.5) {
            prop_assert!(!scene.contains(other + Vec3::Y * 0.5));
        }
        prop_assert_eq!(Scene::parse(&scene.to_toml(), Path::new("")).unwrap(), scene);
    }

    /// A mesh of a box answers as the box does.
    #[test]
    fn a_closed_mesh_is_the_solid_it_encloses(
        low in prop::array::uniform3(-20.0f32..20.0),
        size in prop::array::uniform3(0.5f32..9.0),
        points in prop::collection::vec(prop::array::uniform3(-25.0f32..30.0), 8),
    ) {
        let low = [low[0], low[1] + 22.0, low[2]];
        let high: [f32; 3] = std::array::from_fn(|axis| low[axis] + size[axis]);
        let of_box = scene(vec![aligned(low, high)]);
        let of_mesh = Scene::new(Vec::new(), vec![mesh_of_box(low, high)]).unwrap();
        for pair in points.windows(2) {
            let [a, b] = [Vec3::from(pair[0]), Vec3::from(pair[1])];
            prop_assert_eq!(of_box.contains(a), of_mesh.contains(a));
            prop_assert_eq!(of_box.crosses(a, b), of_mesh.crosses(a, b));
            prop_assert_eq!(of_box.sky(a), of_mesh.sky(a));
        }
        prop_assert_eq!(of_box.occupancy(), of_mesh.occupancy());
    }

    /// Damaged files are errors, or scenes; never a panic.
    #[test]
    fn damaged_texts_are_no_panic(
        at in 0usize..400, with in any::<u8>(), cut in 0usize..400,
    ) {
        let whole = Scene::random(deeptree_graph::Seed(3)).to_toml();
        let mut bytes = whole.into_bytes();
        let length = bytes.len();
        bytes[at % length] = with;
        bytes.truncate(length - cut % length);
        if let Ok(scene) = parse(&String::from_utf8_lossy(&bytes)) {
            prop_assert_eq!(parse(&scene.to_toml()).unwrap(), scene);
        }
        let mut bytes = obj_of_box([1.0; 3], [2.0; 3]).into_bytes();
        let length = bytes.len();
        bytes[at % length] = with;
        let _ = TriangleMesh::from_bytes("a.obj", &bytes);
    }
}
