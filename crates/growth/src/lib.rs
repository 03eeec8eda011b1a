//! The procedural growth model: the teacher.
//!
//! A tree is a set of internodes with buds. [`grow`] runs one growth cycle after another
//! (`cycle.rs` reads from top to bottom) and exports the branch graph. Every number a species is
//! made of stands in one table, [`parameters::TABLE`].
//!
//! Source: Stava et al. 2014, "Inverse procedural modelling of trees", as parametrised in the
//! appendix of the DeepTree paper; where the two leave a rule open, `PAPER.md` records what was
//! taken.

#![forbid(unsafe_code)]

mod cycle;
mod density;
mod export;
mod internode;
pub mod parameters;
mod species;
mod stand;
mod surroundings;
mod tropism;

use deeptree_graph::{BranchGraph, Seed, TreeInfo};
use deeptree_scene::Environment;

pub use parameters::{ParameterError, Parameters};
pub use species::{Profile, SPECIES, Species, SpeciesError};
pub use stand::{Planted, grow_stand, grow_stand_in};
pub use surroundings::{Around, Light, OpenField, Surroundings};

/// Internodes a growth may hold at once; far above what any preset reaches.
pub const DEFAULT_BUDGET: usize = 80_000;

/// A grown tree, and whether its budget cut it short.
#[derive(Clone, Debug, PartialEq)]
pub struct Grown {
    /// The exported branch graph.
    pub tree: BranchGraph,
    /// The growth stopped early because it held more internodes than its budget.
    pub hit_budget: bool,
}

/// Why nothing could be grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GrowError {
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No internode has grown: it was too dark.
    #[error("after {age} growth cycles the tree has no internode yet; it needs more light or time")]
    NothingGrown {
        /// The age asked for.
        age: u32,
    },
}

/// Grows one tree in the open field.
///
/// The same parameters and seed give the same bits on every machine.
///
/// # Errors
///
/// When a parameter is out of range, or the tree is too young to have an internode.
pub fn grow(species: &str, parameters: &Parameters, seed: Seed) -> Result<Grown, GrowError> {
    grow_in(species, parameters, seed, &OpenField, DEFAULT_BUDGET)
}

/// Grows one tree in given surroundings, with at most `budget` internodes.
///
/// # Errors
///
/// As [`grow`].
pub fn grow_in(
    species: &str,
    parameters: &Parameters,
    seed: Seed,
    surroundings: &impl Surroundings,
    budget: usize,
) -> Result<Grown, GrowError> {
    parameters.validate()?;
    let age = parameters.age as u32;
    let mut growth = cycle::Growth::new(parameters, seed);
    let mut hit_budget = false;
    for number in 0..age {
        growth.cycle(number, surroundings, &[]);
        hit_budget = growth.internodes.len() > budget;
        if hit_budget {
            break;
        }
    }
    finish(growth, species, parameters, seed, surroundings, hit_budget)
}

/// Grows one tree among the obstacles and within the volume of an environment; in the open field
/// the same tree as [`grow`].
///
/// # Errors
///
/// As [`grow`].
pub fn grow_around(
    species: &str,
    parameters: &Parameters,
    seed: Seed,
    environment: &Environment,
) -> Result<Grown, GrowError> {
    if environment.is_open() {
        return grow(species, parameters, seed);
    }
    grow_in(species, parameters, seed, &Around::new(environment), DEFAULT_BUDGET)
}

/// The branch graph of a growth that has come to its end.
///
/// Positions in a branch graph follow from lengths and rotations, and are rounded otherwise than
/// those in the growth; so each node is held against the surroundings once more where it ends up.
fn finish(
    mut growth: cycle::Growth<'_>,
    species: &str,
    parameters: &Parameters,
    seed: Seed,
    surroundings: &impl Surroundings,
    hit_budget: bool,
) -> Result<Grown, GrowError> {
    growth.finish();
    let age = parameters.age as u32;
    let (species, gravitropism) = (species.to_owned(), parameters.gravitropism);
    let info = TreeInfo { species, age, gravitropism, seed: seed.0 };
    loop {
        let (tree, internode_of) = export::to_graph(&growth.internodes, info.clone())
            .ok_or(GrowError::NothingGrown { age })?;
        // The first internode stays: scenes have no obstacle over it.
        let gone: Vec<u32> = (1..tree.len())
            .filter(|&id| {
                let node = &tree.nodes()[id];
                let (base, tip) = (node.base(), node.position);
                !surroundings.admits(base, tip) || !surroundings.admits(tip, tip)
            })
            .map(|id| internode_of[id])
            .collect();
        if gone.is_empty() {
            return Ok(Grown { tree, hit_budget });
        }
        growth.prune_these(&gone);
    }
}
