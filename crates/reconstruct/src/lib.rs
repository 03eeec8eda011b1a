//! From a point cloud to a branch graph, and how well the two agree.

#![forbid(unsafe_code)]

mod assemble;
mod circle;
mod complete;
pub mod fit;
mod foot;
mod kdtree;
mod levels;
mod prepare;
mod prior;
mod relink;
mod scaffold;
mod shape;
mod skeleton;
mod thickness;
mod trace;
mod ways;

use deeptree_graph::{BranchGraph, Seed, TreeInfo, Vec3};
use deeptree_infer::{Predictor, Workspace};

pub use fit::Fit;
pub use kdtree::KdTree;
pub use prepare::MOST_POINTS;

/// Why no tree can be made of a cloud.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    #[error("none of the cloud's {given} points is a finite number; a tree needs at least two")]
    NoPoints { given: usize },
    #[error("all {points} points of the cloud are at one place; a tree needs an extent")]
    OnePlace { points: usize },
    #[error("the root is at {x}, {y}, {z}; give three finite numbers")]
    Root { x: f32, y: f32, z: f32 },
    #[error("{what} is {value}; it must be a number above 0")]
    NotPositive { what: &'static str, value: f32 },
    #[error(transparent)]
    Overflow(#[from] deeptree_infer::Overflow),
}

/// How a cloud is read.
#[derive(Clone)]
pub struct Options<'a> {
    /// Where the tree stands, in the cloud's frame; found when none is given.
    pub root: Option<Vec3>,
    /// Points this near to a branch need no branch of their own, in metres; by the cloud's height and
    /// spacing when none is given.
    pub cover: Option<f32>,
    /// Points that are worked on at most.
    pub most_points: usize,
    /// The networks that decide what the points leave open; none for geometry alone.
    pub prior: Option<&'a dyn Predictor>,
    /// Let the networks grow what the scanner did not see.
    pub complete: bool,
    /// The species that the networks take the tree for; the likeliest when none is given.
    pub species: Option<String>,
    /// The seed of what is drawn.
    pub seed: Seed,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self { root: None, cover: None, most_points: MOST_POINTS, prior: None, complete: false, species: None, seed: Seed(0) }
    }
}

/// A tree made of a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The tree, its foot at the origin.
    pub tree: BranchGraph,
    /// Where the foot stands in the cloud's frame: add it to a position of the tree.
    pub foot: Vec3,
}

/// Makes a tree of a cloud: metres, y up.
///
/// # Errors
///
/// When the cloud has no extent or the options make no sense.
pub fn reconstruct(cloud: &[Vec3], options: &Options<'_>) -> Result<Reconstruction, Error> {
    let cloud = prepare::prepare(cloud, options.most_points)?;
    let points = foot::above_ground(&cloud.points).unwrap_or(cloud.points);
    let (low, high) = foot::bounds(&points);
    let side = (high - low).max_element();
    let foot = foot::foot(&points, options.root);
    let index = KdTree::new(&points);
    let neighbours = ways::Neighbours::new(&points, &index);
    let env = |name: &str, or: f32| std::env::var(name).map_or(or, |v| v.parse().unwrap_or(or));
    let ways = ways::ways(&neighbours, points.len(), &foot.points, env("P1", 1.4));
    let cover = options.cover.unwrap_or(env("COV", 0.003) * side);
    let shares = levels::shares_beyond(&neighbours, &ways, 0.015 * side);
    let stem = foot.radius.unwrap_or(0.012 * side);
    let radius: Vec<f32> = shares.iter().map(|share| stem * libm::sqrtf(*share)).collect();
    let tracing = trace::Tracing {
        points: &points,
        index: &index,
        ways: &ways,
        radius: &radius,
        cover,
        worth: env("WORTH", 4.0) * neighbours.spacing,
    };
    let mut work = Workspace::default();
    let prior = |skeleton: &skeleton::Skeleton| {
        let model = options.prior?;
        let places: Vec<Vec3> = skeleton.joints.iter().map(|j| j.position - foot.centre).collect();
        let crown = points.iter().map(|p| (*p - foot.centre).with_y(0.0).length()).fold(0.0, f32::max);
        let shape = prior::Shape { height: high.y - foot.centre.y, crown_radius: crown };
        let species = options.species.as_ref().and_then(|name| model.species().iter().position(|s| s == name)).unwrap_or(3);
        prior::Prior::new(model, species, shape, &places, options.seed)
    };
    let mut skeleton = skeleton::Skeleton::new(foot.centre, points.len());
    foot.points.iter().for_each(|&point| skeleton.owner[point as usize] = 0);
    trace::trace(&tracing, &mut skeleton);
    let limbs = env("LIMBS", 0.01);
    if limbs < 1.0 {
        scaffold::limbs(&mut skeleton, limbs);
        if let Some(prior) = prior(&skeleton) {
            for _ in 0..2 {
                let changed = relink::relink(&mut skeleton, &prior, &mut work)?;
                if changed == 0 { break; }
            }
        }
        let bend = env("BEND", 8.0);
        shape::straighten(&mut skeleton, |joint| bend * stem * joint.radius);
        scaffold::claim(&mut skeleton, &points, &index, stem, cover);
        let sources: Vec<u32> = (0..points.len() as u32).filter(|&i| skeleton.owner[i as usize] != ways::NONE).collect();
        let ways = ways::ways(&neighbours, points.len(), &sources, env("P2", 2.0));
        let thin = vec![0.0; points.len()];
        trace::trace(&trace::Tracing { ways: &ways, radius: &thin, ..tracing }, &mut skeleton);
    }
    shape::shape(&mut skeleton, &points, cover);
    let radii = thickness::Prior { stem, thinnest: 5e-4 * side, visible: env("VIS", 1.2) * neighbours.spacing };
    thickness::thicken(&mut skeleton, &points, &radii);
    if options.complete && let Some(prior) = prior(&skeleton) {
        let bounds = complete::Bounds { low: low.with_y(foot.centre.y + 0.1 * (high.y - low.y)), high };
        complete::complete(&mut skeleton, &prior, bounds, &mut work)?;
    }
    let info = TreeInfo { species: "oak".into(), age: 0, gravitropism: 0.0, seed: 0 };
    for joint in &mut skeleton.joints {
        joint.position -= foot.centre;
    }
    let heirs = match options.prior {
        Some(_) if std::env::var("NOAP").is_err() => match prior(&skeleton) {
            Some(prior) => relink::apical(&skeleton, &prior, &mut work)?,
            None => skeleton.heirs(),
        },
        _ if std::env::var("STRAIGHT").is_ok() => {
            let mut heirs = skeleton.heirs();
            let ch = skeleton.children(); let b = skeleton.lengths_beyond();
            let w: f32 = std::env::var("STRAIGHT").unwrap().parse().unwrap();
            for (i, c) in ch.iter().enumerate() { if i > 0 && c.len() > 1 {
                let p = skeleton.joints[i]; let f = (p.position - skeleton.joints[p.parent as usize].position).normalize_or_zero();
                let s = |k: &u32| { let q = skeleton.joints[*k as usize]; f.dot((q.position - p.position).normalize_or_zero()) * w + b[*k as usize].ln() };
                heirs[i] = *c.iter().max_by(|x, y| s(x).total_cmp(&s(y))).unwrap();
            } }
            heirs
        }
        _ => skeleton.heirs(),
    };
    let (tree, _) = assemble::assemble(&skeleton, &heirs, info);
    Ok(Reconstruction { tree, foot: foot.centre })
}
