use std::error::Error;

use super::*;
use crate::testing::{FAR, labelled};
use crate::{Cloud, ReadCloudError, ReadOptions, Reading, Up};

fn read_bytes(bytes: &[u8]) -> Result<Reading, ReadCloudError> {
    read(bytes, &ReadOptions::default())
}

fn cloud(bytes: &[u8]) -> Cloud {
    let reading = read_bytes(bytes).unwrap();
    assert!(reading.dropped.is_empty(), "{}", reading.dropped);
    reading.cloud
}

const HEADER: &str = "ply\nformat FORMAT 1.0\ncomment made by hand, y up\n\
    element camera 2\nproperty list uchar int pixels\nproperty float f\n\
    element vertex 2\nproperty uchar red\nproperty list uchar short around\n\
    property float z\nproperty double y\nproperty short x\nproperty int scalar_Classification\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n";

fn body(one: impl Fn(f64, usize) -> Vec<u8>) -> Vec<u8> {
    // Camera: 3 pixels and f, no pixels and f. Vertices: red, list, z, y, x, class.
    let cameras = [(3.0, 1), (5.0, 4), (6.0, 4), (7.0, 4), (0.5, 14), (0.0, 1), (0.5, 14)];
    let first = [(9.0, 1), (1.0, 1), (8.0, 2), (3.0, 14), (2.25, 18), (-1.0, 2), (64.0, 4)];
    let second = [(9.0, 1), (0.0, 1), (6.0, 14), (5.5, 18), (4.0, 2), (65.0, 4)];
    let face = [(3.0, 1), (0.0, 4), (1.0, 4), (0.0, 4)];
    let all = [&cameras[..], &first, &second, &face].concat();
    all.into_iter().flat_map(|(value, size)| one(value, size)).collect()
}

/// Sizes of 14 and 18 are floats of 4 and 8 bytes.
fn little(value: f64, size: usize) -> Vec<u8> {
    match size {
        14 => (value as f32).to_le_bytes().to_vec(),
        18 => value.to_le_bytes().to_vec(),
        size => (value as i64).to_le_bytes()[..size].to_vec(),
    }
}

fn big(value: f64, size: usize) -> Vec<u8> {
    little(value, size).into_iter().rev().collect()
}

fn file(format: &str, one: impl Fn(f64, usize) -> Vec<u8>) -> Vec<u8> {
    let mut bytes = HEADER.replace("FORMAT", format).into_bytes();
    bytes.extend(body(one));
    bytes
}

#[test]
fn the_three_encodings_give_one_cloud_whatever_stands_around_it() {
    let ascii = file("ascii", |value, _| format!("{value}\n").into_bytes());
    let little = file("binary_little_endian", little);
    let big = file("binary_big_endian", big);
    for bytes in [ascii, little, big] {
        let cloud = cloud(&bytes);
        let points: Vec<_> = cloud.points.iter().map(|p| p.to_array()).collect();
        assert_eq!(points, [[-1.0, 2.25, 3.0], [4.0, 5.5, 6.0]]);
        assert_eq!(cloud.up, Up::Y);
        assert_eq!(cloud.columns.class.unwrap().map_codes(), [64, 65]);
    }
}

trait Codes {
    fn map_codes(self) -> Vec<u8>;
}

impl Codes for Vec<crate::Class> {
    fn map_codes(self) -> Vec<u8> {
        self.into_iter().map(crate::Class::code).collect()
    }
}

#[test]
fn what_is_written_reads_the_same() {
    for origin in [[0.0; 3], FAR] {
        for up in [Up::Y, Up::Z] {
            let original = Cloud { up, ..labelled(origin) };
            let mut bytes = Vec::new();
            write(&original, &mut bytes).unwrap();
            assert_eq!(cloud(&bytes), original);
        }
    }
}

#[test]
fn a_truncated_file_says_how_much_is_missing() {
    let mut bytes = Vec::new();
    write(&labelled([0.0; 3]), &mut bytes).unwrap();
    let row = 12 + 4 + 1 + 4 + 2 + 4 + 2;
    bytes.truncate(bytes.len() - 10 * row - 1);
    let Reading { cloud, dropped } = read_bytes(&bytes).unwrap();
    assert_eq!((cloud.len(), dropped.missing), (489, 11));
}

#[test]
fn hostile_headers_are_refused_without_taking_memory() {
    let promise = |count: &str, before: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\n{before}element vertex {count}\n\
             property float x\nproperty float y\nproperty float z\nend_header\n"
        )
    };
    let mut billions = promise("4294967295", "").into_bytes();
    billions.extend([0; 24]);
    let Reading { cloud, dropped } = read_bytes(&billions).unwrap();
    assert_eq!((cloud.len(), dropped.missing, dropped.duplicates), (1, 4_294_967_293, 1));
    let refused = |text: String| {
        let error = read_bytes(text.as_bytes()).unwrap_err();
        let cause = error.source().map(ToString::to_string).unwrap_or_default();
        format!("{error}: {cause}")
    };
    assert!(refused(promise("18446744073709551615", "")).contains("no points"));
    assert!(refused(promise("-1", "")).contains("line 3"));
    assert!(refused(promise("1", "element nothing 18446744073709551615\n")).contains("no points"));
    let list = "element l 1\nproperty list uint double v\n";
    let mut endless = promise("1", list).into_bytes();
    endless.extend([0xff; 40]);
    assert!(read_bytes(&endless).is_err());
    assert!(refused("ply\n".repeat(3)).contains("line 2"));
    assert!(refused("ply\nformat ascii 1.0\n".to_owned()).contains("cut off"));
    assert!(refused("ply\nend_header\n".to_owned()).contains("format"));
    assert!(refused("ply\nformat ascii 1.0\nend_header\n".to_owned()).contains("vertex"));
    assert!(refused(format!("ply\ncomment {}\n", "x".repeat(1 << 20))).contains("cut off"));
    assert!(refused(String::new()).contains("line `ply`"));
}
