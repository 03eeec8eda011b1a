use std::error::Error;

use super::*;
use crate::testing::{FAR, labelled};
use crate::{Cloud, ReadOptions, Up};

fn written(cloud: &Cloud) -> Vec<u8> {
    let mut out = Vec::new();
    write(cloud, &mut out).unwrap();
    out
}

#[test]
fn what_is_written_reads_the_same() {
    for origin in [[0.0; 3], FAR] {
        for up in [Up::Y, Up::Z] {
            let cloud = Cloud { up, ..labelled(origin) };
            let reading = read_bytes(written(&cloud), &ReadOptions::default()).unwrap();
            assert!(reading.dropped.is_empty(), "{}", reading.dropped);
            assert_eq!(reading.cloud, cloud);
        }
    }
}

#[test]
fn clouds_of_one_table_keep_apart() {
    let path = tempfile::NamedTempFile::new().unwrap();
    let mut clouds = [labelled([0.0; 3]), labelled([0.0; 3])];
    clouds[1].points.iter_mut().for_each(|p| p.x += 1.0);
    let mut table = ScanWriter::new(path.reopen().unwrap(), &clouds[0]).unwrap();
    table.write(7, &clouds[0]).unwrap();
    table.write(9, &clouds[1]).unwrap();
    assert!(matches!(table.write(10, &labelled(FAR)), Err(WriteCloudError::Unlike { tree: 10 })));
    table.finish().unwrap();
    let scans = Scans::open(path.reopen().unwrap(), &ReadOptions::default()).unwrap();
    let scans: Vec<(u32, Cloud)> =
        scans.map(|scan| scan.map(|(tree, reading)| (tree, reading.cloud)).unwrap()).collect();
    assert_eq!(scans, [(7, clouds[0].clone()), (9, clouds[1].clone())]);
}

#[test]
fn damaged_tables_are_errors() {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let bytes = written(&labelled([0.0; 3]));
    let read = |bytes: Vec<u8>| read_bytes(bytes, &ReadOptions::default());
    assert!(read(Vec::new()).is_err());
    for length in (0..bytes.len()).step_by(101) {
        assert!(read(bytes[..length].to_vec()).is_err());
    }
    for k in 0..500usize {
        let mut damaged = bytes.clone();
        let at = bytes.len() - 1 - k * 7919 % bytes.len();
        damaged[at] ^= 1 << (k % 8);
        let _ = read(damaged);
    }
    std::panic::set_hook(hook);
    let error = read(b"PAR1 is not enough PAR1".to_vec()).unwrap_err();
    assert!(error.source().is_some(), "{error}");
}
