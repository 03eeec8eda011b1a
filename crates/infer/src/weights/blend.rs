//! A species between species: the weights of a model of one species, folded out of those of several.
//!
//! A network reads its species as a one-hot; the first layer adds up rows of weights, one of which
//! the one-hot picks. Reading the parts of a blend instead of a one-hot adds up those rows in these
//! parts, so that a blend is a model of one species whose row is the weighted sum. Tables have a row
//! a species, and are blended likewise: of a law told by its quantiles this is the barycentre of
//! the laws (Agueh and Carlier 2011). Gains have a row a species, too; so have the laws by which trees stand
//! among their kin, whose means and triangles are averaged, and shares of branchings, which are bounded after that. Roots are taken from all the species in their parts, each
//! scaled so that the mean of its species becomes the weighted mean of all.
//!
//! One law does not blend: an apical shoot is exactly aligned where it swings about the level axis, or,
//! in species whose shoots have an angle of their own, where it does not swing at all. Between the two
//! nothing is.
//!
//! It is an interpolation of what the networks have learned; nothing of the kind was ever grown.

use std::collections::BTreeMap;

use deeptree_graph::signature::situated::ROTATION_COMPONENTS;
use deeptree_graph::{Share, TreeTraits};

use super::{ModelKind, ReadWeightsError, Table, Weights};
use crate::predictor::ROOT_COLUMNS;

/// Columns of a root in its table.
const THICKNESS: usize = 4;
const LENGTH: usize = 5;
const AGE: usize = 6;
const GRAVITROPISM: usize = 7;
const TRAITS: usize = ROOT_COLUMNS - TreeTraits::COUNT;

/// What a logit loses that shall be that of nothing.
const NEVER: f32 = 1e3;

/// Why species cannot be blended.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum BlendError {
    #[error("the blend has no species; name at least one")]
    Empty,
    #[error("the blend has species {species} of a model that has {known} only")]
    UnknownSpecies { species: u8, known: usize },
    #[error("the blend has the species {name} twice; name it once")]
    Twice { name: String },
    #[error("the weight of the species {name} is 0; it must be above")]
    NoWeight { name: String },
    #[error("models of kind `{kind}` cannot be blended; take one of kind `situated`")]
    Kind { kind: ModelKind },
    #[error(transparent)]
    Weights(#[from] ReadWeightsError),
}

/// Takes the aligned law of apical swings out of their mixture: its logit sinks below all others.
fn never_aligned(tables: &mut BTreeMap<String, Table>) {
    let layers = tables.keys().filter(|name| is_bias_of_apical_swings(name));
    // Ten layers would sort otherwise; there are three.
    let Some(last) = layers.max().cloned() else { return };
    let Some(bias) = tables.get(&last) else { return };
    let mut values = bias.values().to_vec();
    if let Some(aligned) = values.get_mut(ROTATION_COMPONENTS) {
        *aligned -= NEVER;
    }
    if let Ok(bias) = Table::new(bias.shape().to_vec(), values) {
        tables.insert(last, bias);
    }
}

fn is_bias_of_apical_swings(tensor: &str) -> bool {
    tensor.starts_with("rotation1.") && tensor.ends_with(".bias")
}

/// A species of a blend.
struct Part<'a> {
    number: usize,
    /// Of all parts together 1.
    weight: f64,
    roots: &'a Table,
}

impl Weights {
    /// The model of the one species that lies between those of `shares`. Its hash is that of this
    /// model, which it was made of.
    ///
    /// # Errors
    ///
    /// When the shares are not those of species of this model, or it is of another kind than
    /// `situated`.
    pub fn blend(&self, shares: &[Share]) -> Result<Self, BlendError> {
        if self.kind != ModelKind::Situated {
            return Err(BlendError::Kind { kind: self.kind });
        }
        let parts = self.parts(shares)?;
        let name = self.blend_name(shares);
        let mut tables = BTreeMap::new();
        for (tensor, table) in &self.tables {
            let is_layer = tensor.ends_with(".weight") || tensor.ends_with(".bias");
            // Nothing that hears of points reads a species.
            let reads_species = !tensor.starts_with("points.");
            let blended = if tensor.ends_with(".0.weight") && reads_species {
                self.first_layer(tensor, table, &parts)?
            } else if tensor.starts_with("roots.") || tensor.starts_with("trend.") {
                continue;
            } else if is_layer || table.rows() != self.species.len() {
                table.clone()
            } else {
                let shape = [&[1], &table.shape()[1..]].concat();
                Table::new(shape, weighted(&parts, |part| table.row(part.number)))?
            };
            tables.insert(tensor.clone(), blended);
        }
        if self.align_otherwise(&parts) {
            never_aligned(&mut tables);
        }
        let tip_radius = self.table("tip_radius", &[Some(self.species.len())])?.values();
        tables.insert(format!("roots.{name}"), blend_roots(&parts, tip_radius)?);
        // Of several, each with its own ages, the roots alone say how the blend changes.
        if let [part] = &parts[..]
            && let Some(trend) = self.any_table(&format!("trend.{}", self.species[part.number]))
        {
            tables.insert(format!("trend.{name}"), trend.clone());
        }
        Ok(Self { kind: self.kind, species: vec![name], tables, sha256: self.sha256 })
    }

    /// Are apical shoots aligned in one way in some of these species, and in another in the others?
    fn align_otherwise(&self, parts: &[Part<'_>]) -> bool {
        let means = self.any_table("rotation_mean");
        let Some(means) = means.filter(|table| table.rows() == self.species.len()) else {
            return false;
        };
        // Of the first slot; the mean swing stands before the roll.
        let has_mean = |part: &Part<'_>| !means.row(part.number).starts_with(&[0.0; 2]);
        parts.iter().any(has_mean) && !parts.iter().all(has_mean)
    }

    /// What a blend is called: `oak:0.7,willow:0.3`.
    #[must_use]
    pub fn blend_name(&self, shares: &[Share]) -> String {
        let sum: f64 = shares.iter().map(|share| f64::from(share.weight)).sum();
        let name = |share: &Share| {
            let part = libm::round(f64::from(share.weight) / sum * 1e4) / 1e4;
            let species = self.species.get(usize::from(share.species)).map_or("?", String::as_str);
            format!("{species}:{part}")
        };
        shares.iter().map(name).collect::<Vec<_>>().join(",")
    }

    fn parts(&self, shares: &[Share]) -> Result<Vec<Part<'_>>, BlendError> {
        if shares.is_empty() {
            return Err(BlendError::Empty);
        }
        let known = self.species.len();
        let sum: f64 = shares.iter().map(|share| f64::from(share.weight)).sum();
        let mut parts: Vec<Part<'_>> = Vec::new();
        for share in shares {
            let number = usize::from(share.species);
            let name = self.species.get(number);
            let name =
                name.ok_or(BlendError::UnknownSpecies { species: share.species, known })?.clone();
            if share.weight == 0 {
                return Err(BlendError::NoWeight { name });
            }
            if parts.iter().any(|part| part.number == number) {
                return Err(BlendError::Twice { name });
            }
            let roots = self.table(&format!("roots.{name}"), &[None, Some(ROOT_COLUMNS)])?;
            if roots.rows() == 0 {
                return Err(ReadWeightsError::NoRoots { species: name }.into());
            }
            parts.push(Part { number, weight: f64::from(share.weight) / sum, roots });
        }
        Ok(parts)
    }

    /// The weights of a first layer, whose first inputs are the one-hot of the species.
    fn first_layer(
        &self,
        tensor: &str,
        table: &Table,
        parts: &[Part<'_>],
    ) -> Result<Table, ReadWeightsError> {
        let species = self.species.len();
        let &[inputs, outputs] = table.shape() else { return Ok(table.clone()) };
        if inputs < species {
            let (tensor, shape) = (tensor.to_owned(), table.shape().to_vec());
            return Err(ReadWeightsError::Shape { tensor, shape, expected: vec![None, None] });
        }
        let mut values = weighted(parts, |part| table.row(part.number));
        values.extend(&table.values()[species * outputs..]);
        Table::new(vec![1 + inputs - species, outputs], values)
    }
}

/// The weighted sum of a row of each part.
fn weighted<'a>(parts: &[Part<'_>], row: impl Fn(&Part<'_>) -> &'a [f32]) -> Vec<f32> {
    let value =
        |i: usize| parts.iter().map(|p| p.weight * f64::from(row(p)[i])).sum::<f64>() as f32;
    (0..parts.first().map_or(0, |part| row(part).len())).map(value).collect()
}

/// What is known of the roots of a species at its own age and gravitropism.
struct Own {
    age: f64,
    gravitropism: f64,
    /// Tips, length and traits.
    means: [f64; 2 + TreeTraits::COUNT],
}

/// Tips over the square of a tip's radius, length and traits of a root.
fn sizes(row: &[f32], tip_radius: f32) -> [f64; 2 + TreeTraits::COUNT] {
    let ratio = f64::from(row[THICKNESS]) / f64::from(tip_radius);
    std::array::from_fn(|i| match i {
        0 => ratio * ratio,
        1 => f64::from(row[LENGTH]),
        _ => f64::from(row[TRAITS + i - 2]),
    })
}

impl Own {
    /// Where most of the roots are; of several places the one that comes first.
    fn of(roots: &Table, tip_radius: f32) -> Self {
        let place = |i: usize| [roots.row(i)[AGE], roots.row(i)[GRAVITROPISM]].map(f32::to_bits);
        let mut order: Vec<usize> = (0..roots.rows()).collect();
        order.sort_by_key(|&i| (place(i), i));
        let alike = order.chunk_by(|&a, &b| place(a) == place(b));
        let most = alike.max_by_key(|group| (group.len(), usize::MAX - group[0])).unwrap_or(&[]);
        let row = roots.row(most.first().copied().unwrap_or(0));
        let mut means = [0.0; 2 + TreeTraits::COUNT];
        for &i in most {
            let sizes = sizes(roots.row(i), tip_radius);
            means.iter_mut().zip(sizes).for_each(|(mean, x)| *mean += x / most.len() as f64);
        }
        Self { age: f64::from(row[AGE]), gravitropism: f64::from(row[GRAVITROPISM]), means }
    }
}

/// The roots of all parts, as many of each as its weight says.
fn blend_roots(parts: &[Part<'_>], tip_radius: &[f32]) -> Result<Table, ReadWeightsError> {
    let own: Vec<Own> =
        parts.iter().map(|part| Own::of(part.roots, tip_radius[part.number])).collect();
    let mean = |of: &dyn Fn(&Own) -> f64| -> f64 {
        parts.iter().zip(&own).map(|(part, own)| part.weight * of(own)).sum()
    };
    let (age, gravitropism) = (mean(&|own| own.age), mean(&|own| own.gravitropism));
    let means: [f64; 2 + TreeTraits::COUNT] = std::array::from_fn(|i| mean(&|own| own.means[i]));
    let blended_tip: f64 =
        parts.iter().map(|p| p.weight * f64::from(tip_radius[p.number])).sum::<f64>();
    // As many as there are, without one twice.
    let most = |part: &Part<'_>| part.roots.rows() as f64 / part.weight;
    let total = parts.iter().map(most).fold(f64::INFINITY, f64::min);
    let mut rows = Vec::new();
    for (part, own) in parts.iter().zip(&own) {
        let factors: [f64; 2 + TreeTraits::COUNT] =
            std::array::from_fn(|i| means[i] / own.means[i]);
        let tip = blended_tip / f64::from(tip_radius[part.number]);
        let count = (libm::round(total * part.weight) as usize).clamp(1, part.roots.rows());
        for k in 0..count {
            let mut row = part.roots.row(k * part.roots.rows() / count).to_vec();
            let scale = |x: &mut f32, factor: f64| *x = (f64::from(*x) * factor) as f32;
            scale(&mut row[THICKNESS], tip * libm::sqrt(factors[0]));
            scale(&mut row[LENGTH], factors[1]);
            for (x, factor) in row[TRAITS..].iter_mut().zip(&factors[2..]) {
                scale(x, *factor);
            }
            row[AGE] = libm::round(f64::from(row[AGE]) + age - own.age).max(0.0) as f32;
            row[GRAVITROPISM] =
                (gravitropism + (f64::from(row[GRAVITROPISM]) - own.gravitropism)) as f32;
            rows.extend(row);
        }
    }
    Table::new(vec![rows.len() / ROOT_COLUMNS, ROOT_COLUMNS], rows)
}
