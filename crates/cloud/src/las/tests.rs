use std::error::Error;
use std::io::Cursor;

use super::*;
use crate::testing::{FAR, labelled};
use crate::{Class, Cloud, ReadCloudError, ReadOptions, Reading};

fn read_bytes(bytes: &[u8]) -> Result<Reading, ReadCloudError> {
    read(bytes, &ReadOptions::default())
}

fn written(cloud: &Cloud, packed: bool) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write(cloud, packed, &mut out).unwrap();
    out.into_inner()
}

/// Packed where this build can.
const WAYS: &[bool] = if cfg!(feature = "laz") { &[false, true] } else { &[false] };

fn assert_near(a: &Cloud, b: &Cloud) {
    assert_eq!(a.len(), b.len());
    for i in 0..a.len() {
        let (p, q) = (a.position(i), b.position(i));
        assert!((0..3).all(|k| (p[k] - q[k]).abs() < 0.5e-4 + 1e-6), "{p:?} {q:?}");
    }
    assert_eq!(a.columns, b.columns);
}

#[test]
fn what_is_written_reads_the_same_to_a_tenth_of_a_millimetre() {
    for origin in [[0.0; 3], FAR] {
        for &packed in WAYS {
            let cloud = labelled(origin);
            let Reading { cloud: again, dropped } = read_bytes(&written(&cloud, packed)).unwrap();
            assert!(dropped.is_empty(), "{dropped}");
            assert_near(&cloud, &again);
        }
    }
}

#[test]
fn another_program_reads_what_is_written() {
    let cloud = labelled(FAR);
    for &packed in WAYS {
        let mut reader = ::las::Reader::new(Cursor::new(written(&cloud, packed))).unwrap();
        let header = reader.header().clone();
        assert_eq!(header.number_of_points(), cloud.len() as u64);
        let bounds = header.bounds();
        assert!((bounds.min.x - (FAR[0] - 70.0 / 1024.0)).abs() < 1e-4, "{bounds:?}");
        let points = reader.read_all().unwrap();
        for (i, point) in points.points().map(Result::unwrap).enumerate() {
            let place = cloud.position(i);
            let theirs = [point.x, point.y, point.z];
            assert!((0..3).all(|k| (place[k] - theirs[k]).abs() < 1e-4), "{place:?} {theirs:?}");
            let ours = cloud.columns.get(i);
            assert_eq!(f32::from(point.intensity), ours.intensity);
            assert_eq!(u8::from(point.classification), ours.class.code());
            assert_eq!(point.point_source_id, ours.station);
            assert_eq!(point.extra_bytes[..4], ours.branch.to_le_bytes());
        }
    }
}

#[test]
fn what_another_program_writes_is_read() {
    for (minor, format) in [(2, 0), (2, 1), (2, 3), (4, 6), (4, 7), (4, 8)] {
        for &packed in WAYS {
            let mut builder = ::las::Builder::from((1, minor));
            builder.point_format = ::las::point::Format::new(format).unwrap();
            builder.point_format.is_compressed = packed;
            let step = |offset| ::las::Transform { scale: 0.001, offset };
            builder.transforms =
                ::las::Vector { x: step(FAR[0]), y: step(FAR[1]), z: step(FAR[2]) };
            let format = builder.point_format;
            let header = builder.into_header().unwrap();
            let mut writer = ::las::Writer::new(Cursor::new(Vec::new()), header).unwrap();
            for i in 0..1000u16 {
                writer
                    .write_point(::las::Point {
                        x: FAR[0] + f64::from(i) * 0.25,
                        y: FAR[1] - f64::from(i) * 0.125,
                        z: FAR[2] + 1.5,
                        intensity: i,
                        classification: ::las::point::Classification::Ground,
                        point_source_id: 7,
                        gps_time: format.has_gps_time.then_some(1.0),
                        color: format.has_color.then(::las::Color::default),
                        nir: format.has_nir.then_some(3),
                        ..::las::Point::default()
                    })
                    .unwrap();
            }
            let bytes = writer.into_inner().unwrap().into_inner();
            let Reading { cloud, dropped } = read_bytes(&bytes).unwrap();
            assert!(dropped.is_empty(), "{dropped}");
            assert_eq!(cloud.len(), 1000);
            let place = cloud.position(999);
            let truth = [FAR[0] + 249.75, FAR[1] - 124.875, FAR[2] + 1.5];
            assert!((0..3).all(|k| (place[k] - truth[k]).abs() < 1e-4), "{place:?} {truth:?}");
            let point = cloud.columns.get(999);
            assert_eq!((point.intensity, point.class, point.station), (999.0, Class::Ground, 7));
        }
    }
}

#[test]
fn a_truncated_file_says_how_much_is_missing() {
    let cloud = labelled([0.0; 3]);
    let mut plain = written(&cloud, false);
    plain.truncate(plain.len() - 100 * 40 - 7);
    let Reading { cloud: cut, dropped } = read_bytes(&plain).unwrap();
    assert_eq!((cut.len(), dropped.missing), (399, 101));
    for &packed in WAYS {
        let bytes = written(&cloud, packed);
        for length in (0..bytes.len()).step_by(23) {
            if let Ok(Reading { cloud: cut, dropped }) = read_bytes(&bytes[..length]) {
                assert_eq!(cut.len() as u64 + dropped.missing + dropped.duplicates, 500);
            }
        }
    }
}

#[test]
fn hostile_headers_are_refused_without_taking_memory() {
    let refused = |change: &dyn Fn(&mut Vec<u8>), part: &str| {
        for &packed in WAYS {
            let mut bytes = written(&labelled([0.0; 3]), packed);
            change(&mut bytes);
            let error = read_bytes(&bytes).unwrap_err();
            let cause = error.source().map(ToString::to_string).unwrap_or_default();
            assert!(format!("{error}: {cause}").contains(part), "{error}: {cause}");
        }
    };
    refused(&|b| b[0] = b'X', "LASF");
    refused(&|b| b.truncate(200), "cut off");
    refused(&|b| b[94..96].fill(0), "length of the header");
    refused(&|b| b[96..100].fill(0), "offset of the points");
    refused(&|b| b[104] = 63, "point format");
    refused(&|b| b[105..107].fill(0), "size of a point");
    refused(&|b| b[131..139].fill(0xff), "no points");
    for &packed in WAYS {
        let mut bytes = written(&labelled([0.0; 3]), packed);
        bytes[247..255].fill(0x7f);
        let Reading { cloud, dropped } = read_bytes(&bytes).unwrap();
        assert!(cloud.len() <= 500 && dropped.missing > 1 << 60);
        bytes[100..104].fill(0xff);
        let _ = read_bytes(&bytes);
    }
}

#[cfg(feature = "laz")]
#[test]
fn a_packing_of_items_of_other_sizes_than_theirs_is_refused() {
    // A point of 30 bytes that is told to be a colour of 6 made the library read sizes elsewhere:
    // a file of 627 bytes took 4 GB.
    let mut bytes = written(&labelled([0.0; 3]), true);
    let name = b"laszip encoded";
    let record = bytes.windows(name.len()).position(|found| found == name).unwrap() + 52;
    let first = record + 34;
    assert_eq!(bytes[first..first + 4], [10, 0, 30, 0]);
    bytes[first] = 11;
    let error = read_bytes(&bytes).unwrap_err();
    assert!(matches!(error, ReadCloudError::Las(LasError::Packing)), "{error}");
}

/// A packed file of this point format whose packed part is all ones: each number in it is the
/// last that there is.
#[cfg(feature = "laz")]
fn all_ones(format: u8) -> Vec<u8> {
    const LENGTH: u16 = 227;
    const ONES: u32 = 1 << 18;
    let packing = laz::LazVlrBuilder::default().with_point_format(format, 0).unwrap().build();
    let mut record = Vec::new();
    packing.write_to(&mut record).unwrap();
    let mut bytes = vec![0; usize::from(LENGTH)];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, b"LASF");
    put(24, &[1, 2]);
    put(94, &LENGTH.to_le_bytes());
    put(96, &(u32::from(LENGTH) + 54 + record.len() as u32).to_le_bytes());
    put(100, &1u32.to_le_bytes());
    put(104, &[format | 0x80]);
    put(105, &(packing.items_size() as u16).to_le_bytes());
    put(107, &1000u32.to_le_bytes());
    (0..3).for_each(|axis| put(131 + 8 * axis, &0.01f64.to_le_bytes()));
    let mut head = [0; 54];
    head[2..16].copy_from_slice(b"laszip encoded");
    head[18..20].copy_from_slice(&22204u16.to_le_bytes());
    head[20..22].copy_from_slice(&(record.len() as u16).to_le_bytes());
    bytes.extend(head);
    bytes.extend(record);
    // Where the table of chunks is, which nobody reads, and the first point.
    bytes.extend(vec![0; 8 + packing.items_size() as usize]);
    let layers = match format {
        ..6 => 1,
        6 => 9,
        _ => 10,
    };
    if layers > 1 {
        bytes.extend(1000u32.to_le_bytes());
        bytes.extend(ONES.to_le_bytes().repeat(layers));
    }
    bytes.extend(vec![0xff; ONES as usize * layers]);
    bytes
}

#[cfg(feature = "laz")]
#[test]
fn times_that_change_their_sequence_without_end_take_no_stack() {
    // The library calls itself for each change, a hundred thousand times in eight megabytes.
    for format in [1, 3, 6, 7] {
        let error = read_bytes(&all_ones(format)).unwrap_err();
        assert!(matches!(error, ReadCloudError::Las(LasError::Damaged)), "{format}: {error}");
    }
}

#[test]
fn damaged_bytes_never_panic() {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    for &packed in WAYS {
        let bytes = written(&labelled([0.0; 3]), packed);
        for k in 0..1000usize {
            let mut damaged = bytes.clone();
            let at = k * 7919 % bytes.len().min(4000);
            damaged[at] ^= 1 << (k % 8);
            damaged[(at * 31 + k) % bytes.len()] = (k % 256) as u8;
            let _ = read_bytes(&damaged);
        }
    }
    std::panic::set_hook(hook);
}
