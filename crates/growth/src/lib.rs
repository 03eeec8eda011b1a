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
mod surroundings;
mod tropism;

use deeptree_graph::{BranchGraph, Seed, TreeInfo};

pub use parameters::{ParameterError, Parameters};
pub use species::{Profile, SPECIES, Species, SpeciesError};
pub use surroundings::{Light, OpenField, Surroundings};

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
        growth.cycle(number, surroundings);
        hit_budget = growth.internodes.len() > budget;
        if hit_budget {
            break;
        }
    }
    growth.finish();
    let info = TreeInfo {
        species: species.to_owned(),
        age,
        gravitropism: parameters.gravitropism,
        seed: seed.0,
    };
    let tree = export::to_graph(&growth.internodes, info).ok_or(GrowError::NothingGrown { age })?;
    Ok(Grown { tree, hit_budget })
}
