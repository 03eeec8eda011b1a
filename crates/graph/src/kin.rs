//! What sets a tree apart from others of its kind.

use crate::algebra::{cholesky, solve};
use crate::graph::BranchGraph;
use crate::traits::TreeTraits;

/// Terms of the mean over age and gravitropism.
const TERMS: usize = 7;

/// What the variance of a number grows by, so that a number that follows from those before it, up to
/// rounding, stands near 0.
const RIDGE: f64 = 0.003;

/// Beyond these, standings are told as these, in deviations: trees far from the species' own age scatter
/// otherwise.
const MOST: f64 = 4.0;

/// The law of a species' trees as wholes, by which one is told from another: where it *stands* among
/// trees of its species, age and gravitropism, in independent numbers of mean 0 and variance 1.
///
/// `L z = x − m(a, v)`, with x the state of the tree ([`TreeTraits::state`]) and its *habit*, m a
/// polynomial, and `L Lᵀ` the covariance of what is left at the species' own age and gravitropism.
/// So each number says what those before it do not: the second, how many more nodes there are than the
/// tips lead one to expect. Numbers of the state itself hardly differ where they tell most, such as
/// branches for nodes, which differ by a few percent between trees whose shoots sag more or less.
///
/// The habit is two spreads that say how alike a tree's parts are; trees that shall grow draw them.
#[derive(Clone, Debug, PartialEq)]
pub struct Kin {
    /// The species' own age, in growth cycles, and gravitropism.
    own: [f64; 2],
    /// Of each number, by [`terms`].
    mean: [[f64; TERMS]; Self::NUMBERS],
    /// L
    triangle: [[f64; Self::NUMBERS]; Self::NUMBERS],
}

/// A tree that a law is fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinsman {
    /// In growth cycles.
    pub age: f32,
    /// v
    pub gravitropism: f32,
    /// State and habit.
    pub numbers: [f64; Kin::NUMBERS],
}

impl Kinsman {
    /// Of a tree whose root bears so many tips.
    #[must_use]
    pub fn of(tree: &BranchGraph, tips: u32) -> Self {
        let (state, habit) = (TreeTraits::of(tree).state(tips), habit(tree));
        Self {
            age: tree.info.age as f32,
            gravitropism: tree.info.gravitropism,
            numbers: std::array::from_fn(|i| match i.checked_sub(TreeTraits::STATES) {
                None => state[i],
                Some(i) => habit[i],
            }),
        }
    }
}

impl Kin {
    /// Numbers of the habit.
    pub const HABITS: usize = 2;
    /// Numbers of a standing: of the state, then of the habit.
    pub const NUMBERS: usize = TreeTraits::STATES + Self::HABITS;
    /// Numbers of [`Self::to_row`].
    pub const COLUMNS: usize = 2 + Self::NUMBERS * TERMS + Self::NUMBERS * (Self::NUMBERS + 1) / 2;

    /// The law of some trees of a species; of none, one in which all stand alike.
    #[must_use]
    pub fn fit(trees: &[Kinsman]) -> Self {
        let own = most_common(trees);
        let terms: Vec<_> =
            trees.iter().map(|tree| terms(own, tree.age, tree.gravitropism)).collect();
        let moment = |i: usize, j: usize| -> f64 { terms.iter().map(|t| t[i] * t[j]).sum() };
        // Where all trees are of one age, nothing says how they change: slopes stay at 0.
        let ridge = |i: usize, j: usize| if i == j { 1e-6 * trees.len() as f64 } else { 0.0 };
        let matrix: Vec<Vec<f64>> =
            (0..TERMS).map(|i| (0..TERMS).map(|j| moment(i, j) + ridge(i, j)).collect()).collect();
        let mean = std::array::from_fn(|k| {
            let right =
                |i: usize| terms.iter().zip(trees).map(|(t, tree)| t[i] * tree.numbers[k]).sum();
            let solved = solve(matrix.clone(), (0..TERMS).map(right).collect());
            std::array::from_fn(|i| solved[i])
        });
        let mut kin = Self { own, mean, triangle: [[0.0; Self::NUMBERS]; Self::NUMBERS] };

        let left = |tree: &Kinsman| {
            let mean = kin.mean(tree.age, tree.gravitropism);
            std::array::from_fn::<f64, { Self::NUMBERS }, _>(|i| tree.numbers[i] - mean[i])
        };
        let is_own = |tree: &&Kinsman| place(tree) == own;
        let mut near: Vec<_> = trees.iter().filter(is_own).map(left).collect();
        if near.len() < 3 * Self::NUMBERS {
            near = trees.iter().map(left).collect();
        }
        let count = near.len().max(1) as f64;
        let centre: [f64; Self::NUMBERS] =
            std::array::from_fn(|i| near.iter().map(|x| x[i]).sum::<f64>() / count);
        let covariance: [[f64; Self::NUMBERS]; Self::NUMBERS] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let both = near.iter().map(|x| (x[i] - centre[i]) * (x[j] - centre[j]));
                both.sum::<f64>() / count * if i == j { 1.0 + RIDGE } else { 1.0 }
            })
        });
        kin.triangle = cholesky(&covariance);
        kin
    }

    /// The mean of each number at an age and a gravitropism.
    fn mean(&self, age: f32, gravitropism: f32) -> [f64; Self::NUMBERS] {
        let terms = terms(self.own, age, gravitropism);
        self.mean.map(|own| own.iter().zip(&terms).map(|(a, b)| a * b).sum())
    }

    /// Where a tree stands, in deviations, of which four are the most.
    #[must_use]
    pub fn standing(&self, tree: &Kinsman) -> [f32; Self::NUMBERS] {
        let mean = self.mean(tree.age, tree.gravitropism);
        let mut z = [0.0; Self::NUMBERS];
        for i in 0..Self::NUMBERS {
            let (before, own) = (&self.triangle[i][..i], self.triangle[i][i]);
            let shared: f64 = before.iter().zip(&z).map(|(l, z)| l * z).sum();
            if own > 0.0 {
                z[i] = (tree.numbers[i] - mean[i] - shared) / own;
            }
        }
        z.map(|z| z.clamp(-MOST, MOST) as f32)
    }

    /// Where a tree of this state stands that has this habit, which is told in deviations.
    #[must_use]
    pub fn standing_of(
        &self,
        (age, gravitropism): (f32, f32),
        state: [f64; TreeTraits::STATES],
        habit: [f32; Self::HABITS],
    ) -> [f32; Self::NUMBERS] {
        let numbers = std::array::from_fn(|i| state.get(i).copied().unwrap_or(0.0));
        let mut standing = self.standing(&Kinsman { age, gravitropism, numbers });
        standing[TreeTraits::STATES..].copy_from_slice(&habit);
        standing
    }

    /// The numbers of the law, in the order of the fields; of the triangle row by row what is not 0.
    #[must_use]
    pub fn to_row(&self) -> Vec<f32> {
        let below = self.triangle.iter().enumerate().flat_map(|(i, row)| &row[..=i]);
        let all = self.own.iter().chain(self.mean.iter().flatten()).chain(below);
        all.map(|&x| x as f32).collect()
    }

    /// The law as a file keeps it.
    #[must_use]
    pub fn rounded(&self) -> Self {
        let round = |x: f64| f64::from(x as f32);
        Self {
            own: self.own.map(round),
            mean: self.mean.map(|row| row.map(round)),
            triangle: self.triangle.map(|row| row.map(round)),
        }
    }

    /// The inverse of [`Self::to_row`]; none of numbers that are no law.
    #[must_use]
    pub fn from_row(row: &[f32]) -> Option<Self> {
        if row.len() != Self::COLUMNS || !row.iter().all(|x| x.abs() < 1e9) {
            return None;
        }
        let is_deviation = |x: f64| x == 0.0 || x > 1e-9;
        let mut numbers = row.iter().map(|&x| f64::from(x));
        let mut next = || numbers.next().unwrap_or(0.0);
        let own = std::array::from_fn(|_| next());
        let mean = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let triangle =
            std::array::from_fn(|i| std::array::from_fn(|j| if j <= i { next() } else { 0.0 }));
        let law = Self { own, mean, triangle };
        (0..Self::NUMBERS).all(|i| is_deviation(law.triangle[i][i])).then_some(law)
    }
}

/// What a tree is like besides its traits: the standard deviations of the lengths of its Gravelius
/// branches and of the ways from the foot to its nodes, in metres.
fn habit(tree: &BranchGraph) -> [f64; Kin::HABITS] {
    let ends = tree.nodes().iter().filter(|node| node.children[0].is_none());
    let branches = ends.map(|node| f64::from(node.branch_distance)).collect();
    let paths = tree.nodes().iter().map(|node| f64::from(node.root_distance)).collect();
    [spread(branches), spread(paths)]
}

fn spread(values: Vec<f64>) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    libm::sqrt(values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count)
}

fn place(tree: &Kinsman) -> [f64; 2] {
    [f64::from(tree.age), f64::from(tree.gravitropism)]
}

/// The age and gravitropism that most trees have; of several the lowest.
fn most_common(trees: &[Kinsman]) -> [f64; 2] {
    let mut places: Vec<[f64; 2]> = trees.iter().map(place).collect();
    places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut most: (usize, [f64; 2]) = (0, [0.0; 2]);
    for alike in places.chunk_by(|a, b| a == b) {
        if alike.len() > most.0 {
            most = (alike.len(), alike[0]);
        }
    }
    most.1
}

/// What the mean is a sum of: x in tens of growth cycles and y in halves of gravitropism from the
/// species' own.
fn terms(own: [f64; 2], age: f32, gravitropism: f32) -> [f64; TERMS] {
    let (x, y) = ((f64::from(age) - own[0]) / 10.0, 2.0 * (f64::from(gravitropism) - own[1]));
    [1.0, x, y, x * x, x * y, y * y, x * x * x]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Lineage, Purpose, Seed};

    /// Trees whose numbers follow a polynomial of age and gravitropism and scatter about it, the
    /// last with what the first scatters, too.
    fn trees() -> Vec<Kinsman> {
        let tree = |seed: u64| {
            let mut draws = Seed(seed).draws(Lineage::ROOT, Purpose::Priors);
            let is_own = seed.is_multiple_of(2);
            let age = if is_own { 30.0 } else { 10.0 + (seed % 30) as f32 };
            let gravitropism = if is_own { -0.125 } else { (seed % 7) as f32 / 8.0 - 0.375 };
            let (x, y) = (f64::from(age) / 10.0, f64::from(gravitropism));
            let mut numbers = std::array::from_fn(|i| {
                5.0 + i as f64 + x * x - 0.1 * x * x * x + x * y + 0.1 * draws.normal()
            });
            let last = Kin::NUMBERS - 1;
            numbers[last] += 3.0 * (numbers[0] - 5.0 - x * x + 0.1 * x * x * x - x * y);
            Kinsman { age, gravitropism, numbers }
        };
        (0..4000).map(tree).collect()
    }

    #[test]
    fn standings_are_independent_and_of_variance_one_wherever_trees_are() {
        let trees = trees();
        let kin = Kin::fit(&trees);
        for own in [true, false] {
            let chosen = trees.iter().filter(|tree| (tree.age == 30.0) == own);
            let standings: Vec<_> = chosen.map(|tree| kin.standing(tree)).collect();
            let mean = |of: &dyn Fn(&[f32; Kin::NUMBERS]) -> f32| {
                standings.iter().map(|z| f64::from(of(z))).sum::<f64>() / standings.len() as f64
            };
            for i in 0..Kin::NUMBERS {
                assert!(mean(&|z| z[i]).abs() < 0.1, "{i}");
                for j in 0..=i {
                    let expected = if i == j { 1.0 } else { 0.0 };
                    assert!((mean(&|z| z[i] * z[j]) - expected).abs() < 0.12, "{i} {j} {own}");
                }
            }
        }
    }

    #[test]
    fn a_law_is_read_as_it_is_written_and_a_habit_told_as_it_is() {
        let kin = Kin::fit(&trees());
        let row = kin.to_row();
        let read = Kin::from_row(&row).unwrap();
        assert_eq!(read.to_row(), row);
        let mut state = [0.0; TreeTraits::STATES];
        state.copy_from_slice(&trees()[3].numbers[..TreeTraits::STATES]);
        let place = (trees()[3].age, trees()[3].gravitropism);
        let standing = kin.standing_of(place, state, [0.5, -2.0]);
        let whole = kin.standing(&trees()[3]);
        assert_eq!(standing[..TreeTraits::STATES], whole[..TreeTraits::STATES]);
        assert_eq!(standing[TreeTraits::STATES..], [0.5, -2.0]);
        for bad in [f32::NAN, f32::INFINITY] {
            let mut row = row.clone();
            row[7] = bad;
            assert_eq!(Kin::from_row(&row), None);
        }
        assert_eq!(Kin::from_row(&row[1..]), None);
        let mut negative = row.clone();
        // The last of the triangle is on its diagonal.
        *negative.last_mut().unwrap() *= -1.0;
        assert_eq!(Kin::from_row(&negative), None);
    }

    #[test]
    fn of_trees_that_are_all_alike_and_of_none_all_stand_alike() {
        let tree = trees()[0];
        for kin in [Kin::fit(&[tree; 50]), Kin::fit(&[])] {
            let other = Kinsman { numbers: [3.0; Kin::NUMBERS], ..tree };
            assert_eq!(kin.standing(&other), [0.0; Kin::NUMBERS]);
        }
    }
}
