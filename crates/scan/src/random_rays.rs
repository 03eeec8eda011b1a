//! The paper's scanner: random rays from a random place.

use deeptree_graph::{Draws, Lineage, Purpose, Seed};
use glam::DVec3;

use crate::beam::Beam;
use crate::fans::{TRIPOD, footprint};
use crate::pattern::Pattern;
use crate::target::Target;
use crate::window::Window;

/// Half of the ground's side in metres.
const HALF_GROUND: f64 = 5.0;
/// The ground reaches so far beyond a crown that covers it.
const BEYOND: f64 = 2.5;
/// The scanner keeps this distance from the bounding box.
const CLEARANCE: f64 = 0.5;
/// Draws of a place; each is outside with a chance of a third at least, for trees that stand in the
/// middle of their crowns.
const ATTEMPTS: usize = 256;

/// Endless rays from one place towards the target.
pub(crate) struct RandomRays {
    from: DVec3,
    station: u16,
    window: Window,
    draws: Draws,
}

impl RandomRays {
    pub(crate) fn new(target: &Target, station: u16, seed: Seed) -> Self {
        let key = |purpose| seed.draws(Lineage::ROOT, purpose).at(u64::from(station));
        let from = place(target, &mut key(Purpose::ScanPlace));
        let window = Window::of_box(target.bounds(), from);
        Self { from, station, window, draws: key(Purpose::ScanRay) }
    }

    /// Ray `number`.
    pub(crate) fn ray(&self, number: u64) -> Beam {
        let mut draws = self.draws.clone().at(number);
        let (azimuth, elevation) = (draws.uniform(), draws.uniform());
        let along = self.window.direction(azimuth, elevation);
        Beam { from: self.from, along, station: self.station, number }
    }
}

/// How many points a scan of this seed has.
pub(crate) fn point_count(pattern: &Pattern, seed: Seed) -> usize {
    let (fewest, most) = Pattern::PAPER_POINTS.into_inner();
    let mut draws = seed.draws(Lineage::ROOT, Purpose::ScanPoints);
    pattern.points.unwrap_or_else(|| fewest + draws.index(most - fewest + 1))
}

/// A place on the ground outside the tree's bounding box.
fn place(target: &Target, draws: &mut Draws) -> DVec3 {
    let (low, high) = target.tree_bounds();
    let widest = [low.x, low.z, high.x, high.z].map(|c| f64::from(c.abs()));
    let half = widest.into_iter().fold(HALF_GROUND, |half, reach| half.max(reach + BEYOND));
    let within = |value: f64, low: f32, high: f32| {
        value > f64::from(low) - CLEARANCE && value < f64::from(high) + CLEARANCE
    };
    for _ in 0..ATTEMPTS {
        let mut coordinate = || half * (2.0 * draws.uniform() - 1.0);
        let (x, z) = (coordinate(), coordinate());
        if !within(x, low.x, high.x) || !within(z, low.z, high.z) {
            return DVec3::new(x, TRIPOD, z);
        }
    }
    let (middle, reach) = footprint(target);
    middle + DVec3::new(reach + CLEARANCE, TRIPOD, 0.0)
}
