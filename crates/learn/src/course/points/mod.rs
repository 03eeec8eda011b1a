//! `points`: what the points around a node say, where the networks know a tree by a scan only.
//!
//! The networks of the model stay as they are. One encoder is shared by small networks that add to
//! what `existence` and the three rotations say; their last layers start at 0, so that training
//! starts from the model itself. A step takes as many samples of each law.

mod batch;
mod laws;
mod told;

use burn::tensor::{Device, Gradients, Tensor, activation::relu};
use deeptree_graph::signature::points::{CODE, HIDDEN, POINT_LEN, POINT_WIDTHS, SUMMARY_LEN};
use deeptree_graph::{BranchGraph, Draws, Lineage, Purpose, Seed};
use deeptree_infer::{Model, ReadWeightsError, Table, Weights};

use super::Course;
use crate::Scan;
use crate::mlp::{self, Layers, Mlp};
use crate::order::Order;
use crate::report::{Figures, Tally};
use batch::{Batch, Hears, Trees};
use laws::{LAWS, Laws, NAMES};

/// What is measured of each: the mean −ln p of what happened, of the networks that hear the points,
/// of the same when no points are there, and of the model that knows nothing of points.
const MEASURES: [&str; 3 * LAWS] = [
    "existence",
    "existence_without",
    "existence_base",
    "rotation1",
    "rotation1_without",
    "rotation1_base",
    "rotation2",
    "rotation2_without",
    "rotation2_base",
    "rotation3",
    "rotation3_without",
    "rotation3_base",
];

/// Samples that a validation sends through the networks at once.
const VALIDATION_BATCH: usize = 128;

/// Samples of each law that a validation looks at, evenly spread.
const VALIDATION_SAMPLES: usize = 1 << 13;

/// Keys the draws of the first law; the others follow.
const KEY: u64 = 41;

/// The networks of points.
pub(crate) struct Points<'a> {
    laws: Laws,
    point: Mlp,
    code: Mlp,
    heads: [Mlp; LAWS],
    train: Trees<'a>,
    validation: Trees<'a>,
    /// Samples a step, all laws together.
    batch: usize,
    seed: Seed,
    device: Device,
}

/// All layers as tensors.
struct Tensors {
    point: Layers,
    code: Layers,
    heads: Vec<Layers>,
}

impl Tensors {
    /// What a law says, corrected.
    fn forward(&self, law: usize, batch: &Batch) -> Tensor<2> {
        let width = POINT_WIDTHS[1];
        let each = relu(self.point.forward(batch.places.clone()));
        let each = each.reshape([batch.rows, batch.points, width]) * batch.stands.clone();
        let largest = each.max_dim(1).reshape([batch.rows, width]);
        let code = relu(self.code.forward(largest));
        let told = Tensor::cat(vec![code, batch.summary.clone(), batch.told.clone()], 1);
        batch.said.clone() + self.heads[law].forward(told)
    }
}

impl<'a> Points<'a> {
    /// # Errors
    ///
    /// When the model lacks a network or table of kind `situated`.
    pub(crate) fn new(
        weights: &Weights,
        train: (&'a [BranchGraph], &[Scan], &[usize]),
        validation: (&'a [BranchGraph], &[Scan], &[usize]),
        batch: usize,
        seed: Seed,
        device: Device,
    ) -> Result<Self, ReadWeightsError> {
        let model = Model::from_weights(weights)?;
        let laws = Laws::new(weights)?;
        let trees = |(trees, scans, species): (&'a [BranchGraph], &[Scan], &[usize])| {
            Trees::new(trees, scans, species, &model, &laws.rotations)
        };
        let (train, validation) = (trees(train), trees(validation));
        let head = |law: usize| {
            let outputs = laws.outputs(law);
            Mlp::new(CODE + SUMMARY_LEN + outputs, &[HIDDEN], outputs)
        };
        Ok(Self {
            point: Mlp::new(POINT_LEN, &[POINT_WIDTHS[0]], POINT_WIDTHS[1]),
            code: Mlp::new(POINT_WIDTHS[1], &[], CODE),
            heads: std::array::from_fn(head),
            laws,
            train,
            validation,
            batch,
            seed,
            device,
        })
    }

    /// All networks in the order of the flat parameters.
    fn networks(&self) -> impl Iterator<Item = &Mlp> {
        [&self.point, &self.code].into_iter().chain(&self.heads)
    }

    fn layers(&self, parameters: &Tensor<1>, track: bool) -> Tensors {
        let mut start = 0;
        let mut layers = self.networks().map(|network| {
            let own = parameters.clone().narrow(0, start, network.parameters());
            start += network.parameters();
            network.layers(&own, track)
        });
        // In the order of `networks`.
        let mut next = || layers.next().unwrap_or_else(|| unreachable!("as many as networks"));
        let (point, code) = (next(), next());
        Tensors { point, code, heads: (0..LAWS).map(|_| next()).collect() }
    }
}

impl Course for Points<'_> {
    fn samples(&self) -> usize {
        self.train.samples.iter().map(Vec::len).sum()
    }

    fn sizes(&self) -> Vec<usize> {
        [self.point.sizes(), &self.code.sizes()[1..]].concat()
    }

    fn parameters(&self) -> usize {
        self.networks().map(Mlp::parameters).sum()
    }

    fn initial(&self, draws: &Draws) -> Vec<f32> {
        let mut flat = Vec::new();
        for (i, network) in (0..).zip(self.networks()) {
            let mut own = network.initial(&draws.clone().at(i));
            if i >= 2
                && let Some(last) = network.spans().last()
            {
                own[last.start..].fill(0.0);
            }
            flat.extend(own);
        }
        flat
    }

    fn descend(&self, parameters: &Tensor<1>, step: u64) -> (Tensor<1>, Tensor<1>) {
        let tensors = self.layers(parameters, true);
        let rows = self.batch.div_ceil(LAWS);
        let mut total: Option<Tensor<1>> = None;
        for law in 0..LAWS {
            let samples = &self.train.samples[law];
            if samples.is_empty() {
                continue;
            }
            let mut order = Order::new(self.seed, KEY + law as u64, samples.len());
            let first = step * rows as u64;
            let spots: Vec<(u32, u32)> =
                (0..rows as u64).map(|row| samples[order.sample(first + row)]).collect();
            let draws = self.seed.draws(Lineage::ROOT, Purpose::TrainingNoise);
            let draws = draws.at(KEY + law as u64).at(step);
            let batch = self.batch_of(&self.train, law, &spots, Hears::Some(&draws)).autodiff();
            let outputs = tensors.forward(law, &batch);
            let loss = Laws::loss(law, outputs, batch.targets);
            total = Some(total.map_or_else(|| loss.clone(), |sum| sum + loss.clone()));
        }
        let Some(loss) = total else {
            return (parameters.zeros_like().narrow(0, 0, 1), parameters.zeros_like());
        };
        let mut gradients = loss.backward();
        let gradient = self.gradient(&tensors, &mut gradients, parameters);
        (loss, gradient)
    }

    fn validate(&self, parameters: &Tensor<1>, limit: usize) -> Vec<Tally> {
        let limit = limit.min(VALIDATION_SAMPLES);
        let tensors = self.layers(parameters, false);
        let mut tallies = vec![Tally::default(); self.laws.species];
        for law in 0..LAWS {
            let samples = &self.validation.samples[law];
            let stride = samples.len().div_ceil(limit.max(1)).max(1);
            let spots: Vec<(u32, u32)> = samples.iter().copied().step_by(stride).collect();
            for chunk in spots.chunks(VALIDATION_BATCH) {
                let batch = self.batch_of(&self.validation, law, chunk, Hears::All);
                let heard = mlp::values(tensors.forward(law, &batch));
                let deaf = self.batch_of(&self.validation, law, chunk, Hears::Nothing);
                let unheard = mlp::values(tensors.forward(law, &deaf));
                let (said, targets) = (mlp::values(batch.said), mlp::values(batch.targets));
                let (outputs, wanted) = (self.laws.outputs(law), self.laws.targets(law));
                for (i, &(tree, _)) in chunk.iter().enumerate() {
                    let Some(told) = &self.validation.told[tree as usize] else { continue };
                    let target = &targets[i * wanted..][..wanted];
                    let judge = |outputs: &[f32]| Laws::judge(law, outputs, target);
                    let row = i * outputs..(i + 1) * outputs;
                    let values = [&heard, &unheard, &said].map(|all| judge(&all[row.clone()]));
                    let tally = &mut tallies[told.conditions.species];
                    tally.count(&[]);
                    tally.count_parts(values.len() * law, &[values]);
                }
            }
        }
        tallies
    }

    fn figures(&self, tally: &Tally) -> Figures {
        tally.figures(&MEASURES)
    }

    fn tensors(&self, parameters: &[f32]) -> Result<Vec<(String, Table)>, ReadWeightsError> {
        let names = ["point", "code"].into_iter().chain(NAMES);
        let (mut tensors, mut start) = (Vec::new(), 0);
        for (name, network) in names.zip(self.networks()) {
            let own = &parameters[start..start + network.parameters()];
            tensors.extend(network.tensors(&format!("points.{name}"), own)?);
            start += network.parameters();
        }
        Ok(tensors)
    }
}

impl Points<'_> {
    /// The gradient of the flat parameters; 0 for networks that nothing was asked of.
    fn gradient(
        &self,
        tensors: &Tensors,
        gradients: &mut Gradients,
        parameters: &Tensor<1>,
    ) -> Tensor<1> {
        let layers = [&tensors.point, &tensors.code].into_iter().chain(&tensors.heads);
        let (mut parts, mut start) = (Vec::new(), 0);
        for (network, layers) in self.networks().zip(layers) {
            let own = layers.gradient(gradients);
            let count = network.parameters();
            parts.push(
                own.unwrap_or_else(|| parameters.clone().narrow(0, start, count).zeros_like()),
            );
            start += count;
        }
        Tensor::cat(parts, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::MAX_CHILDREN;
    use deeptree_graph::signature::situated::{Branching, CLASSES};
    use deeptree_graph::testing::random_tree;
    use deeptree_infer::{Active, Known, WeightsBuilder, Workspace};

    const MODEL: &[u8] = include_bytes!("../../../../../models/situated.safetensors");

    #[test]
    fn burn_and_the_inference_kernels_make_the_same_of_points() {
        let weights = Weights::from_bytes(MODEL).unwrap();
        let trees = [random_tree(1, 80), random_tree(2, 80)];
        let scan = |tree: &BranchGraph| {
            let ids = 0..tree.len() as u32;
            let points = tree.nodes().iter().map(|node| node.base().lerp(node.position, 0.7));
            Scan { points: points.collect(), nodes: ids.collect() }
        };
        let scans: Vec<Scan> = trees.iter().map(scan).collect();
        let part = (&trees[..], &scans[..], &[3, 5][..]);
        let device = Device::flex();
        let points = Points::new(&weights, part, part, 64, Seed(1), device.clone()).unwrap();
        let mut draws = Seed(2).draws(Lineage::ROOT, Purpose::InitialWeights);
        let flat: Vec<f32> =
            (0..points.parameters()).map(|_| (0.2 * draws.normal()) as f32).collect();
        let mut model = WeightsBuilder::from_weights(&weights);
        for (name, table) in Course::tensors(&points, &flat).unwrap() {
            model.table(name, table);
        }
        let model = Model::from_bytes(&model.to_bytes().unwrap()).unwrap();
        let layers = points.layers(&mlp::flat(flat, &device), false);

        let spots = &points.train.samples[0];
        let batch = points.batch_of(&points.train, 0, spots, Hears::All);
        let outputs = mlp::values(layers.forward(0, &batch));
        let known = |&(tree, id): &(u32, u32)| {
            let told = points.train.told[tree as usize].as_ref().unwrap();
            let active = Active {
                node: &told.nodes[id as usize],
                parent: None,
                lineage: Lineage::ROOT,
                seed: Seed(0),
                tree: told.conditions,
                plan: told.plans[id as usize],
                sense: told.senses[id as usize],
                settled: None,
                room: None,
                points: Some(&told.cloud),
            };
            Known { active, children: [None; MAX_CHILDREN] }
        };
        let known: Vec<Known<'_>> = spots.iter().map(known).collect();
        let foretold = model.foretell(&known, &mut Workspace::default()).unwrap();
        for (outputs, foretold) in outputs.chunks_exact(CLASSES).zip(&foretold) {
            let odds = |class: usize| {
                let is_possible = Branching::from_class(class).is_ever_possible();
                if is_possible { f64::from(outputs[class]).exp() } else { 0.0 }
            };
            let all: f64 = (0..CLASSES).map(odds).sum();
            for slot in 0..MAX_CHILDREN {
                let has = |class: &usize| Branching::from_class(*class).has(slot);
                let burn = (0..CLASSES).filter(has).map(odds).sum::<f64>() / all;
                assert!((burn - foretold.children[slot]).abs() < 1e-4, "{burn} {foretold:?}");
            }
        }
    }
}
