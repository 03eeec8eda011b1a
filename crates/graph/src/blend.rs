//! A species between species.

/// The part that a species has in a blend: its weight over the sum of all weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Index of the species in the model's list.
    pub species: u8,
    /// Above 0.
    pub weight: u16,
}
