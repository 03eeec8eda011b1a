//! What a user asks of a whole tree, and how the rest follows from it.
//!
//! The traits of the training trees of a species stand for their joint law. A tree that is asked to
//! have some of them gets the traits of a training tree, moved so that the asked ones are exactly
//! met and the others follow as they go with them:
//!
//! `z' = z + Σ_og Σ_gg⁻¹ (w − z_g)`
//!
//! with z the drawn traits, w the wishes, g the given ones, o all others, and Σ their covariance. Of
//! a Gaussian law this draws exactly from what the wishes leave open (conditioning by kriging,
//! Journel and Huijbregts 1978).

use deeptree_graph::TreeTraits;
use deeptree_graph::signature::{thickness_of, tip_count};
use deeptree_infer::Root;

/// What is asked of a whole tree; what is left open is drawn to go with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wishes {
    /// Height in metres.
    pub height: Option<f32>,
    /// Distance of the outermost node from the axis in metres.
    pub crown_radius: Option<f32>,
    /// Number of Gravelius branches.
    pub branches: Option<f32>,
    /// Length of the trunk, the branch of order 0, in metres.
    pub trunk_length: Option<f32>,
}

/// One wish: its name, its value, and the trait of a tree it is about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    pub(crate) what: &'static str,
    pub(crate) value: f32,
    pub(crate) of: fn(&TreeTraits) -> f32,
}

/// ln of the tips, then the seven traits; counts as logarithms.
const STATES: usize = 1 + TreeTraits::COUNT;

/// Where the wishes stand among the states.
const BRANCHES: usize = 3;
const CROWN_RADIUS: usize = 5;
const HEIGHT: usize = 6;
const TRUNK_LENGTH: usize = 7;

type State = [f64; STATES];

impl Wishes {
    /// The wishes that were made.
    pub(crate) fn made(&self) -> impl Iterator<Item = Wish> {
        let Self { height, crown_radius, branches, trunk_length } = *self;
        let height = height.map(|value| Wish { what: "height", value, of: |t| t.height });
        let crown =
            crown_radius.map(|value| Wish { what: "crown radius", value, of: |t| t.crown_radius });
        let branches = branches.map(|value| Wish { what: "branches", value, of: |t| t.branches });
        let trunk = trunk_length.map(|value| Wish { what: "trunk", value, of: |t| t.trunk_length });
        [height, crown, branches, trunk].into_iter().flatten()
    }

    /// The same wishes, each moved by `move_to`.
    pub(crate) fn map(self, move_to: impl Fn(Wish) -> f32) -> Self {
        let mut moved = self;
        for wish in self.made() {
            let value = Some(move_to(wish));
            match wish.what {
                "height" => moved.height = value,
                "crown radius" => moved.crown_radius = value,
                "branches" => moved.branches = value,
                _ => moved.trunk_length = value,
            }
        }
        moved
    }

    /// Pairs of a state's index and the value it is to have.
    fn given(&self) -> Vec<(usize, f64)> {
        [
            (HEIGHT, self.height.map(f64::from)),
            (CROWN_RADIUS, self.crown_radius.map(f64::from)),
            (BRANCHES, self.branches.map(|n| libm::log(f64::from(n)))),
            (TRUNK_LENGTH, self.trunk_length.map(f64::from)),
        ]
        .into_iter()
        .filter_map(|(index, wish)| Some((index, wish?)))
        .collect()
    }
}

/// The root with its traits moved to meet the wishes; `roots` are those of its species.
pub(crate) fn grant(root: Root, roots: &[Root], tip_radius: f32, wishes: &Wishes) -> Root {
    let given = wishes.given();
    if given.is_empty() {
        return root;
    }
    let states: Vec<State> = roots.iter().map(|root| state(root, tip_radius)).collect();
    let covariance = covariance(&states);
    let mut z = state(&root, tip_radius);

    // Σ_gg x = w − z_g, with a trace of ridge for wishes that say the same.
    let matrix: Vec<Vec<f64>> = given
        .iter()
        .map(|&(i, _)| {
            let ridge = |j| if i == j { 1.0 + 1e-6 } else { 1.0 };
            given.iter().map(|&(j, _)| covariance[i][j] * ridge(j)).collect()
        })
        .collect();
    let x = solve(matrix, given.iter().map(|&(i, wish)| wish - z[i]).collect());
    for (o, z) in z.iter_mut().enumerate() {
        let shift: f64 = given.iter().zip(&x).map(|(&(g, _), x)| covariance[o][g] * x).sum();
        let seen = states.iter().map(|state| state[o]);
        let (low, high) = seen
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        *z = (*z + shift).clamp(low, high);
    }
    for (i, wish) in given {
        z[i] = wish;
    }
    with_state(root, tip_radius, &z)
}

fn state(root: &Root, tip_radius: f32) -> State {
    let tips = f64::from(tip_count(root.signature.thickness, tip_radius));
    let [nodes, branches, rest @ ..] = root.traits.to_array().map(f64::from);
    let mut state = [libm::log(tips), libm::log(nodes), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    // The order is that of the constants above.
    let [longest_path, mean_path, crown_radius, height, trunk_length] = rest;
    state[2] = longest_path;
    state[BRANCHES] = libm::log(branches);
    state[4] = mean_path;
    state[CROWN_RADIUS] = crown_radius;
    state[HEIGHT] = height;
    state[TRUNK_LENGTH] = trunk_length;
    state
}

fn with_state(mut root: Root, tip_radius: f32, state: &State) -> Root {
    let tips = libm::round(libm::exp(state[0])).clamp(1.0, 1e7) as u32;
    root.signature.thickness = thickness_of(tips, tip_radius);
    root.traits = TreeTraits {
        nodes: libm::exp(state[1]) as f32,
        branches: libm::exp(state[BRANCHES]) as f32,
        longest_path: state[2] as f32,
        mean_path: state[4] as f32,
        crown_radius: state[CROWN_RADIUS] as f32,
        height: state[HEIGHT] as f32,
        trunk_length: state[TRUNK_LENGTH] as f32,
    };
    root
}

fn covariance(states: &[State]) -> [State; STATES] {
    let n = states.len() as f64;
    let mean: State = std::array::from_fn(|i| states.iter().map(|s| s[i]).sum::<f64>() / n);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            states.iter().map(|s| (s[i] - mean[i]) * (s[j] - mean[j])).sum::<f64>() / n
        })
    })
}

/// Gaussian elimination with pivots; a row without any leaves its unknown at 0.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for column in 0..n {
        let pivot = (column..n)
            .max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))
            .unwrap_or(column);
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        if matrix[column][column].abs() < 1e-12 {
            continue;
        }
        for row in column + 1..n {
            let factor = matrix[row][column] / matrix[column][column];
            let (above, below) = matrix.split_at_mut(row);
            for (x, pivot) in below[0].iter_mut().zip(&above[column]).skip(column) {
                *x -= factor * pivot;
            }
            right[row] -= factor * right[column];
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let rest: f64 = (row + 1..n).map(|k| matrix[row][k] * x[k]).sum();
        if matrix[row][row].abs() >= 1e-12 {
            x[row] = (right[row] - rest) / matrix[row][row];
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{ChildSignature, Quat};

    /// Roots of trees whose branches are `40 · height` and whose crown radius varies by itself.
    fn roots() -> Vec<Root> {
        (0..50)
            .map(|i| {
                let height = 20.0 + i as f32 * 0.2;
                Root {
                    signature: ChildSignature {
                        rotation: Quat::IDENTITY,
                        thickness: thickness_of(1000, 0.01),
                        length: 1.0,
                    },
                    age: 30.0,
                    gravitropism: 0.0,
                    traits: TreeTraits {
                        nodes: 3000.0,
                        branches: 40.0 * height,
                        longest_path: height + 2.0,
                        mean_path: 18.0,
                        crown_radius: if i % 2 == 0 { 10.0 } else { 12.0 },
                        height,
                        trunk_length: 15.0,
                    },
                }
            })
            .collect()
    }

    #[test]
    fn a_wish_is_met_and_what_goes_with_it_follows() {
        let roots = roots();
        let wishes = Wishes { height: Some(27.0), ..Wishes::default() };
        let granted = grant(roots[3], &roots, 0.01, &wishes).traits;
        assert_eq!(granted.height, 27.0);
        assert!((granted.longest_path - 29.0).abs() < 1e-3);
        // ln(branches) is nearly linear in the height over so short a range.
        assert!((granted.branches / (40.0 * 27.0) - 1.0).abs() < 0.02, "{}", granted.branches);
        assert!((granted.crown_radius - roots[3].traits.crown_radius).abs() < 0.3);
    }

    #[test]
    fn without_a_wish_the_root_stays_as_it_is() {
        let roots = roots();
        assert_eq!(grant(roots[7], &roots, 0.01, &Wishes::default()), roots[7]);
    }

    #[test]
    fn elimination_solves_a_system_worked_out_by_hand() {
        // x + 2y = 5, 3x − y = 1
        let x = solve(vec![vec![1.0, 2.0], vec![3.0, -1.0]], vec![5.0, 1.0]);
        assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12);
    }
}
