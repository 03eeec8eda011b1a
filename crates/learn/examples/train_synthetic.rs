//! Trains both kinds on trees of a known law, and prints how fast and how well.
//!
//! `cargo run --release -p deeptree-learn --example train_synthetic -- [TREES] [EPOCHS] [WORKERS]`

#[allow(dead_code, reason = "the tests use more of it")]
#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use std::collections::BTreeMap;

use deeptree_learn::{Kind, Silent, TrainError, TrainOptions, train};

fn main() -> Result<(), TrainError> {
    let argument = |n: usize, or: u64| {
        std::env::args().nth(n).and_then(|text| text.parse().ok()).unwrap_or(or)
    };
    let set = synthetic::set(argument(1, 100));
    for kind in [Kind::Situated, Kind::Paper] {
        let folder = std::env::temp_dir().join(format!("deeptree-{kind:?}-{}", std::process::id()));
        let options = TrainOptions {
            epochs: argument(2, 4) as u32,
            steps_per_epoch: None,
            networks: BTreeMap::new(),
            workers: argument(3, 2) as usize,
            ..TrainOptions::new(kind)
        };
        let model = train(&set, &options, &folder, &Silent)?;
        println!("{kind:?}: {} bytes, {} nodes", model.report.bytes, model.report.training_nodes);
        for (name, network) in &model.report.networks {
            println!(
                "  {name}: {:.0} samples/s, {:.4?}",
                network.samples_per_second, network.total.values
            );
        }
        // A folder left behind in the temporary folder does no harm.
        let _ = std::fs::remove_dir_all(&folder);
    }
    Ok(())
}
