//! `.tree` files: any bytes are an error or a tree that is written as as many nodes.
#![no_main]

use deeptree_graph::TreeInfo;
use deeptree_graph::codec::tree_format::{read, write};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let info = TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: 0 };
    let Ok(tree) = read(bytes, info.clone()) else { return };
    let mut text = Vec::new();
    write(&mut text, &tree).expect("memory takes all bytes");
    // Positions may move by a rounding, which decides near the largest numbers.
    if let Ok(back) = read(&text, info) {
        assert_eq!(back.len(), tree.len());
    }
});
