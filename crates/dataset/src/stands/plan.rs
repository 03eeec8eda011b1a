//! What a corpus of stands holds: `stands.toml`.

use std::ops::Range;

use deeptree_graph::{Draws, Lineage, Purpose, Seed, Vec2};
use serde::{Deserialize, Serialize};

use super::StandsError;

/// Name of the plan's file in the folder of a corpus of stands.
pub const STANDS_FILE: &str = "stands.toml";

/// Trees of a stand, at least and at most.
const TREES: Range<usize> = 2..21;
/// Nearest and farthest mean distance of neighbours in metres; their logarithm is drawn evenly.
const SPACING: Range<f64> = 2.5..18.0;
/// Part of the spacing that trees stand off their grid, at most.
const JITTER: f64 = 0.4;
/// Of ten stands, those of one species, and those of trees of many ages.
const PURE: usize = 5;
const AGED: usize = 4;
/// Growth cycles of trees of stands of many ages.
const AGES: Range<usize> = 12..36;
/// From the seed of a stand's first tree to that of the next stand's.
const SEEDS: u64 = 64;

/// What a corpus of stands holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandsPlan {
    /// The format of the corpus.
    pub format: u32,
    /// The species of the trees.
    pub species: Vec<String>,
    /// How many stands there are.
    pub stands: u32,
    /// How many of them are for training: the first.
    pub training_stands: u32,
    /// The seed of the first tree.
    pub first_seed: u64,
    /// The parameters that the trees were grown with, by name.
    pub profile: String,
    /// How many stands a file has.
    pub shard_stands: u32,
}

/// A row of the plan of a stand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plant {
    /// Number of its species.
    pub species: usize,
    /// Where its foot is: x and z in metres.
    pub at: [f32; 2],
    /// Its seed.
    pub seed: u64,
    /// Age in growth cycles; the species' own where there is none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub age: Option<u32>,
}

impl StandsPlan {
    /// A plan with four fifths of the stands for training.
    #[must_use]
    pub fn new(species: Vec<String>, stands: u32, first_seed: Seed, profile: &str) -> Self {
        Self {
            format: 1,
            species,
            stands,
            training_stands: stands - stands.div_ceil(5),
            first_seed: first_seed.0,
            profile: profile.to_owned(),
            shard_stands: 20,
        }
    }

    /// The plan of a stand: 2 to 20 trees on a square grid of 2.5 to 18 m, each up to two fifths of
    /// that off its place. Half of the stands have one species, the others up to four; in two of
    /// five, the trees are of 12 to 35 growth cycles, in the others of their species' own age.
    #[must_use]
    pub fn stand(&self, number: u32) -> Vec<Plant> {
        let seed = Seed(self.first_seed).of_tree(u64::from(number) * SEEDS);
        let mut draws = seed.draws(Lineage::ROOT, Purpose::Planting);
        let count = TREES.start + draws.index(TREES.len());
        let [low, high] = [SPACING.start, SPACING.end].map(libm::log);
        let spacing = libm::exp(low + draws.uniform() * (high - low));
        let kinds = if draws.index(10) < PURE { 1 } else { 2 + draws.index(3) };
        let kinds: Vec<usize> = (0..kinds).map(|_| draws.index(self.species.len())).collect();
        let is_aged = draws.index(10) < AGED;
        let jitter = JITTER * draws.uniform();
        let side = (1..).find(|side| side * side >= count).unwrap_or(1);
        let place = |draws: &mut Draws, cell: usize| {
            (spacing * (cell as f64 + jitter * (2.0 * draws.uniform() - 1.0))) as f32
        };
        (0..count)
            .map(|row| Plant {
                species: kinds[draws.index(kinds.len())],
                at: [place(&mut draws, row % side), place(&mut draws, row / side)],
                seed: seed.of_tree(row as u64).0,
                age: is_aged.then(|| (AGES.start + draws.index(AGES.len())) as u32),
            })
            .collect()
    }

    /// Are these stands for training, or to judge by?
    #[must_use]
    pub fn numbers(&self, training: bool) -> Range<u32> {
        if training { 0..self.training_stands } else { self.training_stands..self.stands }
    }

    pub(super) fn shards(&self) -> impl Iterator<Item = (String, Range<u32>)> + use<> {
        let (size, stands) = (self.shard_stands.max(1), self.stands);
        (0..stands.div_ceil(size)).map(move |index| {
            let first = index * size;
            (format!("stands-{index:03}.parquet"), first..first.saturating_add(size).min(stands))
        })
    }

    pub(super) fn check(&self) -> Result<(), StandsError> {
        let what = if self.format != 1 {
            "its format is another than 1"
        } else if self.species.is_empty() || self.stands == 0 || self.shard_stands == 0 {
            "it has no species, no stands or shards without stands"
        } else if self.training_stands > self.stands {
            "it has more stands for training than stands"
        } else if self.first_seed > i64::MAX as u64 - u64::from(u32::MAX) * SEEDS {
            "its seeds do not fit into its file; stay below 2^62"
        } else {
            return Ok(());
        };
        Err(StandsError::Plan { what })
    }
}

impl Plant {
    /// Where another stands as seen from this one, in metres.
    #[must_use]
    pub fn to(&self, other: &Self) -> Vec2 {
        Vec2::from(other.at) - Vec2::from(self.at)
    }
}
