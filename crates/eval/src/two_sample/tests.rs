use super::*;

/// Rows of unit normals, all features shifted by `shift`.
fn normals(seed: u64, rows: usize, width: usize, shift: f64) -> Vec<Vec<f64>> {
    let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::Evaluation);
    (0..rows).map(|_| (0..width).map(|_| shift + draws.normal()).collect()).collect()
}

fn names(width: usize) -> Vec<String> {
    (0..width).map(|k| format!("f{k}")).collect()
}

fn quick(seed: u64) -> Options {
    Options { forest_trees: 60, refits: 0, permutations: 199, ..Options::new(Seed(seed)) }
}

#[test]
fn equal_laws_have_the_area_one_half_within_the_interval() {
    let (a, b) = (normals(1, 150, 6, 0.0), normals(2, 150, 6, 0.0));
    let options = Options { refits: 39, ..quick(1) };
    let result = two_sample(&a, &b, &names(6), options).unwrap();
    assert!((result.auc.low..result.auc.high).contains(&0.5), "{result:?}");
    assert!(result.p_value.unwrap() > 0.025, "{result:?}");
    assert!((1.0..2.2).contains(&result.fold_inflation), "{result:?}");
}

#[test]
fn the_interval_covers_equal_laws_as_often_as_it_says() {
    let covers = |seed: u64| {
        let (a, b) = (normals(100 + 2 * seed, 80, 6, 0.0), normals(101 + 2 * seed, 80, 6, 0.0));
        let auc = two_sample(&a, &b, &names(6), quick(seed)).unwrap().auc;
        (auc.low..auc.high).contains(&0.5)
    };
    // 95 % of 60 are 57 ± 1.7; four deviations.
    let covered = (0..60).filter(|&seed| covers(seed)).count();
    assert!(covered >= 51, "{covered} of 60 intervals hold one half");
}

#[test]
fn shifted_normals_come_near_the_analytic_area_of_the_best_classifier() {
    // Four features d/2 = 0.75 apart are d = 1.5 apart in all: Φ(d / √2) = 0.855 578 is the most
    // that any score reaches. A forest of axis-parallel splits loses some of it.
    let best = 0.855_578;
    let (a, b) = (normals(3, 300, 4, 0.0), normals(4, 300, 4, 0.75));
    let auc = two_sample(&a, &b, &names(4), quick(1)).unwrap().auc;
    assert!(auc.value < best + 4.0 * auc.standard_error, "{auc:?}");
    assert!(auc.value > best - 0.04 - 2.0 * auc.standard_error, "{auc:?}");
}

#[test]
fn the_feature_that_differs_is_the_first_telltale() {
    let (a, mut b) = (normals(5, 100, 20, 0.0), normals(6, 100, 20, 0.0));
    b.iter_mut().for_each(|row| row[13] += 2.0);
    let result = two_sample(&a, &b, &names(20), quick(1)).unwrap();
    let first = &result.telltales[0];
    assert_eq!((first.name.as_str(), result.telltales.len()), ("f13", TELLTALES));
    assert!(first.importance > 3.0 * result.telltales[1].importance);
    assert!((first.mean_b - first.mean_a - 2.0).abs() < 0.5 && first.distances.ks > 0.5);
    assert!((result.held_out_p_value - 1.0 / 200.0).abs() < 1e-12);
    assert_eq!((result.p_value, result.fold_inflation), (None, FOLD_INFLATION));
}

#[test]
fn no_refit_reaches_the_area_of_parted_sets() {
    let (a, b) = (normals(7, 30, 3, 0.0), normals(8, 30, 3, 2.0));
    let options = Options { refits: 9, forest_trees: 10, ..quick(1) };
    let result = two_sample(&a, &b, &names(3), options).unwrap();
    assert_eq!(result.p_value, Some(0.1));
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_one_other_folds() {
    let (a, b) = (normals(1, 40, 3, 0.0), normals(2, 40, 3, 0.5));
    let run = |seed| two_sample(&a, &b, &names(3), quick(seed)).unwrap();
    assert_eq!(run(1), run(1));
    assert_ne!(run(1).auc, run(2).auc);
}

#[test]
fn rows_that_cannot_be_tested_are_refused() {
    let rows = normals(1, 20, 3, 0.0);
    let mut poisoned = rows.clone();
    poisoned[4][1] = f64::NAN;
    let refusal = |a: &[Vec<f64>], names: &[String]| {
        two_sample(a, &rows, names, quick(1)).expect_err("refused").to_string()
    };
    assert!(refusal(&rows[..9], &names(3)).contains("9 trees"));
    assert!(refusal(&rows, &names(2)).contains("3 features, not 2"));
    assert!(refusal(&poisoned, &names(3)).contains("feature f1"));
}
