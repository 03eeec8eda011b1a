//! Any bytes as PLY: what reads is written and read again.
#![no_main]

use deeptree_cloud::{ReadOptions, Reading, ply};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions { limit: Some(1 << 12), ..ReadOptions::default() };
    let Ok(Reading { cloud, .. }) = ply::read(bytes, &options) else { return };
    let mut out = Vec::new();
    ply::write(&cloud, &mut out).expect("memory takes all");
    let again = ply::read(&out[..], &ReadOptions::default()).expect("what was written reads");
    assert!(again.cloud.len() <= cloud.len());
});
