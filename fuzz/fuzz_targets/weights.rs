//! Model files: any bytes are an error or a model.
#![no_main]

use deeptree_infer::{Model, Predictor, Weights};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(weights) = Weights::from_bytes(bytes)
        && let Ok(model) = Model::from_weights(&weights)
    {
        assert!((0..model.species().len()).all(|species| !model.roots(species).is_empty()));
        for trend in (0..model.species().len()).filter_map(|species| model.trend(species)) {
            assert!(trend.at(25.0, 0.1).into_iter().all(f64::is_finite));
        }
    }
});
