//! The model file: safetensors with string metadata.
//!
//! | metadata | value |
//! |---|---|
//! | `format` | `1` |
//! | `kind` | `situated`, `paper` or `joint` |
//! | `species` | names, separated by commas; S of them |
//!
//! | tensor (all `F32`, little-endian) | shape | what |
//! |---|---|---|
//! | `tip_radius` | `[S]` | radius of a twig that bears one tip, in metres |
//! | `roots.<species>` | `[n, 15]` | roots: qx, qy, qz, qw, thickness (m), length (m), age (cycles), gravitropism, the seven traits |
//! | `trend.<species>` | `[n, 10]` | not in all models: the mean state of a tree by age and gravitropism: age (cycles), gravitropism, the state of [`TreeTraits::state`](deeptree_graph::TreeTraits::state) |
//! | `<network>.<layer>.weight` | `[inputs, outputs]` | layer = 0, 1, 2 … |
//! | `<network>.<layer>.bias` | `[outputs]` | |
//! | `<network>.<layer>.gain` | `[S, outputs]` | not of all: how much each hidden unit counts in each species, [`Dense::with_gains`] |
//! | `branchings` | `[S, 32]` | not in all models of kind `situated`: the share of each class of branchings among the nodes of a species |
//! | `kin` | `[S, 127]` | not in all models of kind `situated`: the law by which trees of a species stand among each other, [`Kin::to_row`] |
//! | `buds` | `[S, 2, 65]` | not in all models of kind `situated`: the law of the angle of a lateral in the plane of its bud, by slot, at normal scores, in radians |
//! | any other name | any | tables that a model kind asks for by name |

mod blend;
mod builder;
mod error;
mod table;

use core::{fmt, str::FromStr};
use std::collections::BTreeMap;

use deeptree_graph::signature::situated::Slot;
use deeptree_graph::{Kin, MAX_CHILDREN, Vec2};
use safetensors::{Dtype, SafeTensors, tensor::Metadata};
use sha2::{Digest, Sha256};

pub use blend::BlendError;
pub use builder::WeightsBuilder;
pub use error::ReadWeightsError;
pub use table::Table;
pub(crate) use table::check_positive;

use crate::mlp::{Dense, Mlp};

/// What `format` says of a file that this crate reads.
const FORMAT: &str = "1";

/// Largest file that is read, in bytes: far above any model, far below what would fill a memory.
const MAX_BYTES: usize = 64 << 20;

/// Length of the number before the header, in bytes.
const LENGTH_BYTES: usize = 8;

/// Which networks a model has, and how they are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ModelKind {
    /// A distribution for each factor of the chain rule, drawn from.
    Situated,
    /// As the paper has it: a classifier and a cascade of regressors.
    Paper,
    /// The published classifier and regressors in one network of shared layers.
    Joint,
}

impl ModelKind {
    /// The name in the file: `situated`, `paper` or `joint`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Situated => "situated",
            Self::Paper => "paper",
            Self::Joint => "joint",
        }
    }
}

impl fmt::Display for ModelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for ModelKind {
    type Err = ReadWeightsError;

    fn from_str(name: &str) -> Result<Self, ReadWeightsError> {
        [Self::Situated, Self::Paper, Self::Joint]
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| ReadWeightsError::UnknownKind { found: name.into() })
    }
}

/// A model file in memory, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    kind: ModelKind,
    species: Vec<String>,
    tables: BTreeMap<String, Table>,
    sha256: [u8; 32],
}

impl Weights {
    /// Reads a model file.
    ///
    /// # Errors
    ///
    /// When the file is larger than 64 MiB, is not a safetensors file without gaps or overlaps,
    /// lacks metadata, or holds a tensor that is not `F32` or not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadWeightsError> {
        if bytes.len() > MAX_BYTES {
            return Err(ReadWeightsError::TooLarge { bytes: bytes.len(), limit: MAX_BYTES });
        }
        let (header_len, header) =
            SafeTensors::read_metadata(bytes).map_err(ReadWeightsError::Container)?;
        let format = metadata(&header, "format")?;
        if format != FORMAT {
            return Err(ReadWeightsError::UnknownFormat { found: format.into() });
        }
        Ok(Self {
            kind: metadata(&header, "kind")?.parse()?,
            species: read_species(metadata(&header, "species")?)?,
            tables: read_tables(&header, &bytes[LENGTH_BYTES + header_len..])?,
            sha256: Sha256::digest(bytes).into(),
        })
    }

    /// The kind of the model.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        self.kind
    }

    /// The species the model knows; the index is the species' number in its tables.
    #[must_use]
    pub fn species(&self) -> &[String] {
        &self.species
    }

    /// SHA-256 of the file's bytes: what names this model in a tree stored as its seed.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        self.sha256
    }

    /// The names of all tensors, in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.tables.keys().map(String::as_str)
    }

    /// Is there a tensor of this name?
    #[must_use]
    pub fn contains(&self, name: &str) -> bool {
        self.tables.contains_key(name)
    }

    /// The tensor `name`, whatever its shape; none where there is no such tensor.
    #[must_use]
    pub fn any_table(&self, name: &str) -> Option<&Table> {
        self.tables.get(name)
    }

    /// The tensor `name`, of the expected shape; `None` stands for any size.
    ///
    /// # Errors
    ///
    /// When there is no such tensor, or it has another shape.
    pub fn table(
        &self,
        name: &str,
        expected: &[Option<usize>],
    ) -> Result<&Table, ReadWeightsError> {
        let table = self
            .tables
            .get(name)
            .ok_or_else(|| ReadWeightsError::MissingTensor { tensor: name.into() })?;
        let fits = table.shape().len() == expected.len()
            && table
                .shape()
                .iter()
                .zip(expected)
                .all(|(&have, want)| want.is_none_or(|w| w == have));
        if fits {
            Ok(table)
        } else {
            Err(ReadWeightsError::Shape {
                tensor: name.into(),
                shape: table.shape().to_vec(),
                expected: expected.to_vec(),
            })
        }
    }

    /// Is there a network of this name: a tensor `<name>.…`?
    #[must_use]
    pub fn has_network(&self, name: &str) -> bool {
        self.names().any(|tensor| is_of(name, tensor))
    }

    /// How rotations lie, by species and slot: the tables `rotation_mean` and `rotation_scale` of kind
    /// `situated`.
    ///
    /// # Errors
    ///
    /// When one of them is missing or has another shape, or a deviation of a swing is not above 0.
    pub fn slots(&self) -> Result<Vec<[Slot; MAX_CHILDREN]>, ReadWeightsError> {
        let species = self.species.len();
        let table = |name| self.table(name, &[Some(species), Some(MAX_CHILDREN), Some(3)]);
        let (means, scales) = (table("rotation_mean")?, table("rotation_scale")?);
        for scale in scales.values().chunks_exact(3) {
            check_positive("rotation_scale", &scale[..2])?;
        }
        let slot = |species: usize, slot: usize| {
            let (mean, scale) = (&means.row(species)[3 * slot..], &scales.row(species)[3 * slot..]);
            Slot {
                mean: Vec2::from_slice(mean),
                roll: mean[2],
                scale: Vec2::from_slice(scale),
                roll_scale: scale[2],
            }
        };
        let slots = |species| std::array::from_fn(|number| slot(species, number));
        Ok((0..species).map(slots).collect())
    }

    /// The laws by which trees stand among their kin, by species: the table `kin`, of
    /// [`Kin::COLUMNS`] numbers a row. None where there is no such table.
    ///
    /// # Errors
    ///
    /// When it has another shape, or a row is no law.
    pub fn kin(&self) -> Result<Vec<Kin>, ReadWeightsError> {
        if self.any_table("kin").is_none() {
            return Ok(Vec::new());
        }
        let species = self.species.len();
        let table = self.table("kin", &[Some(species), Some(Kin::COLUMNS)])?;
        let law = |row| Kin::from_row(table.row(row)).ok_or(ReadWeightsError::NotKin { row });
        (0..species).map(law).collect()
    }

    /// The network `name`: its layers `<name>.0`, `<name>.1` … chained.
    ///
    /// # Errors
    ///
    /// When a layer is missing, or the shapes of weights, biases and layers do not fit together.
    pub fn mlp(&self, name: &str) -> Result<Mlp, ReadWeightsError> {
        let last = self.last_layer(name).unwrap_or(0);
        let layers = (0..=last).map(|layer| self.dense(name, layer)).collect::<Result<_, _>>()?;
        Mlp::new(layers)
            .map_err(|source| ReadWeightsError::Network { network: name.into(), source })
    }

    /// The highest layer number of a network, from the names of its tensors.
    fn last_layer(&self, network: &str) -> Option<u32> {
        let layer = |name: &str| {
            let (layer, _part) = name.strip_prefix(network)?.strip_prefix('.')?.split_once('.')?;
            layer.parse().ok()
        };
        self.names().filter_map(layer).max()
    }

    fn dense(&self, network: &str, layer: u32) -> Result<Dense, ReadWeightsError> {
        let weight = self.table(&weight_name(network, layer), &[None, None])?;
        let &[inputs, outputs] = weight.shape() else { unreachable!("two dimensions, as asked") };
        let bias = self.table(&bias_name(network, layer), &[Some(outputs)])?;
        let dense = Dense::new(inputs, outputs, weight.values(), bias.values());
        let gains = gain_name(network, layer);
        let dense = match self.any_table(&gains) {
            Some(_) => {
                let gains = self.table(&gains, &[Some(self.species.len()), Some(outputs)])?;
                dense.and_then(|dense| dense.with_gains(gains.rows(), gains.values()))
            }
            None => dense,
        };
        dense.map_err(|source| ReadWeightsError::Network { network: network.into(), source })
    }
}

/// What the tensors of a layer of a network are called: its weight and its bias.
#[must_use]
pub fn layer_names(network: &str, layer: u32) -> [String; 2] {
    [weight_name(network, layer), bias_name(network, layer)]
}

/// What the tensor of the gains of a hidden layer is called, `[species, outputs]`: see
/// [`Dense::with_gains`].
#[must_use]
pub fn gain_name(network: &str, layer: u32) -> String {
    format!("{network}.{layer}.gain")
}

/// Is the tensor one of the network's?
fn is_of(network: &str, tensor: &str) -> bool {
    tensor.strip_prefix(network).is_some_and(|rest| rest.starts_with('.'))
}

fn weight_name(network: &str, layer: u32) -> String {
    format!("{network}.{layer}.weight")
}

fn bias_name(network: &str, layer: u32) -> String {
    format!("{network}.{layer}.bias")
}

fn metadata<'h>(header: &'h Metadata, key: &'static str) -> Result<&'h str, ReadWeightsError> {
    header
        .metadata()
        .as_ref()
        .and_then(|entries| entries.get(key))
        .map(String::as_str)
        .ok_or(ReadWeightsError::MissingMetadata { key })
}

fn read_species(list: &str) -> Result<Vec<String>, ReadWeightsError> {
    let mut species: Vec<String> = Vec::new();
    for name in list.split(',') {
        if name.is_empty() || name.trim() != name || species.iter().any(|known| known == name) {
            return Err(ReadWeightsError::SpeciesName { name: name.into(), list: list.into() });
        }
        species.push(name.into());
    }
    Ok(species)
}

fn read_tables(
    header: &Metadata,
    data: &[u8],
) -> Result<BTreeMap<String, Table>, ReadWeightsError> {
    let mut tables = BTreeMap::new();
    for name in header.offset_keys() {
        let Some(info) = header.info(&name) else { continue };
        if info.dtype != Dtype::F32 {
            return Err(ReadWeightsError::DataType { tensor: name, found: info.dtype });
        }
        let (start, end) = info.data_offsets;
        let values: Vec<f32> =
            data[start..end].as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        if let Some(index) = values.iter().position(|v| !v.is_finite()) {
            let value = values[index];
            return Err(ReadWeightsError::NotFinite { tensor: name, index, value });
        }
        let table = Table::new(info.shape.clone(), values)?;
        tables.insert(name, table);
    }
    Ok(tables)
}
