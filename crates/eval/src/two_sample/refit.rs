//! Forests fitted to permuted labels: how areas scatter where there is nothing to learn.

use std::num::NonZero;
use std::thread;

use crate::auc::{Auc, shuffle};

use super::{
    FOLD_INFLATION, Options, REFITS_FOR_INFLATION, Step, TwoSampleError, cross_validate, mean_area,
};

/// The mean areas of all refits, spread over the processor's threads; their number does not
/// change a bit of the result.
pub(super) fn areas(
    rows: &[&[f64]],
    labels: &[bool],
    options: &Options,
) -> Result<Vec<Auc>, TwoSampleError> {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let runs: Vec<u64> = (1..=options.refits as u64).collect();
    let share = runs.len().div_ceil(threads).max(1);
    let results: Vec<Result<Vec<Auc>, TwoSampleError>> = thread::scope(|scope| {
        let refit =
            |runs: &[u64]| runs.iter().map(|&run| area(rows, labels, options, run)).collect();
        let start = |runs| scope.spawn(move || refit(runs));
        let workers: Vec<_> = runs.chunks(share).map(start).collect();
        let join = |worker: thread::ScopedJoinHandle<'_, _>| {
            worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        workers.into_iter().map(join).collect()
    });
    let chunks: Result<Vec<_>, _> = results.into_iter().collect();
    chunks.map(|chunks| chunks.concat())
}

fn area(
    rows: &[&[f64]],
    labels: &[bool],
    options: &Options,
    run: u64,
) -> Result<Auc, TwoSampleError> {
    let mut labels = labels.to_vec();
    shuffle(&mut labels, &mut options.draws(Step::Refit).at(run));
    cross_validate(rows, &labels, options, run).map(|(folds, _)| mean_area(&folds))
}

/// See [`super::TwoSample::fold_inflation`].
pub(super) fn inflation(refits: &[Auc]) -> f64 {
    let scores = refits.iter().map(|auc| (auc.value - 0.5) / auc.standard_error);
    let squares: Vec<f64> = scores.map(|z| z * z).filter(|z| z.is_finite()).collect();
    if squares.len() < REFITS_FOR_INFLATION {
        return FOLD_INFLATION;
    }
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt().max(1.0)
}

/// The share of refits that reach the observed area, the observation counted among them.
pub(super) fn p_value(refits: &[Auc], observed: f64) -> Option<f64> {
    let reached = refits.iter().filter(|auc| auc.value >= observed).count();
    (!refits.is_empty()).then(|| (1 + reached) as f64 / (1 + refits.len()) as f64)
}
