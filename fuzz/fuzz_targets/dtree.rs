//! `.dtree` files: any bytes are an error or written back as they are.
#![no_main]

use deeptree_graph::codec::dtree::SeedFile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = SeedFile::from_bytes(bytes) {
        assert_eq!(file.to_bytes(), bytes);
    }
});
