//! Building, resuming and reading corpora of stands.
#![allow(clippy::unwrap_used, reason = "what cannot be set up has failed")]

use std::cell::Cell;
use std::convert::Infallible;
use std::fs;
use std::path::Path;

use deeptree_dataset::{Alone, Plant, STANDS_FILE, Stands, StandsError, StandsPlan, build_stands};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{BranchGraph, Seed};

const SPECIES: [&str; 2] = ["oak", "pine"];

fn plan() -> StandsPlan {
    let species = SPECIES.map(String::from).to_vec();
    StandsPlan { shard_stands: 4, ..StandsPlan::new(species, 10, Seed(100), "reference") }
}

fn alone(plant: &Plant) -> Alone {
    Alone { tips: plant.seed as u32 % 50 + 1, traits: [plant.at[0].abs() + 1.5; 7] }
}

fn grow(plants: &[Plant]) -> Result<Vec<(BranchGraph, Alone)>, Infallible> {
    let tree = |plant: &Plant| {
        let mut tree = random_tree(plant.seed, 20);
        (tree.info.species, tree.info.seed) = (SPECIES[plant.species].to_owned(), plant.seed);
        (tree, alone(plant))
    };
    Ok(plants.iter().map(tree).collect())
}

fn built(dir: &Path) -> Stands {
    build_stands(&plan(), dir, grow, |_| {}).unwrap();
    Stands::open(dir).unwrap()
}

#[test]
fn a_corpus_holds_every_stand_with_what_its_trees_are_alone() {
    let dir = tempfile::tempdir().unwrap();
    let done = Cell::new(0);
    build_stands(&plan(), dir.path(), grow, |stands| done.set(stands)).unwrap();
    assert_eq!(done.get(), 10);
    let corpus = Stands::open(dir.path()).unwrap();
    let both = [corpus.stands(true).unwrap(), corpus.stands(false).unwrap()];
    assert_eq!(both.each_ref().map(Vec::len), [8, 2]);
    for (number, stand) in (0..).zip(both.iter().flatten()) {
        let plants = plan().stand(number);
        assert_eq!(stand.len(), plants.len());
        let grown = grow(&plants).unwrap();
        for ((found, plant), (tree, alone)) in stand.iter().zip(plants).zip(grown) {
            assert_eq!((found.plant, &found.tree, found.alone), (plant, &tree, alone));
        }
    }
}

#[test]
fn plans_have_two_to_twenty_trees_apart_from_each_other() {
    let plan = StandsPlan::new(SPECIES.map(String::from).to_vec(), 400, Seed(9), "reference");
    let (mut counts, mut pure, mut aged) = ([0; 21], 0, 0);
    for number in 0..400 {
        let plants = plan.stand(number);
        counts[plants.len()] += 1;
        pure += i32::from(plants.iter().all(|plant| plant.species == plants[0].species));
        aged += i32::from(plants[0].age.is_some());
        for (i, plant) in plants.iter().enumerate() {
            // Neighbours stand at least a fifth of 2.5 m apart.
            assert!(plants[..i].iter().all(|other| plant.to(other).length() > 0.49));
            assert!(plant.age.is_none_or(|age| (12..36).contains(&age)));
        }
    }
    assert!(counts[..2] == [0, 0] && counts[2..].iter().all(|&count| count > 5), "{counts:?}");
    // Two species: of mixtures, some are of one by chance.
    assert!((200..340).contains(&pure) && (120..200).contains(&aged), "{pure} {aged}");
}

#[test]
fn a_build_goes_on_and_mends_what_is_damaged() {
    let (whole, dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let hash = built(whole.path()).hash().unwrap();
    built(dir.path());
    let shard = dir.path().join("stands-001.parquet");
    for damage in [&[][..], b"PAR1", &fs::read(dir.path().join("stands-000.parquet")).unwrap()] {
        fs::write(&shard, damage).unwrap();
        assert!(Stands::open(dir.path()).unwrap().stands(true).is_err());
        assert_eq!(built(dir.path()).hash().unwrap(), hash);
    }
    fs::remove_file(&shard).unwrap();
    assert!(Stands::open(dir.path()).unwrap().stands(true).is_err());
    assert_eq!(built(dir.path()).hash().unwrap(), hash);
}

#[test]
fn what_is_no_corpus_of_stands_is_told_apart() {
    let dir = tempfile::tempdir().unwrap();
    assert!(matches!(Stands::open(dir.path()), Err(StandsError::Io { .. })));
    fs::write(dir.path().join(STANDS_FILE), "trees = 3").unwrap();
    assert!(matches!(Stands::open(dir.path()), Err(StandsError::Toml { .. })));
    fs::remove_file(dir.path().join(STANDS_FILE)).unwrap();
    built(dir.path());
    let other = StandsPlan { first_seed: 3, ..plan() };
    let error = build_stands(&other, dir.path(), grow, |_| {}).unwrap_err();
    assert!(matches!(error, StandsError::OtherCorpus { .. }));
    for bad in [
        StandsPlan { stands: 0, ..plan() },
        StandsPlan { species: vec![], ..plan() },
        StandsPlan { training_stands: 11, ..plan() },
        StandsPlan { first_seed: u64::MAX, ..plan() },
        StandsPlan { format: 2, ..plan() },
    ] {
        let error = build_stands(&bad, dir.path(), grow, |_| {}).unwrap_err();
        assert!(matches!(error, StandsError::Plan { .. }), "{error}");
    }
}
