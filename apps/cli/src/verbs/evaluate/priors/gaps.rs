//! Which ages and gravitropisms the training of a model has left out, as the roots in its file tell.
//!
//! A corpus of priors draws both for each tree, so that what no root of any species has was held
//! out. A species' own place says nothing of the others: it is left out where species are looked at
//! together.

use deeptree_infer::{Model, Predictor, Root};

/// Gravitropisms nearer than this to that of a training tree count as seen.
const NEAR: f32 = 0.03;

/// What the training trees of a model had.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    species: Vec<String>,
    /// Each species' own age and gravitropism: those of most of its roots.
    own: Vec<(f32, f32)>,
    /// Of the roots elsewhere, of all species.
    ages: Vec<f32>,
    gravitropisms: Vec<f32>,
}

impl Seen {
    pub(super) fn of(model: &Model) -> Self {
        let roots: Vec<&[Root]> =
            (0..model.species().len()).map(|species| model.roots(species)).collect();
        Self::new(model.species().to_vec(), &roots)
    }

    fn new(species: Vec<String>, roots: &[&[Root]]) -> Self {
        let own: Vec<(f32, f32)> = roots.iter().map(|roots| own(roots)).collect();
        let (mut ages, mut gravitropisms) = (Vec::new(), Vec::new());
        for (roots, own) in roots.iter().zip(&own) {
            for root in roots.iter().filter(|root| place(root) != *own) {
                ages.push(root.age);
                gravitropisms.push(root.gravitropism);
            }
        }
        ages.sort_by(f32::total_cmp);
        ages.dedup();
        gravitropisms.sort_by(f32::total_cmp);
        Self { species, own, ages, gravitropisms }
    }

    /// Was there a training tree of this age, and one of nearly this gravitropism?
    pub(super) fn has(&self, species: &str, age: f32, gravitropism: f32) -> bool {
        let number = self.species.iter().position(|name| name == species);
        let own = number.map(|number| self.own[number]);
        let near = |a: f32, b: f32| (a - b).abs() <= NEAR;
        let has_age = self.ages.iter().chain(own.iter().map(|(age, _)| age));
        let has_gravitropism = self.gravitropisms.iter().chain(own.iter().map(|(_, v)| v));
        has_age.into_iter().any(|&seen| near(seen, age))
            && has_gravitropism.into_iter().any(|&seen| near(seen, gravitropism))
    }

    /// Runs of ages without a training tree, first and last, between those that have.
    pub(super) fn age_gaps(&self) -> Vec<(f32, f32)> {
        let between = |pair: &[f32]| (pair[0] + 1.0, pair[1] - 1.0);
        self.ages.windows(2).map(between).filter(|(first, last)| first <= last).collect()
    }

    /// Ranges of gravitropism without a training tree, between those that have.
    pub(super) fn gravitropism_gaps(&self) -> Vec<(f32, f32)> {
        let pairs = self.gravitropisms.windows(2).map(|pair| (pair[0], pair[1]));
        pairs.filter(|(low, high)| high - low > 2.0 * NEAR).collect()
    }
}

fn place(root: &Root) -> (f32, f32) {
    (root.age, root.gravitropism)
}

/// Where most of the roots are.
fn own(roots: &[Root]) -> (f32, f32) {
    let count = |root: &&Root| roots.iter().filter(|other| place(other) == place(root)).count();
    roots.iter().max_by_key(count).map_or((0.0, 0.0), place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{ChildSignature, Quat, TreeTraits};

    fn root(age: f32, gravitropism: f32) -> Root {
        let signature = ChildSignature { rotation: Quat::IDENTITY, thickness: 0.1, length: 1.0 };
        let traits = TreeTraits::from_array([1.0; TreeTraits::COUNT]);
        Root { signature, age, gravitropism, traits }
    }

    #[test]
    fn gaps_are_what_no_tree_of_the_priors_has() {
        // Ages 10 to 20 without 13, 16 and 17; gravitropism −0.3 to 0.3 without −0.1 to 0.1.
        let ages = [10.0, 11.0, 12.0, 14.0, 15.0, 18.0, 19.0, 20.0];
        let scattered = (0..80).map(|i| {
            let v = 0.1 + 0.2 * (i / 2) as f32 / 39.0;
            root(ages[i % 8], if i % 2 == 0 { v } else { -v })
        });
        let oaks: Vec<Root> = (0..50).map(|_| root(13.0, 0.0)).chain(scattered).collect();
        let pines: Vec<Root> = (0..9).map(|_| root(16.0, 0.05)).collect();
        let names = vec!["oak".to_owned(), "pine".to_owned()];
        let seen = Seen::new(names, &[&oaks, &pines]);
        assert_eq!(seen.age_gaps(), [(13.0, 13.0), (16.0, 17.0)]);
        let [(low, high)] = seen.gravitropism_gaps()[..] else {
            panic!("{:?}", seen.gravitropism_gaps())
        };
        assert_eq!((low, high), (-0.1, 0.1));
        // Own places count for their species only.
        assert!(seen.has("oak", 13.0, 0.2) && !seen.has("pine", 13.0, 0.2));
        assert!(seen.has("pine", 16.0, 0.2) && !seen.has("oak", 16.0, 0.2));
        assert!(seen.has("oak", 12.0, 0.0) && !seen.has("oak", 17.0, 0.0));
        assert!(seen.has("pine", 12.0, -0.12) && !seen.has("pine", 12.0, -0.04));
    }
}
