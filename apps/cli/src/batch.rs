//! Many trees on all threads, handed on in order.

use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use deeptree_generate::{Avoided, Germ};
use deeptree_graph::{BranchGraph, Vec3};
use rayon::prelude::*;

/// Trees made at a time: enough to keep all threads busy, few enough to fit in memory.
const CHUNK: u64 = 64;

/// A tree that was made.
#[derive(Clone)]
pub(crate) struct Made {
    pub(crate) seed: u64,
    /// Its number in a table.
    pub(crate) number: u32,
    /// The tree, in its own space until it is written.
    pub(crate) tree: BranchGraph,
    /// Where its foot stands in a stand, in metres.
    pub(crate) at: Vec3,
    /// What it grew from, for a tree of the networks.
    pub(crate) germ: Option<Germ>,
    pub(crate) hit_budget: bool,
    /// How often it would have grown where it cannot, for a tree of the networks among obstacles.
    pub(crate) avoided: Option<Avoided>,
}

impl Made {
    /// The same tree at its place.
    pub(crate) fn placed(self) -> Self {
        Self { tree: self.tree.moved(self.at), at: Vec3::ZERO, ..self }
    }
}

/// Makes something of each of `count` seeds from `first` on, on all threads, and hands it to `take`
/// in the order of the seeds, with its number and the time it took.
///
/// `worker` is what each thread works with.
pub(crate) fn make<W, T: Send>(
    first: u64,
    count: u64,
    worker: impl Fn() -> Result<W> + Sync,
    one: impl Fn(&mut W, u64) -> Result<T> + Sync,
    mut take: impl FnMut(u64, T, Duration) -> Result<()>,
) -> Result<()> {
    let mut done = 0;
    while done < count {
        let end = count.min(done + CHUNK);
        let made: Vec<Result<(T, Duration)>> = (done..end)
            .into_par_iter()
            .map_init(&worker, |worker, k| match worker {
                Ok(worker) => {
                    let start = Instant::now();
                    let made = one(worker, first.wrapping_add(k))?;
                    Ok((made, start.elapsed()))
                }
                Err(error) => Err(anyhow::anyhow!("{error:#}")),
            })
            .collect();
        for (k, made) in (done..end).zip(made) {
            let (made, took) = made?;
            take(k, made, took)?;
        }
        done = end;
    }
    Ok(())
}

/// Runs `work` on the given number of threads.
pub(crate) fn on_threads<T: Send>(
    threads: Option<u16>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    match threads {
        None => work(),
        Some(threads) => rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build()
            .context("cannot start the threads")?
            .install(work),
    }
}
