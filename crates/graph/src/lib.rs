//! The nouns of the paper: node, branch graph, branchlet, signature; and the seed that every
//! random draw is keyed by.
//!
//! | paper | field | unit |
//! |---|---|---|
//! | p | [`Node::position`] (tip of the internode) | m, y up |
//! | t | [`Node::thickness`] (radius) | m |
//! | d_r | [`Node::root_distance`] | m |
//! | d_s | [`Node::branch_distance`] | m |
//! | q_p | [`Node::rotation`] against the parent; front −z, up +y | unit quaternion |
//! | l_p | [`Node::length`] of the edge to the parent | m |
//! | o | [`Node::order`] (Gravelius; trunk 0) | – |
//! | m_p | [`Node::sibling_count`]: children of the parent | – |
//! | a, v, s | [`TreeInfo::age`], [`TreeInfo::gravitropism`], [`TreeInfo::species`] | growth cycles, –, name |
//! | Y | [`Occupancy`]: 32³ bits over the growth space | – |
//! | u = (q, t, l) | [`ChildSignature`] | |
//!
//! A tree from the growth model, from the networks or from a file is the same [`BranchGraph`].

#![forbid(unsafe_code)]

mod algebra;
mod blend;
mod cloud_index;
pub mod codec;
mod crowding;
mod graph;
mod kin;
mod occupancy;
mod paths;
mod plan;
mod prune;
mod reach;
mod rows;
mod seed;
pub mod signature;
mod surround;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
mod traits;

pub use algebra::{cholesky, solve};
pub use blend::Share;
pub use cloud_index::CloudIndex;
pub use crowding::{Balance, Crowd, Neighbourhood, Sense, senses, senses_in};
pub use glam::{Mat3, Quat, Vec2, Vec3};
pub use graph::{BranchGraph, ChildSignature, MAX_CHILDREN, Node, NodeId, TreeInfo};
pub use kin::{Kin, Kinsman};
pub use occupancy::{Occupancy, Voxel};
pub use paths::{Path, branches, chains};
pub use plan::{Plan, plans};
pub use prune::{Cut, PruneError, Pruned, Wound, prune};
pub use reach::{least_reach, most_tips, reaches};
pub use rows::{GraphError, Row};
pub use seed::{Draws, Lineage, Purpose, Seed};
pub use surround::{NEIGHBOURS, Passage, Room, Surround};
pub use traits::TreeTraits;
