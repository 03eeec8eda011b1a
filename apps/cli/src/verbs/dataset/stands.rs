//! A corpus of stands.

use anyhow::Result;
use deeptree_dataset::{Alone, Plant, StandsPlan, build_stands};
use deeptree_graph::{BranchGraph, Seed, Vec3};
use deeptree_growth::{Parameters, Planted, Species, grow, grow_stand};
use serde_json::json;

use super::CutOff;
use crate::args::{self, Args};
use crate::report;
use crate::verbs::presets;

pub(super) fn run(args: &Args, verb: &args::Dataset, count: u32) -> Result<()> {
    let species = presets(&verb.species)?;
    let names = species.iter().map(|species| species.name.clone()).collect();
    let plan = StandsPlan::new(names, count, Seed(verb.seed), verb.profile.name());
    let bar = report::bar(args, u64::from(count), "stands");
    let grow = |plants: &[Plant]| together(verb, &species, plants);
    build_stands(&plan, &verb.output, grow, |done| bar.set_position(u64::from(done)))?;
    bar.finish_and_clear();
    let trees: usize = (0..count).map(|number| plan.stand(number).len()).sum();
    let text = format!("{count} stands of {trees} trees in {}", verb.output.display());
    let figures = json!({
        "species": plan.species,
        "stands": count,
        "training_stands": plan.training_stands,
        "trees": trees,
    });
    report::say(args, &figures, &text, false);
    Ok(())
}

/// The trees of a plan, and what each becomes by itself.
fn together(
    verb: &args::Dataset,
    species: &[Species],
    plants: &[Plant],
) -> Result<Vec<(BranchGraph, Alone)>, CutOff> {
    let parameters = |plant: &Plant| {
        let mut parameters = species[plant.species].parameters(verb.profile).clone();
        parameters.age = plant.age.map_or(parameters.age, |age| age as f32);
        parameters
    };
    let parameters: Vec<Parameters> = plants.iter().map(parameters).collect();
    let planted: Vec<Planted<'_>> = plants
        .iter()
        .zip(&parameters)
        .map(|(plant, parameters)| Planted {
            species: &species[plant.species].name,
            parameters,
            seed: Seed(plant.seed),
            at: Vec3::new(plant.at[0], 0.0, plant.at[1]),
        })
        .collect();
    let stand = grow_stand(&planted)?;
    let both = planted.iter().zip(stand).map(|(planted, grown)| {
        let alone = grow(planted.species, planted.parameters, planted.seed)?;
        if grown.hit_budget || alone.hit_budget {
            return Err(CutOff::Budget);
        }
        Ok::<_, CutOff>((grown.tree, Alone::of(&alone.tree, planted.parameters.tip_radius)))
    });
    both.collect()
}
