//! From a target and a pattern to a cloud.

use deeptree_cloud::{Cloud, Columns, Up};
use deeptree_graph::{Lineage, Purpose, Seed};

use crate::beam::{Echo, echo};
use crate::fans::{Angles, fans};
use crate::pattern::{Kind, Pattern};
use crate::random_rays::{RandomRays, point_count};
use crate::target::Target;

/// Random rays that are cast together.
const ROUND: u64 = 1 << 14;
/// Rounds until a scan ends with fewer points than it was to have: the target is hardly to be seen.
const MOST_ROUNDS: u64 = 1 << 11;

/// Scans a tree.
///
/// # Units
///
/// Metres, y up, in the frame of the target. Intensities are 65535 · ρ · cos θ, whole numbers: the
/// apparent reflectance of surfaces that scatter evenly, whatever their distance.
///
/// # Panics
///
/// When the pattern does not pass [`Pattern::validate`].
#[must_use]
pub fn scan(target: &Target, pattern: &Pattern, seed: Seed) -> Cloud {
    if let Err(error) = pattern.validate() {
        panic!("scan: {error}");
    }
    let mut echoes = match pattern.kind {
        Kind::Paper => from_random_rays(target, pattern, seed),
        Kind::Terrestrial | Kind::Mobile | Kind::Airborne => from_fans(target, pattern, seed),
    };
    if let Some(most) = pattern.points {
        thin(&mut echoes, most, seed);
    }
    let mut cloud = Cloud { up: Up::Y, columns: Columns::with([true; 6]), ..Cloud::default() };
    for Echo { place, attributes } in echoes {
        cloud.points.push(place);
        cloud.columns.push(&attributes);
    }
    cloud
}

fn from_fans(target: &Target, pattern: &Pattern, seed: Seed) -> Vec<Echo> {
    let fans = fans(target, pattern, seed);
    let angles = Angles::of(&fans, pattern.step);
    let of_fan = |k: usize| -> Vec<Echo> {
        fans[k].beams(&angles).filter_map(|beam| echo(target, &beam, pattern, seed)).collect()
    };
    map_in_order(fans.len(), of_fan).concat()
}

fn from_random_rays(target: &Target, pattern: &Pattern, seed: Seed) -> Vec<Echo> {
    let wanted = point_count(pattern, seed);
    let stations = usize::from(pattern.stations);
    let mut echoes: Vec<Echo> = Vec::new();
    for station in 0..stations {
        let rays = RandomRays::new(target, station as u16, seed);
        let end = wanted * (station + 1) / stations;
        for round in 0..MOST_ROUNDS {
            if echoes.len() >= end {
                break;
            }
            // Chunks, so that a round has work for every thread.
            let of_chunk = |chunk: usize| -> Vec<Echo> {
                let first = round * ROUND + chunk as u64 * 256;
                let ray = |k| echo(target, &rays.ray(first + k), pattern, seed);
                (0..256).filter_map(ray).collect()
            };
            echoes.extend(map_in_order(ROUND as usize / 256, of_chunk).into_iter().flatten());
        }
        echoes.truncate(end);
    }
    echoes
}

/// Keeps `most` of the echoes, drawn without replacement, in their order.
fn thin(echoes: &mut Vec<Echo>, most: usize, seed: Seed) {
    if echoes.len() <= most {
        return;
    }
    let draws = seed.draws(Lineage::ROOT, Purpose::ScanPoints);
    let mut drawn: Vec<(u64, usize)> =
        (0..echoes.len()).map(|i| (draws.clone().at(i as u64).bits(), i)).collect();
    drawn.sort_unstable();
    drawn.truncate(most);
    let mut kept: Vec<usize> = drawn.into_iter().map(|(_, i)| i).collect();
    kept.sort_unstable();
    *echoes = kept.into_iter().map(|i| echoes[i]).collect();
}

/// The results for `0..count`, in this order, whatever computes them.
#[cfg(feature = "parallel")]
fn map_in_order<T: Send>(count: usize, each: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    use rayon::prelude::*;
    (0..count).into_par_iter().map(each).collect()
}

/// The results for `0..count`, in this order.
#[cfg(not(feature = "parallel"))]
fn map_in_order<T>(count: usize, each: impl Fn(usize) -> T) -> Vec<T> {
    (0..count).map(each).collect()
}
