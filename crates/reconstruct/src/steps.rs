//! The way from points to a tree, step by step.

use deeptree_graph::{TreeInfo, Vec3};
use deeptree_infer::Workspace;

use crate::assemble::assemble;
use crate::complete::{self, complete};
use crate::foot::{self, Foot};
use crate::kdtree::KdTree;
use crate::prepare::{self, Cloud};
use crate::prior::{Prior, Shape};
use crate::skeleton::Skeleton;
use crate::thickness::{self, thicken};
use crate::tips::grow_on;
use crate::trace::{Tracing, trace};
use crate::ways::{NONE, Neighbours, ways};
use crate::{Options, ReconstructError, Reconstruction};
use crate::{forks, levels, links, scaffold, shape};

/// Covered at first, as a share of the cloud's longest side.
const COVER: f32 = 0.0026;

/// Length of the levels that tell how much of the cloud is beyond a point; a share as above.
const LEVEL: f32 = 0.015;

/// Radius of a stem that does not show, as a share as above.
const STEM: f32 = 0.012;

/// Radius of the thinnest twigs, as a share as above: 2.5 mm of a tree of 5 m.
const THINNEST: f32 = 5e-4;

/// Metres of gap that a point that a limb covers is worth, as a multiple of the points' spacing.
const WORTH: f32 = 4.0;

/// Metres of gap that a point that a twig covers is worth, as a share as above. Less leaves out lone
/// points, more bridges wider gaps for them. A scanner may meet a twig once or never, however near to
/// one another its points are on the stem.
const TWIG_WORTH: f32 = 0.035;

/// The widest gap in a branch, as a share of the cloud's height.
const WIDEST: f32 = 0.15;

/// Steps to the powers of these cost a way of a limb, and of a twig: limbs run straighter, twigs
/// keep to rows of points.
const POWERS: [f32; 2] = [1.4, 2.0];

/// Limbs carry at least this share of the tree's metres.
const LIMB: f32 = 0.003;

/// Limbs are straightened over so many radii to both sides. Less leaves zigzags, more cuts bends.
const STRAIGHT: f32 = 6.0;

/// Wood does not show as round where its radius is below so many spacings of the points.
const VISIBLE: f32 = 1.2;

/// Makes a tree of a cloud: metres, y up, relative to an origin near by.
///
/// # Errors
///
/// When the cloud has no extent, the options make no sense, or the model's numbers overflow.
///
/// # Source
///
/// DeepTree, section "Point-based Modeling", sets the task. Deviation: there the networks grow the
/// tree and read the points around each node; here ways through the cloud (as AdTree, Du et al.
/// 2019, and others) give the observed skeleton, and the networks decide what it leaves open.
pub fn reconstruct(
    cloud: &[Vec3],
    options: &Options<'_>,
) -> Result<Reconstruction, ReconstructError> {
    check(options)?;
    let Cloud { points, not_finite, voxel } = prepare::prepare(cloud, options.most_points)?;
    let whole = points.len();
    let points = foot::above_ground(&points).unwrap_or(points);
    let (low, high) = foot::bounds(&points);
    let side = (high - low).max_element();
    let index = KdTree::new(&points);
    let foot = foot::foot(&points, &index, options.root)?;
    let size = Size {
        side,
        // A cloud that lies has some height, too.
        height: (high.y - low.y).max(0.2 * side),
        cover: options.cover.unwrap_or(COVER * side),
        stem: foot.radius.unwrap_or(STEM * side),
    };
    let mut skeleton = skeleton(&points, &index, &foot, size);
    let mut work = Workspace::default();
    let mut prior = prior(&skeleton, &points, options, &mut work)?;
    let left_out = skeleton.owner.iter().filter(|&&owner| owner == NONE).count();
    let mut completed = match &prior {
        Some(prior) => grow_on(&mut skeleton, prior, low.y, &mut work)?,
        None => 0,
    };
    if let Some(prior) = prior.as_mut().filter(|_| options.complete) {
        if options.hear {
            let root = skeleton.joints[0].position;
            prior.hear(points.iter().map(|&point| point - root));
        }
        // What hangs lower than the points is no tree's.
        let bounds = complete::Bounds { low, high };
        completed += complete(&mut skeleton, prior, bounds, &mut work)?;
        // Which child a branch goes on with, points do not say.
        prior.hear_nothing();
    }
    let heirs = match &prior {
        Some(prior) => forks::apical(&skeleton, prior, &mut work)?,
        None => skeleton.heirs(),
    };
    let info = prior.map_or_else(
        || TreeInfo { species: String::new(), age: 0, gravitropism: 0.0, seed: options.seed.0 },
        |prior| prior.info(),
    );
    for joint in &mut skeleton.joints {
        joint.position -= foot.centre;
    }
    let (points, ground) = (points.len(), whole - points.len());
    Ok(Reconstruction {
        tree: assemble(&skeleton, &heirs, info),
        foot: foot.centre,
        points,
        not_finite,
        ground,
        left_out,
        voxel,
        completed,
    })
}

fn check(options: &Options<'_>) -> Result<(), ReconstructError> {
    if let Some(Vec3 { x, y, z }) = options.root.filter(|root| !root.is_finite()) {
        return Err(ReconstructError::Root { x, y, z });
    }
    if let Some(value) = options.cover.filter(|cover| !(*cover > 0.0 && cover.is_finite())) {
        return Err(ReconstructError::NotPositive { what: "the radius of cover", value });
    }
    Ok(())
}

/// Lengths that the steps go by, in metres.
#[derive(Clone, Copy)]
struct Size {
    side: f32,
    height: f32,
    cover: f32,
    stem: f32,
}

/// The observed skeleton with its radii, in the cloud's frame.
fn skeleton(points: &[Vec3], index: &KdTree, foot: &Foot, size: Size) -> Skeleton {
    let Size { side, cover, stem, .. } = size;
    let neighbours = Neighbours::new(points, index);
    // 1. Everything, along ways that cut corners.
    let first = ways(&neighbours, points.len(), &foot.points, POWERS[0]);
    let shares = levels::shares_beyond(&neighbours, &first, LEVEL * side);
    let radius: Vec<f32> = shares.iter().map(|share| stem * libm::sqrtf(*share)).collect();
    let (worth, widest) = (WORTH * neighbours.spacing, WIDEST * size.height);
    let tracing = Tracing { points, index, ways: &first, radius: &radius, cover, worth, widest };
    let mut skeleton = Skeleton::new(foot.centre, points.len());
    foot.points.iter().for_each(|&point| skeleton.owner[point as usize] = 0);
    trace(&tracing, &mut skeleton);
    // 2. Of that the limbs, straightened.
    scaffold::limbs(&mut skeleton, LIMB);
    shape::straighten(&mut skeleton, |joint| STRAIGHT * stem * joint.radius);
    scaffold::claim(&mut skeleton, points, index, stem, cover);
    // 3. What the limbs leave uncovered, along rows of points.
    let is_covered = |i: &u32| skeleton.owner[*i as usize] != NONE;
    let sources: Vec<u32> = (0..points.len() as u32).filter(is_covered).collect();
    let second = ways(&neighbours, points.len(), &sources, POWERS[1]);
    let thin = vec![0.0; points.len()];
    let worth = TWIG_WORTH * side;
    trace(&Tracing { ways: &second, radius: &thin, worth, ..tracing }, &mut skeleton);
    links::relink(&mut skeleton, side);
    // 4. Where exactly, and how thick.
    shape::shape(&mut skeleton, points, cover);
    let visible = VISIBLE * neighbours.spacing;
    let radii = thickness::Known { stem, thinnest: THINNEST * side, visible };
    thicken(&mut skeleton, points, &radii);
    skeleton
}

/// The networks, told of which species the tree is; none where there are none, or no tree to ask
/// them about.
fn prior<'a>(
    skeleton: &Skeleton,
    points: &[Vec3],
    options: &Options<'a>,
    work: &mut Workspace,
) -> Result<Option<Prior<'a>>, ReconstructError> {
    let Some(model) = options.prior else { return Ok(None) };
    let root = skeleton.joints[0].position;
    let from_root = |place: &Vec3| *place - root;
    let places: Vec<Vec3> = skeleton.joints.iter().map(|j| j.position - root).collect();
    let most = |of: fn(Vec3) -> f32| points.iter().map(from_root).map(of).fold(0.0, f32::max);
    let shape = Shape { height: most(|p| p.y), crown_radius: most(|p| p.with_y(0.0).length()) };
    let named = |species| Prior::new(model, species, shape, &places, options.seed);
    if let Some(name) = &options.species {
        let known = model.species();
        let number = known.iter().position(|other| other == name).ok_or_else(|| {
            ReconstructError::UnknownSpecies { name: name.clone(), known: known.to_vec() }
        })?;
        return Ok(named(number));
    }
    let mut best: Option<(f32, Prior<'_>)> = None;
    for species in 0..model.species().len() {
        let Some(prior) = named(species) else { continue };
        let likelihood = forks::ln_likelihood(skeleton, &prior, work)?;
        if best.as_ref().is_none_or(|(most, _)| likelihood > *most) {
            best = Some((likelihood, prior));
        }
    }
    Ok(best.map(|(_, prior)| prior))
}
