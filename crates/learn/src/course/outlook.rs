//! `outlook`: what an environment makes of a tree.
//!
//! Half of a batch are trees in environments, half stand in the open field, whose empty grids go
//! through the convolutions once. Trees are turned about the vertical with all that stands around
//! them, by quarters, and mirrored: the teacher knows no direction of the sky.
//!
//! The loss is the mean squared error of the lengths, in deviations of the species, and of the
//! crown's offset. Of a count n with ln n = x in deviations d it is
//!
//! `2 / d² · (exp(d (x − o)) + d o)`
//!
//! the deviance of a gamma law of mean exp(d o) but for a constant: near its minimum as steep as a
//! squared error, and least where exp(d o) is the mean of the counts. The mean of their logarithms
//! would be too few: some of the trees that obstacles or volumes hem in stay very small.

use burn::tensor::module::conv3d;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Device, Gradients, Tensor, TensorData, activation::relu};
use deeptree_graph::signature::outlook::{
    self, CHANNELS, CODE, KERNEL, MAPS, NAMES, OFFSET_SCALE, OUTPUTS, crown_offset,
};
use deeptree_graph::{Draws, Occupancy, Seed, TreeTraits};
use deeptree_infer::{ReadWeightsError, Table};

use super::Course;
use crate::mlp::{self, Layers, Mlp};
use crate::order::Order;
use crate::report::{Figures, Tally};
use crate::set::Corpus;
use crate::surroundings::{GRID, Surroundings, Turn, write};
use crate::tasks::{Network, noise_draws};

const STATES: usize = TreeTraits::STATES;
/// Values of both grids.
const GRIDS: usize = CHANNELS[0] * GRID;
/// Convolutions.
const DEPTH: usize = CHANNELS.len() - 1;
/// Grids that a validation sends through the network at once.
const VALIDATION_BATCH: usize = 64;

/// The network that reads environments.
pub(crate) struct Outlook<'a> {
    /// From the maps to the code.
    code: Mlp,
    /// From the tree and the code to what is expected.
    tree: Mlp,
    train: Trees<'a>,
    validation: Trees<'a>,
    /// Of the states of the training trees, by species.
    mean: Vec<[f32; STATES]>,
    deviation: Vec<[f32; STATES]>,
    /// Trees a step.
    batch: usize,
    seed: Seed,
    device: Device,
}

/// Trees, told apart by where they have grown.
struct Trees<'a> {
    corpus: &'a Corpus<'a>,
    inside: Vec<(usize, &'a Surroundings)>,
    open: Vec<usize>,
    /// What the network is to say of each tree.
    targets: Vec<[f32; OUTPUTS]>,
}

impl<'a> Trees<'a> {
    fn new(corpus: &'a Corpus<'a>, mean: &[[f32; STATES]], deviation: &[[f32; STATES]]) -> Self {
        let (mut inside, mut open) = (Vec::new(), Vec::new());
        for (tree, surroundings) in corpus.surroundings.iter().enumerate() {
            match surroundings {
                Some(surroundings) => inside.push((tree, surroundings)),
                None => open.push(tree),
            }
        }
        let target = |(tree, graph)| {
            let (state, species) = state(corpus, tree);
            let offset = (crown_offset(graph) / OFFSET_SCALE).to_array();
            std::array::from_fn(|i| match i.checked_sub(STATES) {
                Some(axis) => offset[axis],
                None => (state[i] as f32 - mean[species][i]) / deviation[species][i],
            })
        };
        let targets = corpus.trees.iter().enumerate().map(target).collect();
        Self { corpus, inside, open, targets }
    }

    /// Writes what is read of a tree, without the code.
    fn encode(&self, tree: usize, species: usize, row: &mut [f32]) {
        let of = &self.corpus.conditions[tree];
        outlook::encode(species, of.species, of.age, of.gravitropism, row);
    }

    /// What the network is to say of a tree that is turned.
    fn target(&self, tree: usize, turn: Turn) -> [f32; OUTPUTS] {
        let mut target = self.targets[tree];
        let turned = turn.vector([target[STATES], target[STATES + 1]]);
        target[STATES..].copy_from_slice(&turned);
        target
    }
}

/// The state of a tree, and its species.
fn state(corpus: &Corpus<'_>, tree: usize) -> ([f64; STATES], usize) {
    let of = &corpus.conditions[tree];
    (of.traits.state(of.root_tips), of.species)
}

/// Mean and deviation of the states of each species. What does not vary has the deviation 1.
fn moments(corpus: &Corpus<'_>, species: usize) -> (Vec<[f32; STATES]>, Vec<[f32; STATES]>) {
    let mut sums = vec![(0.0, [0.0; STATES], [0.0; STATES]); species];
    let states = || (0..corpus.trees.len()).map(|tree| state(corpus, tree));
    for (state, species) in states() {
        let (count, sum, _) = &mut sums[species];
        *count += 1.0;
        sum.iter_mut().zip(state).for_each(|(sum, x)| *sum += x);
    }
    for (count, mean, _) in &mut sums {
        mean.iter_mut().for_each(|mean| *mean /= f64::max(*count, 1.0));
    }
    for (state, species) in states() {
        let (_, mean, squares) = &mut sums[species];
        for ((square, mean), x) in squares.iter_mut().zip(mean).zip(state) {
            *square += (x - *mean) * (x - *mean);
        }
    }
    let deviation = |count: f64, square: f64| {
        let deviation = libm::sqrt(square / count.max(1.0));
        if deviation > 1e-6 { deviation as f32 } else { 1.0 }
    };
    let mean = |(_, mean, _): &(f64, [f64; STATES], [f64; STATES])| mean.map(|x| x as f32);
    let means = sums.iter().map(mean).collect();
    let deviations =
        sums.iter().map(|(count, _, squares)| squares.map(|s| deviation(*count, s))).collect();
    (means, deviations)
}

/// One convolution of the flat parameters.
///
/// # Shapes  weight: `[3, 3, 3, inputs, outputs]` by z, y and x; bias: `[outputs]`; weight first
#[derive(Clone, Copy)]
struct Span {
    inputs: usize,
    outputs: usize,
    start: usize,
}

impl Span {
    /// The convolutions in their order, and where they end.
    fn all() -> ([Self; DEPTH], usize) {
        let mut end = 0;
        let spans = std::array::from_fn(|i| {
            let span = Self { inputs: CHANNELS[i], outputs: CHANNELS[i + 1], start: end };
            end = span.end();
            span
        });
        (spans, end)
    }

    const fn bias(&self) -> usize {
        self.start + KERNEL * self.inputs * self.outputs
    }

    const fn end(&self) -> usize {
        self.bias() + self.outputs
    }

    const fn shape(&self) -> [usize; 5] {
        [3, 3, 3, self.inputs, self.outputs]
    }
}

/// All layers as tensors.
struct Tensors {
    convolutions: Vec<(Tensor<5>, Tensor<1>)>,
    code: Layers,
    tree: Layers,
}

impl Tensors {
    /// The codes of environments.
    ///
    /// # Shapes  grids: `[batch, 2, 32, 32, 32]`; result: `[batch, CODE]`
    fn codes(&self, grids: Tensor<5>) -> Tensor<2> {
        let rows = grids.dims()[0];
        let mut maps = grids;
        for (weight, bias) in &self.convolutions {
            // Burn has outputs and inputs first.
            let weight = weight.clone().permute([4, 3, 0, 1, 2]);
            let options = ConvOptions::new([2; 3], [1; 3], [1; 3], 1);
            maps = relu(conv3d(maps, weight, Some(bias.clone()), options));
        }
        self.code.forward(maps.permute([0, 2, 3, 4, 1]).reshape([rows, MAPS]))
    }

    /// # Shapes  trees: `[batch, tree_len]`; codes: `[batch, CODE]`; result: `[batch, OUTPUTS]`
    fn expect(&self, trees: Tensor<2>, codes: Tensor<2>) -> Tensor<2> {
        self.tree.forward(Tensor::cat(vec![trees, codes], 1))
    }

    /// The gradient of the flat parameters.
    fn gradient(&self, gradients: &mut Gradients) -> Option<Tensor<1>> {
        let mut parts = Vec::with_capacity(2 * DEPTH + 2);
        for (weight, bias) in &self.convolutions {
            parts.push(weight.grad_remove(gradients)?.flatten::<1>(0, 4));
            parts.push(bias.grad_remove(gradients)?);
        }
        parts.push(self.code.gradient(gradients)?);
        parts.push(self.tree.gradient(gradients)?);
        Some(Tensor::cat(parts, 0))
    }
}

impl<'a> Outlook<'a> {
    pub(crate) fn new(
        train: &'a Corpus<'a>,
        validation: &'a Corpus<'a>,
        species: usize,
        hidden: &[usize],
        batch: usize,
        seed: Seed,
        device: Device,
    ) -> Self {
        let (mean, deviation) = moments(train, species);
        Self {
            code: Mlp::new(MAPS, &[], CODE),
            tree: Mlp::new(outlook::len(species), hidden, OUTPUTS),
            train: Trees::new(train, &mean, &deviation),
            validation: Trees::new(validation, &mean, &deviation),
            mean,
            deviation,
            batch,
            seed,
            device,
        }
    }

    fn species(&self) -> usize {
        self.mean.len()
    }

    /// Where the layers of the code and those of the tree start, and where they end.
    fn ends(&self) -> [usize; 3] {
        let (_, code) = Span::all();
        let tree = code + self.code.parameters();
        [code, tree, tree + self.tree.parameters()]
    }

    fn tensors_of(&self, flat: &Tensor<1>, track: bool) -> Tensors {
        let part = |start, end| flat.clone().narrow(0, start, end - start);
        let leaf = |start, end| {
            let part = part(start, end);
            if track { part.autodiff() } else { part }
        };
        let convolution = |span: Span| {
            let weight = leaf(span.start, span.bias()).reshape(span.shape());
            let bias = leaf(span.bias(), span.end());
            if track { (weight.require_grad(), bias.require_grad()) } else { (weight, bias) }
        };
        let [code, tree, end] = self.ends();
        Tensors {
            convolutions: Span::all().0.map(convolution).into(),
            code: self.code.layers(&part(code, tree), track),
            tree: self.tree.layers(&part(tree, end), track),
        }
    }

    /// For each output the deviation of a logarithm, where it is one; 0 elsewhere.
    fn deviations_of_counts(&self, tree: usize) -> [f32; OUTPUTS] {
        let deviation = &self.deviation[self.train.corpus.conditions[tree].species];
        let is_count = |i: usize| i < STATES && TreeTraits::STATE_IS_COUNT[i];
        std::array::from_fn(|i| if is_count(i) { deviation[i] } else { 0.0 })
    }

    fn grids_tensor(&self, grids: Vec<f32>) -> Tensor<5> {
        const SIDE: usize = Occupancy::SIDE;
        let shape = [grids.len() / GRIDS, CHANNELS[0], SIDE, SIDE, SIDE];
        Tensor::from_data(TensorData::new(grids, shape), &self.device)
    }

    fn rows_tensor(&self, values: Vec<f32>, width: usize) -> Tensor<2> {
        let shape = [values.len() / width, width];
        Tensor::from_data(TensorData::new(values, shape), &self.device)
    }

    /// The outputs for all trees of a part: those in environments, then those in the open field.
    fn outputs(&self, tensors: &Tensors, inside: &[usize], open: &[usize]) -> Vec<f32> {
        let width = outlook::tree_len(self.species());
        let rows = |trees: &mut dyn Iterator<Item = usize>| {
            let mut values = Vec::new();
            for tree in trees {
                let start = values.len();
                values.resize(start + width, 0.0);
                self.validation.encode(tree, self.species(), &mut values[start..]);
            }
            self.rows_tensor(values, width)
        };
        let mut outputs = Vec::new();
        for chunk in inside.chunks(VALIDATION_BATCH) {
            let mut grids = vec![0.0; chunk.len() * GRIDS];
            for (&number, grids) in chunk.iter().zip(grids.chunks_exact_mut(GRIDS)) {
                put(self.validation.inside[number].1, Turn::NONE, grids);
            }
            let trees = rows(&mut chunk.iter().map(|&number| self.validation.inside[number].0));
            let codes = tensors.codes(self.grids_tensor(grids));
            outputs.extend(mlp::values(tensors.expect(trees, codes)));
        }
        if !open.is_empty() {
            let empty = tensors.codes(self.grids_tensor(vec![0.0; GRIDS]));
            let trees = rows(&mut open.iter().map(|&number| self.validation.open[number]));
            let codes = empty.repeat_dim(0, open.len());
            outputs.extend(mlp::values(tensors.expect(trees, codes)));
        }
        outputs
    }
}

/// Squares of the errors where the deviation d is 0, `2 / d² · (exp(d e) − d e − 1)` elsewhere.
fn losses(errors: Tensor<2>, deviations: Tensor<2>) -> Tensor<2> {
    let squares = errors.clone().square();
    let is_length = deviations.clone().equal_elem(0.0);
    // What is not taken must not be infinite either: a gradient of 0 times infinity is none.
    let deviations = deviations.mask_fill(is_length.clone(), 1.0);
    let scaled = (errors * deviations.clone()).mask_fill(is_length.clone(), 0.0);
    let gamma = (scaled.clone().exp() - scaled - 1.0) * 2.0 / deviations.square();
    gamma.mask_where(is_length, squares)
}

/// Writes both grids.
fn put(surroundings: &Surroundings, turn: Turn, out: &mut [f32]) {
    let (taken, shading) = out.split_at_mut(GRID);
    write(&surroundings.taken, turn, taken);
    write(&surroundings.shading, turn, shading);
}

impl Course for Outlook<'_> {
    fn samples(&self) -> usize {
        self.train.inside.len()
    }

    /// Those of the second network.
    fn sizes(&self) -> Vec<usize> {
        self.tree.sizes().to_vec()
    }

    fn parameters(&self) -> usize {
        self.ends()[2]
    }

    fn initial(&self, draws: &Draws) -> Vec<f32> {
        let mut flat = vec![0.0; Span::all().1];
        for (layer, span) in Span::all().0.into_iter().enumerate() {
            // He et al. 2015, Eq. 10, as for the dense layers.
            let bound = (6.0 / (KERNEL * span.inputs) as f64).sqrt();
            let mut draws = draws.clone().at(100 + layer as u64);
            for weight in &mut flat[span.start..span.bias()] {
                *weight = (bound * (2.0 * draws.uniform() - 1.0)) as f32;
            }
        }
        flat.extend(self.code.initial(&draws.clone().at(200)));
        flat.extend(self.tree.initial(draws));
        flat
    }

    fn descend(&self, parameters: &Tensor<1>, step: u64) -> (Tensor<1>, Tensor<1>) {
        let half = self.batch / 2;
        let width = outlook::tree_len(self.species());
        // The last is the empty one.
        let mut grids = vec![0.0; (half + 1) * GRIDS];
        let mut rows = vec![0.0; 2 * half * width];
        let mut targets = Vec::with_capacity(2 * half * OUTPUTS);
        let mut deviations = Vec::with_capacity(2 * half * OUTPUTS);
        let key = Network::Outlook.key();
        let mut inside = Order::new(self.seed, key, self.train.inside.len());
        let mut open = Order::new(self.seed, key + 1, self.train.open.len());
        for (row, values) in rows.chunks_exact_mut(width).enumerate() {
            let position = step * half as u64 + (row % half) as u64;
            let is_open = row >= half;
            let mut draws = noise_draws(self.seed, key + u64::from(is_open), position);
            let turn = Turn::new(draws.index(Turn::COUNT));
            let tree = if is_open {
                self.train.open[open.sample(position)]
            } else {
                let (tree, surroundings) = self.train.inside[inside.sample(position)];
                put(surroundings, turn, &mut grids[row * GRIDS..][..GRIDS]);
                tree
            };
            self.train.encode(tree, self.species(), values);
            targets.extend(self.train.target(tree, turn));
            deviations.extend(self.deviations_of_counts(tree));
        }
        let tensors = self.tensors_of(parameters, true);
        let codes = tensors.codes(self.grids_tensor(grids).autodiff());
        let empty = codes.clone().narrow(0, half, 1).repeat_dim(0, half);
        let codes = Tensor::cat(vec![codes.narrow(0, 0, half), empty], 0);
        let outputs = tensors.expect(self.rows_tensor(rows, width).autodiff(), codes);
        let targets = self.rows_tensor(targets, OUTPUTS).autodiff();
        let deviations = self.rows_tensor(deviations, OUTPUTS).autodiff();
        let loss = losses(targets - outputs, deviations).mean();
        let mut gradients = loss.backward();
        let gradient = tensors.gradient(&mut gradients);
        (loss, gradient.unwrap_or_else(|| parameters.zeros_like()))
    }

    fn validate(&self, parameters: &Tensor<1>, limit: usize) -> Vec<Tally> {
        let spread = |count: usize| -> Vec<usize> {
            (0..count).step_by(count.div_ceil(limit.max(1)).max(1)).collect()
        };
        let (inside, open) = (&self.validation.inside, &self.validation.open);
        let (ours, others) = (spread(inside.len()), spread(open.len()));
        let outputs = self.outputs(&self.tensors_of(parameters, false), &ours, &others);
        let inside = ours.iter().map(|&number| (inside[number].0, true));
        let open = others.iter().map(|&number| (open[number], false));
        let mut tallies = vec![Tally::default(); self.species()];
        for ((tree, is_inside), said) in inside.chain(open).zip(outputs.chunks_exact(OUTPUTS)) {
            let tally = &mut tallies[self.validation.corpus.conditions[tree].species];
            let truth = self.validation.targets[tree].map(f64::from);
            let square =
                |i: usize| (f64::from(said[i]) - truth[i]) * (f64::from(said[i]) - truth[i]);
            let squares: [f64; OUTPUTS] = std::array::from_fn(square);
            tally.count(&[]);
            if is_inside {
                tally.count_parts(0, &[[squares, truth, truth.map(|x| x * x)].concat()]);
            } else {
                let mean = squares.iter().sum::<f64>() / OUTPUTS as f64;
                tally.count_parts(3 * OUTPUTS, &[[mean]]);
            }
        }
        tallies
    }

    /// `R² = 1 − mean (y − ŷ)² / (mean y² − (mean y)²)`
    fn figures(&self, tally: &Tally) -> Figures {
        let raw: Vec<String> = (0..=3 * OUTPUTS).map(|i| i.to_string()).collect();
        let names: Vec<&str> = raw.iter().map(String::as_str).collect();
        let mut figures = tally.figures(&names);
        let means = std::mem::take(&mut figures.values);
        let mean = |i: usize| means.get(&raw[i]).copied().filter(|mean| mean.is_finite());
        let mut add = |name: String, value: Option<f64>| {
            // Of no trees, or of such that do not differ, there is nothing to say.
            if let Some(value) = value.filter(|value| value.is_finite()) {
                figures.values.insert(name, value);
            }
        };
        let mut total = Some(0.0);
        for (i, name) in NAMES.into_iter().enumerate() {
            let (mse, first, second) = (mean(i), mean(OUTPUTS + i), mean(2 * OUTPUTS + i));
            total = total.zip(mse).map(|(total, mse)| total + mse / OUTPUTS as f64);
            add(format!("mse_{name}"), mse);
            let variance = first.zip(second).map(|(first, second)| second - first * first);
            add(format!("r2_{name}"), mse.zip(variance).map(|(mse, var)| 1.0 - mse / var));
        }
        add("mse".into(), total);
        add("mse_open".into(), mean(3 * OUTPUTS));
        figures
    }

    fn tensors(&self, parameters: &[f32]) -> Result<Vec<(String, Table)>, ReadWeightsError> {
        let name = Network::Outlook.name();
        let mut tensors = Vec::new();
        for (i, span) in Span::all().0.into_iter().enumerate() {
            let weight = parameters[span.start..span.bias()].to_vec();
            let bias = parameters[span.bias()..span.end()].to_vec();
            let layer = format!("{name}.conv{}", i + 1);
            tensors.push((format!("{layer}.weight"), Table::new(span.shape().into(), weight)?));
            tensors.push((format!("{layer}.bias"), Table::new(vec![span.outputs], bias)?));
        }
        let [code, tree, end] = self.ends();
        let bias = tree - CODE;
        let weight = Table::new(vec![MAPS, CODE], parameters[code..bias].to_vec())?;
        tensors.push((format!("{name}.code.weight"), weight));
        let bias = Table::new(vec![CODE], parameters[bias..tree].to_vec())?;
        tensors.push((format!("{name}.code.bias"), bias));
        tensors.extend(self.tree.tensors(name, &parameters[tree..end])?);
        for (table, rows) in [("mean", &self.mean), ("deviation", &self.deviation)] {
            let table_of = Table::new(vec![rows.len(), STATES], rows.concat())?;
            tensors.push((format!("{name}.{table}"), table_of));
        }
        Ok(tensors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the sum of losses by the outputs.
    fn slopes<const N: usize>(
        targets: [[f32; 2]; N],
        outputs: [[f32; 2]; N],
        deviations: [f32; 2],
    ) -> Vec<f32> {
        let device = Device::flex();
        let tensor = |rows: [[f32; 2]; N]| {
            let data = TensorData::new(rows.concat(), [N, 2]);
            Tensor::<2>::from_data(data, &device).autodiff()
        };
        let outputs = tensor(outputs).require_grad();
        let loss = losses(tensor(targets) - outputs.clone(), tensor([deviations; N])).sum();
        mlp::values(outputs.grad_remove(&mut loss.backward()).unwrap())
    }

    #[test]
    fn counts_are_fitted_by_their_mean_and_lengths_by_theirs() {
        // Trees of 1 and of 9 nodes; and lengths of 0 and 2.
        let d = 0.8;
        let state = |count: f32| count.ln() / d;
        let at = |count: f32| {
            let outputs = [[state(count), 1.0]; 2];
            slopes([[state(1.0), 0.0], [state(9.0), 2.0]], outputs, [d, 0.0])
        };
        let sums = |slopes: &[f32]| [slopes[0] + slopes[2], slopes[1] + slopes[3]];
        let [count, length] = sums(&at(5.0));
        assert!(count.abs() < 1e-5 && length.abs() < 1e-5, "{count} {length}");
        // The mean of the logarithms is too few: more would cost less.
        assert!(sums(&at(3.0))[0] < -0.5);
    }

    #[test]
    fn lengths_that_are_far_off_have_the_slope_of_their_square() {
        let slopes = slopes([[0.0, 1e3]], [[0.0, 0.0]], [1.0, 0.0]);
        assert_eq!(slopes, [0.0, -2e3]);
    }
}
