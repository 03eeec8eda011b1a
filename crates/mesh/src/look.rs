//! What a tree is asked to look like: season, health, leaves, textures.

/// The texture sizes there are, in pixels a side.
pub const TEXTURE_SIZES: core::ops::RangeInclusive<u32> = 256..=2048;

/// The species whose leaves and bark are known.
pub const SPECIES: [&str; 8] =
    ["beech", "corkscrew", "maple", "oak", "pine", "tulip", "walnut", "willow"];

/// The greatest density of leaves that can be asked for.
pub const MAX_LEAF_DENSITY: f32 = 4.0;

/// A season of the temperate zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Season {
    /// Leaves that unfold: fewer, smaller and lighter.
    Spring,
    /// Full leaves.
    #[default]
    Summer,
    /// Leaves in the colours that the species turns to, some of them fallen.
    Autumn,
    /// Bare twigs but for evergreens.
    Winter,
}

impl Season {
    /// The seasons in the order of the year.
    pub const ALL: [Self; 4] = [Self::Spring, Self::Summer, Self::Autumn, Self::Winter];

    /// Its name in lower case.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Spring => "spring",
            Self::Summer => "summer",
            Self::Autumn => "autumn",
            Self::Winter => "winter",
        }
    }
}

/// What a tree is asked to look like.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Whether there are leaves at all; textures of bark are made in any case. Default true.
    pub leaves: bool,
    /// The season. Default summer.
    pub season: Season,
    /// From 0 (dying: most twigs bare, what is left yellow and spotted) to 1. Default 1.
    pub health: f32,
    /// Leaf area as a multiple of the species' own, above 0 to [`MAX_LEAF_DENSITY`]. Default 1.
    pub density: f32,
    /// Level of detail: at 1, 2 and 3 there are a half, a fifth and a fifteenth of the shoots, as
    /// much larger, so that the leaf area stays; above 3 as at 3. Default 0.
    pub lod: u8,
    /// Side of each texture in pixels, one of [`TEXTURE_SIZES`]. Default 1024.
    pub texture_size: u32,
    /// The species that the tree is dressed as, one of [`SPECIES`]; none for its own. Default none.
    pub species: Option<String>,
    /// Seed of the textures: trees of one species share them. Where leaves stand is drawn from the
    /// seed of the tree. Default 0.
    pub seed: u64,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            leaves: true,
            season: Season::Summer,
            health: 1.0,
            density: 1.0,
            lod: 0,
            texture_size: 1024,
            species: None,
            seed: 0,
        }
    }
}

/// What is wrong with a [`Look`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum LookError {
    #[error("the health is {value}; it must be a number from 0 (dying) to 1 (healthy)")]
    Health { value: f32 },
    #[error(
        "the leaf density is {value}; it must be a number above 0 and at most {MAX_LEAF_DENSITY}"
    )]
    Density { value: f32 },
    #[error(
        "the texture size is {value}; it must be from {} to {} pixels",
        TEXTURE_SIZES.start(),
        TEXTURE_SIZES.end()
    )]
    TextureSize { value: u32 },
    #[error("nothing is known of leaves of '{name}'; the species are {}", SPECIES.join(", "))]
    Species { name: String },
}

impl Look {
    /// Checks the ranges that the fields state.
    ///
    /// # Errors
    ///
    /// When a field is out of its range, or not a number.
    pub fn validate(&self) -> Result<(), LookError> {
        if !(0.0..=1.0).contains(&self.health) {
            return Err(LookError::Health { value: self.health });
        }
        if !(self.density > 0.0 && self.density <= MAX_LEAF_DENSITY) {
            return Err(LookError::Density { value: self.density });
        }
        if !TEXTURE_SIZES.contains(&self.texture_size) {
            return Err(LookError::TextureSize { value: self.texture_size });
        }
        if let Some(name) = self.species.as_ref().filter(|name| !SPECIES.contains(&name.as_str())) {
            return Err(LookError::Species { name: name.clone() });
        }
        Ok(())
    }

    /// The share of shoots that this level of detail keeps.
    pub(crate) fn kept(&self) -> f32 {
        match self.lod {
            0 => 1.0,
            1 => 1.0 / 2.0,
            2 => 1.0 / 5.0,
            _ => 1.0 / 15.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_out_of_range_are_refused() {
        let good = Look::default();
        assert_eq!(good.validate(), Ok(()));
        for bad in [
            Look { health: -0.1, ..good.clone() },
            Look { health: f32::NAN, ..good.clone() },
            Look { density: 0.0, ..good.clone() },
            Look { density: f32::INFINITY, ..good.clone() },
            Look { texture_size: 0, ..good.clone() },
            Look { texture_size: 3000, ..good.clone() },
            Look { species: Some("fern".into()), ..good.clone() },
        ] {
            assert!(bad.validate().is_err(), "{bad:?}");
        }
    }
}
