//! Why bytes are not a model.

use safetensors::{Dtype, SafeTensorError};

use crate::mlp::MlpError;

/// Why bytes are not a model file, or a model lacks what was asked of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadWeightsError {
    #[error("the model has {bytes} bytes; at most {limit} are read, so this is no DeepTree model")]
    TooLarge { bytes: usize, limit: usize },
    #[error("this is no safetensors file, or it is damaged; get or train the model again")]
    Container(#[source] SafeTensorError),
    #[error(
        "the metadata lack `{key}`, so this is no DeepTree model; one has `format`, `kind` and \
         `species`"
    )]
    MissingMetadata { key: &'static str },
    #[error("the model has format `{found}`, this program reads format `1`; use another version")]
    UnknownFormat { found: String },
    #[error("no kind of model is called `{found}`; there are `situated`, `paper` and `joint`")]
    UnknownKind { found: String },
    #[error(
        "`{name}` cannot be a species in the list `{list}`; names are separated by commas without \
         blanks, none empty, each once"
    )]
    SpeciesName { name: String, list: String },
    #[error("tensor `{tensor}` holds {found}; convert it to F32")]
    DataType { tensor: String, found: Dtype },
    #[error(
        "tensor `{tensor}`: value {index} is {value}; every number of a model must be finite, so \
         train it again"
    )]
    NotFinite { tensor: String, index: usize, value: f32 },
    #[error("{values} values do not fill a table of shape {shape:?}")]
    ValueCount { shape: Vec<usize>, values: usize },
    #[error("the model has no tensor `{tensor}`; it is incomplete or of another kind")]
    MissingTensor { tensor: String },
    #[error("tensor `{tensor}` has shape {shape:?}, expected {}", Expected(expected))]
    Shape { tensor: String, shape: Vec<usize>, expected: Vec<Option<usize>> },
    #[error("tensor `{tensor}`: value {index} is {value}; it must be above 0")]
    NotPositive { tensor: String, index: usize, value: f32 },
    #[error("tensor `{tensor}`: row {row} has no unit quaternion where one belongs")]
    NotUnit { tensor: String, row: usize },
    #[error("tensor `{tensor}`: row {row} has age {age}; it must be a whole number up to 65535")]
    BadAge { tensor: String, row: usize, age: f32 },
    #[error("tensor `{tensor}`: row {row} has traits that no tree has")]
    BadTraits { tensor: String, row: usize },
    #[error(
        "tensor `{tensor}`: row {row} does not fit a grid of consecutive ages and rising \
         gravitropisms, or has numbers that no mean of trees has; fit it again (train --only trend)"
    )]
    NotATrend { tensor: String, row: usize },
    #[error(
        "tensor `kin`: row {row} has a number beyond 1e9, or a deviation below 0; train the model again"
    )]
    NotKin { row: usize },
    #[error("the model has no root of a `{species}` to start a tree from; train it again")]
    NoRoots { species: String },
    #[error(
        "network `{network}` reads {inputs} features and gives {outputs} values; this version \
         needs {expected_inputs} and {expected_outputs}: use the version it was trained with"
    )]
    NetworkWidth {
        network: String,
        inputs: usize,
        outputs: usize,
        expected_inputs: usize,
        expected_outputs: usize,
    },
    #[error("network `{network}` does not fit together; export it again")]
    Network {
        network: String,
        #[source]
        source: MlpError,
    },
}

/// Writes an expected shape, with `_` for any size.
struct Expected<'a>(&'a [Option<usize>]);

impl core::fmt::Display for Expected<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("[")?;
        for (i, size) in self.0.iter().enumerate() {
            f.write_str(if i == 0 { "" } else { ", " })?;
            match size {
                Some(size) => write!(f, "{size}")?,
                None => f.write_str("_")?,
            }
        }
        f.write_str("]")
    }
}
