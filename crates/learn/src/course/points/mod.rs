//! `points`: what the points around a node say, where the networks know a tree by a scan only.
//!
//! The networks of the model stay as they are. One encoder is shared by small networks that add to
//! what `existence` and the three rotations say; their last layers start at 0, so that training
//! starts from the model itself. A step takes as many samples of each law.

mod told;

use burn::tensor::{Device, Gradients, Tensor, TensorData, activation::relu};
use deeptree_graph::signature::points::{
    self, CODE, HIDDEN, POINT_LEN, POINT_WIDTHS, SUMMARY_LEN, encode, summary,
};
use deeptree_graph::signature::situated::{
    self, Alignment, Branching, CLASSES, ROTATION_COMPONENTS, RotationContext, rotation_len,
};
use deeptree_graph::{BranchGraph, Draws, Lineage, MAX_CHILDREN, Purpose, Seed, Vec3};
use deeptree_infer::{Mlp as Kernels, Model, ReadWeightsError, Scratch, SimdPath, Table, Weights};

use super::Course;
use crate::Scan;
use crate::loss::{self, EXISTENCE_TARGETS, IMPOSSIBLE, ROTATION_TARGETS};
use crate::mlp::{self, Layers, Mlp};
use crate::order::Order;
use crate::report::{Figures, Tally};
use crate::rotations::Rotations;
use crate::tasks::{judge_swing, ln_class};
use told::Told;

/// Laws that hear of points: existence, and the swing of each slot.
const LAWS: usize = 1 + MAX_CHILDREN;

/// Their names among the tensors.
const NAMES: [&str; LAWS] = ["existence", "rotation1", "rotation2", "rotation3"];

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

/// One in so many training samples is told of no points, so that the networks know what to say
/// without them.
const ONE_DEAF: u64 = 5;

/// Points of a node that a training step looks at, drawn from those there are: a cloud could as well
/// have fewer.
const POINTS_A_STEP: usize = 96;

/// Samples that a validation sends through the networks at once.
const VALIDATION_BATCH: usize = 128;

/// Samples of each law that a validation looks at, evenly spread.
const VALIDATION_SAMPLES: usize = 1 << 13;

/// Keys the draws of the first law; the others follow.
const KEY: u64 = 41;

/// The networks of points.
pub(crate) struct Points<'a> {
    base: Base,
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

/// The model that is listened to points for.
struct Base {
    laws: [Kernels; LAWS],
    rotations: Rotations,
    species: usize,
    path: SimdPath,
}

/// Scanned trees as they are told, and the samples that they hold.
struct Trees<'a> {
    trees: &'a [BranchGraph],
    told: Vec<Option<Told>>,
    /// Of each law: tree and node.
    samples: [Vec<(u32, u32)>; LAWS],
}

impl<'a> Trees<'a> {
    fn new(
        trees: &'a [BranchGraph],
        scans: &[Scan],
        species: &[usize],
        model: &Model,
        rotations: &Rotations,
    ) -> Self {
        let each = trees.iter().zip(scans).zip(species);
        let told: Vec<Option<Told>> = each
            .map(|((tree, scan), &species)| Told::new(tree, scan, species, model, rotations))
            .collect();
        let mut samples: [Vec<(u32, u32)>; LAWS] = Default::default();
        for (number, (tree, _)) in
            trees.iter().zip(&told).enumerate().filter(|(_, t)| t.1.is_some())
        {
            for (id, node) in tree.nodes().iter().enumerate() {
                let spot = (number as u32, id as u32);
                samples[0].push(spot);
                for slot in (0..MAX_CHILDREN).filter(|&slot| node.children[slot].is_some()) {
                    samples[1 + slot].push(spot);
                }
            }
        }
        Self { trees, told, samples }
    }
}

/// The samples of one law in one batch, as tensors.
struct Batch {
    /// `[batch · points, POINT_LEN]`, and 1 where there is a point.
    places: Tensor<2>,
    stands: Tensor<3>,
    summary: Tensor<2>,
    /// What the model says.
    said: Tensor<2>,
    /// The same as it is told to the network that corrects it.
    told: Tensor<2>,
    targets: Tensor<2>,
    /// Shape of the points.
    rows: usize,
    points: usize,
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
        let species = weights.species().len();
        let network = |i: usize| weights.mlp(NAMES[i]);
        let base = Base {
            laws: [network(0)?, network(1)?, network(2)?, network(3)?],
            rotations: Rotations::of(weights)?,
            species,
            path: SimdPath::detect(),
        };
        let trees = |(trees, scans, species): (&'a [BranchGraph], &[Scan], &[usize])| {
            Trees::new(trees, scans, species, &model, &base.rotations)
        };
        let (train, validation) = (trees(train), trees(validation));
        let head = |law: usize| {
            let outputs = base.laws[law].outputs();
            Mlp::new(CODE + SUMMARY_LEN + outputs, &[HIDDEN], outputs)
        };
        Ok(Self {
            point: Mlp::new(POINT_LEN, &[POINT_WIDTHS[0]], POINT_WIDTHS[1]),
            code: Mlp::new(POINT_WIDTHS[1], &[], CODE),
            heads: std::array::from_fn(head),
            base,
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

    /// What is heard at some nodes, and what the model says of them.
    fn batch_of(
        &self,
        of: &Trees<'_>,
        law: usize,
        spots: &[(u32, u32)],
        hears: Hears<'_>,
    ) -> Batch {
        let base = &self.base;
        let (inputs, targets) = (base.inputs(law), base.targets(law));
        let mut rows = vec![0.0; spots.len() * inputs];
        let mut wanted = vec![0.0; spots.len() * targets];
        let (mut all, mut near, mut summaries) = (Vec::new(), Vec::new(), Vec::new());
        for (i, &(tree, node)) in spots.iter().enumerate() {
            let Some(told) = &of.told[tree as usize] else { continue };
            let (row, target) =
                (&mut rows[i * inputs..][..inputs], &mut wanted[i * targets..][..targets]);
            base.encode(law, &of.trees[tree as usize], told, node as usize, row, target);
            let node = &told.nodes[node as usize];
            told.cloud.around(node.position, &mut near);
            if hears.is_deaf(i) {
                near.clear();
            }
            summaries.extend(summary(node, &near));
            if let Hears::Some(draws) = hears {
                some(&mut near, POINTS_A_STEP, &mut draws.clone().at(i as u64));
            }
            let mut places = vec![0.0; near.len() * POINT_LEN];
            for (&point, place) in near.iter().zip(places.chunks_exact_mut(POINT_LEN)) {
                encode(node, point, place);
            }
            all.push(places);
        }
        let points = all.iter().map(Vec::len).max().unwrap_or(0).max(POINT_LEN) / POINT_LEN;
        let mut places = vec![0.0; spots.len() * points * POINT_LEN];
        let mut stands = vec![0.0; spots.len() * points];
        for (i, own) in all.iter().enumerate() {
            places[i * points * POINT_LEN..][..own.len()].copy_from_slice(own);
            stands[i * points..][..own.len() / POINT_LEN].fill(1.0);
        }
        let mut scratch = Scratch::new();
        let said = base.laws[law].forward(base.path, &rows, &mut scratch).to_vec();
        let told = said.iter().map(|&value| points::said(value)).collect();
        let (count, outputs) = (spots.len(), base.laws[law].outputs());
        let flat = |values: Vec<f32>, rows: usize, width: usize| -> Tensor<2> {
            Tensor::from_data(TensorData::new(values, [rows, width]), &self.device)
        };
        let stands = TensorData::new(stands, [count, points, 1]);
        Batch {
            places: flat(places, count * points, POINT_LEN),
            stands: Tensor::from_data(stands, &self.device),
            summary: flat(summaries, count, SUMMARY_LEN),
            said: flat(said, count, outputs),
            told: flat(told, count, outputs),
            targets: flat(wanted, count, targets),
            rows: count,
            points,
        }
    }
}

impl Batch {
    fn autodiff(self) -> Self {
        Self {
            places: self.places.autodiff(),
            stands: self.stands.autodiff(),
            summary: self.summary.autodiff(),
            said: self.said.autodiff(),
            told: self.told.autodiff(),
            targets: self.targets.autodiff(),
            ..self
        }
    }
}

impl Base {
    fn inputs(&self, law: usize) -> usize {
        situated::len(self.species) + law.checked_sub(1).map_or(0, rotation_len)
    }

    fn targets(&self, law: usize) -> usize {
        if law == 0 { EXISTENCE_TARGETS } else { ROTATION_TARGETS }
    }

    /// Writes what a law's network reads of a node as it is told, and what is true.
    fn encode(
        &self,
        law: usize,
        tree: &BranchGraph,
        told: &Told,
        id: usize,
        inputs: &mut [f32],
        targets: &mut [f32],
    ) {
        let (node, plan, tips) = (&told.nodes[id], told.plans[id], told.tips[id]);
        let (own, rest) = inputs.split_at_mut(situated::len(self.species));
        situated::encode(node, &told.conditions, plan, &told.senses[id], self.species, own);
        let truth = told.branchings[id];
        let Some(slot) = law.checked_sub(1) else {
            let (label, possible) = targets.split_at_mut(CLASSES);
            label[truth.class()] = 1.0;
            for (class, possible) in possible.iter_mut().enumerate() {
                // What was told of the plan is a guess.
                let is_possible = Branching::from_class(class).is_ever_possible();
                *possible = if is_possible { 0.0 } else { IMPOSSIBLE };
            }
            return;
        };
        let siblings: [_; MAX_CHILDREN] = std::array::from_fn(|slot| told.sibling(tree, id, slot));
        let (Some(child), Some(child_id)) = (siblings[slot], tree.nodes()[id].children[slot])
        else {
            return;
        };
        let species = told.conditions.species;
        let (tips, plan) = plan.bent_to(truth, tips);
        let context = RotationContext {
            branching: truth,
            parent_tips: tips,
            tips: child.tips,
            parent_reach: plan.reach,
            plan: told.plans[child_id as usize],
            slot: self.rotations.slots[species][slot],
            roll: child.turn.roll,
            own: told.own_turn(id),
            earlier: &siblings[..slot],
        };
        situated::encode_rotation(node, &told.conditions, &context, rest);
        let (x, others) = targets.split_at_mut(ROTATION_COMPONENTS);
        let (y, flags) = others.split_at_mut(ROTATION_COMPONENTS);
        x.fill(child.turn.swing.x);
        y.fill(child.turn.swing.y);
        let alignment = context.slot.alignment(child.turn.roll, node);
        flags[0] = f32::from(u8::from(context.slot.is_aligned(alignment, child.turn)));
        flags[1] = f32::from(u8::from(alignment == Alignment::Straight));
    }
}

/// Which of the points around a node are told.
#[derive(Clone, Copy)]
enum Hears<'a> {
    All,
    Nothing,
    /// Those that are drawn, and of some samples none.
    Some(&'a Draws),
}

impl Hears<'_> {
    fn is_deaf(self, sample: usize) -> bool {
        match self {
            Self::All => false,
            Self::Nothing => true,
            Self::Some(draws) => {
                draws.clone().at(sample as u64).at(1).bits().is_multiple_of(ONE_DEAF)
            }
        }
    }
}

/// Keeps `most` points of more, drawn without replacement.
fn some(points: &mut Vec<Vec3>, most: usize, draws: &mut Draws) {
    if points.len() <= most {
        return;
    }
    for i in 0..most {
        let k = i + (draws.bits() % (points.len() - i) as u64) as usize;
        points.swap(i, k);
    }
    points.truncate(most);
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
            let loss = match law.checked_sub(1) {
                None => loss::existence(outputs, batch.targets),
                Some(slot) => loss::rotation(outputs, batch.targets, slot),
            };
            total = Some(total.map_or_else(|| loss.clone(), |sum| sum + loss.clone()));
        }
        let Some(loss) = total else {
            return (parameters.zeros_like().slice([0..1]), parameters.zeros_like());
        };
        let mut gradients = loss.backward();
        let gradient = self.gradient(&tensors, &mut gradients, parameters);
        (loss, gradient)
    }

    fn validate(&self, parameters: &Tensor<1>, limit: usize) -> Vec<Tally> {
        let limit = limit.min(VALIDATION_SAMPLES);
        let tensors = self.layers(parameters, false);
        let mut tallies = vec![Tally::default(); self.base.species];
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
                let (outputs, wanted) = (self.base.laws[law].outputs(), self.base.targets(law));
                for (i, &(tree, _)) in chunk.iter().enumerate() {
                    let Some(told) = &self.validation.told[tree as usize] else { continue };
                    let target = &targets[i * wanted..][..wanted];
                    let judge = |outputs: &[f32]| match law.checked_sub(1) {
                        None => -ln_class(outputs, target),
                        Some(slot) => {
                            let y = f64::from(target[ROTATION_COMPONENTS]);
                            let [is_aligned, is_straight] =
                                [0, 1].map(|flag| target[2 * ROTATION_COMPONENTS + flag] > 0.5);
                            let alignment = match is_straight {
                                _ if slot > 0 => Alignment::Bud,
                                true => Alignment::Straight,
                                false => Alignment::Gravity,
                            };
                            judge_swing(outputs, alignment, f64::from(target[0]), y, is_aligned)
                        }
                    };
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
