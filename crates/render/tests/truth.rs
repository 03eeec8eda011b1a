//! Pictures of which it is known what they must show.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use std::f32::consts::{FRAC_PI_2, TAU};

use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
use deeptree_mesh::{Blade, Dressed, Foliage, Image, Leaf, Material, Mesh, WoodOptions, wood};
use deeptree_render::{
    Camera, Ground, Kind, Light, Options, Picture, RenderError, Scene, View, impostor, marks,
    plain_bark, render,
};

/// A tree of one node: a post of 2 m.
fn post() -> Mesh {
    round_post(24)
}

/// A post of so many sides.
fn round_post(sides: u32) -> Mesh {
    let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
    let upright = Quat::from_rotation_x(FRAC_PI_2);
    let edge = ChildSignature { rotation: upright, thickness: 0.1, length: 2.0 };
    let (min_sides, max_sides) = (sides, sides);
    let options = WoodOptions { min_sides, max_sides, fluting: 0.0, ..WoodOptions::default() };
    wood(&BranchGraph::new(info, Vec3::ZERO, edge), &options)
}

fn material(albedo: f32, roughness: f32, translucency: f32) -> Material {
    Material {
        name: "test".to_owned(),
        color: [albedo, albedo, albedo, 1.0],
        roughness,
        translucency,
        double_sided: true,
        ..plain_bark()
    }
}

/// A square leaf of 1 m, level, with its foot in the middle of one side.
fn square() -> Blade {
    Blade {
        positions: vec![
            Vec3::new(-0.5, 0.0, 0.0),
            Vec3::new(0.5, 0.0, 0.0),
            Vec3::new(0.5, 0.0, -1.0),
            Vec3::new(-0.5, 0.0, -1.0),
        ],
        normals: vec![Vec3::Y; 4],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        indices: vec![0, 1, 2, 0, 2, 3],
    }
}

/// A disc of radius 1 about the origin, level.
fn disc() -> Blade {
    const SIDES: u32 = 512;
    let rim = (0..SIDES).map(|i| {
        let (sin, cos) = (TAU * i as f32 / SIDES as f32).sin_cos();
        Vec3::new(cos, 0.0, -sin)
    });
    let positions: Vec<Vec3> = std::iter::once(Vec3::ZERO).chain(rim).collect();
    let n = positions.len();
    Blade {
        positions,
        normals: vec![Vec3::Y; n],
        uvs: vec![[0.0; 2]; n],
        indices: (0..SIDES).flat_map(|i| [0, 1 + i, 1 + (i + 1) % SIDES]).collect(),
    }
}

/// Leaves alone.
fn leaves(blade: Blade, leaves: Vec<Leaf>, material: Material) -> Dressed {
    let foliage = vec![Foliage { blade, leaves, material, woody: false }];
    Dressed { wood: Mesh::default(), bark: plain_bark(), foliage }
}

fn leaf(position: Vec3, rotation: Quat, scale: f32) -> Leaf {
    Leaf { position, rotation, scale, node: 0 }
}

fn options(samples: u32) -> Options {
    Options { size: [24, 24], samples, error: 0.0, depth: 200, ..Options::default() }
}

fn picture(tree: &Dressed, light: Light, ground: Ground, options: &Options) -> Picture {
    let scene = Scene::new(tree, light, ground).unwrap();
    let camera = Camera::framing(scene.points(), View::Quarter, 1.0, 0.6).unwrap();
    render(&scene, &camera, options, |_| ()).unwrap()
}

/// The white furnace: where light is the same from everywhere and nothing absorbs, nothing can be
/// told from anything else.
#[test]
fn what_absorbs_nothing_cannot_be_seen_in_a_furnace() {
    for (roughness, translucency) in [(0.3, 0.0), (0.6, 0.5), (1.0, 1.0), (0.8, 0.2)] {
        let white = material(1.0, roughness, translucency);
        // Leaves that throw light at each other.
        let crowd = (0..12)
            .map(|i| {
                let turn = Quat::from_rotation_y(i as f32) * Quat::from_rotation_x(0.7 * i as f32);
                leaf(Vec3::new(0.0, 1.0, 0.0), turn, 0.5 + 0.1 * i as f32)
            })
            .collect();
        let tree = leaves(square(), crowd, white);
        let mean = picture(&tree, Light::uniform(), Ground::None, &options(256)).mean();
        assert!((mean[0] - 1.0).abs() < 0.01, "leaves {roughness} {translucency}: {mean:?}");
    }
    // Wood is shaded with rounded normals, which cost a little at its silhouette.
    for roughness in [0.4, 0.9] {
        let bark = material(1.0, roughness, 0.0);
        let tree = Dressed { wood: post(), bark, foliage: Vec::new() };
        let mean = picture(&tree, Light::uniform(), Ground::None, &options(256)).mean();
        assert!((mean[0] - 1.0).abs() < 0.015, "wood {roughness}: {mean:?}");
    }
}

/// White ground below a uniform sky, and white leaves above it, is a furnace as well.
#[test]
fn white_ground_closes_the_furnace() {
    let tree = leaves(
        square(),
        vec![leaf(Vec3::new(0.0, 0.4, 0.5), Quat::IDENTITY, 1.0)],
        material(1.0, 0.7, 0.5),
    );
    let picture = picture(&tree, Light::uniform(), Ground::Plain(Vec3::ONE), &options(512));
    let mean = picture.mean()[0];
    assert!((mean - 1.0).abs() < 0.015, "{mean}");
}

/// All light on open ground is π, so ground of albedo ρ has the radiance ρ.
#[test]
fn open_ground_is_as_bright_as_its_albedo() {
    let tree = Dressed { wood: post(), bark: plain_bark(), foliage: Vec::new() };
    for light in [
        Light::uniform(),
        Light::overcast(0.6, 1.0, 0.7).unwrap(),
        Light::daylight(0.8, 2.0, 3.0).unwrap(),
    ] {
        let scene = Scene::new(&tree, light, Ground::Plain(Vec3::splat(0.3))).unwrap();
        // Ten metres from the post, a patch of 1 m.
        let at = Vec3::new(-10.0, 2.0, 9.0);
        let near = [at, at + Vec3::new(0.5, 0.0, 0.5)];
        let camera = Camera::framing(near.into_iter(), View::Top, 1.0, 1.2).unwrap();
        let picture = render(&scene, &camera, &options(256), |_| ()).unwrap();
        let mean = picture.mean();
        assert!((mean[0] / 0.3 - 1.0).abs() < 0.01, "{mean:?}");
    }
}

/// A disc of radius r at the height h above level ground takes the share r²/(r² + h²) of a
/// uniform sky's light from the point below its middle (Howell, "A Catalog of Radiation Heat
/// Transfer Configuration Factors", B-12).
#[test]
fn a_disc_takes_its_configuration_factor_of_the_skylight() {
    for (r, h) in [(1.0f32, 1.0f32), (2.0, 1.0), (0.5, 2.0)] {
        let black = material(0.0, 1.0, 0.0);
        let tree = leaves(disc(), vec![leaf(Vec3::Y * h, Quat::IDENTITY, r)], black);
        let scene = Scene::new(&tree, Light::uniform(), Ground::Plain(Vec3::ONE)).unwrap();
        // A patch of a millimetre around the point, seen from below the disc.
        let camera = Camera::orthographic(Vec3::Y * 1e-3, 0.5, 0.05, [2e-3, 1e-4]);
        let options = Options { surroundings: false, ..options(1024) };
        let picture = render(&scene, &camera, &options, |_| ()).unwrap();
        let mean = picture.shadow.iter().sum::<f32>() / picture.shadow.len() as f32;
        let factor = r * r / (r * r + h * h);
        // A uniform dome is closed here; level ground gets its upper half: π.
        assert!((mean - factor).abs() < 0.01, "{r} {h}: {mean} {factor}");
    }
}

/// Where light grazes a round post, it fades out: faces of a coarse one do not stand out.
#[test]
fn a_coarse_post_is_lit_as_a_fine_one() {
    // Brightness from left to right, of a look from the front with the sun on the left.
    let across = |sides| {
        let bark = material(0.5, 1.0, 0.0);
        let tree = Dressed { wood: round_post(sides), bark, foliage: Vec::new() };
        let light = Light::daylight(0.2, -FRAC_PI_2, 3.0).unwrap();
        let scene = Scene::new(&tree, light, Ground::None).unwrap();
        let camera = Camera::orthographic(Vec3::Y, 0.0, 0.0, [0.16, 0.01]);
        let options = Options { size: [16, 1], samples: 512, ..options(1) };
        let picture = render(&scene, &camera, &options, |_| ()).unwrap();
        picture.pixels.iter().map(|pixel| pixel[0]).collect::<Vec<f32>>()
    };
    let (fine, coarse) = (across(256), across(7));
    for (a, b) in fine.iter().zip(&coarse) {
        assert!((a - b).abs() < 0.1 * fine[0], "{fine:?} {coarse:?}");
    }
}

#[test]
fn holes_of_leaves_let_light_and_eyes_through() {
    let image =
        |alpha: u8| Image { width: 1, height: 1, channels: 4, pixels: vec![9, 9, 9, alpha] };
    for (alpha, covered) in [(255, true), (0, false)] {
        let mask = Material {
            color_image: Some(image(alpha).into()),
            alpha_cutoff: Some(0.5),
            ..material(1.0, 0.8, 0.0)
        };
        let tree = leaves(square(), vec![leaf(Vec3::Y, Quat::IDENTITY, 1.0)], mask);
        let scene = Scene::new(&tree, Light::uniform(), Ground::Plain(Vec3::ONE)).unwrap();
        let camera = Camera::framing(scene.points(), View::Top, 1.0, 0.5).unwrap();
        let options = Options { surroundings: false, ..options(16) };
        let picture = render(&scene, &camera, &options, |_| ()).unwrap();
        let alpha: f32 = picture.pixels.iter().map(|pixel| pixel[3]).sum();
        assert_eq!(alpha > 0.0, covered);
        assert_eq!(picture.shadow.iter().any(|&shadow| shadow > 0.0), covered);
        let seen = marks(&scene, &camera, &options).unwrap();
        assert_eq!(seen.iter().any(|mark| mark.kind == Kind::Leaf), covered);
    }
}

/// A leaf lit from behind by the sun is brighter than the same leaf if it lets no light through.
#[test]
fn leaves_shine_when_the_sun_is_behind_them() {
    let from_below = |translucency| {
        let tree = leaves(
            square(),
            vec![leaf(Vec3::new(0.0, 1.0, 0.5), Quat::IDENTITY, 1.0)],
            material(0.5, 0.9, translucency),
        );
        let light = Light::overcast(1.2, 0.0, 0.9).unwrap();
        let scene = Scene::new(&tree, light, Ground::None).unwrap();
        let camera = Camera::orthographic(Vec3::Y, 0.0, -1.5, [0.1, 0.1]);
        render(&scene, &camera, &options(64), |_| ()).unwrap().mean()[0]
    };
    // The sun sheds 0.9 π on the leaf; half of half of what enters comes out below.
    let (through, opaque) = (from_below(0.5), from_below(0.0));
    assert!(through - opaque > 0.5 * 0.5 * 0.9 * 0.8, "{through} {opaque}");
}

#[test]
fn marks_say_what_stands_where() {
    let tree = Dressed { wood: post(), bark: plain_bark(), foliage: Vec::new() };
    let scene = Scene::new(&tree, Light::uniform(), Ground::Meadow).unwrap();
    let camera = Camera::framing(scene.points(), View::Front, 1.0, 0.5).unwrap();
    let options = Options { size: [65, 65], ..options(1) };
    let seen = marks(&scene, &camera, &options).unwrap();
    let middle = &seen[32 * 65 + 32];
    assert_eq!((middle.kind, middle.branch, middle.order, middle.node), (Kind::Wood, 0, 0, 0));
    // The surface of the post towards the camera, seen square.
    let (_, depth) = camera.project(Vec3::new(0.0, 1.0, 0.1)).unwrap();
    assert!((middle.depth - depth).abs() < 0.03, "{} {depth}", middle.depth);
    assert!(Vec3::from(middle.normal).dot(Vec3::Z) > 0.95);
    assert_eq!(seen[0].kind, Kind::Nothing);
    assert_eq!(seen[64 * 65].kind, Kind::Ground);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let crowd = (0..40)
        .map(|i| {
            let turn = Quat::from_rotation_y(i as f32) * Quat::from_rotation_x(0.3 * i as f32);
            leaf(Vec3::new(0.0, 1.0 + 0.02 * i as f32, 0.0), turn, 0.3)
        })
        .collect();
    let foliage = vec![Foliage {
        blade: disc(),
        leaves: crowd,
        material: material(0.4, 0.5, 0.4),
        woody: false,
    }];
    let tree = Dressed { wood: post(), bark: plain_bark(), foliage };
    let take = |threads| {
        let options = Options { size: [70, 50], samples: 48, error: 0.05, ..Options::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let light = Light::daylight(0.7, 0.2, 3.0).unwrap();
        pool.install(|| picture(&tree, light, Ground::Meadow, &options))
    };
    let one = take(1);
    assert_eq!(one, take(2));
    assert_eq!(one, take(7));
    assert!(one.samples < 70 * 50 * 48, "the sky is done early");
}

#[test]
fn cards_show_the_tree_from_each_side() {
    let tree = Dressed { wood: post(), bark: material(0.18, 1.0, 0.0), foliage: Vec::new() };
    let cards = impostor(&tree, 3, 64, 16, deeptree_graph::Seed(0)).unwrap();
    let [low, high] = [0, 2].map(|corner| cards.cards[0].corners[corner].y);
    assert!(low < 0.0 && high > 2.0 && high - low < 2.2);
    let image = &cards.color;
    let width = image.width / 3;
    for card in 0..3 {
        let at = |x: u32, y: u32| ((y * image.width + card * width + x) * 4) as usize;
        let (middle, edge) = (at(width / 2, 32), at(0, 32));
        assert_eq!(image.pixels[middle + 3], 255);
        assert_eq!(image.pixels[edge + 3], 0);
        // 18 % grey is 118 in sRGB; the boundary mirrors a little and lets a little less in.
        assert!((105..140).contains(&image.pixels[middle]), "{}", image.pixels[middle]);
        let normal = ((32 * image.width + card * width + width / 2) * 3) as usize;
        assert!(cards.normal.pixels[normal + 2] > 240, "it faces who looks");
    }
}

#[test]
fn what_cannot_be_pictured_is_refused() {
    let bare = |wood| Dressed { wood, bark: plain_bark(), foliage: Vec::new() };
    let light = Light::uniform;
    let new = |tree: &Dressed| Scene::new(tree, light(), Ground::None).map(|_| ());
    assert_eq!(new(&bare(Mesh::default())), Err(RenderError::Empty));

    let mut torn = post();
    torn.positions[3].y = f32::NAN;
    assert!(matches!(new(&bare(torn)), Err(RenderError::NotFinite { vertex: 3, .. })));
    let mut wrong = post();
    wrong.indices[0] = 1_000_000;
    assert!(matches!(new(&bare(wrong)), Err(RenderError::Index { vertex: 1_000_000, .. })));
    let mut short = post();
    short.uvs.pop();
    assert!(new(&bare(short)).is_err());

    let flat = leaf(Vec3::ZERO, Quat::IDENTITY, 0.0);
    assert!(new(&leaves(square(), vec![flat], plain_bark())).is_err());
    assert!(new(&leaves(Blade::default(), Vec::new(), plain_bark())).is_err());
    let image = Image { width: 2, height: 2, channels: 3, pixels: vec![0; 11] };
    let bark = Material { color_image: Some(image.into()), ..plain_bark() };
    let tree = Dressed { wood: post(), bark, foliage: Vec::new() };
    assert!(matches!(new(&tree), Err(RenderError::Image { bytes: 11, .. })));

    let tree = bare(post());
    let scene = Scene::new(&tree, light(), Ground::None).unwrap();
    let camera = Camera::framing(scene.points(), View::Front, 1.0, 0.5).unwrap();
    for bad in [
        Options { size: [0, 10], ..options(1) },
        Options { size: [10, 100_000], ..options(1) },
        options(0),
        Options { error: f32::NAN, ..options(1) },
        Options { depth: 0, ..options(1) },
    ] {
        assert!(render(&scene, &camera, &bad, |_| ()).is_err(), "{bad:?}");
    }
}

/// Koschmieder 1924: what is far off has the light of the horizon behind it.
#[test]
fn the_meadow_ends_in_the_light_of_the_horizon() {
    let tree = Dressed { wood: post(), bark: plain_bark(), foliage: Vec::new() };
    let light = Light::daylight(0.7, -0.8, 3.0).unwrap();
    let scene = Scene::new(&tree, light, Ground::Meadow).unwrap();
    // From so far that the last row before the horizon shows ground some kilometres away.
    let camera = Camera::framing(scene.points(), View::Front, 1.0, 0.02).unwrap();
    let side = 64;
    let options = Options { size: [side; 2], samples: 64, error: 0.0, ..Options::default() };
    let picture = render(&scene, &camera, &options, |_| ()).unwrap();
    let horizon = camera.position() + camera.axes()[2] * 1e6;
    let ([_, y], _) = camera.project(horizon).unwrap();
    let row = (y * side as f32) as usize;
    let green = |row: usize| {
        let pixels = &picture.pixels[row * side as usize..][..8];
        pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / 8.0
    };
    let (sky, far, near) = (green(row - 2), green(row + 1), green(side as usize - 1));
    assert!((far / sky - 1.0).abs() < 0.1, "{far} {sky}");
    assert!((near / sky - 1.0).abs() > 0.2, "{near} {sky}");
}
