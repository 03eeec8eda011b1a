//! How finely wood is meshed.

/// The most sides a ring can have.
pub const MAX_SIDES: u32 = 256;

/// How finely wood is meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WoodOptions {
    /// Sides of the thinnest rings, 3 to [`MAX_SIDES`]. Default 4.
    pub min_sides: u32,
    /// Sides of the thickest rings, `min_sides` to [`MAX_SIDES`]. Default 16.
    pub max_sides: u32,
    /// How far a side may lie inside the round branch, in metres, within the limits above; a
    /// branch has as many sides as its thickest ring needs. Default 0.005: a limb of 10 cm radius
    /// gets 10 sides. Towards 0 everything gets `max_sides`.
    pub tolerance: f32,
    /// Radius of the trunk at the ground, as a multiple of the root's radius, at least 1.
    /// Default 1.25; 1 is a trunk without a flare.
    pub foot_flare: f32,
    /// Side of the bark texture in metres: v counts it along the branch, and u has as many whole
    /// repeats as fit around the branch's start. Default 1.
    pub texture_size: f32,
}

impl Default for WoodOptions {
    fn default() -> Self {
        Self { min_sides: 4, max_sides: 16, tolerance: 0.005, foot_flare: 1.25, texture_size: 1.0 }
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
    #[error("foot_flare is {value}; it must be 1 (no flare) or more")]
    Flare { value: f32 },
}

impl WoodOptions {
    /// The options of a level of detail: 0 is the default, each further one about halves the
    /// triangles; above 3 they stay as at 3.
    #[must_use]
    pub fn lod(level: u8) -> Self {
        let (min_sides, max_sides, tolerance) = match level {
            0 => return Self::default(),
            1 => (4, 10, 0.01),
            2 => (3, 7, 0.03),
            _ => (3, 5, 0.1),
        };
        Self { min_sides, max_sides, tolerance, ..Self::default() }
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
        for (option, value) in [("tolerance", self.tolerance), ("texture_size", self.texture_size)]
        {
            if !(value > 0.0 && value.is_finite()) {
                return Err(WoodOptionsError::NotPositive { option, value });
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
        let options = WoodOptions { max_sides: 200, ..WoodOptions::default() };
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
        ] {
            assert!(bad.validate().is_err(), "{bad:?}");
        }
    }
}
