//! Any bytes as a Parquet table of points: what reads is written and read again.
#![no_main]

use std::sync::Once;

use deeptree_cloud::{ReadOptions, Reading, table};
use libfuzzer_sys::fuzz_target;

static HOOK: Once = Once::new();

fuzz_target!(|bytes: &[u8]| {
    // The hook of libFuzzer aborts before the reader can turn a panic into an error.
    HOOK.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let options = ReadOptions { limit: Some(1 << 12), ..ReadOptions::default() };
    let Ok(Reading { cloud, .. }) = table::read_bytes(bytes.to_vec(), &options) else { return };
    let mut out = Vec::new();
    table::write(&cloud, &mut out).expect("memory takes all");
    let again = table::read_bytes(out, &ReadOptions::default());
    // Not `assert!`: it would panic without a word.
    if !again.is_ok_and(|again| again.cloud.len() <= cloud.len()) {
        eprintln!("a written table reads back as another cloud");
        std::process::abort();
    }
});
