//! What the trees around make of a tree, learned from stands.
//!
//! A sample is a tree of a stand with the trees around it, each told by what it is by itself, and by
//! how much the tree's state in the stand differs from its own by itself. The network says something
//! of the tree with the others and something of it without them; the difference is fitted to that of
//! the states, so that it is nothing where there are no others.

use std::collections::BTreeMap;

use burn::tensor::{Device, Tensor, TensorData};
use deeptree_graph::signature::competition::{self, Contender, INDICES, OUTPUTS};
use deeptree_graph::{Lineage, Purpose, Seed, TreeTraits, Vec2};
use deeptree_infer::{Table, Weights, WeightsBuilder};

use crate::adam::State;
use crate::mlp::{self, Mlp};
use crate::order::Order;
use crate::report::{Figures, Tally};
use crate::{Kind, NetworkReport, Report, TrainError};

/// Name of the network.
pub(crate) const NAME: &str = "competition";
/// Keys the network's draws; those below are of the networks of nodes.
const KEY: u64 = 31;
/// Widths of the hidden layers: 1 660 weights with eight species.
const HIDDEN: [usize; 2] = [28, 28];
const BATCH: usize = 256;
const STEPS: u64 = 6000;
const LEARNING_RATE: f64 = 3e-3;
/// Pull of the weights towards 0: there are few stands.
const DECAY: f64 = 1e-3;
/// Of the running average that is judged and written.
const AVERAGE: f64 = 0.99;

/// Number of ln nodes among the outputs.
const NODES: usize = 1;

/// A tree of a stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Rivalry {
    /// The tree as it is by itself.
    pub own: Contender,
    /// The others of the stand as they are by themselves, and where they stand as seen from it.
    pub others: Vec<(Vec2, Contender)>,
    /// What the stand adds to its state.
    pub shift: [f64; OUTPUTS],
}

/// Trees of stands to learn from, and others to judge by.
#[derive(Clone, Debug, PartialEq)]
pub struct Rivalries {
    /// To learn from.
    pub train: Vec<Rivalry>,
    /// To judge by: of other stands.
    pub validation: Vec<Rivalry>,
    /// What tells this data from other data.
    pub data_hash: String,
}

/// Trains the network of competition, and puts it into a model whose other networks are kept.
///
/// # Errors
///
/// When there are no trees to learn from or to judge by, their species are none of the model's, the
/// report is of another model, the model is not of kind `situated`, or the training diverges.
pub fn train_competition(
    set: &Rivalries,
    seed: Seed,
    (model, report): (&Weights, &Report),
) -> Result<(Vec<u8>, Report), TrainError> {
    report.check(model, Kind::Situated)?;
    let species = model.species().len();
    for (part, trees) in [("training", &set.train), ("validation", &set.validation)] {
        if trees.is_empty() {
            return Err(TrainError::NoTrees { part });
        }
        if let Some(tree) = trees.iter().position(|tree| tree.own.species >= species) {
            let number = format!("number {}", trees[tree].own.species);
            return Err(TrainError::UnknownSpecies { part, tree, species: number });
        }
    }
    let start = std::time::Instant::now();
    let (tables, network) = fit(set, seed, species)?;
    let mut builder = WeightsBuilder::from_weights(model);
    for (name, table) in tables {
        builder.table(name, table);
    }
    let bytes = builder.to_bytes()?;
    let seconds = start.elapsed().as_secs_f64();
    let samples_per_second = (STEPS * BATCH as u64) as f64 / seconds.max(1e-9);
    let network = NetworkReport { seconds, samples_per_second, ..network };
    let report = report.with(NAME, network, &bytes)?;
    Ok((bytes, report))
}

/// Rows of what the network reads, each with the others and without, and what it is to say.
struct Rows {
    width: usize,
    with: Vec<f32>,
    without: Vec<f32>,
    targets: Vec<f32>,
}

impl Rows {
    /// `deviation` is the unit of the targets.
    fn of(trees: &[&Rivalry], species: usize, deviation: &[f64; OUTPUTS]) -> Self {
        let width = competition::len(species);
        let mut with = vec![0.0; trees.len() * width];
        for (tree, row) in trees.iter().zip(with.chunks_exact_mut(width)) {
            competition::encode(species, &tree.own, &tree.others, row);
        }
        let mut without = with.clone();
        for row in without.chunks_exact_mut(width) {
            row[width - INDICES..].fill(0.0);
        }
        let unit = |tree: &&Rivalry| -> [f32; OUTPUTS] {
            std::array::from_fn(|i| (tree.shift[i] / deviation[i]) as f32)
        };
        Self { width, with, without, targets: trees.iter().flat_map(unit).collect() }
    }

    /// The rows of these numbers: with, without, targets.
    fn pick(&self, numbers: &[usize]) -> [Tensor<2>; 3] {
        let tensor = |values: &[f32], width: usize| {
            let rows = numbers.iter().flat_map(|&n| &values[n * width..(n + 1) * width]).copied();
            let data = TensorData::new(rows.collect::<Vec<f32>>(), [numbers.len(), width]);
            Tensor::<2>::from_data(data, &device())
        };
        [
            tensor(&self.with, self.width),
            tensor(&self.without, self.width),
            tensor(&self.targets, OUTPUTS),
        ]
    }
}

/// Few and small steps: nothing but the main processor is worth it.
fn device() -> Device {
    Device::flex()
}

fn fit(
    set: &Rivalries,
    seed: Seed,
    species: usize,
) -> Result<(Vec<(String, Table)>, NetworkReport), TrainError> {
    let deviation = deviations(&set.train);
    let all: Vec<&Rivalry> = set.train.iter().collect();
    let rows = Rows::of(&all, species, &deviation);
    let net = Mlp::new(competition::len(species), &HIDDEN, OUTPUTS);
    let draws = seed.draws(Lineage::ROOT, Purpose::InitialWeights).at(KEY);
    let mut state = State::new(mlp::flat(net.initial(&draws), &device()));
    let mut order = Order::new(seed, KEY, all.len());
    for step in 0..STEPS {
        let first = step * BATCH as u64;
        let numbers: Vec<usize> =
            (first..first + BATCH as u64).map(|position| order.sample(position)).collect();
        let [with, without, targets] = rows.pick(&numbers).map(Tensor::autodiff);
        let layers = net.layers(&state.parameters, true);
        let said = layers.forward(with) - layers.forward(without);
        let mut gradients = (said - targets).square().mean().backward();
        // The last bias is in both, so its gradient is 0; there is one all the same.
        let gradient =
            layers.gradient(&mut gradients).unwrap_or_else(|| state.parameters.zeros_like());
        let gradient = gradient + state.parameters.clone() * DECAY;
        let wave = 0.5 * (1.0 + libm::cos(core::f64::consts::PI * step as f64 / STEPS as f64));
        state = state.update(gradient, LEARNING_RATE * wave + 1e-5, AVERAGE);
    }
    let mut parameters = mlp::values(state.average);
    if parameters.iter().any(|weight| !weight.is_finite()) {
        return Err(TrainError::Diverged { network: NAME.into(), step: STEPS, loss: f32::NAN });
    }
    let judged = judge(&net, &parameters, set, species, &deviation);
    // Outputs in the states' own units; the last bias cancels.
    if let Some(last) = net.spans().last() {
        for row in parameters[last.start..last.bias()].chunks_exact_mut(OUTPUTS) {
            row.iter_mut().zip(deviation).for_each(|(weight, unit)| *weight *= unit as f32);
        }
        parameters[last.bias()..last.end()].fill(0.0);
    }
    let report = NetworkReport {
        sizes: net.sizes().to_vec(),
        weight_count: net.parameters(),
        samples: all.len(),
        steps: STEPS,
        seconds: 0.0,
        samples_per_second: 0.0,
        total: judged,
        species: BTreeMap::new(),
        data_hash: Some(set.data_hash.clone()),
    };
    Ok((net.tensors(NAME, &parameters)?, report))
}

/// Standard deviation of each shift over the trees.
fn deviations(trees: &[Rivalry]) -> [f64; OUTPUTS] {
    let count = trees.len() as f64;
    std::array::from_fn(|i| {
        let mean = trees.iter().map(|tree| tree.shift[i]).sum::<f64>() / count;
        let square = |tree: &Rivalry| (tree.shift[i] - mean) * (tree.shift[i] - mean);
        let deviation = libm::sqrt(trees.iter().map(square).sum::<f64>() / count);
        if deviation > 1e-6 { deviation } else { 1.0 }
    })
}

/// On the validation trees: mean squared error in deviations and R² of each state, and the part of
/// the foreseen shift of ln nodes that trees are off, as roots of mean squares.
fn judge(
    net: &Mlp,
    parameters: &[f32],
    set: &Rivalries,
    species: usize,
    deviation: &[f64; OUTPUTS],
) -> Figures {
    let all: Vec<&Rivalry> = set.validation.iter().collect();
    let rows = Rows::of(&all, species, deviation);
    let layers = net.layers(&mlp::flat(parameters.to_vec(), &device()), false);
    let [with, without, _] = rows.pick(&(0..all.len()).collect::<Vec<_>>());
    let said = mlp::values(layers.forward(with) - layers.forward(without));
    let mut tally = Tally::default();
    for (said, truth) in said.chunks_exact(OUTPUTS).zip(rows.targets.chunks_exact(OUTPUTS)) {
        let pairs = || said.iter().zip(truth).map(|(&a, &b)| (f64::from(a), f64::from(b)));
        let squares = pairs().map(|(a, b)| (a - b) * (a - b));
        let values = squares.chain(pairs().map(|(_, b)| b)).chain(pairs().map(|(_, b)| b * b));
        let foreseen = f64::from(said[NODES]) * f64::from(said[NODES]);
        tally.count(&values.chain([foreseen]).collect::<Vec<_>>());
    }
    let raw: Vec<String> = (0..=3 * OUTPUTS).map(|i| i.to_string()).collect();
    let mut figures = tally.figures(&raw.iter().map(String::as_str).collect::<Vec<_>>());
    let means = std::mem::take(&mut figures.values);
    let mean = |i: usize| means.get(&raw[i]).copied().unwrap_or(f64::NAN);
    figures.values.insert("scatter_nodes".into(), libm::sqrt(mean(NODES) / mean(3 * OUTPUTS)));
    for (i, name) in TreeTraits::STATE_NAMES.into_iter().enumerate() {
        let (error, first, second) = (mean(i), mean(OUTPUTS + i), mean(2 * OUTPUTS + i));
        figures.values.insert(format!("mse_{name}"), error);
        let r2 = 1.0 - error / (second - first * first);
        if r2.is_finite() {
            figures.values.insert(format!("r2_{name}"), r2);
        }
    }
    figures
}
