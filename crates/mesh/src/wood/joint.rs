//! Where laterals leave a limb: the places where they come out of its surface, and how these share
//! the limb.
//!
//! Laterals that leave side by side share a *band*: a stretch of the limb between two rings, each
//! with a *patch* of the band's sides to itself. Bands do not overlap, nor do the patches of one.

use deeptree_graph::{BranchGraph, NodeId, Vec3};

use super::axis::{Axis, Sample};
use super::limbs::Limbs;
use super::ring::Ring;
use super::spread::{Interval, spread, spread_around};
use crate::options::WoodOptions;
use crate::tubes::MIN_RADIUS;

/// A collar is at most this half-width around its limb, in radians.
const MAX_HALF_ANGLE: f32 = 1.3;

/// Patches are this much wider and longer than the collar in them.
const RIM: f32 = 1.25;

/// Share of its place along the limb that a band takes: the rest keeps rings of neighbours apart.
const FILL: f32 = 0.9;

/// Least angle between two patches, in radians, where the circle has room for it.
const BETWEEN: f32 = 0.06;

/// A branch leaves its parent's surface at no flatter slope: the sine of 30°.
pub(crate) const LEAST_RISE: f32 = 0.5;

/// A lateral leaves the surface when it is this share of its radius above it.
const CLEAR: f32 = 0.3;

/// A lateral of the limb at hand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lateral {
    pub(crate) limb: u32,
    /// Near which point of the axis it starts.
    pub(crate) near: f32,
}

/// The place where a lateral comes out of the surface of its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exit {
    pub(crate) limb: u32,
    /// Its first node that lies outside; none if it has none.
    pub(crate) outside: Option<NodeId>,
    /// Radius of the lateral.
    pub(crate) radius: f32,
    /// Where on the axis of the parent.
    pub(crate) s: f32,
    /// On which side: unit direction from the axis.
    side: Vec3,
    /// Half of the collar's length along the parent, in metres.
    pub(crate) half: f32,
    /// Half of the collar's width around the parent, in metres along the surface's chord.
    pub(crate) rim: f32,
    /// The same in radians, at the parent's radius there.
    half_angle: f32,
}

/// A stretch of a limb that laterals leave from: a range of exits.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    pub(crate) low: f32,
    pub(crate) high: f32,
    pub(crate) exits: core::ops::Range<usize>,
}

/// The columns of a ring that a patch takes, and the angles between which they stand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    /// Which exit.
    pub(crate) exit: usize,
    /// Angle of its middle.
    pub(crate) center: f32,
    /// Half of its width, in radians.
    pub(crate) half: f32,
    /// Half of the width of the collar in it, in radians.
    pub(crate) half_angle: f32,
    /// Its first column, below the ring's sides, and the one after its last.
    pub(crate) columns: (i32, i32),
}

/// Where `lateral` comes out of the surface around `axis`.
pub(crate) fn exit(
    tree: &BranchGraph,
    limbs: &Limbs,
    axis: &Axis,
    lateral: Lateral,
    options: &WoodOptions,
) -> Exit {
    let start = limbs.starts[lateral.limb as usize];
    let first = tree.node(start);
    let base = first.parent.map_or(first.base(), |parent| tree.node(parent).position);
    let here = axis.at(lateral.near);
    let radius = first.thickness.min(here.radius).max(MIN_RADIUS);

    let gap = |p: Vec3, s: f32| {
        let at = axis.nearest(p, s);
        (p.distance(at.position) - at.radius, at)
    };
    let (mut before, mut at) = (base, here);
    let mut outside = None;
    for id in limbs.nodes(start) {
        let p = tree.node(id).position;
        let (distance, next) = gap(p, at.s);
        if distance > CLEAR * radius {
            outside = Some((id, p, distance));
            break;
        }
        (before, at) = (p, next);
    }
    // Between the last node inside and the first outside: regula falsi, halving the end that stays.
    let (mut point, mut way) = (before, Vec3::ZERO);
    if let Some((_, end, distance)) = outside {
        let (mut low, mut high) = ((0.0, gap(before, at.s).0), (1.0, distance));
        for _ in 0..4 {
            if low.1 >= 0.0 {
                break;
            }
            let t = low.0 + (high.0 - low.0) * (low.1 / (low.1 - high.1)).clamp(0.05, 0.95);
            let (distance, next) = gap(before.lerp(end, t), at.s);
            at = next;
            if distance < 0.0 {
                (low, high.1) = ((t, distance), 0.5 * high.1);
            } else {
                (high, low.1) = ((t, distance), 0.5 * low.1);
            }
        }
        let t = if low.1 >= 0.0 { 0.0 } else { 0.5 * (low.0 + high.0) };
        point = before.lerp(end, t);
        at = gap(point, at.s).1;
        way = (end - point).normalize_or_zero();
    }
    let side = side(&at, point, way);
    let along = way.dot(at.tangent);
    let rise = libm::sqrtf((1.0 - along * along).max(0.0)).max(LEAST_RISE);
    let rim = options.collar * radius;
    Exit {
        limb: lateral.limb,
        outside: outside.map(|(id, ..)| id),
        radius,
        s: at.s,
        side,
        half: rim / rise,
        rim,
        half_angle: half_angle(rim, at.radius),
    }
}

/// Half of the angle that a collar takes around a limb.
fn half_angle(rim: f32, radius: f32) -> f32 {
    libm::asinf((rim / radius).min(1.0)).min(MAX_HALF_ANGLE)
}

/// The unit direction from the axis towards `point`, or failing that, towards `way`.
fn side(at: &Sample, point: Vec3, way: Vec3) -> Vec3 {
    let flat = |v: Vec3| v - at.tangent * v.dot(at.tangent);
    let (out, on) = (flat(point - at.position), flat(way));
    if out.length_squared() > 1e-8 * at.radius * at.radius {
        out.normalize()
    } else if on.length_squared() > 1e-8 {
        on.normalize()
    } else {
        at.tangent.any_orthonormal_vector()
    }
}

/// The room along a limb that its laterals need at least, in metres.
pub(crate) fn least_room(radii: impl Iterator<Item = f32>) -> f32 {
    radii.map(|radius| radius.max(2.0 * MIN_RADIUS)).sum()
}

/// Divides a limb between `low` and `high` among its exits, which are sorted and moved by it.
pub(crate) fn bands(exits: &mut [Exit], low: f32, high: f32, out: &mut Vec<Band>) {
    out.clear();
    exits.sort_by(|a, b| a.s.total_cmp(&b.s));
    // Neighbours that overlap along the limb, but not around it, share a band.
    let reach = |exit: &Exit| (exit.s - RIM * exit.half, exit.s + RIM * exit.half);
    let mut i = 0;
    while i < exits.len() {
        let (mut start, mut end) = reach(&exits[i]);
        let mut longest = end - start;
        let mut last = i + 1;
        while last < exits.len() {
            let (a, b) = reach(&exits[last]);
            longest = longest.max(b - a);
            let (from, to) = (start.min(a), end.max(b));
            let overlap = end.min(b) - a.max(start);
            let apart = exits[i..last].iter().all(|other| beside(other, &exits[last]));
            if overlap < 0.2 * (b - a) || !apart || to - from > 1.8 * longest {
                break;
            }
            (start, end) = (from, to);
            last += 1;
        }
        out.push(Band { low: start, high: end, exits: i..last });
        i = last;
    }
    settle(exits, low, high, out);
}

/// Whether two exits at one height do not meet.
fn beside(a: &Exit, b: &Exit) -> bool {
    let angle = libm::acosf(a.side.dot(b.side).clamp(-1.0, 1.0));
    angle > a.half_angle + b.half_angle
}

/// Moves bands apart, and their exits with them; where there is too little room, all get shorter.
fn settle(exits: &mut [Exit], low: f32, high: f32, bands: &mut [Band]) {
    let middle = |band: &Band| 0.5 * (band.low + band.high);
    bands.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let wanted: f32 = bands.iter().map(|band| (band.high - band.low) / FILL).sum();
    let scale = ((high - low) / wanted).min(1.0);
    let mut places: Vec<Interval> = bands
        .iter()
        .map(|band| {
            let half = 0.5 * scale * (band.high - band.low) / FILL;
            Interval { center: middle(band), half }
        })
        .collect();
    spread(&mut places, low, high);
    for (band, place) in bands.iter_mut().zip(&places) {
        let before = middle(band);
        for exit in &mut exits[band.exits.clone()] {
            exit.s = place.center + scale * (exit.s - before);
            exit.half *= scale;
        }
        band.low = place.center - FILL * place.half;
        band.high = place.center + FILL * place.half;
    }
}

/// Gives each exit of a band a patch of columns of a ring of `sides` sides, at least two a patch;
/// `ring` is the band's lower one.
pub(crate) fn patches(exits: &[Exit], band: &Band, sides: u32, ring: &Ring, out: &mut Vec<Patch>) {
    out.clear();
    let tau = core::f32::consts::TAU;
    out.extend(band.exits.clone().map(|exit| {
        let side = exits[exit].side;
        let center = libm::atan2f(side.dot(ring.y), side.dot(ring.x)).rem_euclid(tau);
        let half_angle = half_angle(exits[exit].rim, ring.radius);
        let half = (RIM * half_angle).max(0.35 * tau / sides as f32);
        Patch { exit, center, half, half_angle, columns: (0, 0) }
    }));
    out.sort_by(|a, b| a.center.total_cmp(&b.center));

    let total: f32 = out.iter().map(|patch| 2.0 * patch.half + BETWEEN).sum();
    let scale = (0.98 * tau / total).min(1.0);
    let mut places: Vec<Interval> = out
        .iter()
        .map(|patch| Interval { center: patch.center, half: scale * (patch.half + 0.5 * BETWEEN) })
        .collect();
    let first = spread_around(&mut places);
    out.rotate_left(first);
    for (patch, place) in out.iter_mut().zip(&places) {
        patch.center = place.center;
        patch.half *= scale;
        patch.half_angle *= scale;
    }
    columns(out, sides as i32);
}

/// Gives each patch the columns next to its angles, with at least one column between two.
fn columns(patches: &mut [Patch], sides: i32) {
    let a_side = core::f32::consts::TAU / sides as f32;
    let width = |patch: &Patch| patch.columns.1 - patch.columns.0;
    for patch in &mut *patches {
        patch.columns = (0, (libm::roundf(2.0 * patch.half / a_side) as i32).max(1));
    }
    while patches.iter().map(|patch| width(patch) + 1).sum::<i32>() > sides {
        if let Some(widest) = patches.iter_mut().max_by_key(|patch| width(patch)) {
            widest.columns.1 -= 1;
        }
    }
    let mut free = i32::MIN;
    for patch in &mut *patches {
        let width = width(patch);
        let start = libm::roundf(patch.center / a_side - 0.5 * width as f32) as i32;
        let start = start.max(free);
        patch.columns = (start, start + width);
        free = start + width + 1;
    }
    let mut limit = patches[0].columns.0 + sides - 1;
    for patch in patches.iter_mut().rev() {
        let over = (patch.columns.1 - limit).max(0);
        patch.columns = (patch.columns.0 - over, patch.columns.1 - over);
        limit = patch.columns.0 - 1;
    }
}

/// The angles of a ring's columns, the first again at the end: those at the sides of patches stand
/// where the patches end, the others evenly between.
///
/// Turns the columns of the patches so that they start within the ring.
pub(crate) fn angles(patches: &mut [Patch], sides: u32, out: &mut Vec<f32>) {
    let (tau, n) = (core::f32::consts::TAU, sides as i32);
    out.clear();
    out.resize(sides as usize + 1, 0.0);
    let first = patches[0];
    let ends = patches.iter().flat_map(|patch| {
        let Patch { center, half, columns: (low, high), .. } = *patch;
        [(low, center - half), (high, center + half)]
    });
    let closing = (first.columns.0 + n, first.center - first.half + tau);
    let mut before = (first.columns.0, first.center - first.half);
    for end in ends.skip(1).chain([closing]) {
        let step = (end.1 - before.1) / (end.0 - before.0) as f32;
        for column in before.0..end.0 {
            let angle = before.1 + step * (column - before.0) as f32;
            let turns = column.div_euclid(n);
            out[column.rem_euclid(n) as usize] = angle - tau * turns as f32;
        }
        before = end;
    }
    out[sides as usize] = out[0] + tau;
    for patch in patches {
        let turns = patch.columns.0.div_euclid(n);
        patch.columns = (patch.columns.0 - turns * n, patch.columns.1 - turns * n);
        patch.center -= tau * turns as f32;
    }
}
