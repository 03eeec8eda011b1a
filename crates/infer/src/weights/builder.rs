//! Writing a model file: the training side.

use std::collections::BTreeMap;

use super::{FORMAT, LENGTH_BYTES, ModelKind, ReadWeightsError, Table, Weights};
use super::{bias_name, is_of, weight_name};

/// Collects what goes into a model file.
///
/// The file is laid out here and not by the `safetensors` crate, which writes the metadata in the
/// random order of a hash map: the same model must give the same bytes, since their hash names it.
#[derive(Clone, Debug)]
pub struct WeightsBuilder {
    kind: ModelKind,
    species: Vec<String>,
    tables: BTreeMap<String, Table>,
}

impl WeightsBuilder {
    /// A file without tensors.
    pub fn new<S: Into<String>>(kind: ModelKind, species: impl IntoIterator<Item = S>) -> Self {
        let species = species.into_iter().map(Into::into).collect();
        Self { kind, species, tables: BTreeMap::new() }
    }

    /// A file with all that `weights` hold: to make a model that differs in some tensors.
    #[must_use]
    pub fn from_weights(weights: &Weights) -> Self {
        Self {
            kind: weights.kind,
            species: weights.species.clone(),
            tables: weights.tables.clone(),
        }
    }

    /// Leaves the network `name` out, with all its tensors.
    pub fn without(&mut self, name: &str) -> &mut Self {
        self.tables.retain(|tensor, _| !is_of(name, tensor));
        self
    }

    /// Leaves the tensor `name` out.
    pub fn without_table(&mut self, name: &str) -> &mut Self {
        self.tables.remove(name);
        self
    }

    /// Takes the network `name` of another model, tensor by tensor, in the place of its own.
    pub fn network_of(&mut self, name: &str, other: &Weights) -> &mut Self {
        self.without(name);
        let own = other.tables.iter().filter(|(tensor, _)| is_of(name, tensor));
        self.tables.extend(own.map(|(tensor, table)| (tensor.clone(), table.clone())));
        self
    }

    /// Sets the tensor `name`.
    pub fn table(&mut self, name: impl Into<String>, table: Table) -> &mut Self {
        self.tables.insert(name.into(), table);
        self
    }

    /// Sets one layer of a network.
    ///
    /// # Shapes
    ///
    /// `weight: [inputs, outputs]`, `bias: [outputs]`
    pub fn layer(&mut self, network: &str, layer: u32, weight: Table, bias: Table) -> &mut Self {
        self.table(weight_name(network, layer), weight).table(bias_name(network, layer), bias)
    }

    /// The bytes of the file; the same for the same content.
    ///
    /// # Errors
    ///
    /// When [`Weights::from_bytes`] would not read the file.
    pub fn to_bytes(&self) -> Result<Vec<u8>, ReadWeightsError> {
        let mut header = self.header();
        // Spaces up to a multiple of 8, as the format asks, so that the floats are aligned.
        while !header.len().is_multiple_of(LENGTH_BYTES) {
            header.push(' ');
        }
        let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
        bytes.extend(header.as_bytes());
        for table in self.tables.values() {
            bytes.extend(table.values().iter().flat_map(|v| v.to_le_bytes()));
        }
        Weights::from_bytes(&bytes)?;
        Ok(bytes)
    }

    fn header(&self) -> String {
        let entries =
            [("format", FORMAT), ("kind", self.kind.name()), ("species", &self.species.join(","))]
                .map(|(key, value)| format!("{}:{}", quoted(key), quoted(value)))
                .join(",");
        let mut header = format!("{{\"__metadata__\":{{{entries}}}");
        let mut start = 0;
        for (name, table) in &self.tables {
            let end = start + size_of_val(table.values());
            header += &format!(
                ",{}:{{\"dtype\":\"F32\",\"shape\":{:?},\"data_offsets\":[{start},{end}]}}",
                quoted(name),
                table.shape(),
            );
            start = end;
        }
        header + "}"
    }
}

/// A JSON string.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
