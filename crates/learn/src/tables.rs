//! What a model knows besides its networks: laws that are tabulated, not learned.

use deeptree_graph::signature::situated::turn_of;
use deeptree_graph::{BranchGraph, MAX_CHILDREN, Node, Quat, Vec3};
use deeptree_infer::{ROOT_COLUMNS, ReadWeightsError, Table, WeightsBuilder};

use crate::set::Corpus;

/// Quantiles of the edge length that are kept: 0, 1/512 … 1. The law is uniform between two of them,
/// so with few the rarest lengths, at both ends, would come too often.
pub(crate) const QUANTILES: usize = 513;

/// Least deviation of a rotation, in radians: some directions are the same in all trees of a
/// species, and a law must have a width.
const LEAST_DEVIATION: f64 = 1e-4;

/// Times the mean rotation is improved in its tangent space; the spread is a fraction of a turn,
/// so that two suffice.
const MEAN_STEPS: usize = 2;

/// Radius of the thinnest node of each species: a twig that bears one tip.
pub(crate) fn tip_radii(trees: &[BranchGraph], species: &[usize], count: usize) -> Vec<f32> {
    let mut radii = vec![f32::INFINITY; count];
    for (tree, &species) in trees.iter().zip(species) {
        let thinnest = tree.nodes().iter().map(|node| node.thickness);
        radii[species] = thinnest.fold(radii[species], f32::min);
    }
    radii
}

/// Mean and deviation of the rotations in each slot, by species.
#[derive(Clone, Debug)]
pub(crate) struct Rotations {
    /// A slot without children has the identity.
    pub(crate) mean: Vec<[Quat; MAX_CHILDREN]>,
    /// In radians, by component of the rotation vector from the mean.
    pub(crate) scale: Vec<[Vec3; MAX_CHILDREN]>,
}

impl Rotations {
    pub(crate) fn new(corpus: &Corpus<'_>, species: usize) -> Self {
        let mut sums = vec![[[0.0f64; 4]; MAX_CHILDREN]; species];
        each_child(corpus, |species, child| {
            let q = child.rotation.to_array().map(f64::from);
            let sum = &mut sums[species][usize::from(child.slot)];
            let aligned = q.iter().zip(&*sum).map(|(a, b)| a * b).sum::<f64>() >= 0.0;
            let sign = if aligned { 1.0 } else { -1.0 };
            sum.iter_mut().zip(q).for_each(|(sum, q)| *sum += sign * q);
        });
        let mean = sums.iter().map(|slots| slots.map(normalized)).collect();
        let mut rotations = Self { mean, scale: vec![[Vec3::ONE; MAX_CHILDREN]; species] };
        for _ in 0..MEAN_STEPS {
            rotations.improve_mean(corpus);
        }
        rotations.set_scale(corpus);
        rotations
    }

    /// The turn of a child, in deviations from the mean of its slot.
    pub(crate) fn turn(&self, species: usize, child: &Node) -> Vec3 {
        let slot = usize::from(child.slot);
        turn_of(child.rotation, self.mean[species][slot], self.scale[species][slot])
    }

    fn improve_mean(&mut self, corpus: &Corpus<'_>) {
        let moments = self.moments(corpus);
        for (mean, moments) in self.mean.iter_mut().zip(moments) {
            for (mean, moments) in mean.iter_mut().zip(moments) {
                let step = Quat::from_scaled_axis(moments.mean());
                *mean = (*mean * step).normalize();
            }
        }
    }

    fn set_scale(&mut self, corpus: &Corpus<'_>) {
        self.scale =
            self.moments(corpus).into_iter().map(|slots| slots.map(|m| m.deviation())).collect();
    }

    /// Moments of the rotation vectors from the means.
    fn moments(&self, corpus: &Corpus<'_>) -> Vec<[Moments; MAX_CHILDREN]> {
        let mut moments = vec![[Moments::default(); MAX_CHILDREN]; self.mean.len()];
        each_child(corpus, |species, child| {
            let slot = usize::from(child.slot);
            let vector = turn_of(child.rotation, self.mean[species][slot], Vec3::ONE);
            moments[species][slot].add(vector);
        });
        moments
    }
}

/// Count, sum and sum of squares, by component.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    count: f64,
    sum: [f64; 3],
    squares: [f64; 3],
}

impl Moments {
    fn add(&mut self, vector: Vec3) {
        self.count += 1.0;
        for (i, x) in vector.to_array().into_iter().enumerate() {
            self.sum[i] += f64::from(x);
            self.squares[i] += f64::from(x) * f64::from(x);
        }
    }

    fn mean(&self) -> Vec3 {
        Vec3::from_array(self.sum.map(|sum| (sum / self.count.max(1.0)) as f32))
    }

    /// 1 where there is nothing to measure.
    fn deviation(&self) -> Vec3 {
        if self.count == 0.0 {
            return Vec3::ONE;
        }
        Vec3::from_array(std::array::from_fn(|i| {
            let mean = self.sum[i] / self.count;
            let variance = (self.squares[i] / self.count - mean * mean).max(0.0);
            variance.sqrt().max(LEAST_DEVIATION) as f32
        }))
    }
}

fn normalized(sum: [f64; 4]) -> Quat {
    let norm = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 0.0 { Quat::from_array(sum.map(|x| (x / norm) as f32)) } else { Quat::IDENTITY }
}

/// Calls `visit` with the species and node of everything but roots.
fn each_child(corpus: &Corpus<'_>, mut visit: impl FnMut(usize, &Node)) {
    for (tree, conditions) in corpus.trees.iter().zip(&corpus.conditions) {
        tree.nodes()[1..].iter().for_each(|child| visit(conditions.species, child));
    }
}

/// [`QUANTILES`] quantiles of the edge length of each species, roots left out, in metres.
pub(crate) fn length_quantiles(corpus: &Corpus<'_>, species: usize) -> Vec<f32> {
    let mut lengths = vec![Vec::new(); species];
    each_child(corpus, |species, child| lengths[species].push(child.length));
    lengths.iter_mut().flat_map(|lengths| quantiles(lengths)).collect()
}

/// Linear interpolation between order statistics; zeros where there are none.
fn quantiles(values: &mut [f32]) -> [f32; QUANTILES] {
    values.sort_unstable_by(f32::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return [0.0; QUANTILES] };
    std::array::from_fn(|i| {
        let place = (i * last) as f64 / (QUANTILES - 1) as f64;
        let (low, part) = (place as usize, place.fract());
        let (a, b) = (f64::from(values[low]), f64::from(values[(low + 1).min(last)]));
        (a + (b - a) * part) as f32
    })
}

/// Writes the tables that both kinds have: the radii of tips, and the root of each training tree.
pub(crate) fn write_common(
    model: &mut WeightsBuilder,
    corpus: &Corpus<'_>,
    species: &[String],
    tip_radius: &[f32],
) -> Result<(), ReadWeightsError> {
    model.table("tip_radius", Table::new(vec![species.len()], tip_radius.to_vec())?);
    for (number, name) in species.iter().enumerate() {
        let trees = corpus.trees.iter().zip(&corpus.conditions);
        let trees = trees.filter(|(_, conditions)| conditions.species == number);
        let roots: Vec<f32> = trees
            .flat_map(|(tree, conditions)| {
                let (root, [x, y, z, w]) = (tree.root(), tree.root().rotation.to_array());
                let shared = [conditions.age, conditions.gravitropism];
                let own = [x, y, z, w, root.thickness, root.length, shared[0], shared[1]];
                own.into_iter().chain(conditions.traits.to_array())
            })
            .collect();
        model.table(
            format!("roots.{name}"),
            Table::new(vec![roots.len() / ROOT_COLUMNS, ROOT_COLUMNS], roots)?,
        );
    }
    Ok(())
}

/// Writes the tables of kind `situated`: laws of lengths, and means and deviations of rotations.
pub(crate) fn write_situated(
    model: &mut WeightsBuilder,
    corpus: &Corpus<'_>,
    rotations: &Rotations,
) -> Result<(), ReadWeightsError> {
    let species = rotations.mean.len();
    let lengths = length_quantiles(corpus, species);
    model.table("length_quantiles", Table::new(vec![species, QUANTILES], lengths)?);
    let mean = rotations.mean.iter().flatten().flat_map(|q| q.to_array()).collect();
    model.table("rotation_mean", Table::new(vec![species, MAX_CHILDREN, 4], mean)?);
    let scale = rotations.scale.iter().flatten().flat_map(|s| s.to_array()).collect();
    model.table("rotation_scale", Table::new(vec![species, MAX_CHILDREN, 3], scale)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_evenly_spaced_values_are_evenly_spaced() {
        let mut values: Vec<f32> = (0..=5120).rev().map(|i| i as f32 / 5120.0).collect();
        for (i, q) in quantiles(&mut values).into_iter().enumerate() {
            assert!((q - i as f32 / 512.0).abs() < 1e-6);
        }
        assert_eq!(quantiles(&mut [2.5]), [2.5; QUANTILES]);
        assert_eq!(quantiles(&mut []), [0.0; QUANTILES]);
    }
}
