//! The roots of the training trees: where a new tree starts.

use deeptree_graph::{ChildSignature, Quat, TreeTraits};

use crate::weights::{ReadWeightsError, Weights};

/// The root of a training tree, with what all nodes of that tree share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// q, t, l of the first internode; q in the world.
    pub signature: ChildSignature,
    /// a: age in growth cycles.
    pub age: f32,
    /// v: gravitropism.
    pub gravitropism: f32,
    /// What the tree as a whole is like.
    pub traits: TreeTraits,
}

/// Columns of a root: qx, qy, qz, qw, thickness, length, age, gravitropism, and the traits.
pub const ROOT_COLUMNS: usize = 8 + TreeTraits::COUNT;

/// Reads the table `roots.<species>`: [`ROOT_COLUMNS`] numbers a row.
pub(super) fn read(weights: &Weights, species: &str) -> Result<Vec<Root>, ReadWeightsError> {
    let name = format!("roots.{species}");
    let table = weights.table(&name, &[None, Some(ROOT_COLUMNS)])?;
    if table.rows() == 0 {
        return Err(ReadWeightsError::NoRoots { species: species.to_owned() });
    }
    (0..table.rows())
        .map(|i| {
            let row = table.row(i);
            let rotation = Quat::from_xyzw(row[0], row[1], row[2], row[3]);
            check_positive(&name, &row[4..6])?;
            if (rotation.length() - 1.0).abs() > 1e-3 {
                return Err(ReadWeightsError::NotUnit { tensor: name.clone(), row: i });
            }
            let (age, gravitropism) = (row[6], row[7]);
            let is_whole = age.to_bits() == libm::floorf(age).to_bits();
            if !(is_whole && (0.0..=f32::from(u16::MAX)).contains(&age)) {
                return Err(ReadWeightsError::BadAge { tensor: name.clone(), row: i, age });
            }
            let traits = TreeTraits::from_array(std::array::from_fn(|column| row[8 + column]));
            if !traits.is_sound() {
                return Err(ReadWeightsError::BadTraits { tensor: name.clone(), row: i });
            }
            Ok(Root {
                signature: ChildSignature { rotation, thickness: row[4], length: row[5] },
                age,
                gravitropism,
                traits,
            })
        })
        .collect()
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
