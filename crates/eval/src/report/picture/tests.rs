use deeptree_graph::{BranchGraph, ChildSignature, Quat, TreeInfo, Vec3};
use tiny_skia::Pixmap;

use super::*;

fn edge(rotation: Quat, length: f32) -> ChildSignature {
    ChildSignature { rotation, thickness: 0.5, length }
}

/// A trunk of 10 m and half a metre, with an arm of 6 m to the right (+x) at its top.
fn gallows() -> BranchGraph {
    let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
    let upright = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::Y);
    let aside = upright.inverse() * Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::X);
    let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(upright, 10.0));
    tree.grow(0, [None, Some(edge(aside, 6.0)), None]);
    tree
}

/// Left, top, right and bottom of the pixels that are darker than the line of the ground.
fn dark(pixmap: &Pixmap) -> [usize; 4] {
    let width = pixmap.width() as usize;
    let dark = |(_, pixel): &(usize, &tiny_skia::PremultipliedColorU8)| pixel.red() < 160;
    let pixels = pixmap.pixels().iter().enumerate().filter(dark);
    pixels.fold([usize::MAX, usize::MAX, 0, 0], |[left, top, right, bottom], (i, _)| {
        let (x, y) = (i % width, i / width);
        [left.min(x), top.min(y), right.max(x), bottom.max(y)]
    })
}

fn near(a: [usize; 4], b: [usize; 4]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 1)
}

#[test]
fn a_tree_covers_the_pixels_it_should() {
    // The gallows are 7 m wide (−0.5 to 6.5) and reach from 0 to 10.5 m: at 10 pixels a metre the
    // sheet is full, but for a strip of 5 pixels below the ground, where nothing is.
    let sheet = Sheet { columns: 1, width: 70, row: 105 };
    let tree = gallows();
    let picture = sheet.draw(&[Shot::new(&tree, View::FRONT)]).unwrap();
    assert_eq!((picture.width(), picture.height()), (70 + 16, 105 + 16));
    assert!(near(dark(&picture), [8, 8, 77, 112]), "{:?}", dark(&picture));
    // The trunk is at the left edge and the arm at the top; below the arm there is nothing.
    let level = |x, y| picture.pixel(x, y).unwrap().red();
    assert!(level(13, 60) < 160 && level(60, 13) < 160);
    assert_eq!(level(60, 60), 255);
    // Light comes from the left.
    assert!(level(10, 60) > level(16, 60));
}

#[test]
fn behind_it_is_mirrored_and_from_the_side_the_arm_hides_the_trunk_only() {
    let tree = gallows();
    let sheet = Sheet { columns: 1, width: 70, row: 105 };
    let back = sheet.draw(&[Shot::new(&tree, View::BACK)]).unwrap();
    let level = |x, y| back.pixel(x, y).unwrap().red();
    assert!(level(86 - 13, 60) < 160);
    assert_eq!(level(86 - 60, 60), 255);
    // From the side it is a post of 1 m: the height decides the scale.
    let side = sheet.draw(&[Shot::new(&tree, View::SIDE)]).unwrap();
    assert!(near(dark(&side), [8, 8, 17, 112]), "{:?}", dark(&side));
    // From above it is a bar of 1 m.
    let top = sheet.draw(&[Shot::new(&tree, View::TOP)]).unwrap();
    let [left, _, right, _] = dark(&top);
    assert!(left.abs_diff(8) <= 1 && right.abs_diff(77) <= 1);
    assert_eq!(top.height(), 10 + 16);
}

#[test]
fn trees_of_a_sheet_have_one_scale_and_one_ground() {
    let large = gallows();
    let upright = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::Y);
    let small = BranchGraph::new(large.info.clone(), Vec3::ZERO, edge(upright, 4.5));
    let sheet = Sheet { columns: 2, width: 80, row: 1000 };
    let [high, low] = [&large, &small].map(|tree| Shot::new(tree, View::FRONT));
    // Columns of 7 and 1 m, rows of 10.5 and 5 m with their margins: 10 pixels a metre.
    let picture = sheet.draw(&[high, low, Shot::empty(View::FRONT), low]).unwrap();
    assert_eq!((picture.width(), picture.height()), (80 + 32, 105 + 50 + 32));
    let level = |x, y| picture.pixel(x, y).unwrap().red();
    // The small tree's middle is at 70 + 16 + 8 + 5 pixels; it stands on the ground of its row and
    // ends 5 m above.
    for ground in [8 + 105, 8 + 105 + 16 + 50] {
        assert!(level(99, ground - 2) < 160 && level(99, ground - 49) < 160);
        assert!(level(99, ground + 1) == 255 && level(99, ground - 52) == 255);
        assert!(level(84, ground) < 255, "the line of the ground");
    }
    // The empty cell is empty above its ground.
    assert!((121..170).all(|y| (0..86).all(|x| level(x, y) == 255)));
}

#[test]
fn a_box_around_a_tree_is_pale_behind_it_and_widens_its_cell() {
    let tree = gallows();
    // From 8 to 10 m on the right, 4 m high.
    let corner = |i: usize| {
        let pick = |bit: usize, low: f32, high: f32| if i >> bit & 1 == 1 { high } else { low };
        Vec3::new(pick(0, 8.0, 10.0), pick(1, 0.0, 4.0), pick(2, -3.0, 3.0))
    };
    let boxes = [std::array::from_fn(corner)];
    let sheet = Sheet { columns: 1, width: 105, row: 105 };
    let shot = Shot::new(&tree, View::FRONT).among(&boxes);
    let picture = sheet.draw(&[shot]).unwrap();
    // From −0.5 to 10 m, at 10 pixels a metre.
    assert_eq!(picture.width(), 105 + 16);
    let level = |x, y| picture.pixel(x, y).unwrap().red();
    let (middle, ground) = (8 + 5 + 90, 8 + 105);
    assert!((160..250).contains(&level(middle, ground - 20)));
    assert_eq!([level(middle, ground - 45), level(middle - 15, ground - 20)], [255; 2]);
    // From above the arm ends 1.5 m before it, and it is 6 m deep.
    let boxes = [boxes[0].map(|corner| corner - 5.0 * Vec3::X)];
    let top = sheet.draw(&[Shot::new(&tree, View::TOP).among(&boxes)]).unwrap();
    assert_eq!(top.height(), 60 * 105 / 70 + 16);
    let pale = |x: f32, z: f32| {
        let (x, z) = (8.0 + 15.0 * (x + 0.5), 8.0 + 15.0 * (z + 3.0));
        (160..250).contains(&top.pixel(x as u32, z as u32).unwrap().red())
    };
    assert!(pale(4.0, 2.0) && pale(4.0, -2.0) && !pale(4.0, 0.0) && !pale(6.0, 2.0));
}

#[test]
fn a_picture_is_a_png_file_and_the_same_each_time() {
    let tree = gallows();
    let sheet = Sheet { columns: 1, width: 70, row: 105 };
    let shots = [Shot::new(&tree, View::QUARTER)];
    let png = sheet.png(&shots).unwrap();
    assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
    assert_eq!(png, sheet.png(&shots).unwrap());
}

#[test]
fn no_tree_or_no_pixels_are_errors() {
    let sheet = Sheet { columns: 2, width: 140, row: 105 };
    assert_eq!(sheet.png(&[]), Err(PictureError::NoTree));
    assert_eq!(sheet.png(&[Shot::empty(View::TOP)]), Err(PictureError::NoTree));
    let wide = Sheet { columns: 1, width: 10_000, row: 10_000 };
    let tree = gallows();
    let error = wide.png(&[Shot::new(&tree, View::FRONT)]);
    assert!(matches!(error, Err(PictureError::Size { .. })), "{error:?}");
}
