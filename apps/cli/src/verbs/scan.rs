//! `scan`: a simulated laser scan of a tree.

use anyhow::Result;
use deeptree_cloud::Up;
use deeptree_graph::Seed;
use deeptree_mesh::{Dressed, Look, TEXTURE_SIZES, WoodOptions, dress, wood};
use deeptree_scan::{Pattern, Target, scan};
use serde_json::json;

use crate::args::{self, Args, UsageError};
use crate::clouds::{self, CloudFormat};
use crate::output::is_stdout;
use crate::{input, report};

pub(crate) fn run(args: &Args, verb: &args::Scan) -> Result<()> {
    let format = CloudFormat::of(&verb.output, verb.format)?;
    let pattern = pattern(&verb.scanner)?;
    if let Some(threads) = verb.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
        pool.build_global()?;
    }
    let mut scanned = None;
    input::read_chosen(&verb.input, &verb.model, verb.tree, false, |_, made| {
        let surface = wood(&made.tree, &WoodOptions::default());
        // Of the pictures only the outlines of leaves count.
        let look =
            Look { leaves: verb.leaves, texture_size: *TEXTURE_SIZES.start(), ..Look::default() };
        let Dressed { wood, foliage, .. } = dress(&made.tree, surface, &look)?;
        let target = if verb.ground {
            Target::on_ground(&made.tree, &wood, &foliage, GROUND)
        } else {
            Target::new(&made.tree, &wood, &foliage)
        };
        scanned = Some(scan(&target, &pattern, Seed(verb.seed)).with_up(Up::Z));
        Ok(())
    })?;
    let cloud = scanned.unwrap_or_default();
    clouds::not_empty(&cloud)?;
    clouds::write(&verb.output, format, &cloud)?;
    let mut figures = clouds::figures(&cloud);
    let text = format!("{} → {}", clouds::text(&figures), verb.output.display());
    figures["pattern"] = json!(format!("{:?}", pattern.kind).to_lowercase());
    figures["seed"] = json!(verb.seed);
    report::say(args, &figures, &text, is_stdout(&verb.output));
    Ok(())
}

/// The ground reaches so far beyond the crown, in metres.
const GROUND: f32 = 2.0;

/// The pattern that is asked for.
pub(crate) fn pattern(scanner: &args::Scanner) -> Result<Pattern> {
    let usual = Pattern::usual(scanner.pattern.into());
    let pattern = Pattern {
        stations: scanner.stations.unwrap_or(usual.stations),
        step: scanner.step.map_or(usual.step, f64::to_radians),
        noise: scanner.noise.unwrap_or(usual.noise),
        divergence: scanner.divergence.map_or(usual.divergence, |angle| angle / 1e3),
        points: scanner.points.map(|points| points as usize).or(usual.points),
        ..usual
    };
    pattern.validate().map_err(|error| UsageError(error.to_string()))?;
    Ok(pattern)
}
