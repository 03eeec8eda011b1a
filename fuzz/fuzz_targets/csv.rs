//! Skeleton tables in CSV: any bytes are an error or trees that read back as the same bits.
#![no_main]

use deeptree_graph::TreeInfo;
use deeptree_graph::codec::csv::{CsvWriter, read};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let info = TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: 0 };
    let Ok(trees) = read(bytes, &info) else { return };
    let mut table = CsvWriter::new(Vec::new()).expect("memory takes all bytes");
    for (number, tree) in &trees {
        table.write(*number, tree).expect("memory takes all bytes");
    }
    let table = table.finish().expect("memory takes all bytes");
    assert_eq!(read(&table, &info).expect("a written table is a table"), trees);
});
