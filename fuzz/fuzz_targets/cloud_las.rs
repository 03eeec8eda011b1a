//! Any bytes as LAS or LAZ: what reads is written and read again.
#![no_main]

use std::io::Cursor;
use std::sync::Once;

use deeptree_cloud::{ReadOptions, Reading, las};
use libfuzzer_sys::fuzz_target;

static HOOK: Once = Once::new();

fuzz_target!(|bytes: &[u8]| {
    // The hook of libFuzzer aborts before the reader can turn a panic into an error.
    HOOK.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let options = ReadOptions { limit: Some(1 << 12), ..ReadOptions::default() };
    let Ok(Reading { cloud, .. }) = las::read(bytes, &options) else { return };
    // Packing takes nearly all of the time.
    let packed = bytes.len().is_multiple_of(64);
    let mut out = Cursor::new(Vec::new());
    las::write(&cloud, packed, &mut out).expect("memory takes all");
    let again = las::read(&out.get_ref()[..], &ReadOptions::default());
    // Not `assert!`: it would panic without a word.
    if !again.is_ok_and(|again| again.cloud.len() <= cloud.len()) {
        eprintln!("a written file reads back as another cloud");
        std::process::abort();
    }
});
