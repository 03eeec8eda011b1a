//! Many trees on all threads, handed on in order.

use anyhow::{Context, Result};
use deeptree_generate::Germ;
use deeptree_graph::BranchGraph;
use rayon::prelude::*;

/// Trees made at a time: enough to keep all threads busy, few enough to fit in memory.
const CHUNK: u64 = 64;

/// A tree that was made.
pub(crate) struct Made {
    pub(crate) seed: u64,
    pub(crate) tree: BranchGraph,
    /// What it grew from, for a tree of the networks.
    pub(crate) germ: Option<Germ>,
    pub(crate) hit_budget: bool,
}

/// Makes the trees of `count` seeds from `first` on and hands them to `take` in their order.
///
/// `worker` is what each thread works with.
pub(crate) fn make<W, T: Send>(
    first: u64,
    count: u64,
    worker: impl Fn() -> Result<W> + Sync,
    one: impl Fn(&mut W, u64) -> Result<T> + Sync,
    mut take: impl FnMut(T) -> Result<()>,
) -> Result<()> {
    let mut done = 0;
    while done < count {
        let end = count.min(done + CHUNK);
        let made: Vec<Result<T>> = (done..end)
            .into_par_iter()
            .map_init(&worker, |worker, k| match worker {
                Ok(worker) => one(worker, first.wrapping_add(k)),
                Err(error) => Err(anyhow::anyhow!("{error:#}")),
            })
            .collect();
        for made in made {
            take(made?)?;
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
