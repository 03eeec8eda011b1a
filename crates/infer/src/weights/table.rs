//! An array of numbers with a shape.

use super::ReadWeightsError;

/// An array of numbers with a shape; the last dimension's values lie next to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    shape: Vec<usize>,
    values: Vec<f32>,
}

impl Table {
    /// A table of its values.
    ///
    /// # Errors
    ///
    /// When the shape does not hold exactly that many values.
    pub fn new(shape: Vec<usize>, values: Vec<f32>) -> Result<Self, ReadWeightsError> {
        let len = shape.iter().try_fold(1usize, |len, &size| len.checked_mul(size));
        if len == Some(values.len()) {
            Ok(Self { shape, values })
        } else {
            Err(ReadWeightsError::ValueCount { shape, values: values.len() })
        }
    }

    /// The sizes, outermost first.
    #[must_use]
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// All values.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// How many rows there are: the outermost size, 1 for a single number.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.shape.first().copied().unwrap_or(1)
    }

    /// The values of one row: all that share the outermost index.
    ///
    /// # Panics
    ///
    /// When there is no such row.
    #[must_use]
    pub fn row(&self, index: usize) -> &[f32] {
        assert!(index < self.rows(), "row {index} of a table of {} rows", self.rows());
        let width = self.values.len() / self.rows();
        &self.values[index * width..][..width]
    }
}

/// Refuses numbers that are not above 0.
pub(crate) fn check_positive(tensor: &str, values: &[f32]) -> Result<(), ReadWeightsError> {
    match values.iter().position(|&x| x.is_nan() || x <= 0.0) {
        None => Ok(()),
        Some(index) => Err(ReadWeightsError::NotPositive {
            tensor: tensor.to_owned(),
            index,
            value: values[index],
        }),
    }
}
