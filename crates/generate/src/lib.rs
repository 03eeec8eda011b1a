//! Growth by network: Algorithm 1 of the paper over whole frontiers.
//!
//! A tree starts from a root drawn from the law of its species, age and gravitropism, and grows
//! level by level: the model draws the branchlets of all nodes of one depth at once, and the new
//! nodes are the next level, until every branch has ended by itself or the node budget is spent.
//! What has grown up to a level is what its nodes see of each other. With a model
//! of kind `situated` every branch ends, as far out as the longest path of the traits says.

#![forbid(unsafe_code)]

mod aim;
mod density;
mod growing;
mod legacy;
mod regrow;
mod stand;
mod state;
mod wish;

use deeptree_graph::signature::GROWTH_SPACE;
use deeptree_graph::{BranchGraph, Kin, Lineage, Occupancy, Purpose, Seed, TreeInfo, Vec3};
use deeptree_infer::{Predictor, Root, Workspace};
use deeptree_scene::Site;

use aim::Aim;
use density::Stock;
pub use growing::Avoided;
use growing::{Growing, Grown};
pub use regrow::{RegrowError, Regrown, regrow, regrow_in};
pub use stand::{Planted, StandError, generate_stand};
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
    /// a: age in growth cycles; when none is given the species' own, or the nearest to it at which
    /// the model has seen what is wished.
    pub age: Option<u16>,
    /// v: gravitropism; the species' own when none is given.
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
    /// How often a branch would have gone where none can.
    pub avoided: Avoided,
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
        "the model has seen {species}{} of {what} {low} to {high} only, not {value}; ask for that, \
         or train a model on a corpus that has it",
        at(*age)
    )]
    OutOfRange {
        species: String,
        /// When the range is that of one age.
        age: Option<f32>,
        what: &'static str,
        value: f32,
        low: f32,
        high: f32,
    },
    #[error(
        "the model has seen no {species} of age {age} and gravitropism {gravitropism}, nor any near; \
         the nearest are of {near_age} and {near_gravitropism}"
    )]
    NotSeen { species: String, age: f32, gravitropism: f32, near_age: f32, near_gravitropism: f32 },
    #[error(
        "the model has seen each of what is asked of the {species}, but at no age all of it; ask \
         for less"
    )]
    NotTogether { species: String },
    #[error("the model's numbers overflow at node {node}; train it or get it again")]
    Overflow { node: usize },
    #[error("the root has {what} {value}; no tree starts from such a root")]
    Root { what: &'static str, value: f32 },
    #[error("the budget is 0 nodes; a tree has at least its root")]
    NoBudget,
}

/// Grows the tree of a request in the open field.
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

/// Grows the tree of a request among what stands around.
///
/// # Errors
///
/// As [`generate`].
pub fn generate_in(
    model: &impl Predictor,
    request: &Request,
    site: &Site,
    limits: Limits,
    work: &mut Workspace,
) -> Result<Generated, GenerateError> {
    let germ = germ_in(model, request, site)?;
    regenerate_in(model, germ, Some(site), limits, work)
}

/// As [`germ`], among what stands around: the root's state in the open field is moved by what the
/// model expects of the difference. A model that has not learned from environments moves nothing.
///
/// # Errors
///
/// As [`germ`], and when the model's numbers overflow.
pub fn germ_in(
    model: &impl Predictor,
    request: &Request,
    site: &Site,
) -> Result<Germ, GenerateError> {
    let mut germ = germ(model, request)?;
    let Some(outlook) = model.outlook() else { return Ok(germ) };
    let Root { age, gravitropism, .. } = germ.root;
    let expect = |taken, shading| {
        let code = outlook.code(taken, shading);
        let expected = outlook.expect(&code, germ.species, age, gravitropism);
        expected.map_err(|_| GenerateError::Overflow { node: 0 })
    };
    let (here, open) =
        (expect(site.taken(), site.shading())?, expect(&Occupancy::EMPTY, &Occupancy::EMPTY)?);
    let tip_radius = model.tip_radius(germ.species);
    let shift = std::array::from_fn(|i| here.state[i] - open.state[i]);
    germ.root = density::moved(germ.root, tip_radius, &shift);
    Ok(germ)
}

/// As [`germ_in`] where something stands around, as [`germ`] in the open field.
fn germ_in_or_open(
    model: &impl Predictor,
    request: &Request,
    site: Option<&Site>,
) -> Result<Germ, GenerateError> {
    match site {
        Some(site) => germ_in(model, request, site),
        None => germ(model, request),
    }
}

fn at(age: Option<f32>) -> String {
    age.map_or(String::new(), |age| format!(", at age {age},"))
}

/// What the tree of a request grows from: a root drawn from the law of roots of its species at the
/// age and gravitropism asked for, with traits that meet the wishes.
///
/// # Errors
///
/// As [`generate`].
pub fn germ(model: &impl Predictor, request: &Request) -> Result<Germ, GenerateError> {
    let species = number_of(model, &request.species)?;
    let stock = Stock::of(model, species);
    let Aim { place, law } = aim::aim(stock, request)?;

    let draws = || request.seed.draws(Lineage::ROOT, Purpose::RootSignature);
    let (number, state) = law.draw(&mut draws());
    let state = density::consistent(wish::grant(state, &law, &request.wishes));
    let mut root = state::with_state(stock.roots[number], stock.tip_radius, &state);
    root.signature.rotation = density::yawed(root.signature.rotation, &mut draws().at(1));
    (root.age, root.gravitropism) = (place.age, place.gravitropism);
    Ok(Germ { species, seed: request.seed, root })
}

/// The wishes of a request, moved into the range of what the model has seen of the species, at the
/// age and gravitropism asked for.
///
/// # Errors
///
/// When the request cannot be met with other wishes either.
pub fn clamp_wishes(model: &impl Predictor, request: &Request) -> Result<Wishes, GenerateError> {
    let species = number_of(model, &request.species)?;
    aim::clamp(Stock::of(model, species), request)
}

fn number_of(model: &impl Predictor, name: &str) -> Result<usize, GenerateError> {
    let number = model.species().iter().position(|known| known == name);
    number.ok_or_else(|| GenerateError::UnknownSpecies {
        name: name.to_owned(),
        known: model.species().to_vec(),
    })
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
    regenerate_in(model, germ, None, limits, work)
}

/// As [`regenerate`], among what stands around.
///
/// # Errors
///
/// As [`regenerate`].
pub fn regenerate_in(
    model: &impl Predictor,
    germ: Germ,
    site: Option<&Site>,
    limits: Limits,
    work: &mut Workspace,
) -> Result<Generated, GenerateError> {
    let growing = sprout(model, &germ, site, limits)?;
    let Grown { tree, hit_budget, avoided, .. } = growing.grow(model, limits, work)?;
    Ok(Generated { tree, germ, hit_budget, avoided })
}

/// What the tree of a germ is before it grows: its root alone.
fn sprout<'a>(
    model: &impl Predictor,
    germ: &Germ,
    site: Option<&'a Site>,
    limits: Limits,
) -> Result<Growing<'a>, GenerateError> {
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
    let (tip_radius, kin) = (model.tip_radius(germ.species), model.kin(germ.species));
    let conditions = germ.root.conditions(germ.species, tip_radius, kin, habit(germ.seed));
    let tree = BranchGraph::new(info, Vec3::ZERO, germ.root.signature);
    Ok(Growing::new(tree, conditions, germ.seed, site))
}

/// Habits are drawn within so many deviations.
const MOST_HABIT: f64 = 2.5;

/// The habit of a tree, in deviations: whatever it is told besides, its habit is independent of it.
fn habit(seed: Seed) -> [f32; Kin::HABITS] {
    let mut draws = seed.draws(Lineage::ROOT, Purpose::Habit);
    std::array::from_fn(|_| draws.normal().clamp(-MOST_HABIT, MOST_HABIT) as f32)
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
