//! What a user asks of a whole tree, and how the rest follows from it.
//!
//! A tree that is asked to have some traits gets a state drawn from the law of its species, moved so
//! that the asked ones are exactly met and the others follow as they go with them:
//!
//! `z' = z + Σ_og Σ_gg⁻¹ (w − z_g)`
//!
//! with z the drawn state, w the wishes, g the given numbers, o all others, and Σ the covariance of
//! the law. Of a Gaussian law this draws exactly from what the wishes leave open (conditioning by
//! kriging, Journel and Huijbregts 1978).

use deeptree_graph::solve;

use crate::density::Law;
use crate::state::{BRANCHES, CROWN_RADIUS, HEIGHT, State, TRUNK_LENGTH};

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

/// One wish: its name, its value, and where it stands in a state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    pub(crate) what: &'static str,
    pub(crate) value: f32,
    pub(crate) index: usize,
}

impl Wish {
    /// The number of a state as a user tells it.
    pub(crate) fn told(&self, number: f64) -> f32 {
        (if self.index == BRANCHES { libm::exp(number) } else { number }) as f32
    }

    /// The wish as the number of a state.
    pub(crate) fn number(&self) -> f64 {
        let value = f64::from(self.value);
        if self.index == BRANCHES { libm::log(value) } else { value }
    }
}

impl Wishes {
    /// The wishes that were made.
    pub(crate) fn made(&self) -> impl Iterator<Item = Wish> + use<> {
        [
            ("height", HEIGHT, self.height),
            ("crown radius", CROWN_RADIUS, self.crown_radius),
            ("branches", BRANCHES, self.branches),
            ("trunk", TRUNK_LENGTH, self.trunk_length),
        ]
        .into_iter()
        .filter_map(|(what, index, value)| Some(Wish { what, value: value?, index }))
    }

    /// The same wishes, each moved by `move_to`.
    pub(crate) fn map(self, move_to: impl Fn(Wish) -> f32) -> Self {
        let mut moved = self;
        for wish in self.made() {
            let value = Some(move_to(wish));
            match wish.index {
                HEIGHT => moved.height = value,
                CROWN_RADIUS => moved.crown_radius = value,
                BRANCHES => moved.branches = value,
                _ => moved.trunk_length = value,
            }
        }
        moved
    }
}

/// The state moved to meet the wishes, as states of this law are.
pub(crate) fn grant(mut z: State, law: &Law, wishes: &Wishes) -> State {
    let given: Vec<(usize, f64)> = wishes.made().map(|wish| (wish.index, wish.number())).collect();
    if given.is_empty() {
        return z;
    }
    // Σ_gg x = w − z_g, with a trace of ridge for wishes that say the same.
    let covariance = &law.covariance;
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
        *z += shift;
    }
    z = law.clamp(z);
    for (i, wish) in given {
        z[i] = wish;
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::density::{Place, Stock};
    use crate::state::{LONGEST_PATH, state};
    use deeptree_graph::signature::thickness_of;
    use deeptree_graph::{ChildSignature, Quat, TreeTraits};
    use deeptree_infer::Root;

    fn stock(roots: &[Root]) -> Stock<'_> {
        Stock { roots, trend: None, tip_radius: 0.01 }
    }

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
        let law = Law::at(stock(&roots), Place { age: 30.0, gravitropism: 0.0 });
        let wishes = Wishes { height: Some(27.0), ..Wishes::default() };
        let own = state(&roots[3], 0.01);
        let granted = grant(own, &law, &wishes);
        assert_eq!(granted[HEIGHT], 27.0);
        assert!((granted[LONGEST_PATH] - 29.0).abs() < 1e-3);
        // ln(branches) is nearly linear in the height over so short a range.
        let branches = libm::exp(granted[BRANCHES]);
        assert!((branches / (40.0 * 27.0) - 1.0).abs() < 0.02, "{branches}");
        assert!((granted[CROWN_RADIUS] - own[CROWN_RADIUS]).abs() < 0.3);
    }

    #[test]
    fn without_a_wish_the_state_stays_as_it_is() {
        let roots = roots();
        let law = Law::at(stock(&roots), Place { age: 30.0, gravitropism: 0.0 });
        let own = state(&roots[7], 0.01);
        assert_eq!(grant(own, &law, &Wishes::default()), own);
    }
}
