//! One beam of the scanner, and its echo.

use deeptree_cloud::{Attributes, Class};
use deeptree_graph::{Draws, Lineage, Purpose, Seed, Vec3};
use glam::DVec3;

use crate::pattern::Pattern;
use crate::target::{Hit, Target};

/// A beam.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    pub(crate) from: DVec3,
    /// Of unit length.
    pub(crate) along: DVec3,
    pub(crate) station: u16,
    /// What its draws are keyed by.
    pub(crate) number: u64,
}

/// A point of the cloud.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Echo {
    pub(crate) place: Vec3,
    pub(crate) attributes: Attributes,
}

/// Rays of a beam that widens: one in the middle, the others on a circle.
const RAYS: usize = 7;
/// The circle's radius in radii of the cone, √(4/7): it halves the area outside of the inner seventh.
const CIRCLE: f64 = 0.755_928_946_018_454_5;
/// Half of √3: the sine of 60°.
const SINE: f64 = 0.866_025_403_784_438_6;
/// The six corners of the circle.
const CORNERS: [[f64; 2]; RAYS - 1] =
    [[1.0, 0.0], [0.5, SINE], [-0.5, SINE], [-1.0, 0.0], [-0.5, -SINE], [0.5, -SINE]];

/// How much of the light of a scanner's wavelength (1064 to 1550 nm) comes back: bark and leaves
/// near that of dry wood and of leaves in the near infrared, the ground of soil.
fn reflectance(class: Class) -> f64 {
    match class {
        Class::Wood => 0.4,
        Class::Leaf => 0.5,
        Class::Ground | Class::Other(_) => 0.25,
    }
}

/// One ray of a beam that met something.
#[derive(Clone, Copy)]
struct Return {
    hit: Hit,
    along: DVec3,
    /// Apparent reflectance ρ · cos θ of a surface that scatters evenly (Lambert).
    strength: f64,
}

/// The echo of a beam; none where it meets nothing.
pub(crate) fn echo(target: &Target, beam: &Beam, pattern: &Pattern, seed: Seed) -> Option<Echo> {
    let radius = CIRCLE * libm::tan(pattern.divergence / 2.0);
    if !passes(target.bounds(), beam, radius) {
        return None;
    }
    let returns = if radius > 0.0 {
        cast(target, beam.from, &cone(beam.along, radius), radius)
    } else {
        let [single] = cast(target, beam.from, &[beam.along], 0.0);
        let mut returns = [None; RAYS];
        returns[0] = single;
        returns
    };
    let rays = if radius > 0.0 { RAYS } else { 1 };
    let (range, nearest) = mean_range(returns.iter().flatten())?;
    let place = (beam.from + nearest.along * nearest.hit.distance).as_vec3();
    let label = target.label(&nearest.hit, place);
    let strength: f64 = together(returns.iter().flatten()).map(|back| back.strength).sum();
    let noise = if pattern.noise > 0.0 { pattern.noise * draws(beam, seed).normal() } else { 0.0 };
    Some(Echo {
        place: (beam.from + beam.along * (range + noise)).as_vec3(),
        attributes: Attributes {
            intensity: libm::round(65535.0 * strength / rays as f64) as f32,
            class: label.class,
            branch: label.branch,
            order: label.order,
            node: label.node,
            station: beam.station,
        },
    })
}

/// Can a cone around a beam, which grows by `slope` a metre, meet a box? For most beams of a moving
/// scanner the answer is no.
fn passes((low, high): (Vec3, Vec3), beam: &Beam, slope: f64) -> bool {
    let (low, high) = (low.as_dvec3() - beam.from, high.as_dvec3() - beam.from);
    let reach = low.abs().max(high.abs()).length();
    let margin = DVec3::splat(slope * reach + 1e-6);
    let (low, high) = (low - margin, high + margin);
    let (mut near, mut far) = (0.0, reach + margin.x);
    for axis in 0..3 {
        let step = beam.along[axis];
        if step == 0.0 {
            if low[axis] > 0.0 || high[axis] < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (low[axis] / step, high[axis] / step);
        (near, far) = (a.min(b).max(near), a.max(b).min(far));
    }
    near <= far
}

/// The rays of a beam that widens.
fn cone(along: DVec3, radius: f64) -> [DVec3; RAYS] {
    let side = along.any_orthonormal_vector();
    let other = along.cross(side);
    let mut rays = [along; RAYS];
    for ([x, y], ray) in CORNERS.into_iter().zip(&mut rays[1..]) {
        *ray = (along + (side * x + other * y) * radius).normalize();
    }
    rays
}

fn cast<const N: usize>(
    target: &Target,
    from: DVec3,
    rays: &[DVec3; N],
    slope: f64,
) -> [Option<Return>; N] {
    let hits = target.first_hits(from, rays, slope, Pattern::RESOLUTION);
    std::array::from_fn(|k| {
        hits[k].map(|hit| {
            let strength = reflectance(target.class(&hit)) * target.cosine(&hit, rays[k]);
            Return { hit, along: rays[k], strength }
        })
    })
}

/// The rays of the first echo: what the nearest and those not far behind it have met.
fn together<'a>(
    returns: impl Iterator<Item = &'a Return> + Clone,
) -> impl Iterator<Item = &'a Return> + Clone {
    let first = returns.clone().map(|back| back.hit.distance).fold(f64::INFINITY, f64::min);
    returns.filter(move |back| back.hit.distance <= first + Pattern::RESOLUTION)
}

/// The mean range of the first echo, weighted by strength, and the ray nearest to it.
fn mean_range<'a>(returns: impl Iterator<Item = &'a Return> + Clone) -> Option<(f64, Return)> {
    // What is seen edge-on still counts for something, so that the mean is defined.
    let weight = |back: &Return| back.strength.max(1e-6);
    let together = together(returns);
    let (mut sum, mut weights) = (0.0, 0.0);
    for back in together.clone() {
        sum += weight(back) * back.hit.distance;
        weights += weight(back);
    }
    let mean = sum / weights;
    let off = |back: &Return| (back.hit.distance - mean).abs();
    let nearest = together.copied().reduce(|a, b| if off(&b) < off(&a) { b } else { a })?;
    Some((mean, nearest))
}

fn draws(beam: &Beam, seed: Seed) -> Draws {
    seed.draws(Lineage::ROOT, Purpose::ScanRange).at(u64::from(beam.station)).at(beam.number)
}
