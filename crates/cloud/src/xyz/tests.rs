use super::*;
use crate::testing::labelled;
use crate::{ReadCloudError, ReadOptions, Reading};

fn read_text(text: &str) -> Result<Reading, ReadCloudError> {
    read(text.as_bytes(), &ReadOptions::default())
}

fn points(text: &str) -> Vec<[f32; 3]> {
    read_text(text).unwrap().cloud.points.iter().map(|p| p.to_array()).collect()
}

const TWO: [[f32; 3]; 2] = [[1.0, 2.0, 3.5], [-4.0, 5e-1, 6.0]];

#[test]
fn separators_comments_blank_lines_and_carriage_returns_make_no_difference() {
    for text in [
        "1 2 3.5\n-4 .5 6\n",
        "1,2,3.5\r\n-4,0.5,6",
        "# a comment\n\n1\t2\t3.5\t255 0 0\n   \n-4;0.5;6;1;2;3 # another\n",
        "// x y z\n1 2 3.5\n-4 0.5 6\n",
        "\u{feff}East;North;Height\n1;2;3.5\n-4;5e-1;6\n",
        "2\n1 2 3.5 -700\n-4 0.5 6 -800\n",
        "//X Y Z R G B\n2\n1 2 3.5 0 0 0\n-4 0.5 6 0 0 0\n",
        "id,z,y,x\n9,3.5,2,1\n10,6,0.5,-4\n",
    ] {
        assert_eq!(points(text), TWO, "{text:?}");
    }
}

#[test]
fn what_is_no_point_is_counted() {
    let text = "1 2 3\n1 2 nan\n1 2 3\ninf 0 0\n4 5 6\n1e300 0 0\n7 8 9\n10 1\n";
    let Reading { cloud, dropped } = read_text(text).unwrap();
    assert_eq!(cloud.len(), 3);
    assert_eq!((dropped.not_finite, dropped.duplicates), (3, 1));
    assert_eq!((dropped.malformed, dropped.first_malformed), (1, 8));
    let said = dropped.to_string();
    assert!(said.contains("line 8") && said.contains("1 at the place of another"), "{said}");
}

#[test]
fn what_is_no_cloud_is_an_error() {
    let error = |text: &str| read_text(text).unwrap_err().to_string();
    assert!(error("").contains("no points"));
    assert!(error("# x y z\n\n").contains("no points"));
    assert!(error("nan nan nan\n").contains("no points"));
    assert!(error("1 2\n3 4\n").contains("line 1"));
    assert!(error("1,5 2,5 3,5\n").contains("decimal"));
    assert!(error("ply\0\u{1}").contains("binary"));
    assert!(error(&"7".repeat(1 << 17)).contains("longer"));
}

#[test]
fn a_point_or_a_million_at_one_place_is_one_point() {
    assert_eq!(points("1 2 3"), [[1.0, 2.0, 3.0]]);
    let many = "5 5 5\n".repeat(1_000_000);
    let options = ReadOptions { limit: Some(2000), ..ReadOptions::default() };
    let Reading { cloud, dropped } = read(many.as_bytes(), &options).unwrap();
    assert_eq!((cloud.len(), dropped.duplicates, dropped.thinned), (1, 999_999, 0));
}

#[test]
fn map_coordinates_keep_their_millimetres() {
    // UTM: a tree of 20 m, measured to a millimetre.
    let at = |i: u32| {
        let step = f64::from(i) * 0.02;
        [448_262.123 + step, 5_411_932.456 + step / 2.0, 170.789 + step]
    };
    let text: String =
        (0..1000).map(|i| at(i).map(|c| format!("{c:.3}")).join(" ") + "\n").collect();
    let cloud = read_text(&text).unwrap().cloud;
    assert!(cloud.points.iter().all(|p| p.abs().max_element() < 256.0));
    for i in 0..1000 {
        let truth: [f64; 3] = at(i).map(|c| (c * 1000.0).round() / 1000.0);
        let read = cloud.position(i as usize);
        for k in 0..3 {
            assert!((truth[k] - read[k]).abs() < 1e-5, "point {i}: {truth:?} {read:?}");
        }
    }
    let mut written = Vec::new();
    write(&cloud, &mut written).unwrap();
    let again = read(&written[..], &ReadOptions::default()).unwrap().cloud;
    for i in 0..1000 {
        let difference = (again.position(i)[1] - cloud.position(i)[1]).abs();
        assert!(difference <= 1e-6, "{difference}");
    }
}

#[test]
fn one_stray_point_does_not_move_the_origin() {
    let text = format!("9e9 9e9 9e9\n{}", "500000.25 500000.5 3\n500001 500001 4\n".repeat(3));
    let cloud = read_text(&text).unwrap().cloud;
    assert_eq!(cloud.position(1), [500_000.25, 500_000.5, 3.0]);
}

#[test]
fn what_is_written_reads_the_same() {
    let cloud = labelled([0.0; 3]);
    let mut text = Vec::new();
    write(&cloud, &mut text).unwrap();
    assert_eq!(read(&text[..], &ReadOptions::default()).unwrap().cloud, cloud);
}

#[test]
fn a_limit_holds_and_keeps_the_shape() {
    // A plane of 4 m × 4 m, more points than may be held.
    let text: String = (0..40_000)
        .map(|i| format!("{} {} 0\n", (i % 200) as f32 * 0.02, (i / 200) as f32 * 0.02))
        .collect();
    let options = ReadOptions { limit: Some(5000), ..ReadOptions::default() };
    let Reading { cloud, dropped } = read(text.as_bytes(), &options).unwrap();
    assert!(cloud.len() <= 5000 && cloud.len() > 1000, "{}", cloud.len());
    assert_eq!(dropped.thinned as usize + cloud.len(), 40_000);
    let (low, high) = cloud.bounds().unwrap();
    assert!((high - low).truncate().min_element() > 3.8);
    // Thinned on the way or at once: the same points stay.
    let mut whole = read_text(&text).unwrap().cloud;
    whole.thin(dropped.voxel);
    assert_eq!(whole, cloud);
}
