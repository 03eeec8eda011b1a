//! How the trees of a species change with age and gravitropism, learned from trees as wholes.
//!
//! The mean state at each age and at some gravitropisms is a local polynomial: of the trees nearest
//! to the place, weighted by their distance, linear in the age and quadratic in the gravitropism
//! (Cleveland 1979). How near is chosen for each species, as what foretells trees best that were left
//! out of the fit.

use deeptree_graph::{TreeTraits, solve};
use deeptree_infer::{TREND_COLUMNS, Table, Weights, WeightsBuilder};

use crate::TrainError;
use crate::report::{Report, TrendReport};

/// What its tables are called before the name of their species.
pub(crate) const NAME: &str = "trend";

/// Numbers of a state.
const STATES: usize = TreeTraits::STATES;

type State = [f64; STATES];

/// Gravitropisms of a trend, but for the species' own.
const GRAVITROPISMS: usize = 9;

/// How many trees a fit takes, and how many growth cycles count as much as a fifth of gravitropism.
const BANDWIDTHS: [(f64, f64); 7] = [
    (60.0, 5.0),
    (60.0, 2.0),
    (100.0, 2.0),
    (150.0, 2.0),
    (150.0, 1.0),
    (200.0, 1.0),
    (300.0, 1.0),
];

/// A unit of gravitropism.
const GRAVITROPISM: f64 = 0.2;

/// As how many trees those of one age and gravitropism count, next to others.
const MOST_OF_A_PLACE: f64 = 20.0;

/// At most so many trees judge a bandwidth.
const JUDGED: usize = 200;

/// Keeps slopes at 0 that nothing is known of, as part of the squared bandwidth.
const RIDGE: f64 = 1e-3;

/// A tree as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surveyed {
    /// Number of its species in the model.
    pub species: usize,
    /// In growth cycles.
    pub age: f32,
    /// v: gravitropism.
    pub gravitropism: f32,
    /// As [`TreeTraits::state`] has it.
    pub state: State,
}

/// Fits how the trees of each species change with age and gravitropism, and puts it into a model that
/// stays otherwise as it is.
///
/// # Errors
///
/// When a species of the model has no trees, a tree is of none of its species, or the report is of
/// another model.
pub fn train_trend(
    trees: &[Surveyed],
    data_hash: String,
    (model, report): (&Weights, &Report),
) -> Result<(Vec<u8>, Report), TrainError> {
    report.check(model, report.options.kind)?;
    if let Some(tree) = trees.iter().position(|tree| tree.species >= model.species().len()) {
        let species = format!("number {}", trees[tree].species);
        return Err(TrainError::UnknownSpecies { part: "training", tree, species });
    }
    let mut builder = WeightsBuilder::from_weights(model);
    for (number, name) in model.species().iter().enumerate() {
        let own: Vec<Surveyed> = trees.iter().copied().filter(|t| t.species == number).collect();
        if own.is_empty() {
            return Err(TrainError::MissingSpecies { species: name.clone() });
        }
        let rows = Survey::new(&own).trend();
        let shape = vec![rows.len() / TREND_COLUMNS, TREND_COLUMNS];
        builder.table(format!("{NAME}.{name}"), Table::new(shape, rows)?);
    }
    let bytes = builder.to_bytes()?;
    let trend = TrendReport { data_hash, trees: trees.len() };
    Ok((bytes.clone(), report.with_trend(trend, &bytes)?))
}

/// The trees of a species.
struct Survey<'a> {
    trees: &'a [Surveyed],
    /// As how many each counts.
    shares: Vec<f64>,
    /// Where most of them are, if many are of one age and gravitropism.
    own: Option<(f32, f32)>,
}

impl<'a> Survey<'a> {
    fn new(trees: &'a [Surveyed]) -> Self {
        let key = |i: usize| (trees[i].age.to_bits(), trees[i].gravitropism.to_bits());
        let mut order: Vec<usize> = (0..trees.len()).collect();
        order.sort_by_key(|&i| (key(i), i));
        let mut shares = vec![1.0; trees.len()];
        let mut own = (1, None);
        for alike in order.chunk_by(|&a, &b| key(a) == key(b)) {
            let count = alike.len() as f64;
            alike.iter().for_each(|&i| shares[i] = count.min(MOST_OF_A_PLACE) / count);
            if alike.len() > own.0 {
                own = (alike.len(), Some((trees[alike[0]].age, trees[alike[0]].gravitropism)));
            }
        }
        Self { trees, shares, own: own.1 }
    }

    /// The rows of the table.
    fn trend(&self) -> Vec<f32> {
        let bandwidth = self.bandwidth();
        let (youngest, oldest) = self.range(|tree| tree.age);
        let gravitropisms = self.gravitropisms();
        let mut rows = Vec::new();
        for age in youngest as u32..=oldest as u32 {
            for &gravitropism in &gravitropisms {
                let place = (age as f32, gravitropism);
                rows.extend([place.0, place.1]);
                rows.extend(self.mean(place, bandwidth, None).map(|x| x as f32));
            }
        }
        rows
    }

    fn range(&self, of: impl Fn(&Surveyed) -> f32) -> (f32, f32) {
        let ends = (f32::INFINITY, f32::NEG_INFINITY);
        self.trees.iter().map(of).fold(ends, |(low, high), x| (low.min(x), high.max(x)))
    }

    /// Evenly over those of the trees, and the species' own.
    fn gravitropisms(&self) -> Vec<f32> {
        let (low, high) = self.range(|tree| tree.gravitropism);
        let step = (high - low) / (GRAVITROPISMS - 1) as f32;
        let mut all: Vec<f32> = (0..GRAVITROPISMS).map(|i| low + step * i as f32).collect();
        all.extend(self.own.map(|own| own.1));
        all.sort_by(f32::total_cmp);
        all.dedup();
        all
    }

    /// The bandwidth by which trees that are left out are foretold best.
    fn bandwidth(&self) -> (f64, f64) {
        if self.trees.len() < 2 {
            return BANDWIDTHS[0];
        }
        let scattered: Vec<usize> =
            (0..self.trees.len()).filter(|&i| Some(place(&self.trees[i])) != self.own).collect();
        let judged = scattered.iter().step_by(scattered.len().div_ceil(JUDGED).max(1));
        let error = |bandwidth: (f64, f64)| -> f64 {
            let errors = judged.clone().map(|&i| {
                let mean = self.mean(place(&self.trees[i]), bandwidth, Some(i));
                // Logarithms and lengths in metres: relative errors are alike.
                let off = |k: usize| (self.trees[i].state[k] - mean[k]) / scale(k, &mean);
                (0..STATES).map(|k| off(k) * off(k)).sum::<f64>()
            });
            errors.sum()
        };
        let errors = BANDWIDTHS.map(|bandwidth| (error(bandwidth), bandwidth));
        let best = errors.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or(BANDWIDTHS[0], |(_, bandwidth)| bandwidth)
    }

    /// The mean state at a place, of all trees but `without`.
    fn mean(
        &self,
        place: (f32, f32),
        (count, cycles): (f64, f64),
        without: Option<usize>,
    ) -> State {
        let offset = |tree: &Surveyed| {
            let age = f64::from(tree.age) - f64::from(place.0);
            let gravitropism = f64::from(tree.gravitropism) - f64::from(place.1);
            [age / cycles, gravitropism / GRAVITROPISM]
        };
        let square = |[a, v]: [f64; 2]| a * a + v * v;
        let mut order: Vec<(f64, usize)> = (0..self.trees.len())
            .filter(|&i| Some(i) != without)
            .map(|i| (square(offset(&self.trees[i])), i))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // Where there are many, nobody else is asked.
        let here = order.partition_point(|(distance, _)| *distance == 0.0);
        if here as f64 >= count {
            let sum =
                |k: usize| order[..here].iter().map(|&(_, i)| self.trees[i].state[k]).sum::<f64>();
            return std::array::from_fn(|k| sum(k) / here as f64);
        }
        let mut found = 0.0;
        let mut last = 0;
        while last < order.len() && found < count {
            found += self.shares[order[last].1];
            last += 1;
        }
        let reach = 1.1 * libm::sqrt(order[last - 1].0).max(f64::MIN_POSITIVE);
        let near = order[..last].iter().map(|&(distance, i)| {
            let part = libm::sqrt(distance) / reach;
            let falls = 1.0 - part * part * part;
            let [a, v] = offset(&self.trees[i]);
            ([1.0, a, v, v * v], self.shares[i] * falls * falls * falls, &self.trees[i].state)
        });
        polynomial(near, reach * reach)
    }
}

fn place(tree: &Surveyed) -> (f32, f32) {
    (tree.age, tree.gravitropism)
}

/// What an error in number `k` of a state is told in.
fn scale(k: usize, mean: &State) -> f64 {
    if TreeTraits::STATE_IS_COUNT[k] { 1.0 } else { mean[k].abs().max(1.0) }
}

/// The value at 0 of the polynomials that fit states best, by weighted least squares: of trees with
/// the terms of the polynomial, a weight and a state each.
fn polynomial<'s>(trees: impl Iterator<Item = ([f64; 4], f64, &'s State)>, square: f64) -> State {
    let mut matrix = vec![vec![0.0; 4]; 4];
    let mut right = vec![vec![0.0; 4]; STATES];
    for (terms, weight, state) in trees {
        for (row, a) in matrix.iter_mut().zip(terms) {
            row.iter_mut().zip(terms).for_each(|(sum, b)| *sum += weight * a * b);
        }
        for (row, x) in right.iter_mut().zip(state) {
            row.iter_mut().zip(terms).for_each(|(sum, a)| *sum += weight * a * x);
        }
    }
    let total = matrix[0][0];
    for (i, row) in matrix.iter_mut().enumerate().skip(1) {
        row[i] += RIDGE * total * if i == 3 { square * square } else { square };
    }
    std::array::from_fn(|k| solve(matrix.clone(), right[k].clone())[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trees of the ages 10 to 30, linear in the age and quadratic in the gravitropism, each number
    /// in its own way.
    fn state(age: f64, v: f64) -> State {
        std::array::from_fn(|k| 5.0 + k as f64 + 0.1 * age - (k as f64 - 3.0) * v * v + 0.5 * v)
    }

    fn trees(count: usize, noise: f64) -> Vec<Surveyed> {
        let part = |i: usize, step: f64| (i as f64 * step).fract();
        (0..count)
            .map(|i| {
                let (age, v) =
                    (10.0 + (21.0 * part(i, 0.618_034)).floor(), 0.8 * part(i, 0.754_878) - 0.4);
                let sign = if i.is_multiple_of(2) { noise } else { -noise };
                let state = state(age, v).map(|x| x + sign);
                Surveyed { species: 0, age: age as f32, gravitropism: v as f32, state }
            })
            .collect()
    }

    #[test]
    fn what_is_quadratic_is_found() {
        let trees = trees(600, 0.0);
        for row in Survey::new(&trees).trend().chunks_exact(TREND_COLUMNS) {
            let expected = state(row[0].into(), row[1].into());
            for (x, y) in row[2..].iter().zip(expected) {
                // The ridge takes a little of the slopes, most where trees are on one side only.
                assert!((f64::from(*x) - y).abs() < 0.05, "{row:?} {expected:?}");
            }
        }
    }

    #[test]
    fn an_age_at_which_trees_thin_out_is_kept_where_there_are_many() {
        let mut trees = trees(6000, 0.1);
        let step = |age: f32| if age >= 20.0 { -1.0 } else { 0.0 };
        trees.iter_mut().for_each(|tree| tree.state[1] += step(tree.age));
        for row in Survey::new(&trees).trend().chunks_exact(TREND_COLUMNS) {
            let expected = state(row[0].into(), row[1].into())[1] + step(row[0]);
            let off = (f64::from(row[3]) - expected).abs();
            let is_beside = (18.0..22.0).contains(&row[0]);
            assert!(off < if is_beside { 0.5 } else { 0.15 }, "{row:?}: {expected}");
        }
    }

    #[test]
    fn many_trees_of_one_place_have_their_own_mean_there() {
        let mut all = trees(300, 0.0);
        let at_home = |i: usize| Surveyed {
            species: 0,
            age: 20.0,
            gravitropism: 0.05,
            state: state(20.0, 0.05).map(|x| x + if i.is_multiple_of(4) { 4.0 } else { 0.0 }),
        };
        all.extend((0..400).map(at_home));
        let rows = Survey::new(&all).trend();
        let own = rows.chunks_exact(TREND_COLUMNS).find(|row| row[0] == 20.0 && row[1] == 0.05);
        let expected = state(20.0, 0.05).map(|x| x + 1.0);
        let off = own.unwrap()[2..].iter().zip(expected).map(|(x, y)| (f64::from(*x) - y).abs());
        assert!(off.fold(0.0, f64::max) < 1e-4);
    }

    #[test]
    fn trees_of_one_place_are_a_trend_of_one_row() {
        let all = [Surveyed { species: 0, age: 7.0, gravitropism: 0.1, state: [3.0; STATES] }; 4];
        let mut expected = vec![7.0, 0.1];
        expected.extend([3.0; STATES]);
        assert_eq!(Survey::new(&all).trend(), expected);
        assert_eq!(Survey::new(&all[..1]).trend(), expected);
    }

    #[test]
    fn where_nothing_but_noise_differs_more_trees_are_asked() {
        let mut flat = trees(3000, 0.0);
        for (i, tree) in flat.iter_mut().enumerate() {
            // Signs that go with neither the age nor the gravitropism.
            let sign = if (i * i / 7).is_multiple_of(2) { 1.0 } else { -1.0 };
            tree.state = [5.0 + sign; STATES];
        }
        let mut steps = trees(3000, 0.0);
        for tree in &mut steps {
            tree.state = [5.0 + 2.0 * (tree.age % 2.0) as f64; STATES];
        }
        let [flat, steps] = [flat, steps].map(|all| Survey::new(&all).bandwidth());
        assert!(flat.0 > 100.0, "{flat:?}");
        assert!(steps.1 < 5.0 && steps.0 < flat.0, "{steps:?} {flat:?}");
    }
}
