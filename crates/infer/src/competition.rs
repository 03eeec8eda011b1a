//! What the trees around make of a tree.
//!
//! The network reads a tree and the indices of the others around it, as
//! [`deeptree_graph::signature::competition`] tells them. What they change is the difference to what
//! it says without them: none, to the last bit, where no other is near.
//!
//! | tensor | shape | what |
//! |---|---|---|
//! | `competition.<layer>.weight`, `.bias` | | a network as any other; it gives states |

use deeptree_graph::signature::competition::{self, Contender, OUTPUTS};
use deeptree_graph::{TreeTraits, Vec2};

use crate::kernels::SimdPath;
use crate::mlp::{Mlp, Scratch};
use crate::predictor::Overflow;
use crate::weights::{ReadWeightsError, Weights};

const NAME: &str = "competition";

/// The network that says what the trees around make of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Competition {
    network: Mlp,
    species: usize,
}

impl Competition {
    /// The network of a model; `None` of a model that was not trained on stands.
    ///
    /// # Errors
    ///
    /// When a part of it is missing, or has another shape than it must have.
    pub fn read(weights: &Weights) -> Result<Option<Self>, ReadWeightsError> {
        if !weights.has_network(NAME) {
            return Ok(None);
        }
        let species = weights.species().len();
        let network = crate::predictor::network(weights, NAME, competition::len(species), OUTPUTS)?;
        Ok(Some(Self { network, species }))
    }

    /// Weights and biases of all layers.
    #[must_use]
    pub fn weight_count(&self) -> usize {
        self.network.weight_count()
    }

    /// By how much the others move the [`TreeTraits::state`] of a tree. They are told with the
    /// places of their feet as seen from its own, x and z in metres.
    ///
    /// # Errors
    ///
    /// When the numbers of the network overflow.
    ///
    /// # Panics
    ///
    /// When the model has no such species.
    pub fn shift(
        &self,
        own: &Contender,
        others: &[(Vec2, Contender)],
    ) -> Result<[f64; TreeTraits::STATES], Overflow> {
        assert!(own.species < self.species, "species {} of {}", own.species, self.species);
        let mut scratch = Scratch::new();
        let mut say = |others: &[(Vec2, Contender)]| {
            let mut row = vec![0.0; competition::len(self.species)];
            competition::encode(self.species, own, others, &mut row);
            let said = self.network.forward(SimdPath::detect(), &row, &mut scratch);
            let is_sound = said.iter().all(|value| value.is_finite());
            let said = || std::array::from_fn(|i| f64::from(said[i]));
            is_sound.then(said).ok_or(Overflow { row: 0 })
        };
        let (here, open): ([f64; OUTPUTS], [f64; OUTPUTS]) = (say(others)?, say(&[])?);
        Ok(std::array::from_fn(|i| here[i] - open[i]))
    }
}
