//! The law of roots, given the species, the age and the gravitropism.
//!
//! The roots of the training trees nearest to what is asked for stand for their law there. Around
//! an age a and gravitropism v, told as x = (a / 5, 5 v), their states z follow a line:
//!
//! `z_i = m + B (x_i − x) + r_i`,
//!
//! fitted by least squares with weights that fall with the distance (local linear regression,
//! Cleveland 1979). A new state is one of them, moved along the line to x, and blurred:
//!
//! `z = m + √(1 − b²) (z_i − B (x_i − x) − m) + b L ε`, `L Lᵀ = cov(r)`, ε standard normal
//!
//! which leaves mean and covariance as they are (smoothed bootstrap, Silverman 1986, §6.4).
//!
//! Where the model has a [`Trend`] it takes the place of the line: it was fitted to more trees than
//! the model has roots, and knows ages at which a species thins out. The roots say how trees scatter
//! about it, so m is the trend at the place, and r_i is what is left of z_i less the trend where the
//! root was seen, less the mean of that.

use std::cmp::Ordering;

use deeptree_graph::{Draws, Quat, cholesky, solve};
use deeptree_infer::{Predictor, Root, Trend};

use crate::state::{
    BRANCHES, CROWN_RADIUS, HEIGHT, LENGTHS, LONGEST_PATH, MEAN_PATH, NODES, STATES, State, TIPS,
    TRUNK_LENGTH, state, with_state,
};

/// Roots that a law is fitted to: fewer follow the line more closely, more scatter less.
const NEIGHBOURS: f64 = 60.0;

/// As how many roots those of one age and gravitropism count, next to others: a corpus has hundreds
/// of a species' own age, and only scattered ones say how the traits change with it.
const MOST_OF_A_PLACE: f64 = 20.0;

/// b: how much of the spread is blur. 0 gives training trees back, 1 a Gaussian law.
const BLUR: f64 = 0.25;

/// How far beyond the neighbours a state may lie, in standard deviations.
const MARGIN: f64 = 0.5;

/// Keeps slopes at 0 that nothing is known of, as part of the squared bandwidth.
const RIDGE: f64 = 1e-3;

/// What a model knows of the trees of a species as wholes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stock<'a> {
    pub(crate) roots: &'a [Root],
    pub(crate) trend: Option<&'a Trend>,
    /// Of a twig that bears one tip, in metres.
    pub(crate) tip_radius: f32,
}

impl<'a> Stock<'a> {
    pub(crate) fn of(model: &'a impl Predictor, species: usize) -> Self {
        Self {
            roots: model.roots(species),
            trend: model.trend(species),
            tip_radius: model.tip_radius(species),
        }
    }

    fn state(&self, root: usize) -> State {
        state(&self.roots[root], self.tip_radius)
    }
}

/// An age and a gravitropism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// In growth cycles.
    pub(crate) age: f32,
    pub(crate) gravitropism: f32,
}

impl Place {
    pub(crate) fn of(root: &Root) -> Self {
        Self { age: root.age, gravitropism: root.gravitropism }
    }

    /// Where the law is told from: a unit is five growth cycles, or a fifth of gravitropism. With
    /// ten cycles instead, the steps in which some species thin out are smoothed away.
    fn x(self) -> [f64; 2] {
        [f64::from(self.age) / 5.0, 5.0 * f64::from(self.gravitropism)]
    }

    /// How far apart two places are, in those units.
    pub(crate) fn distance(self, other: Self) -> f64 {
        let ([a, v], [b, w]) = (self.x(), other.x());
        libm::sqrt((a - b) * (a - b) + (v - w) * (v - w))
    }

    /// Where most of the roots are: the species' own age and gravitropism; of several the first.
    pub(crate) fn own(roots: &[Root]) -> Self {
        let mut order: Vec<usize> = (0..roots.len()).collect();
        order.sort_by(|&a, &b| Self::of(&roots[a]).order(Self::of(&roots[b])));
        let alike = order.chunk_by(|&a, &b| Self::of(&roots[a]) == Self::of(&roots[b]));
        let most = alike.max_by_key(|group| (group.len(), usize::MAX - group[0]));
        most.map_or(Self { age: 0.0, gravitropism: 0.0 }, |group| Self::of(&roots[group[0]]))
    }

    fn order(self, other: Self) -> Ordering {
        let by_age = self.age.total_cmp(&other.age);
        by_age.then(self.gravitropism.total_cmp(&other.gravitropism))
    }
}

/// A root near the place asked for.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    /// Its number among the species' roots.
    root: usize,
    weight: f64,
    /// Its state, moved along the line to the place asked for.
    state: State,
}

/// The law of the states of roots at one place.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    neighbours: Vec<Neighbour>,
    /// m
    mean: State,
    /// Of the states around their line.
    pub(crate) covariance: [State; STATES],
    /// What the spread of the neighbours is multiplied by: the line has taken some of it.
    spread: f64,
    /// L
    triangle: [State; STATES],
    /// Lowest and highest of the neighbours' states that are such both where they were seen and at
    /// the place: a line can lead to what no tree ever was.
    seen: (State, State),
    /// What states are kept within: a margin more.
    bounds: (State, State),
}

impl Law {
    /// The law at `place`, of the roots of a species, of which there is at least one.
    pub(crate) fn at(stock: Stock<'_>, place: Place) -> Self {
        let near = nearest(stock.roots, place);
        let total: f64 = near.iter().map(|near| near.weight).sum();
        let mut neighbours: Vec<Neighbour> = near
            .iter()
            .map(|near| Neighbour {
                root: near.root,
                weight: near.weight / total,
                state: stock.state(near.root),
            })
            .collect();
        let (mean, slopes) = match stock.trend {
            Some(trend) => (follow(&mut neighbours, stock.roots, trend, place), 0.0),
            // A line has two slopes, unless all are at one place.
            None => {
                let is_place = near.iter().all(|n| n.offset == near[0].offset);
                (line(&mut neighbours, &near), if is_place { 0.0 } else { 2.0 })
            }
        };

        let covariance: [State; STATES] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let product =
                    |n: &Neighbour| n.weight * (n.state[i] - mean[i]) * (n.state[j] - mean[j]);
                neighbours.iter().map(product).sum()
            })
        });
        // As many residuals as n independent ones with the weights they have: of their squares, a
        // fitted mean and each fitted slope take one part in n.
        let effective = 1.0 / neighbours.iter().map(|n| n.weight * n.weight).sum::<f64>();
        let fitted = 1.0 + slopes;
        let factor = if effective > 2.0 * fitted { effective / (effective - fitted) } else { 1.0 };
        let covariance = covariance.map(|row| row.map(|x| factor * x));

        let extreme = |start: f64, pick: fn(f64, f64) -> f64| -> State {
            std::array::from_fn(|i| neighbours.iter().map(|n| n.state[i]).fold(start, pick))
        };
        let mut seen = (extreme(f64::INFINITY, f64::min), extreme(f64::NEG_INFINITY, f64::max));
        let margin = |i: usize| MARGIN * libm::sqrt(covariance[i][i]);
        let mut low: State = std::array::from_fn(|i| seen.0[i] - margin(i));
        let mut high: State = std::array::from_fn(|i| seen.1[i] + margin(i));
        for i in 0..STATES {
            let own = near.iter().map(|near| stock.state(near.root)[i]);
            let (least, most) = own
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), own| (a.min(own), b.max(own)));
            seen.0[i] = seen.0[i].clamp(least, most);
            seen.1[i] = seen.1[i].clamp(least, most);
            // No line or margin leads to lengths of nothing or less.
            if LENGTHS.contains(&i) {
                low[i] = low[i].max(0.5 * least);
                high[i] = high[i].max(low[i]);
            }
        }
        Self {
            mean,
            covariance,
            spread: libm::sqrt(factor),
            triangle: cholesky(&covariance),
            seen,
            bounds: (low, high),
            neighbours,
        }
    }

    /// Draws a root and its state.
    pub(crate) fn draw(&self, draws: &mut Draws) -> (usize, State) {
        let mut left = draws.uniform();
        let mut drawn = &self.neighbours[self.neighbours.len() - 1];
        for neighbour in &self.neighbours {
            if left < neighbour.weight {
                drawn = neighbour;
                break;
            }
            left -= neighbour.weight;
        }
        let noise: State = std::array::from_fn(|_| draws.normal());
        let keep = self.spread * libm::sqrt(1.0 - BLUR * BLUR);
        let blurred = std::array::from_fn(|i| {
            let blur: f64 = self.triangle[i].iter().zip(&noise).map(|(l, e)| l * e).sum();
            self.mean[i] + keep * (drawn.state[i] - self.mean[i]) + BLUR * blur
        });
        (drawn.root, self.clamp(blurred))
    }

    /// The state within the bounds.
    pub(crate) fn clamp(&self, state: State) -> State {
        std::array::from_fn(|i| state[i].clamp(self.bounds.0[i], self.bounds.1[i]))
    }

    /// How far a number is from the mean of number `i` of the states, in standard deviations.
    pub(crate) fn strain(&self, i: usize, number: f64) -> f64 {
        let deviation = libm::sqrt(self.covariance[i][i]);
        if deviation > 0.0 { (number - self.mean[i]).abs() / deviation } else { 0.0 }
    }

    /// What number `i` of the neighbours' states goes from and to.
    pub(crate) fn seen(&self, i: usize) -> (f64, f64) {
        (self.seen.0[i], self.seen.1[i])
    }

    /// What number `i` of a state is kept within.
    pub(crate) fn bounds(&self, i: usize) -> (f64, f64) {
        (self.bounds.0[i], self.bounds.1[i])
    }
}

/// A root near a place, as the fit sees it.
struct Near {
    root: usize,
    distance: f64,
    /// x_i − x
    offset: [f64; 2],
    weight: f64,
}

/// The roots near a place with their weights, which are tricube in the distance.
fn nearest(roots: &[Root], place: Place) -> Vec<Near> {
    let distance = |i: usize| place.distance(Place::of(&roots[i]));
    let mut order: Vec<(f64, usize)> = (0..roots.len()).map(|i| (distance(i), i)).collect();
    // Those of one place next to each other.
    order.sort_by(|a, b| {
        let by_place = || Place::of(&roots[a.1]).order(Place::of(&roots[b.1]));
        a.0.total_cmp(&b.0).then_with(by_place).then(a.1.cmp(&b.1))
    });
    let many = |count: usize| (count as f64).min(MOST_OF_A_PLACE);
    let mut near = Vec::new();
    let (mut reach, mut found) = (0.0, 0.0);
    let x = place.x();
    for alike in order.chunk_by(|a, b| Place::of(&roots[a.1]) == Place::of(&roots[b.1])) {
        let distance = alike[0].0;
        if found >= NEIGHBOURS && distance > reach {
            break;
        }
        let own = Place::of(&roots[alike[0].1]).x();
        let offset = [own[0] - x[0], own[1] - x[1]];
        let weight = many(alike.len()) / alike.len() as f64;
        near.extend(alike.iter().map(|&(_, root)| Near { root, distance, offset, weight }));
        reach = distance;
        found += many(alike.len());
        if reach == 0.0 && alike.len() as f64 >= NEIGHBOURS {
            break;
        }
    }
    // A bit more than the reach, so that the furthest has a weight too.
    let bandwidth = 1.1 * reach;
    for near in &mut near {
        let part = if bandwidth > 0.0 { near.distance / bandwidth } else { 0.0 };
        let falls = 1.0 - part * part * part;
        near.weight *= falls * falls * falls;
    }
    near
}

/// Fits the line, moves the neighbours along it to the place asked for, and gives m.
fn line(neighbours: &mut [Neighbour], near: &[Near]) -> State {
    let weighted = |of: &dyn Fn(usize) -> f64| -> f64 {
        neighbours.iter().enumerate().map(|(k, n)| n.weight * of(k)).sum()
    };
    let middle = [0, 1].map(|c| weighted(&|k| near[k].offset[c]));
    let centred = |k: usize, c: usize| near[k].offset[c] - middle[c];
    let scale = near.iter().map(|n| n.offset[0] * n.offset[0] + n.offset[1] * n.offset[1]);
    let ridge = RIDGE * scale.fold(0.0, f64::max);
    let moments = |c: usize, d: usize| {
        weighted(&|k| centred(k, c) * centred(k, d)) + if c == d { ridge } else { 0.0 }
    };
    let matrix = vec![vec![moments(0, 0), moments(0, 1)], vec![moments(1, 0), moments(1, 1)]];
    let mut mean = [0.0; STATES];
    let mut slopes = [[0.0; 2]; STATES];
    for i in 0..STATES {
        let centre = weighted(&|k| neighbours[k].state[i]);
        let with = |c: usize| weighted(&|k| centred(k, c) * (neighbours[k].state[i] - centre));
        let slope = solve(matrix.clone(), vec![with(0), with(1)]);
        slopes[i] = [slope[0], slope[1]];
        mean[i] = centre - slope[0] * middle[0] - slope[1] * middle[1];
    }
    for (neighbour, near) in neighbours.iter_mut().zip(near) {
        for (state, slope) in neighbour.state.iter_mut().zip(&slopes) {
            *state -= slope[0] * near.offset[0] + slope[1] * near.offset[1];
        }
    }
    mean
}

/// Moves the neighbours along the trend to the place asked for, about its mean there, which it gives.
fn follow(neighbours: &mut [Neighbour], roots: &[Root], trend: &Trend, place: Place) -> State {
    let mean = trend.at(place.age, place.gravitropism);
    for neighbour in &mut *neighbours {
        let seen = Place::of(&roots[neighbour.root]);
        let there = trend.at(seen.age, seen.gravitropism);
        neighbour.state = std::array::from_fn(|i| neighbour.state[i] - there[i]);
    }
    let middle: State =
        std::array::from_fn(|i| neighbours.iter().map(|n| n.weight * n.state[i]).sum());
    for neighbour in neighbours {
        neighbour.state = std::array::from_fn(|i| mean[i] + neighbour.state[i] - middle[i]);
    }
    mean
}

/// A state that a tree can have: no way is longer than the longest, and every branch has a node.
/// Numbers that were `given` stay.
pub(crate) fn consistent(mut state: State) -> State {
    for i in [MEAN_PATH, CROWN_RADIUS, HEIGHT, TRUNK_LENGTH] {
        state[LONGEST_PATH] = state[LONGEST_PATH].max(state[i]);
    }
    state[NODES] = state[NODES].max(state[BRANCHES]);
    state
}

/// The root whose state is moved by what stands around, as far as a tree can be.
pub(crate) fn moved(root: Root, tip_radius: f32, shift: &State) -> Root {
    let state = state(&root, tip_radius);
    let moved = std::array::from_fn(|i| state[i] + shift[i]);
    with_state(root, tip_radius, &possible(moved))
}

/// The state of a tree that what stands around has left next to nothing of: at least a stump.
fn possible(mut state: State) -> State {
    for i in LENGTHS {
        state[i] = state[i].max(1.0);
    }
    for i in [TIPS, NODES, BRANCHES] {
        state[i] = state[i].max(0.0);
    }
    consistent(state)
}

/// The rotation turned about the vertical: a law of roots has no direction of its own.
pub(crate) fn yawed(rotation: Quat, draws: &mut Draws) -> Quat {
    let yaw = (draws.uniform() * core::f64::consts::TAU) as f32;
    (Quat::from_rotation_y(yaw) * rotation).normalize()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::state::TIPS;
    use deeptree_graph::{ChildSignature, Lineage, Purpose, Seed, TreeTraits, Vec3};
    use deeptree_infer::{ModelKind, TREND_COLUMNS, Table, Weights, WeightsBuilder};

    pub(crate) const TIP: f32 = 0.01;
    /// A law that is linear and Gaussian: its value at age 25 and gravitropism 0.2, its slopes by
    /// age and gravitropism, and what eight independent normal numbers are multiplied by.
    const MIDDLE: State = [7.5, 8.0, 40.0, 6.5, 20.0, 12.0, 25.0, 22.0];
    const SLOPES: [[f64; 2]; STATES] = [
        [0.25, 0.1],
        [0.3, -0.1],
        [1.5, 0.5],
        [0.25, 0.0],
        [1.0, -0.3],
        [0.75, 0.4],
        [1.25, -0.8],
        [1.0, -0.5],
    ];
    const DEVIATIONS: State = [0.2, 0.2, 2.0, 0.25, 1.0, 0.8, 1.5, 1.2];
    const GAP: Place = Place { age: 25.0, gravitropism: 0.2 };

    /// Roots without a trend.
    pub(crate) fn stock(roots: &[Root]) -> Stock<'_> {
        Stock { roots, trend: None, tip_radius: TIP }
    }

    pub(crate) fn draws(seed: u64) -> Draws {
        Seed(seed).draws(Lineage::ROOT, Purpose::RootSignature)
    }

    pub(crate) fn root(place: Place, state: &State) -> Root {
        let signature = ChildSignature { rotation: Quat::IDENTITY, thickness: 1.0, length: 1.0 };
        let traits = TreeTraits::from_array([1.0; TreeTraits::COUNT]);
        let Place { age, gravitropism } = place;
        with_state(Root { signature, age, gravitropism, traits }, TIP, state)
    }

    /// Each number goes with the one before it.
    pub(crate) fn noise(draws: &mut Draws) -> State {
        let normal: State = std::array::from_fn(|_| draws.normal());
        std::array::from_fn(|i| DEVIATIONS[i] * (normal[i] + normal[i.saturating_sub(1)]))
    }

    /// The covariance of [`noise`], worked out by hand.
    fn covariance(i: usize, j: usize) -> f64 {
        let shared = match (i.min(j), i.abs_diff(j)) {
            (0, 0) => 4.0,
            (_, 0) => 2.0,
            (0, 1) => 2.0,
            (_, 1) => 1.0,
            _ => 0.0,
        };
        shared * DEVIATIONS[i] * DEVIATIONS[j]
    }

    pub(crate) fn on_the_line(place: Place) -> State {
        let ([a, v], [b, w]) = (place.x(), GAP.x());
        std::array::from_fn(|i| MIDDLE[i] + SLOPES[i][0] * (a - b) + SLOPES[i][1] * (v - w))
    }

    /// Roots of ages 10 to 22 and 28 to 40, and of three ranges of gravitropism.
    pub(crate) fn scattered(seed: u64, count: usize, noisy: f64) -> Vec<Root> {
        let mut draws = draws(seed);
        let mut one = || {
            let years = draws.index(26) as f32;
            let age = if years < 13.0 { 10.0 + years } else { 15.0 + years };
            let v = draws.uniform() as f32;
            let gravitropism = [v * 0.15 - 0.4, v * 0.3 - 0.15, v * 0.15 + 0.25][draws.index(3)];
            let place = Place { age, gravitropism };
            let (line, noise) = (on_the_line(place), noise(&mut draws));
            root(place, &std::array::from_fn(|i| line[i] + noisy * noise[i]))
        };
        (0..count).map(|_| one()).collect()
    }

    #[test]
    fn in_a_gap_draws_lie_on_the_line_of_the_roots_around_it() {
        let roots = scattered(1, 300, 0.0);
        let law = Law::at(stock(&roots), GAP);
        assert!(law.neighbours.iter().all(|n| Place::of(&roots[n.root]) != GAP));
        for seed in 0..50 {
            let (_, state) = law.draw(&mut draws(seed));
            for i in 0..STATES {
                // Tips are whole numbers, and the ridge takes a little of the slope.
                assert!((state[i] - MIDDLE[i]).abs() < 0.02 * DEVIATIONS[i], "{i}: {state:?}");
            }
        }
    }

    #[test]
    fn in_a_gap_draws_have_the_mean_and_covariance_of_the_law() {
        // Over many training sets, since each has an error of its own.
        let (sets, each) = (600, 20);
        let mut states = Vec::new();
        for set in 0..sets {
            let law = Law::at(stock(&scattered(set, 300, 1.0)), GAP);
            states.extend((0..each).map(|k| law.draw(&mut draws(set * each + k + 7_000_000)).1));
        }
        let n = states.len() as f64;
        let mean: State =
            std::array::from_fn(|i| states.iter().map(|state| state[i]).sum::<f64>() / n);
        for i in 0..STATES {
            let deviation = libm::sqrt(covariance(i, i));
            assert!((mean[i] - MIDDLE[i]).abs() < 0.05 * deviation, "mean {i}: {}", mean[i]);
            for j in 0..STATES {
                let own = states.iter().map(|s| (s[i] - MIDDLE[i]) * (s[j] - MIDDLE[j]));
                let scale = libm::sqrt(covariance(i, i) * covariance(j, j));
                let error = (own.sum::<f64>() / n - covariance(i, j)) / scale;
                // The error of the line itself adds to what is drawn around it: a 40th or so.
                assert!((-0.06..0.10).contains(&error), "covariance {i} {j}: {error}");
            }
        }
    }

    /// A trend through these states at three ages of one gravitropism.
    fn trend(ages: [(f32, State); 3]) -> Trend {
        let rows = ages
            .iter()
            .flat_map(|(age, state)| [*age, 0.0].into_iter().chain(state.map(|x| x as f32)));
        let mut weights = WeightsBuilder::new(ModelKind::Paper, &["oak".to_owned()]);
        let table = Table::new(vec![3, TREND_COLUMNS], rows.collect()).unwrap();
        weights.table("trend.oak", table);
        let weights = Weights::from_bytes(&weights.to_bytes().unwrap()).unwrap();
        Trend::read(&weights, "oak").unwrap().unwrap()
    }

    #[test]
    fn where_there_is_a_trend_draws_scatter_about_it_as_the_roots_do_about_theirs() {
        // The trees thin out at 21; the roots are of 20 and 21, each two above the trend.
        let at = |shift: f64| MIDDLE.map(|x| x + shift);
        let trend = trend([(19.0, at(1.0)), (20.0, at(0.0)), (21.0, at(-4.0))]);
        let mut source = draws(12);
        let mut one = |i: usize| {
            let place = Place { age: 20.0 + (i % 2) as f32, gravitropism: 0.0 };
            let (mean, noise) = (trend.at(place.age, place.gravitropism), noise(&mut source));
            root(place, &std::array::from_fn(|i| mean[i] + 2.0 + noise[i]))
        };
        let roots: Vec<Root> = (0..50).map(&mut one).collect();
        let here = Stock { trend: Some(&trend), ..stock(&roots) };
        for (age, shift) in [(19.0, 1.0), (20.0, 0.0), (21.0, -4.0)] {
            let law = Law::at(here, Place { age, gravitropism: 0.0 });
            let n = 4000;
            for (i, middle) in MIDDLE.into_iter().enumerate() {
                let mean = (0..n).map(|k| law.draw(&mut draws(k)).1[i]).sum::<f64>() / n as f64;
                let deviation = libm::sqrt(covariance(i, i));
                assert!((mean - middle - shift).abs() < 0.1 * deviation, "{age} {i}: {mean}");
                let found = libm::sqrt(law.covariance[i][i]);
                assert!((0.7..1.3).contains(&(found / deviation)), "{age} {i}: {found}");
            }
        }
    }

    #[test]
    fn at_one_place_draws_have_the_moments_of_its_roots() {
        let place = Place { age: 35.0, gravitropism: -0.2 };
        let mut source = draws(3);
        let roots: Vec<Root> = (0..400)
            .map(|_| noise(&mut source))
            .map(|noise| root(place, &std::array::from_fn(|i| MIDDLE[i] + noise[i])))
            .collect();
        // Others, however near, say nothing that the place's own roots do not.
        let others = scattered(4, 300, 1.0);
        let law = Law::at(stock(&[&roots[..], &others].concat()), place);
        assert_eq!(law.neighbours.len(), 400);
        let own: Vec<State> = roots.iter().map(|root| state(root, TIP)).collect();
        let n = 50_000;
        let drawn: Vec<State> = (0..n).map(|k| law.draw(&mut draws(k)).1).collect();
        let moments = |states: &[State], i: usize| {
            let n = states.len() as f64;
            let mean = states.iter().map(|s| s[i]).sum::<f64>() / n;
            (mean, states.iter().map(|s| (s[i] - mean) * (s[i] - mean)).sum::<f64>() / (n - 1.0))
        };
        for i in 0..STATES {
            let ((mean, variance), (m, v)) = (moments(&own, i), moments(&drawn, i));
            // Five standard errors of a mean and of a variance near a Gaussian law's.
            let n = n as f64;
            assert!((m - mean).abs() < 5.0 * libm::sqrt(variance / n), "{i}: {m} {mean}");
            assert!((v / variance - 1.0).abs() < 5.0 * libm::sqrt(2.0 / n), "{i}: {v} {variance}");
        }
    }

    #[test]
    fn a_line_that_leads_below_nothing_leaves_lengths_above_it() {
        // Crowns that widen by half a metre a year from age 20 on: by the line, −2 m at age 16.
        let crown = |age: f32| {
            let mut state = MIDDLE;
            state[CROWN_RADIUS] = 0.5 * f64::from(age - 20.0) + 0.2;
            root(Place { age, gravitropism: 0.2 }, &state)
        };
        let roots: Vec<Root> = (0..90).map(|i| crown(20.0 + (i % 3) as f32)).collect();
        let law = Law::at(stock(&roots), Place { age: 16.0, gravitropism: 0.2 });
        // Half of the least that was seen is drawn at least, and what was seen is told.
        let (low, high) = law.bounds(CROWN_RADIUS);
        assert!((low - 0.1).abs() < 1e-6 && high >= low, "{low} {high}");
        let (low, high) = law.seen(CROWN_RADIUS);
        assert!((low - 0.2).abs() < 1e-6 && high >= low, "{low} {high}");
    }

    #[test]
    fn draws_stay_near_what_was_seen_and_are_no_training_trees() {
        let roots = scattered(5, 300, 1.0);
        for place in [GAP, Place { age: 10.0, gravitropism: -0.4 }] {
            let law = Law::at(stock(&roots), place);
            for seed in 0..2000 {
                let (root, drawn) = law.draw(&mut draws(seed));
                for i in 0..STATES {
                    let (low, high) = law.bounds(i);
                    assert!((low..=high).contains(&drawn[i]), "{i}: {drawn:?}");
                    let (seen_low, seen_high) = law.seen(i);
                    assert!(low < seen_low && seen_high < high);
                }
                assert!(state(&roots[root], TIP)[TIPS] != drawn[TIPS]);
                assert_eq!(law.draw(&mut draws(seed)), (root, drawn));
            }
        }
    }

    #[test]
    fn the_own_place_of_a_species_is_where_most_roots_are() {
        let mut roots = scattered(6, 300, 1.0);
        let own = Place { age: 30.0, gravitropism: 0.1 };
        roots.insert(100, root(own, &MIDDLE));
        roots.push(root(own, &MIDDLE));
        assert_eq!(Place::own(&roots), own);
        assert_eq!(Place::own(&roots[..1]), Place::of(&roots[0]));
    }

    #[test]
    fn a_single_root_is_a_law() {
        let law = Law::at(stock(&[root(GAP, &MIDDLE)]), Place { age: 27.0, gravitropism: 0.2 });
        let (number, drawn) = law.draw(&mut draws(0));
        let close = drawn.iter().zip(&MIDDLE).all(|(a, b)| (a - b).abs() < 1e-3);
        assert!(number == 0 && close, "{drawn:?}");
    }

    #[test]
    fn a_turn_about_the_vertical_keeps_the_slope_and_has_every_direction() {
        let tilted = Quat::from_rotation_x(1.2);
        let slope = (tilted * Vec3::NEG_Z).y;
        let fronts: Vec<Vec3> =
            (0..4000).map(|seed| yawed(tilted, &mut draws(seed)) * Vec3::NEG_Z).collect();
        assert!(fronts.iter().all(|front| (front.y - slope).abs() < 1e-5));
        // Directions that are all as likely add up to less than 5 √n.
        let sum: Vec3 = fronts.iter().copied().sum();
        assert!(libm::sqrtf(sum.x * sum.x + sum.z * sum.z) < 5.0 * 4000f32.sqrt());
    }
}
