//! Growth by network: Algorithm 1 of the paper over whole frontiers.
//!
//! A tree starts from the root of a training tree. All nodes that have no children yet form the
//! frontier; the model draws the branchlets of a whole frontier at once, and the new nodes are the
//! next frontier, until every branch has ended by itself or the node budget is spent.

#![forbid(unsafe_code)]

mod wish;

use deeptree_graph::signature::{GROWTH_SPACE, TreeConditions, tip_count};
use deeptree_graph::{BranchGraph, Lineage, Purpose, Seed, TreeInfo, Vec3};
use deeptree_infer::{Active, Branchlet, Predictor, Root, Workspace};

use wish::Wish;
pub use wish::Wishes;

/// Nodes a tree may have unless another budget is asked for.
pub const DEFAULT_BUDGET: usize = 50_000;

/// Nodes of a frontier that go through the networks together. Any number gives the same tree.
pub const DEFAULT_BATCH: usize = 512;

/// What to grow.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Name of the species.
    pub species: String,
    /// The seed of the tree.
    pub seed: Seed,
    /// a: age in growth cycles; as the training roots have it when none is given.
    pub age: Option<u16>,
    /// v: gravitropism; likewise.
    pub gravitropism: Option<f32>,
    /// What is asked of the tree as a whole.
    pub wishes: Wishes,
}

impl Request {
    /// The tree of a species and seed, nothing else asked.
    #[must_use]
    pub fn new(species: &str, seed: Seed) -> Self {
        let species = species.to_owned();
        Self { species, seed, age: None, gravitropism: None, wishes: Wishes::default() }
    }
}

/// Bounds of the work; they do not change the tree, except that the budget can cut it short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Nodes a tree may have.
    pub budget: usize,
    /// Nodes that go through the networks together.
    pub batch: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { budget: DEFAULT_BUDGET, batch: DEFAULT_BATCH }
    }
}

/// What a tree is stored as: all that [`regenerate`] needs besides the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Germ {
    /// Number of the species in the model.
    pub species: usize,
    /// The seed of the tree.
    pub seed: Seed,
    /// The root it starts from, with its age and gravitropism.
    pub root: Root,
}

/// A tree grown by a model, and whether its budget cut it short.
#[derive(Clone, Debug, PartialEq)]
pub struct Generated {
    /// The tree.
    pub tree: BranchGraph,
    /// What it grew from.
    pub germ: Germ,
    /// Some branches had not ended when the budget was spent.
    pub hit_budget: bool,
}

/// Why nothing could be grown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum GenerateError {
    #[error("the model knows no species '{name}'; it knows {}", known.join(", "))]
    UnknownSpecies { name: String, known: Vec<String> },
    #[error("{what} is {value}; it must be a finite number")]
    NotFinite { what: &'static str, value: f32 },
    #[error(
        "the model has seen {species} of {what} {low} to {high} only, not {value}; ask for that, or \
         train a model on a corpus that has it"
    )]
    OutOfRange { species: String, what: &'static str, value: f32, low: f32, high: f32 },
    #[error("the model's numbers overflow at node {node}; train it or get it again")]
    Overflow { node: usize },
    #[error("the root has {what} {value}; no tree starts from such a root")]
    Root { what: &'static str, value: f32 },
    #[error("the budget is 0 nodes; a tree has at least its root")]
    NoBudget,
}

/// Grows the tree of a request.
///
/// # Errors
///
/// When the model does not know the species, or was not trained on such an age or gravitropism.
pub fn generate(
    model: &impl Predictor,
    request: &Request,
    limits: Limits,
    work: &mut Workspace,
) -> Result<Generated, GenerateError> {
    let germ = germ(model, request)?;
    regenerate(model, germ, limits, work)
}

/// What the tree of a request grows from: a root drawn from the training roots of its species,
/// among those nearest to the age and gravitropism asked for, with traits that meet the wishes.
///
/// # Errors
///
/// As [`generate`].
pub fn germ(model: &impl Predictor, request: &Request) -> Result<Germ, GenerateError> {
    let species = model.species().iter().position(|name| *name == request.species);
    let species = species.ok_or_else(|| GenerateError::UnknownSpecies {
        name: request.species.clone(),
        known: model.species().to_vec(),
    })?;
    let roots = model.roots(species);
    let age = request.age.map(f32::from);
    check_range(request, "age", age, roots.iter().map(|root| root.age))?;
    let gravitropisms = roots.iter().map(|root| root.gravitropism);
    check_range(request, "gravitropism", request.gravitropism, gravitropisms)?;

    for Wish { what, value, of } in request.wishes.made() {
        check_range(request, what, Some(value), roots.iter().map(|root| of(&root.traits)))?;
    }

    let distance = |root: &Root| {
        let age = age.map_or(0.0, |age| (age - root.age).abs());
        // One growth cycle weighs as much as a fortieth of the gravitropism.
        let gravitropism =
            request.gravitropism.map_or(0.0, |v| 40.0 * (v - root.gravitropism).abs());
        age + gravitropism
    };
    let nearest = roots.iter().map(distance).fold(f32::INFINITY, f32::min);
    let candidates: Vec<&Root> = roots.iter().filter(|root| distance(root) <= nearest).collect();
    let mut draws = request.seed.draws(Lineage::ROOT, Purpose::RootSignature);
    let mut root = *candidates[draws.index(candidates.len())];
    root.age = age.unwrap_or(root.age);
    root.gravitropism = request.gravitropism.unwrap_or(root.gravitropism);
    let root = wish::grant(root, roots, model.tip_radius(species), &request.wishes);
    Ok(Germ { species, seed: request.seed, root })
}

/// The wishes, moved into the range of what the model has seen of the species.
///
/// # Errors
///
/// When the model does not know the species, or a wish is not finite.
pub fn clamp_wishes(
    model: &impl Predictor,
    species: &str,
    wishes: Wishes,
) -> Result<Wishes, GenerateError> {
    let number = model.species().iter().position(|name| name == species);
    let number = number.ok_or_else(|| GenerateError::UnknownSpecies {
        name: species.to_owned(),
        known: model.species().to_vec(),
    })?;
    if let Some(Wish { what, value, .. }) = wishes.made().find(|wish| !wish.value.is_finite()) {
        return Err(GenerateError::NotFinite { what, value });
    }
    Ok(wishes.map(|wish| {
        let seen = model.roots(number).iter().map(|root| (wish.of)(&root.traits));
        let (low, high) = range(seen);
        wish.value.clamp(low, high)
    }))
}

fn range(seen: impl Iterator<Item = f32>) -> (f32, f32) {
    seen.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

fn check_range(
    request: &Request,
    what: &'static str,
    value: Option<f32>,
    seen: impl Iterator<Item = f32>,
) -> Result<(), GenerateError> {
    let Some(value) = value else { return Ok(()) };
    if !value.is_finite() {
        return Err(GenerateError::NotFinite { what, value });
    }
    let (low, high) = range(seen);
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        let species = request.species.clone();
        Err(GenerateError::OutOfRange { species, what, value, low, high })
    }
}

/// Grows the tree of a germ: the same model and germ give the same bits.
///
/// # Errors
///
/// When the germ's species is not one of the model's, its root no root of a tree, the budget 0, or
/// the model's numbers overflow.
///
/// # Source
///
/// DeepTree, Algorithm 1, on all active nodes at once instead of one after the other.
pub fn regenerate(
    model: &impl Predictor,
    germ: Germ,
    limits: Limits,
    work: &mut Workspace,
) -> Result<Generated, GenerateError> {
    let Some(name) = model.species().get(germ.species) else {
        return Err(GenerateError::UnknownSpecies {
            name: format!("number {}", germ.species),
            known: model.species().to_vec(),
        });
    };
    if limits.budget == 0 {
        return Err(GenerateError::NoBudget);
    }
    check_root(&germ.root)?;
    let info = TreeInfo {
        species: name.clone(),
        age: germ.root.age as u32,
        gravitropism: germ.root.gravitropism,
        seed: germ.seed.0,
    };
    let tip_radius = model.tip_radius(germ.species);
    let conditions = TreeConditions {
        age: germ.root.age,
        gravitropism: germ.root.gravitropism,
        species: germ.species,
        tip_radius,
        root_tips: tip_count(germ.root.signature.thickness, tip_radius),
        traits: germ.root.traits,
    };
    let mut tree = BranchGraph::new(info, Vec3::ZERO, germ.root.signature);
    let mut lineages = vec![Lineage::ROOT];
    let mut branchlets = Vec::new();
    // Nodes are in level order, so those without children yet are the tail of the tree.
    let mut next = 0;
    let mut hit_budget = false;
    while next < tree.len() && !hit_budget {
        let end = tree.len().min(next + limits.batch.max(1));
        let active = |id: usize| Active {
            node: &tree.nodes()[id],
            lineage: lineages[id],
            seed: germ.seed,
            tree: conditions,
        };
        let frontier: Vec<Active<'_>> = (next..end).map(active).collect();
        model
            .branchlets(&frontier, work, &mut branchlets)
            .map_err(|overflow| GenerateError::Overflow { node: next + overflow.row })?;
        hit_budget = add(&mut tree, &mut lineages, next, &branchlets, limits.budget);
        next = end;
    }
    Ok(Generated { tree, germ, hit_budget })
}

/// Adds the branchlets of the nodes from `first` on; true when the budget stopped it.
fn add(
    tree: &mut BranchGraph,
    lineages: &mut Vec<Lineage>,
    first: usize,
    branchlets: &[Branchlet],
    budget: usize,
) -> bool {
    for (id, branchlet) in (first..).zip(branchlets) {
        if tree.len() + branchlet.iter().flatten().count() > budget {
            return true;
        }
        let ids = tree.grow(id as u32, *branchlet);
        for (slot, child) in (0u8..).zip(ids) {
            if child.is_some() {
                lineages.push(lineages[id].child(slot));
            }
        }
    }
    false
}

/// Refuses roots that no tree starts from, as damaged files can hold.
fn check_root(root: &Root) -> Result<(), GenerateError> {
    let Root { signature, age, gravitropism, traits } = *root;
    if !traits.is_sound() {
        return Err(GenerateError::Root { what: "nodes", value: traits.nodes });
    }
    let size = f32::MIN_POSITIVE..=GROWTH_SPACE;
    for (what, value, range) in [
        ("thickness", signature.thickness, size.clone()),
        ("length", signature.length, size),
        ("age", age, 0.0..=f32::from(u16::MAX)),
        ("gravitropism", gravitropism, -10.0..=10.0),
    ] {
        if !range.contains(&value) {
            return Err(GenerateError::Root { what, value });
        }
    }
    Ok(())
}
