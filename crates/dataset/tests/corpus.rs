//! Building, resuming and reading corpora on disk.

#![allow(clippy::unwrap_used, reason = "what cannot be set up has failed")]

use std::convert::Infallible;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use deeptree_cloud::{Cloud, Up};
use deeptree_dataset::{
    BuildError, BuildReport, Corpus, CorpusError, CorpusPlan, PLAN_FILE, Priors, ShardError, Span,
    Split, build, build_scans,
};
use deeptree_graph::testing::random_tree;
use deeptree_graph::{BranchGraph, Seed, Vec3};
use deeptree_scene::{Environment, Scene, Volume};

fn plan() -> CorpusPlan {
    let species = vec!["oak".into(), "pine".into()];
    CorpusPlan { shard_trees: 4, ..CorpusPlan::new(species, 10, Seed(100), "reference") }
}

fn grow(
    species: &str,
    seed: Seed,
    priors: &Priors,
    _: &Environment,
) -> Result<BranchGraph, Infallible> {
    let mut tree = random_tree(seed.0 ^ species.len() as u64, 30);
    tree.info.species = species.into();
    tree.info.seed = seed.0;
    tree.info.age = priors.age.unwrap_or(tree.info.age);
    tree.info.gravitropism = priors.gravitropism.unwrap_or(tree.info.gravitropism);
    Ok(tree)
}

fn built(dir: &Path) -> BuildReport {
    build(&plan(), dir, grow, |_| {}).unwrap()
}

/// Names and bytes of all files of a folder.
fn files(dir: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(dir)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, fs::read(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

#[test]
fn a_corpus_holds_each_planned_tree_once_in_its_split() {
    let dir = tempfile::tempdir().unwrap();
    let mut done = Vec::new();
    let report = build(&plan(), dir.path(), grow, |progress| {
        assert_eq!((progress.trees, progress.kept), (20, false));
        done.push((progress.species.to_owned(), progress.trees_done));
    });
    assert_eq!(report.unwrap(), BuildReport { written: 6, replaced: 0, kept: 0 });
    let expected = [("oak", 4), ("oak", 8), ("oak", 10), ("pine", 14), ("pine", 18), ("pine", 20)];
    assert_eq!(done, expected.map(|(species, done)| (species.to_owned(), done)));

    let corpus = Corpus::open(dir.path()).unwrap();
    assert_eq!(corpus.plan(), &plan());
    let numbers = |split| -> Vec<(usize, u32)> {
        corpus.trees(split).map(|tree| tree.unwrap()).map(|t| (t.species, t.number)).collect()
    };
    let both = |range: std::ops::Range<u32>| -> Vec<_> {
        (0..2).flat_map(|species| range.clone().map(move |number| (species, number))).collect()
    };
    assert_eq!(numbers(Split::Train), both(0..8));
    assert_eq!(numbers(Split::Validation), both(8..10));
    assert_eq!(numbers(Split::All), both(0..10));
    for tree in corpus.trees_of(1, Split::All) {
        let tree = tree.unwrap();
        assert_eq!(tree.tree, {
            let seed = Seed(100 + u64::from(tree.number));
            grow("pine", seed, &Priors::default(), &Environment::default()).unwrap()
        });
    }
}

#[test]
fn a_build_that_was_killed_goes_on_without_losing_or_doubling_a_tree() {
    let (whole, cut) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    built(whole.path());
    built(cut.path());
    fs::remove_file(cut.path().join("pine-002.parquet")).unwrap();
    let broken = cut.path().join("oak-001.parquet");
    let bytes = fs::read(&broken).unwrap();
    fs::write(&broken, &bytes[..bytes.len() / 2]).unwrap();
    fs::write(cut.path().join(".pine-002.parquet.0.part"), b"half a shard").unwrap();

    let calls = AtomicUsize::new(0);
    let counted = |species: &str, seed, priors: &Priors, around: &Environment| {
        calls.fetch_add(1, Ordering::Relaxed);
        grow(species, seed, priors, around)
    };
    let report = build(&plan(), cut.path(), counted, |_| {}).unwrap();
    assert_eq!(report, BuildReport { written: 2, replaced: 1, kept: 4 });
    assert_eq!(calls.into_inner(), 6);
    assert_eq!(files(cut.path()), files(whole.path()));
    assert_eq!(built(cut.path()), BuildReport { written: 0, replaced: 0, kept: 6 });
}

#[test]
fn shards_with_other_trees_than_planned_are_grown_anew() {
    let dir = tempfile::tempdir().unwrap();
    built(dir.path());
    let whole = files(dir.path());
    fs::copy(dir.path().join("oak-000.parquet"), dir.path().join("oak-001.parquet")).unwrap();
    fs::copy(dir.path().join("oak-000.parquet"), dir.path().join("pine-002.parquet")).unwrap();
    let corpus = Corpus::open(dir.path()).unwrap();
    let error = corpus.trees(Split::All).find_map(Result::err).unwrap();
    let is_other =
        matches!(error, CorpusError::Shard(ShardError::OtherTree { found: 0, number: 4, .. }));
    assert!(is_other, "{error}");
    assert_eq!(built(dir.path()).replaced, 2);
    assert_eq!(files(dir.path()), whole);
}

#[test]
fn files_that_are_not_ours_stay() {
    let dir = tempfile::tempdir().unwrap();
    for name in [".notes.part", "README", ".oak-000.parquet.x.part"] {
        fs::write(dir.path().join(name), b"mine").unwrap();
    }
    built(dir.path());
    assert_eq!(files(dir.path()).iter().filter(|(_, bytes)| bytes == b"mine").count(), 3);
}

#[cfg(feature = "parallel")]
#[test]
fn one_and_two_threads_write_the_same_bytes() {
    let hash_with = |threads: usize| {
        let dir = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| built(dir.path()));
        (files(dir.path()), Corpus::open(dir.path()).unwrap().hash().unwrap())
    };
    let one = hash_with(1);
    assert_eq!(one, hash_with(2));
    assert_eq!(one.1.len(), 64);
}

#[test]
fn the_hash_changes_with_any_byte() {
    let dir = tempfile::tempdir().unwrap();
    built(dir.path());
    let corpus = Corpus::open(dir.path()).unwrap();
    let before = corpus.hash().unwrap();
    let path = dir.path().join("pine-001.parquet");
    let mut bytes = fs::read(&path).unwrap();
    bytes[100] ^= 1;
    fs::write(&path, bytes).unwrap();
    assert_ne!(corpus.hash().unwrap(), before);
}

#[test]
fn another_corpus_in_the_folder_is_an_error_that_says_what_differs() {
    let dir = tempfile::tempdir().unwrap();
    built(dir.path());
    let other = CorpusPlan { profile: "published".into(), ..plan() };
    let error = build(&other, dir.path(), grow, |_| {}).unwrap_err();
    assert!(matches!(error, BuildError::OtherCorpus { field: "profile", .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("`reference`") && text.contains("`published`"), "{text}");

    fs::remove_file(dir.path().join(PLAN_FILE)).unwrap();
    let error = build(&plan(), dir.path(), grow, |_| {}).unwrap_err();
    assert!(matches!(error, BuildError::ShardWithoutPlan { .. }), "{error}");
}

#[test]
fn an_unfinished_corpus_does_not_open() {
    let dir = tempfile::tempdir().unwrap();
    assert!(matches!(Corpus::open(dir.path()), Err(CorpusError::Io { .. })));
    built(dir.path());
    fs::remove_file(dir.path().join("oak-002.parquet")).unwrap();
    assert!(matches!(Corpus::open(dir.path()), Err(CorpusError::MissingShard { .. })));
}

#[test]
fn the_first_tree_that_fails_is_named_and_earlier_shards_stay() {
    let dir = tempfile::tempdir().unwrap();
    let failing = |species: &str, seed: Seed, priors: &Priors, around: &Environment| {
        if seed.0 >= 105 {
            return Err(std::io::Error::other("no light"));
        }
        grow(species, seed, priors, around).map_err(|never| match never {})
    };
    let error = build(&plan(), dir.path(), failing, |_| {}).unwrap_err();
    assert!(matches!(error, BuildError::Grow { number: 5, seed: 105, .. }), "{error}");
    assert_eq!(error.source().unwrap().to_string(), "no light");
    assert_eq!(built(dir.path()), BuildReport { written: 5, replaced: 0, kept: 1 });

    let careless =
        |_: &str, seed, priors: &Priors, around: &Environment| grow("willow", seed, priors, around);
    let dir = tempfile::tempdir().unwrap();
    let error = build(&plan(), dir.path(), careless, |_| {}).unwrap_err();
    assert!(matches!(error, BuildError::GrownOther { number: 0, .. }), "{error}");
}

/// A plan whose trees differ in age and gravitropism.
fn of_priors() -> CorpusPlan {
    let gravitropisms = Some(vec![Span(-0.4, -0.25), Span(0.25, 0.4)]);
    CorpusPlan { ages: Some(vec![Span(10, 12), Span(30, 31)]), gravitropisms, ..plan() }
}

#[test]
fn trees_carry_the_age_and_gravitropism_that_the_plan_draws() {
    let dir = tempfile::tempdir().unwrap();
    build(&of_priors(), dir.path(), grow, |_| {}).unwrap();
    let whole = files(dir.path());
    let corpus = Corpus::open(dir.path()).unwrap();
    assert_eq!(corpus.plan(), &of_priors());
    let trees: Vec<_> = corpus.trees(Split::All).map(|tree| tree.unwrap()).collect();
    for tree in &trees {
        let info = &tree.tree.info;
        assert!([10, 11, 12, 30, 31].contains(&info.age), "{info:?}");
        assert!((0.25f32..=0.4).contains(&info.gravitropism.abs()), "{info:?}");
        assert!(of_priors().priors(tree.number).hold(info), "{info:?}");
    }
    let ages: std::collections::BTreeSet<u32> = trees.iter().map(|t| t.tree.info.age).collect();
    assert!(ages.len() > 1);

    // Cut off and run again, it comes to the same bytes.
    fs::remove_file(dir.path().join("oak-001.parquet")).unwrap();
    let report = build(&of_priors(), dir.path(), grow, |_| {}).unwrap();
    assert_eq!(report, BuildReport { written: 1, replaced: 0, kept: 5 });
    assert_eq!(files(dir.path()), whole);
}

#[test]
fn trees_of_another_age_than_drawn_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let careless = |species: &str, seed, _: &Priors, around: &Environment| {
        grow(species, seed, &Priors::default(), around)
    };
    let error = build(&of_priors(), dir.path(), careless, |_| {}).unwrap_err();
    assert!(matches!(error, BuildError::GrownAtOther { number: 0, .. }), "{error}");

    // Nor do the shards of a plan without ranges pass for those of a plan with them.
    built(dir.path().join("plain").as_path());
    let mixed = dir.path().join("mixed");
    build(&of_priors(), &mixed, grow, |_| {}).unwrap();
    fs::copy(dir.path().join("plain/oak-000.parquet"), mixed.join("oak-000.parquet")).unwrap();
    assert_eq!(build(&of_priors(), &mixed, grow, |_| {}).unwrap().replaced, 1);

    let other = CorpusPlan { ages: None, ..of_priors() };
    let error = build(&other, &mixed, grow, |_| {}).unwrap_err();
    assert!(matches!(error, BuildError::OtherCorpus { field: "ages", .. }), "{error}");
}

#[cfg(feature = "parallel")]
#[test]
fn ages_and_gravitropisms_are_the_same_on_any_number_of_threads() {
    let with = |threads: usize| {
        let dir = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build(&of_priors(), dir.path(), grow, |_| {}).unwrap());
        files(dir.path())
    };
    assert_eq!(with(1), with(3));
}

/// A plan whose trees stand in scenes and forms.
fn of_environments() -> CorpusPlan {
    let forms = Some(vec!["cone".into(), "ring".into()]);
    CorpusPlan { scenes: true, forms, ..plan() }
}

#[test]
fn what_stood_around_a_tree_comes_back_with_it() {
    let dir = tempfile::tempdir().unwrap();
    let seen = |species: &str, seed: Seed, priors: &Priors, around: &Environment| {
        assert_eq!(around.scene, Scene::random(seed));
        grow(species, seed, priors, around)
    };
    build(&of_environments(), dir.path(), seen, |_| {}).unwrap();
    let whole = files(dir.path());
    let corpus = Corpus::open(dir.path()).unwrap();
    assert_eq!(corpus.plan(), &of_environments());
    let mut trees = 0;
    for tree in corpus.trees(Split::All) {
        let tree = tree.unwrap();
        assert_eq!(tree.environment.scene, Scene::random(Seed(100 + u64::from(tree.number))));
        let form = if tree.number % 2 == 0 { Volume::Cone } else { Volume::Ring };
        assert_eq!(tree.environment.volume, Some(form));
        trees += 1;
    }
    assert_eq!(trees, 20);

    // Cut off and run again, it comes to the same bytes.
    fs::remove_file(dir.path().join("oak-001.parquet")).unwrap();
    let report = build(&of_environments(), dir.path(), grow, |_| {}).unwrap();
    assert_eq!(report, BuildReport { written: 1, replaced: 0, kept: 5 });
    assert_eq!(files(dir.path()), whole);
}

#[test]
fn shards_without_their_scenes_are_grown_anew() {
    let dir = tempfile::tempdir().unwrap();
    let (plain, mixed) = (dir.path().join("plain"), dir.path().join("mixed"));
    built(&plain);
    build(&of_environments(), &mixed, grow, |_| {}).unwrap();
    fs::copy(plain.join("oak-000.parquet"), mixed.join("oak-000.parquet")).unwrap();
    let corpus = Corpus::open(&mixed).unwrap();
    let error = corpus.trees(Split::All).find_map(Result::err).unwrap();
    let is_told = matches!(error, CorpusError::Shard(ShardError::NoEnvironment { number: 0, .. }));
    assert!(is_told, "{error}");
    assert_eq!(build(&of_environments(), &mixed, grow, |_| {}).unwrap().replaced, 1);

    let other = CorpusPlan { scenes: false, ..of_environments() };
    let error = build(&other, &mixed, grow, |_| {}).unwrap_err();
    assert!(matches!(error, BuildError::OtherCorpus { field: "scenes", .. }), "{error}");
    for tree in Corpus::open(&plain).unwrap().trees(Split::All) {
        assert!(tree.unwrap().environment.is_open());
    }
}

#[test]
fn scans_stand_beside_the_trees_and_are_made_once() {
    let dir = tempfile::tempdir().unwrap();
    built(dir.path());
    let corpus = Corpus::open(dir.path()).unwrap();
    let hash = corpus.hash().unwrap();
    // A cloud that tells of which tree it is.
    let scan = |tree: &BranchGraph, seed: Seed| Cloud {
        points: vec![Vec3::new(seed.0 as f32, tree.len() as f32, 0.0), Vec3::ONE],
        up: Up::Y,
        ..Cloud::default()
    };
    assert!(corpus.scans(Split::Train).next().unwrap().is_err());
    let report = build_scans(&corpus, scan, |_| {}).unwrap();
    assert_eq!((report.written, report.kept), (6, 0));
    let before = files(dir.path());
    for split in [Split::Train, Split::Validation] {
        let scans: Vec<_> = corpus.scans(split).map(Result::unwrap).collect();
        let trees: Vec<_> = corpus.trees(split).map(Result::unwrap).collect();
        assert_eq!(scans.len(), trees.len());
        for (made, tree) in scans.iter().zip(&trees) {
            assert_eq!((made.species, made.number), (tree.species, tree.number));
            assert_eq!(made.cloud, scan(&tree.tree, Seed(tree.tree.info.seed)));
        }
    }
    fs::write(dir.path().join("oak-001.scans.parquet"), b"PAR1").unwrap();
    let report = build_scans(&corpus, scan, |_| {}).unwrap();
    assert_eq!((report.written, report.replaced, report.kept), (1, 1, 5));
    assert_eq!(files(dir.path()), before);
    assert_eq!(corpus.hash().unwrap(), hash, "scans are no part of what a corpus is");
    assert_eq!(built(dir.path()).kept, 6);
}
