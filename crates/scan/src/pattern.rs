//! How a scanner moves and looks.

use std::f64::consts::PI;

/// Where the scanner is, and how its beams fan out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// As the training scans of the paper: at random places on a ground of 10 m × 10 m outside the
    /// tree's bounding box, with rays over the sphere towards the tree.
    ///
    /// # Source
    ///
    /// DeepTree, section "Point-based Modeling". Not said there: the scanner stands 1.5 m high; where
    /// a crown covers the ground, the ground reaches 2.5 m beyond it; and how many points there are
    /// is drawn from the published range.
    Paper,
    /// From a tripod at each of several stations on a circle around the tree.
    Terrestrial,
    /// From a vehicle that passes the tree, with two heads that turn about axes 45° to the track.
    Mobile,
    /// From an aircraft, in parallel tracks over the tree, across each of which the beam swings.
    Airborne,
}

/// A scan.
///
/// # Units
///
/// Radians and metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    /// Where the scanner is.
    pub kind: Kind,
    /// How many places, passes or tracks there are.
    pub stations: u16,
    /// Angle between two beams; random rays have none.
    pub step: f64,
    /// Standard deviation of the range.
    pub noise: f64,
    /// Full angle of the cone that a beam widens to; 0 is a ray. The ranges of all that lies in the
    /// cone and within [`Pattern::RESOLUTION`] are averaged, which gives the points that hang in the
    /// air behind edges ("mixed pixels").
    pub divergence: f64,
    /// The most points; more are thinned at random. Random rays are cast until there are so many.
    pub points: Option<usize>,
}

/// Why a pattern is none.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatternError {
    /// No or too many stations.
    #[error("a scan has 1 to {most} stations, not {0}", most = Pattern::MAX_STATIONS)]
    Stations(u16),
    /// The step is out of range.
    #[error("the step between beams is 0.01° to 10°, not {0}°")]
    Step(f64),
    /// The noise is out of range.
    #[error("the noise of the range is 0 m to 1 m, not {0} m")]
    Noise(f64),
    /// The divergence is out of range.
    #[error("the divergence of a beam is 0 to 100 mrad, not {0} mrad")]
    Divergence(f64),
    /// No points are wanted.
    #[error("a scan has at least one point")]
    NoPoints,
}

impl Pattern {
    /// The most stations.
    pub const MAX_STATIONS: u16 = 64;
    /// What lies within this distance in one beam gives one echo, in metres: half of the length of a
    /// pulse of 2.7 ns.
    pub const RESOLUTION: f64 = 0.4;
    /// The number of points of the paper's scans.
    pub const PAPER_POINTS: std::ops::RangeInclusive<usize> = 8_000..=35_000;

    /// [`Kind::Paper`]: exact rays from one place.
    #[must_use]
    pub fn paper() -> Self {
        Self { stations: 1, noise: 0.0, divergence: 0.0, ..Self::terrestrial() }.of(Kind::Paper)
    }

    /// [`Kind::Terrestrial`]: four stations, 0.1°, 3 mm, 0.35 mrad.
    #[must_use]
    pub fn terrestrial() -> Self {
        let (step, divergence) = (degrees(0.1), 0.35e-3);
        let kind = Kind::Terrestrial;
        Self { kind, stations: 4, step, noise: 0.003, divergence, points: None }
    }

    /// [`Kind::Mobile`]: one pass, 0.2°, 1 cm, 0.5 mrad.
    #[must_use]
    pub fn mobile() -> Self {
        let (step, divergence) = (degrees(0.2), 0.5e-3);
        Self { kind: Kind::Mobile, stations: 1, step, noise: 0.01, divergence, points: None }
    }

    /// [`Kind::Airborne`]: three tracks, 0.05°, 2 cm, 0.5 mrad.
    #[must_use]
    pub fn airborne() -> Self {
        let (step, divergence) = (degrees(0.05), 0.5e-3);
        Self { kind: Kind::Airborne, stations: 3, step, noise: 0.02, divergence, points: None }
    }

    /// The usual pattern of a kind.
    #[must_use]
    pub fn usual(kind: Kind) -> Self {
        match kind {
            Kind::Paper => Self::paper(),
            Kind::Terrestrial => Self::terrestrial(),
            Kind::Mobile => Self::mobile(),
            Kind::Airborne => Self::airborne(),
        }
    }

    fn of(self, kind: Kind) -> Self {
        Self { kind, ..self }
    }

    /// Checks that the pattern is one.
    ///
    /// # Errors
    ///
    /// When a number is out of its range.
    pub fn validate(&self) -> Result<(), PatternError> {
        if !(1..=Self::MAX_STATIONS).contains(&self.stations) {
            return Err(PatternError::Stations(self.stations));
        }
        // Half a millionth of a degree for the way from degrees.
        if !(degrees(0.009_999_5)..=degrees(10.000_000_5)).contains(&self.step) {
            return Err(PatternError::Step(self.step * 180.0 / PI));
        }
        if !(0.0..=1.0).contains(&self.noise) {
            return Err(PatternError::Noise(self.noise));
        }
        if !(0.0..=0.1).contains(&self.divergence) {
            return Err(PatternError::Divergence(self.divergence * 1e3));
        }
        if self.points == Some(0) { Err(PatternError::NoPoints) } else { Ok(()) }
    }
}

/// Degrees in radians.
const fn degrees(angle: f64) -> f64 {
    angle * PI / 180.0
}
