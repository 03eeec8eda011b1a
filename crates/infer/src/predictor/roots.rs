//! The roots of the training trees: where a new tree starts.

use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{ChildSignature, Kin, Quat, TreeTraits};

use crate::weights::{ReadWeightsError, Weights, check_positive};

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

impl Root {
    /// Of some roots, that of the tree whose crown is most nearly so wide for its height: the radius
    /// of the crown over the height.
    #[must_use]
    pub fn of_shape(roots: &[Self], width: f32) -> Option<&Self> {
        let off = |root: &&Self| (root.traits.crown_radius / root.traits.height - width).abs();
        roots.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// What all nodes of the tree that grows from it share, as one of species number `species`, whose
    /// twigs of one tip have the radius `tip_radius`, in metres, among its kin, with this habit in
    /// deviations.
    #[must_use]
    pub fn conditions(
        &self,
        species: usize,
        tip_radius: f32,
        kin: Option<&Kin>,
        habit: [f32; Kin::HABITS],
    ) -> TreeConditions {
        let root_tips = tip_count(self.signature.thickness, tip_radius);
        let place = (self.age, self.gravitropism);
        let standing = kin.map(|kin| kin.standing_of(place, self.traits.state(root_tips), habit));
        TreeConditions {
            age: self.age,
            gravitropism: self.gravitropism,
            species,
            tip_radius,
            root_tips,
            traits: self.traits,
            standing: standing.unwrap_or_default(),
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_shape_is_that_of_the_tree_nearest_to_it() {
        let root = |crown_radius, height| {
            let traits = TreeTraits {
                crown_radius,
                height,
                ..TreeTraits::from_array([1.0; TreeTraits::COUNT])
            };
            let signature =
                ChildSignature { rotation: Quat::IDENTITY, thickness: 0.03, length: 1.0 };
            Root { signature, age: 30.0, gravitropism: -0.1, traits }
        };
        let roots = [root(2.0, 10.0), root(10.0, 20.0), root(30.0, 20.0)];
        let of = |width| Root::of_shape(&roots, width).copied();
        assert_eq!([0.0, 0.4, 9.0].map(of), [0, 1, 2].map(|i| Some(roots[i])));
        assert_eq!(Root::of_shape(&[], 1.0), None);
        let conditions = roots[0].conditions(4, 0.01, None, [0.0; Kin::HABITS]);
        // (0.03 / 0.01)² tips.
        assert_eq!((conditions.species, conditions.root_tips), (4, 9));
    }
}
