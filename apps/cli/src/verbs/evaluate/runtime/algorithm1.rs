//! Algorithm 1 in PyTorch, node by node, as `benches/algorithm1.py` has it.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use deeptree_graph::signature::paper;
use deeptree_graph::{BranchGraph, Kin, MAX_CHILDREN, TreeInfo, Vec3};
use deeptree_infer::{Model, Predictor, Scratch, SimdPath, Weights};
use serde::Deserialize;

use super::Timing;
use crate::verbs::evaluate::study::Study;

const SCRIPT: &str = include_str!("../../../../../../benches/algorithm1.py");

/// A Python that knows torch, with the script and the model it reads.
pub(super) struct Torch {
    python: PathBuf,
    pub(super) version: String,
    script: PathBuf,
    weights: PathBuf,
    bytes: Vec<u8>,
}

/// What the script prints.
#[derive(Deserialize)]
struct Printed {
    classifier: Vec<[f64; MAX_CHILDREN]>,
    trees: Vec<Tree>,
}

#[derive(Deserialize)]
struct Tree {
    nodes: u32,
    branches: u32,
    cut: bool,
    seconds: f64,
}

/// How many trees, repeated how often, of how many nodes at most.
#[derive(Clone, Copy)]
pub(super) struct Work {
    pub(super) trees: u32,
    pub(super) repeats: u32,
    pub(super) budget: u32,
}

impl Torch {
    /// The Python that was asked for, or one of the system where it has torch.
    pub(super) fn find(study: &Study<'_>, paper: &[u8]) -> Result<Option<Self>> {
        let asked = study.verb.python.clone();
        let asked = asked.or_else(|| std::env::var_os("DEEPTREE_PYTHON").map(PathBuf::from));
        let python = asked.clone().unwrap_or_else(|| "python3".into());
        let print = "import torch; print(torch.__version__)";
        let output = Command::new(&python).args(["-c", print]).output();
        let version = match output {
            Ok(output) if output.status.success() => {
                String::from_utf8_lossy(&output.stdout).trim().to_owned()
            }
            _ if asked.is_some() => bail!("{} has no torch to import", python.display()),
            _ => return Ok(None),
        };
        let script = study.leave("algorithm1.py", SCRIPT.as_bytes())?;
        let weights = study.leave("algorithm1.safetensors", paper)?;
        Ok(Some(Self { python, version, script, weights, bytes: paper.to_vec() }))
    }

    /// Grows trees of a species, and compares what the classifier says of the model's first roots
    /// with what it says here; the largest difference comes back with the timing.
    pub(super) fn run(&self, species: &str, seed: u64, work: Work) -> Result<(Timing, f64)> {
        let output = Command::new(&self.python)
            .arg(&self.script)
            .arg(&self.weights)
            .arg(species)
            .args(["--seed", &seed.to_string()])
            .args(["--trees", &work.trees.to_string()])
            .args(["--repeats", &work.repeats.to_string()])
            .args(["--budget", &work.budget.to_string()])
            .output()
            .with_context(|| format!("cannot run {}", self.python.display()))?;
        let errors = String::from_utf8_lossy(&output.stderr);
        let last = errors.trim_end().lines().last().unwrap_or_default();
        ensure!(output.status.success(), "{}: {last}", name(&self.script));
        let printed: Printed = serde_json::from_slice(&output.stdout)
            .with_context(|| format!("{} printed no figures", name(&self.script)))?;
        let ours = classifier(&self.bytes, species, printed.classifier.len())?;
        let apart = |(a, b): (&[f64; 3], &[f64; 3])| {
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let apart = printed.classifier.iter().zip(&ours).map(apart).fold(0.0, f64::max);
        let mut timing = Timing::new(super::TORCH);
        for tree in &printed.trees {
            timing.add(tree.seconds, tree.nodes, tree.branches, tree.cut);
        }
        Ok((timing, apart))
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// What the classifier of a model of kind `paper` says of the first roots of a species.
fn classifier(bytes: &[u8], species: &str, count: usize) -> Result<Vec<[f64; MAX_CHILDREN]>> {
    let weights = Weights::from_bytes(bytes)?;
    let model = Model::from_weights(&weights)?;
    let network = weights.mlp("classifier")?;
    let names = model.species();
    let number = names.iter().position(|name| name == species).context("no such species")?;
    let tip_radius = model.tip_radius(number);
    let mut row = vec![0.0; paper::len(names.len())];
    let mut said = Vec::new();
    for root in model.roots(number).iter().take(count) {
        let info = TreeInfo { species: species.into(), age: 0, gravitropism: 0.0, seed: 0 };
        let tree = BranchGraph::new(info, Vec3::ZERO, root.signature);
        let conditions = root.conditions(number, tip_radius, None, [0.0; Kin::HABITS]);
        paper::encode(tree.root(), &conditions, names.len(), &mut row);
        let mut scratch = Scratch::new();
        let logits = network.forward(SimdPath::detect(), &row, &mut scratch);
        said.push(std::array::from_fn(|i| 1.0 / (1.0 + (-f64::from(logits[i])).exp())));
    }
    Ok(said)
}
