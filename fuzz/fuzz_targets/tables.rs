//! Skeleton tables in Parquet: any bytes are an error or trees that read back as the same bits.
#![no_main]

use std::sync::Once;

use deeptree_export::tables::{TableMeta, TableReader, TableWriter};
use deeptree_graph::{BranchGraph, TreeInfo};
use libfuzzer_sys::fuzz_target;

static QUIET: Once = Once::new();

fn read(bytes: &[u8]) -> Option<Vec<(u32, BranchGraph)>> {
    let info = TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: 0 };
    TableReader::from_bytes(bytes.to_vec(), info).ok()?.collect::<Result<_, _>>().ok()
}

fuzz_target!(|bytes: &[u8]| {
    // The hook of libFuzzer aborts before the reader can turn a panic into an error.
    QUIET.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let Some(trees) = read(bytes) else { return };
    let mut table = TableWriter::new(Vec::new(), &TableMeta::default()).expect("memory is there");
    for (number, tree) in &trees {
        table.write(*number, tree).expect("memory is there");
    }
    let table = table.finish().expect("memory is there");
    // Not `assert!`: it would panic without a word.
    if read(&table).as_ref() != Some(&trees) {
        eprintln!("a written table reads back as other trees");
        std::process::abort();
    }
});
