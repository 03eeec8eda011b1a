//! Any bytes as text of points: what reads is written and read again.
#![no_main]

use deeptree_cloud::{ReadOptions, Reading, xyz};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions { limit: Some(1 << 12), ..ReadOptions::default() };
    let Ok(Reading { cloud, .. }) = xyz::read(bytes, &options) else { return };
    let mut text = Vec::new();
    xyz::write(&cloud, &mut text).expect("memory takes all");
    let again = xyz::read(&text[..], &ReadOptions::default()).expect("what was written reads");
    assert!(again.cloud.len() <= cloud.len());
});
