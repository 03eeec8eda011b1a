//! What to expect of a tree in an environment.
//!
//! The grids of an environment become a [`Code`], once for a scene; of that and of a tree's
//! species, age and gravitropism come its expected state and the offset of its crown. What an
//! environment changes is the difference to what is expected in [`Occupancy::EMPTY`]: none, to the
//! last bit, where nothing stands.
//!
//! | tensor | shape | what |
//! |---|---|---|
//! | `outlook.conv1.weight` … `conv3` | `[3, 3, 3, in, out]` by z, y, x | see [`CHANNELS`](outlook::CHANNELS) |
//! | `outlook.conv1.bias` … | `[out]` | |
//! | `outlook.code.weight`, `.bias` | `[512, 8]`, `[8]` | from the maps to the code, linear |
//! | `outlook.<layer>.weight`, `.bias` | | the network that reads tree and code, as any other |
//! | `outlook.mean`, `outlook.deviation` | `[S, 8]` | of the states of the training trees |

mod convolution;

use deeptree_graph::signature::outlook::{self, CHANNELS, CODE, MAPS, OFFSET_SCALE, OUTPUTS};
use deeptree_graph::{Occupancy, TreeTraits, Vec2};

use crate::kernels::SimdPath;
use crate::mlp::{Dense, Mlp, Scratch};
use crate::predictor::Overflow;
use crate::weights::{ReadWeightsError, Table, Weights, check_positive};
use convolution::Convolution;

const NAME: &str = "outlook";
const STATES: usize = TreeTraits::STATES;

/// The network that says what an environment makes of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlook {
    first: Convolution<{ CHANNELS[0] }, { CHANNELS[1] }>,
    second: Convolution<{ CHANNELS[1] }, { CHANNELS[2] }>,
    third: Convolution<{ CHANNELS[2] }, { CHANNELS[3] }>,
    /// From the maps to the code.
    code: Mlp,
    /// From the tree and the code to what is expected.
    tree: Mlp,
    species: usize,
    /// Of the states of the training trees, by species.
    mean: Table,
    deviation: Table,
}

/// An environment as the network sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Code([f32; CODE]);

/// What to expect of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expectation {
    /// Its [`TreeTraits::state`]: mean lengths, and the logarithms of mean counts.
    pub state: [f64; STATES],
    /// Mean x and z of its nodes, in metres.
    pub offset: Vec2,
}

impl Outlook {
    /// The network of a model; `None` of a model that was not trained on environments.
    ///
    /// # Errors
    ///
    /// When a part of it is missing, or has another shape than it must have.
    pub fn read(weights: &Weights) -> Result<Option<Self>, ReadWeightsError> {
        if !weights.has_network(NAME) {
            return Ok(None);
        }
        let species = weights.species().len();
        let per_species = |name| weights.table(name, &[Some(species), Some(STATES)]);
        let (mean, deviation) = (per_species("outlook.mean")?, per_species("outlook.deviation")?);
        check_positive("outlook.deviation", deviation.values())?;
        let network = |source| ReadWeightsError::Network { network: "outlook.code".into(), source };
        let weight = weights.table("outlook.code.weight", &[Some(MAPS), Some(CODE)])?;
        let bias = weights.table("outlook.code.bias", &[Some(CODE)])?;
        let code = Dense::new(MAPS, CODE, weight.values(), bias.values()).map_err(network)?;
        Ok(Some(Self {
            first: Convolution::read(weights, "outlook.conv1")?,
            second: Convolution::read(weights, "outlook.conv2")?,
            third: Convolution::read(weights, "outlook.conv3")?,
            code: Mlp::new(vec![code]).map_err(network)?,
            tree: crate::predictor::network(weights, NAME, outlook::len(species), OUTPUTS)?,
            species,
            mean: mean.clone(),
            deviation: deviation.clone(),
        }))
    }

    /// Weights and biases of all layers.
    #[must_use]
    pub fn weight_count(&self) -> usize {
        let dense = self.code.weight_count() + self.tree.weight_count();
        let (first, second, third) = (&self.first, &self.second, &self.third);
        first.weight_count() + second.weight_count() + third.weight_count() + dense
    }

    /// The code of the environment in which the voxels of `taken` cannot be grown into, and those
    /// of `shading` take light away.
    #[must_use]
    pub fn code(&self, taken: &Occupancy, shading: &Occupancy) -> Code {
        let maps = self.first.maps_of_bits([taken, shading]);
        let maps = self.second.maps(Occupancy::SIDE / 2, &maps);
        let maps = self.third.maps(Occupancy::SIDE / 4, &maps);
        let mut scratch = Scratch::new();
        let code = self.code.forward(SimdPath::detect(), maps.as_flattened(), &mut scratch);
        Code(std::array::from_fn(|i| code[i]))
    }

    /// What to expect of a tree of species number `species` in the environment of this code.
    ///
    /// # Units  age: growth cycles
    ///
    /// # Errors
    ///
    /// When the numbers of the network overflow.
    ///
    /// # Panics
    ///
    /// When the model has no such species.
    pub fn expect(
        &self,
        code: &Code,
        species: usize,
        age: f32,
        gravitropism: f32,
    ) -> Result<Expectation, Overflow> {
        assert!(species < self.species, "species {species} of {}", self.species);
        let mut row = vec![0.0; outlook::tree_len(self.species)];
        outlook::encode(self.species, species, age, gravitropism, &mut row);
        row.extend(code.0);
        let mut scratch = Scratch::new();
        let said = self.tree.forward(SimdPath::detect(), &row, &mut scratch);
        if code.0.iter().chain(said).any(|value| !value.is_finite()) {
            return Err(Overflow { row: 0 });
        }
        let (mean, deviation) = (self.mean.row(species), self.deviation.row(species));
        let state = |i| f64::from(mean[i]) + f64::from(deviation[i]) * f64::from(said[i]);
        let offset = OFFSET_SCALE * Vec2::new(said[STATES], said[STATES + 1]);
        if !offset.is_finite() {
            return Err(Overflow { row: 0 });
        }
        Ok(Expectation { state: std::array::from_fn(state), offset })
    }
}
