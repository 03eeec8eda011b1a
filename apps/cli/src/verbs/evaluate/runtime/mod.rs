//! Chapter 8: what a tree costs, from the growth model, from the networks, and from a
//! straightforward PyTorch version of Algorithm 1.

mod algorithm1;

use std::fs;
use std::time::Instant;

use anyhow::Result;
use deeptree_eval::published::RUNTIME;
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_generate::{DEFAULT_BUDGET, Limits, Request, generate};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::Species;
use deeptree_infer::{Model, ModelKind, SimdPath};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::study::Study;
use super::trees;
use crate::args::ModelChoice;
use crate::report;
use algorithm1::{Torch, Work};

/// Trees of each species, as in the paper, and how often each is made: the fastest time counts, as
/// what slows a run down is not the method.
const FULL: Counts = Counts { trees: 10, repeats: 5, budget: 5000 };
const QUICK: Counts = Counts { trees: 2, repeats: 2, budget: 500 };

#[derive(Clone, Copy)]
struct Counts {
    trees: u32,
    repeats: u32,
    /// Nodes of a tree of kind `paper`, which seldom ends by itself.
    budget: u32,
}

const GROWTH: &str = "growth model";
const NETWORKS: &str = "networks";
const PAPER: &str = "kind paper";
const TORCH: &str = "kind paper, PyTorch";

/// What the trees of one method cost.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Timing {
    method: String,
    trees: u32,
    seconds: f64,
    nodes: u64,
    branches: u64,
    /// Trees that the node budget cut short.
    cut: u32,
}

/// What the methods cost for one species, one after the other in one run.
#[derive(Serialize, Deserialize)]
struct Costs {
    species: String,
    timings: Vec<Timing>,
    /// The largest difference between the classifier of the script and ours.
    apart: Option<f64>,
}

impl Timing {
    fn new(method: &str) -> Self {
        Self { method: method.to_owned(), ..Self::default() }
    }

    fn add(&mut self, seconds: f64, nodes: u32, branches: u32, cut: bool) {
        self.trees += 1;
        self.seconds += seconds;
        self.nodes += u64::from(nodes);
        self.branches += u64::from(branches);
        self.cut += u32::from(cut);
    }

    fn each(&self, sum: f64) -> f64 {
        sum / f64::from(self.trees.max(1))
    }

    fn nodes_a_second(&self) -> f64 {
        self.nodes as f64 / self.seconds
    }
}

impl Costs {
    fn of(&self, method: &str) -> Option<&Timing> {
        self.timings.iter().find(|timing| timing.method == method)
    }
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let counts = if study.verb.quick { QUICK } else { FULL };
    let counts = Counts { trees: counts.trees.min(study.trees()), ..counts };
    let paper = ModelChoice { model: "paper".into(), simd: study.verb.model.simd };
    let torch = match study.model {
        Some(_) => Torch::find(study, &paper.bytes()?)?,
        None => None,
    };
    let paper = paper.load()?;
    let bar = report::bar(study.args, study.species.len() as u64, "runtime");
    let mut rows = Vec::new();
    for species in &study.species {
        let with = if torch.is_some() { "-torch" } else { "" };
        rows.push(study.part(&format!("runtime{with}-{}", species.name), || {
            measure(study, species, &paper, torch.as_ref(), counts)
        })?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mut chapter = Chapter::new("runtime", "Runtime performance");
    say(&mut chapter, study, &rows, torch.as_ref(), counts);
    table(&mut chapter, &rows, counts);
    save(study, &rows)?;
    Ok(chapter)
}

/// Times all methods, tree by tree on this thread.
fn measure(
    study: &Study<'_>,
    species: &Species,
    paper: &Model,
    torch: Option<&Torch>,
    counts: Counts,
) -> Result<Costs> {
    let name = &species.name;
    let mut costs = Costs { species: name.clone(), timings: Vec::new(), apart: None };
    costs.timings.push(time(study, GROWTH, counts, |seed| {
        let grown = trees::grown(study, species, seed)?;
        Ok((grown.tree, grown.hit_budget))
    })?);
    let Some(model) = &study.model else { return Ok(costs) };
    let mut work = study.verb.model.workspace()?;
    let mut grow = |method, model: &Model| {
        let budget = match model.kind() {
            ModelKind::Paper => counts.budget as usize,
            _ => DEFAULT_BUDGET,
        };
        let limits = Limits { budget, ..Limits::default() };
        time(study, method, counts, |seed| {
            let grown = generate(model, &Request::new(name, Seed(seed)), limits, &mut work)?;
            Ok((grown.tree, grown.hit_budget))
        })
    };
    costs.timings.push(grow(NETWORKS, model)?);
    costs.timings.push(grow(PAPER, paper)?);
    if let Some(torch) = torch {
        // Once is enough for what takes seconds.
        let work = Work { trees: counts.trees, repeats: 1, budget: counts.budget };
        let (timing, apart) = torch.run(name, study.verb.seed, work)?;
        costs.timings.push(timing);
        costs.apart = Some(apart);
    }
    Ok(costs)
}

/// Makes each tree several times; its fastest time counts.
fn time(
    study: &Study<'_>,
    method: &str,
    counts: Counts,
    mut make: impl FnMut(u64) -> Result<(BranchGraph, bool)>,
) -> Result<Timing> {
    let mut timing = Timing::new(method);
    for k in 0..u64::from(counts.trees) {
        let seed = study.verb.seed.wrapping_add(k);
        let mut fastest = f64::INFINITY;
        let mut last = None;
        for _ in 0..counts.repeats {
            let start = Instant::now();
            let made = make(seed)?;
            fastest = fastest.min(start.elapsed().as_secs_f64());
            last = Some(made);
        }
        if let Some((tree, cut)) = last {
            let branches = deeptree_graph::branches(&tree).len() as u32;
            timing.add(fastest, tree.len() as u32, branches, cut);
        }
    }
    Ok(timing)
}

/// All species of one method together.
fn total(rows: &[Costs], method: &str) -> Option<Timing> {
    let mut timings = rows.iter().filter_map(|row| row.of(method)).peekable();
    timings.peek()?;
    Some(timings.fold(Timing::new(method), |sum, one| Timing {
        method: sum.method,
        trees: sum.trees + one.trees,
        seconds: sum.seconds + one.seconds,
        nodes: sum.nodes + one.nodes,
        branches: sum.branches + one.branches,
        cut: sum.cut + one.cut,
    }))
}

fn say(
    chapter: &mut Chapter,
    study: &Study<'_>,
    rows: &[Costs],
    torch: Option<&Torch>,
    counts: Counts,
) {
    let [growth, networks, paper, script] =
        [GROWTH, NETWORKS, PAPER, TORCH].map(|method| total(rows, method));
    let mean = |timing: &Timing| timing.each(timing.seconds);
    if let (Some(growth), Some(networks)) = (&growth, &networks) {
        let published = |of: fn(&deeptree_eval::published::PublishedRuntime) -> f64| {
            RUNTIME.iter().map(of).sum::<f64>() / RUNTIME.len() as f64
        };
        let (p, dt) = (published(|row| row.p.0), published(|row| row.dt.0));
        chapter.text(format!(
            "A tree takes {} from the growth model and {} from the networks, {:.1} times as fast; \
             in the paper {p:.0} s and {dt:.1} s, {:.0} times as fast. A node of the networks takes \
             {:.2} µs.",
            seconds(mean(growth)),
            seconds(mean(networks)),
            mean(growth) / mean(networks),
            p / dt,
            1e6 / networks.nodes_a_second(),
        ));
    }
    match (&paper, &script, torch) {
        (Some(paper), Some(script), Some(torch)) => {
            let apart = rows.iter().filter_map(|row| row.apart).fold(0.0, f64::max);
            chapter.text(format!(
                "The networks of kind paper draw {:.0} nodes a second here, and {:.0} in a \
                 straightforward PyTorch {} version of Algorithm 1 that asks the networks for one \
                 node at a time (benches/algorithm1.py, one thread, same weights, same budget of {} \
                 nodes): {:.0} times as many. What the two say of the same roots differs by at most \
                 {apart:.0e}.",
                paper.nodes_a_second(),
                script.nodes_a_second(),
                torch.version,
                counts.budget,
                paper.nodes_a_second() / script.nodes_a_second(),
            ));
        }
        _ => chapter.text(
            "The PyTorch version of Algorithm 1 was not measured: no Python with torch was found; \
             name one with --python or $DEEPTREE_PYTHON.",
        ),
    }
    let set = study.verb.model.simd.unwrap_or_else(SimdPath::detect);
    chapter.text(format!(
        "One thread, {}instruction set {set}; {} trees a species, each made {} times (PyTorch: \
         once), of which the fastest counts. Only the branch graph is timed. The paper does \
         not say on what it ran; seconds of different machines say less than ratios.",
        processor().map_or(String::new(), |name| format!("{name}, ")),
        counts.trees,
        counts.repeats,
    ));
}

/// What the processor calls itself, where the system tells.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn seconds(x: f64) -> String {
    if x < 1.0 { format!("{:.1} ms", 1e3 * x) } else { format!("{x:.2} s") }
}

fn table(chapter: &mut Chapter, rows: &[Costs], counts: Counts) {
    let mut body = Vec::new();
    let quiet = |text: String| Cell::new(text, Tone::Quiet);
    let mut lines = |species: &str, timings: &[Timing], base: Option<&Timing>| {
        for timing in timings {
            let base = base.map_or(f64::NAN, |base| base.each(base.seconds));
            let mean = timing.each(timing.seconds);
            let faster = if timing.cut == 0 { format!("{:.1}", base / mean) } else { "–".into() };
            let paper = RUNTIME.iter().find(|row| row.species == species);
            let paper = match (paper, timing.method.as_str()) {
                (Some(row), GROWTH) => Some((row.p, 1.0)),
                (Some(row), NETWORKS) => Some((row.dt, row.p.0 / row.dt.0)),
                _ => None,
            };
            let mut cells: Vec<Cell> = vec![
                species.into(),
                timing.method.as_str().into(),
                seconds(mean).into(),
                faster.into(),
                format!("{:.0}", timing.each(timing.nodes as f64)).into(),
                format!("{:.0}", timing.each(timing.branches as f64)).into(),
                format!("{:.1}", timing.nodes_a_second() / 1e3).into(),
                timing.cut.to_string().into(),
            ];
            cells.extend(match paper {
                Some(((seconds, nodes, branches), ratio)) => [
                    quiet(format!("{seconds:.1} s")),
                    quiet(format!("{ratio:.1}")),
                    quiet(nodes.to_string()),
                    quiet(branches.to_string()),
                    quiet(format!("{:.2}", f64::from(nodes) / seconds / 1e3)),
                ],
                None => std::array::from_fn(|_| quiet("–".into())),
            });
            body.push(cells);
        }
    };
    for row in rows {
        lines(&row.species, &row.timings, row.of(GROWTH));
    }
    let totals: Vec<Timing> = [GROWTH, NETWORKS, PAPER, TORCH]
        .into_iter()
        .filter_map(|method| total(rows, method))
        .collect();
    if rows.len() > 1 {
        lines("all", &totals, totals.first());
    }
    let caption = format!(
        "Runtime performance comparison, means of the trees; beside ours (grey) the paper's table, \
         whose times are of other machines. Faster: how many trees for one of the growth model, \
         where all trees are whole. Cut: trees that ran into their budget, {} nodes for kind paper, \
         whose trees seldom end by themselves.",
        counts.budget
    );
    let header = [
        "species",
        "method",
        "a tree",
        "faster",
        "nodes",
        "branches",
        "1000 nodes/s",
        "cut",
        "paper: a tree",
        "faster",
        "nodes",
        "branches",
        "1000 nodes/s",
    ];
    chapter.table(caption, &header, body);
}

fn save(study: &Study<'_>, rows: &[Costs]) -> Result<()> {
    let mut csv =
        String::from("species,method,trees,cut,seconds_a_tree,nodes,branches,nodes_a_second\n");
    for row in rows {
        for timing in &row.timings {
            csv += &format!(
                "{},\"{}\",{},{},{},{},{},{}\n",
                row.species,
                timing.method,
                timing.trees,
                timing.cut,
                timing.each(timing.seconds),
                timing.each(timing.nodes as f64),
                timing.each(timing.branches as f64),
                timing.nodes_a_second(),
            );
        }
    }
    study.save("runtime.csv", csv.as_bytes())?;
    study.save("runtime.json", serde_json::to_string_pretty(&json!({ "rows": rows }))?.as_bytes())
}
