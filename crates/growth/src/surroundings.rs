//! What a growing tree meets outside itself: light, and places where nothing can grow.

use deeptree_graph::Vec3;

/// The light at a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// I: the free part of the sky, 1 in the open.
    pub availability: f32,
    /// d: the direction to grow towards; none where no direction is better than another.
    pub direction: Option<Vec3>,
}

/// Surroundings that a tree responds to.
pub trait Surroundings {
    /// The light at `position`, where `outward` points away from the crown's centre.
    fn light(&self, position: Vec3, outward: Option<Vec3>) -> Light;

    /// May an internode start at `base`? One that may not is removed with all it bears.
    fn admits(&self, base: Vec3) -> bool;
}

/// Nothing around: full light from outside the crown, and room above the ground.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpenField;

impl Surroundings for OpenField {
    fn light(&self, _: Vec3, outward: Option<Vec3>) -> Light {
        Light { availability: 1.0, direction: outward }
    }

    fn admits(&self, _: Vec3) -> bool {
        true
    }
}
