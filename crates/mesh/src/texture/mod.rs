//! Pictures of leaves and bark, made from a seed.

pub(crate) mod atlas;
pub(crate) mod bark;
pub(crate) mod canvas;
pub(crate) mod frond;
pub(crate) mod leaf;
pub(crate) mod noise;
pub(crate) mod outline;
mod veins;
