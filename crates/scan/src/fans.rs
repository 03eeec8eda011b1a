//! Beams in fans: the planes that the mirror of a scanner sweeps.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use deeptree_graph::{Lineage, Purpose, Seed, Vec3};
use glam::DVec3;

use crate::beam::Beam;
use crate::pattern::{Kind, Pattern};
use crate::target::Target;
use crate::window::Window;

/// Height of the instrument on its tripod in metres.
pub(crate) const TRIPOD: f64 = 1.5;
/// Height of the instrument on a vehicle.
const ROOF: f64 = 2.5;
/// A vehicle keeps this distance from a crown.
const BESIDE: f64 = 3.0;
/// A station keeps this distance from a crown, and this share of the tree's height from its middle:
/// nearer ones see the crown's underside only.
const AROUND: f64 = 2.0;
const AROUND_SHARE: f64 = 0.7;
/// An aircraft flies so high over the top of the tree.
const OVER: f64 = 50.0;
/// Distance between parallel tracks in the air.
const APART: f64 = 15.0;
/// Half of the angle that the beam of an aircraft swings through.
const SWING: f64 = 35.0 * PI / 180.0;
/// Distance between two fans along a track.
const ALONG: f64 = 0.05;

/// Beams in one plane: beam `k` goes along `across · cos(k · step) + up · sin(k · step)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fan {
    from: DVec3,
    across: DVec3,
    up: DVec3,
    station: u16,
    number: u32,
    /// The first beam and the one after the last.
    beams: [i32; 2],
}

/// The cosines and sines of the angles `k · step` that fans use.
pub(crate) struct Angles {
    first: i32,
    table: Vec<[f64; 2]>,
}

impl Angles {
    /// Those of these fans.
    pub(crate) fn of(fans: &[Fan], step: f64) -> Self {
        let first = fans.iter().map(|fan| fan.beams[0]).min().unwrap_or_default();
        let end = fans.iter().map(|fan| fan.beams[1]).max().unwrap_or_default();
        let angle = |k: i32| f64::from(k) * step;
        let table = (first..end).map(|k| [libm::cos(angle(k)), libm::sin(angle(k))]).collect();
        Self { first, table }
    }
}

impl Fan {
    /// Its beams, in order.
    pub(crate) fn beams(self, angles: &Angles) -> impl Iterator<Item = Beam> {
        (self.beams[0]..self.beams[1]).map(move |k| {
            let [cosine, sine] = angles.table[(k - angles.first) as usize];
            Beam {
                from: self.from,
                along: self.across * cosine + self.up * sine,
                station: self.station,
                number: u64::from(self.number) << 32 | u64::from(k.cast_unsigned()),
            }
        })
    }
}

/// The fans of a pattern that is not [`Kind::Paper`], station by station.
pub(crate) fn fans(target: &Target, pattern: &Pattern, seed: Seed) -> Vec<Fan> {
    // All tracks and circles are turned by one draw, so that no axis of the tree is special.
    let mut draws = seed.draws(Lineage::ROOT, Purpose::ScanPlace);
    let turn = TAU * draws.uniform();
    let mut fans = Vec::new();
    for station in 0..pattern.stations {
        match pattern.kind {
            Kind::Paper => {}
            Kind::Terrestrial => tripod(target, pattern, station, turn, &mut fans),
            Kind::Mobile => pass(target, pattern, station, turn, &mut fans),
            Kind::Airborne => track(target, pattern, station, turn, &mut fans),
        }
    }
    for (number, fan) in fans.iter_mut().enumerate() {
        fan.number = number as u32;
    }
    fans
}

/// The middle of the tree's bounding box on the ground, and how far its corners are from it.
pub(crate) fn footprint(target: &Target) -> (DVec3, f64) {
    let (low, high) = target.tree_bounds();
    let flat = |v: Vec3| DVec3::new(f64::from(v.x), 0.0, f64::from(v.z));
    let (low, high) = (flat(low), flat(high));
    ((low + high) / 2.0, (high - low).length() / 2.0)
}

/// The horizontal unit vector at an azimuth.
fn heading(azimuth: f64) -> DVec3 {
    DVec3::new(libm::cos(azimuth), 0.0, libm::sin(azimuth))
}

/// Upright fans all around a station on a circle.
fn tripod(target: &Target, pattern: &Pattern, station: u16, turn: f64, fans: &mut Vec<Fan>) {
    let (middle, reach) = footprint(target);
    let height = f64::from(target.tree_bounds().1.y);
    let distance = (reach + AROUND).max(AROUND_SHARE * height);
    let azimuth = turn + TAU * f64::from(station) / f64::from(pattern.stations);
    let from = middle + heading(azimuth) * distance + DVec3::Y * TRIPOD;
    let window = Window::of_box(target.bounds(), from);
    let [first, last] = window.azimuths.map(|a| a / pattern.step);
    let rows = window.elevations.map(|e| e / pattern.step);
    let beams = [libm::ceil(rows[0]) as i32, libm::floor(rows[1]) as i32 + 1];
    for column in libm::ceil(first) as i32..=libm::floor(last) as i32 {
        let across = heading(f64::from(column) * pattern.step);
        fans.push(Fan { from, across, up: DVec3::Y, station, number: 0, beams });
    }
}

/// Two heads whose planes stand upright, 45° to the track, on alternating sides of the tree.
fn pass(target: &Target, pattern: &Pattern, station: u16, turn: f64, fans: &mut Vec<Fan>) {
    let (middle, reach) = footprint(target);
    let side = if station.is_multiple_of(2) { turn } else { turn + PI };
    let (forward, aside) = (heading(side + FRAC_PI_2), heading(side));
    // Each further pair of passes is one lane farther away.
    let distance = reach + BESIDE * (1.0 + f64::from(station / 2));
    let half = 2.0 * reach + distance;
    let whole_turn = libm::floor(TAU / pattern.step) as i32;
    for head in [-1.0, 1.0] {
        let across = heading(side + PI + head * FRAC_PI_4);
        for k in 0..=libm::ceil(2.0 * half / ALONG) as i32 {
            let along = f64::from(k) * ALONG - half;
            let from = middle + aside * distance + forward * along + DVec3::Y * ROOF;
            let beams = [0, whole_turn];
            fans.push(Fan { from, across, up: DVec3::Y, station, number: 0, beams });
        }
    }
}

/// Fans across one of several parallel tracks.
fn track(target: &Target, pattern: &Pattern, station: u16, turn: f64, fans: &mut Vec<Fan>) {
    let (middle, reach) = footprint(target);
    let (forward, across) = (heading(turn), heading(turn + FRAC_PI_2));
    let offset = (f64::from(station) - f64::from(pattern.stations - 1) / 2.0) * APART;
    let altitude = f64::from(target.tree_bounds().1.y) + OVER;
    let swing = libm::floor(SWING / pattern.step) as i32;
    for k in 0..=libm::ceil(2.0 * reach / ALONG) as i32 {
        let along = f64::from(k) * ALONG - reach;
        let from = middle + across * offset + forward * along + DVec3::Y * altitude;
        let beams = [-swing, swing + 1];
        fans.push(Fan { from, across: -DVec3::Y, up: across, station, number: 0, beams });
    }
}
