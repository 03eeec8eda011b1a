//! Species presets: any text is an error or a valid set of parameters.
#![no_main]

use deeptree_growth::{Profile, Species};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(species) = Species::from_toml("fuzzed", text) {
        for profile in [Profile::Reference, Profile::Published] {
            assert_eq!(species.parameters(profile).validate(), Ok(()));
        }
    }
});
