//! How finely wood is meshed.

use crate::wood::{BARKED, GRAIN};

/// The most sides a ring can have.
pub const MAX_SIDES: u32 = 256;

/// How finely wood is meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WoodOptions {
    /// Sides of the thinnest rings, 3 to [`MAX_SIDES`]. Default 5.
    pub min_sides: u32,
    /// Sides of the thickest rings, `min_sides` to [`MAX_SIDES`]. Default 24.
    pub max_sides: u32,
    /// How far a side may lie inside the round branch, in metres, within the limits above; a
    /// branch has as many sides as its thickest ring needs. Default 0.004: a limb of 10 cm radius
    /// gets 12 sides. Towards 0 everything gets `max_sides`.
    pub tolerance: f32,
    /// How far the axis of a limb may lie beside the smooth curve through its nodes, in metres: at
    /// bends there are as many rings as that takes. Default 0.02.
    pub axis_tolerance: f32,
    /// Laterals thinner than this are left out with all they carry, radius in metres. Default 0.
    pub min_radius: f32,
    /// Rings between the rim of a collar, where a branch leaves its parent, and its first round
    /// ring; at most this many, fewer for thin branches. Default 2.
    pub collar_rings: u32,
    /// Size of the rim of a collar, as a multiple of the branch, 1 to 2. Default 1.35.
    pub collar: f32,
    /// How deep the flutes of the trunk are as a share of its radius, 0 (round) to 0.2; cross-
    /// sections get rounder with the order and towards thin wood. Default 0.05.
    pub fluting: f32,
    /// Depth of the fissures in the bark of thick wood in metres, 0 for none. Default 0: it takes
    /// rings every few centimetres.
    pub bark: f32,
    /// Radius of the trunk at the ground, as a multiple of the root's radius, at least 1.
    /// Default 1.4; 1 is a trunk without a flare.
    pub foot_flare: f32,
    /// Side of the bark texture in metres: u has as many whole repeats as fit around the branch's
    /// start, so that a texture that repeats shows no seam. Default 1.
    pub texture_size: f32,
    /// Texels of one size all over the tree, in metres, in place of whole repeats: the texture then has
    /// a seam along each limb. Default false.
    pub even_texels: bool,
}

impl Default for WoodOptions {
    fn default() -> Self {
        Self {
            min_sides: 5,
            max_sides: 24,
            tolerance: 0.004,
            axis_tolerance: 0.02,
            min_radius: 0.0,
            collar_rings: 2,
            collar: 1.35,
            fluting: 0.05,
            bark: 0.0,
            foot_flare: 1.4,
            texture_size: 1.0,
            even_texels: false,
        }
    }
}

/// What is wrong with [`WoodOptions`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum WoodOptionsError {
    #[error("rings of {min} to {max} sides; give 3 ≤ min_sides ≤ max_sides ≤ {MAX_SIDES}")]
    Sides { min: u32, max: u32 },
    #[error("{option} is {value}; it must be a number above 0, in metres")]
    NotPositive { option: &'static str, value: f32 },
    #[error("{option} is {value}; it must be a number from {low} to {high}")]
    Range { option: &'static str, value: f32, low: f32, high: f32 },
    #[error("foot_flare is {value}; it must be 1 (no flare) or more")]
    Flare { value: f32 },
}

impl WoodOptions {
    /// The options of a level of detail: 0 is the default; 1, 2 and 3 take 52, 30 and 25 % of its
    /// triangles for an oak of 5 000 nodes. Above 3 they stay as at 3; what is coarser still leaves
    /// laterals out, as [`within`](crate::within) does.
    #[must_use]
    pub fn lod(level: u8) -> Self {
        let best = Self::default();
        let (min_sides, max_sides, tolerance, axis_tolerance, collar_rings) = match level {
            0 => return best,
            1 => (4, 16, 0.008, 0.06, 1),
            2 => (3, 10, 0.02, 0.2, 0),
            _ => (3, 6, 0.06, 0.6, 0),
        };
        Self { min_sides, max_sides, tolerance, axis_tolerance, collar_rings, ..best }
    }

    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    ///
    /// When a field is out of its range, or not a number.
    pub fn validate(&self) -> Result<(), WoodOptionsError> {
        let (min, max) = (self.min_sides, self.max_sides);
        if min < 3 || max < min || max > MAX_SIDES {
            return Err(WoodOptionsError::Sides { min, max });
        }
        for (option, value) in [
            ("tolerance", self.tolerance),
            ("axis_tolerance", self.axis_tolerance),
            ("texture_size", self.texture_size),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(WoodOptionsError::NotPositive { option, value });
            }
        }
        for (option, value, low, high) in [
            ("min_radius", self.min_radius, 0.0, f32::MAX),
            ("collar", self.collar, 1.0, 2.0),
            ("fluting", self.fluting, 0.0, 0.2),
            ("bark", self.bark, 0.0, 0.1),
        ] {
            if !(low..=high).contains(&value) {
                return Err(WoodOptionsError::Range { option, value, low, high });
            }
        }
        if !(self.foot_flare >= 1.0 && self.foot_flare.is_finite()) {
            return Err(WoodOptionsError::Flare { value: self.foot_flare });
        }
        Ok(())
    }

    /// How many sides a branch of this radius gets.
    ///
    /// A chord of an n-gon lies `r (1 − cos(π/n)) < r π² / (2 n²)` inside its circle.
    pub(crate) fn sides(&self, radius: f32) -> u32 {
        if self.bark > 0.0 && radius > BARKED.0 {
            let grains = core::f32::consts::TAU * radius / GRAIN;
            return (libm::ceilf(grains) as u32).clamp(self.min_sides, MAX_SIDES);
        }
        let needed = core::f32::consts::PI * libm::sqrtf(radius / (2.0 * self.tolerance));
        (libm::ceilf(needed) as u32).clamp(self.min_sides, self.max_sides)
    }

    /// Whole repeats of the texture around a branch of this radius.
    pub(crate) fn repeats(&self, radius: f32) -> f32 {
        libm::roundf(core::f32::consts::TAU * radius / self.texture_size).max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_levels_of_detail_are_valid_and_get_coarser() {
        let sides: Vec<u32> = (0..5)
            .map(|level| {
                let options = WoodOptions::lod(level);
                assert_eq!(options.validate(), Ok(()));
                options.sides(0.3) + options.sides(0.01)
            })
            .collect();
        assert!(sides.is_sorted_by(|a, b| a >= b), "{sides:?}");
    }

    #[test]
    fn sides_stay_within_the_tolerance_until_the_limit() {
        let options = WoodOptions {
            min_sides: 3,
            max_sides: 200,
            tolerance: 0.005,
            ..WoodOptions::default()
        };
        for radius in [0.02f32, 0.1, 0.5, 1.0] {
            let n = f64::from(options.sides(radius));
            let inside = f64::from(radius) * (1.0 - libm::cos(core::f64::consts::PI / n));
            assert!(inside < 0.005 && inside > 0.003, "{radius} {n} {inside}");
        }
    }

    #[test]
    fn options_out_of_range_are_refused() {
        let good = WoodOptions::default();
        for bad in [
            WoodOptions { min_sides: 2, ..good },
            WoodOptions { max_sides: 3, ..good },
            WoodOptions { max_sides: MAX_SIDES + 1, ..good },
            WoodOptions { tolerance: 0.0, ..good },
            WoodOptions { texture_size: f32::NAN, ..good },
            WoodOptions { foot_flare: 0.9, ..good },
            WoodOptions { collar: 0.5, ..good },
            WoodOptions { fluting: f32::NAN, ..good },
            WoodOptions { min_radius: -1.0, ..good },
            WoodOptions { bark: 1.0, ..good },
        ] {
            assert!(bad.validate().is_err(), "{bad:?}");
        }
    }
}
