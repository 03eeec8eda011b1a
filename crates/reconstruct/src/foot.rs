//! Where the tree stands: the ground is left out, and the stem's foot found.

use deeptree_graph::{Vec2, Vec3};

use crate::kdtree::KdTree;
use crate::ways::Parts;
use crate::{ReconstructError, circle};

/// Height of the slab in which the foot is looked for, as a share of the cloud's.
const SLAB: f32 = 0.03;

/// Side of the cells in which the ground is looked for, as a share of the cloud's longest side.
const CELL: f32 = 0.04;

/// The foot of a stem.
#[derive(Clone, Debug)]
pub(crate) struct Foot {
    /// In the middle of the stem, at the height of its lowest points.
    pub(crate) centre: Vec3,
    /// Radius of the stem in metres; none where it does not show.
    pub(crate) radius: Option<f32>,
    /// The points around it.
    pub(crate) points: Vec<u32>,
}

/// The foot: given, or in the middle of the largest group among the lowest points.
///
/// # Errors
///
/// When it is given and far from every point.
pub(crate) fn foot(
    points: &[Vec3],
    index: &KdTree,
    given: Option<Vec3>,
) -> Result<Foot, ReconstructError> {
    let (low, high) = bounds(points);
    let side = (high - low).max_element();
    if let Some((_, squared)) = given.and_then(|root| index.nearest(root)) {
        let distance = libm::sqrtf(squared);
        // Written so that an overflow is far, too.
        let is_near = distance <= 0.25 * side;
        if !is_near {
            return Err(ReconstructError::FarRoot { distance, side });
        }
    }
    let slab = SLAB * (high.y - low.y).max(1e-3 * side);
    let floor = given.map_or(low.y, |root| root.y);
    let beside = |p: Vec3| given.map_or(0.0, |root| (p - root).with_y(0.0).length());
    let lowest: Vec<u32> = (0..points.len() as u32)
        .filter(|&i| {
            let p = points[i as usize];
            (p.y - floor).abs() <= slab && beside(p) <= 3.0 * slab
        })
        .collect();
    let group = if given.is_some() { lowest } else { largest_group(points, lowest, slab) };
    if group.is_empty() {
        let centre = given.unwrap_or(low);
        let nearest = index.nearest(centre).map(|(i, _)| i);
        return Ok(Foot { centre, radius: None, points: nearest.into_iter().collect() });
    }
    let flat: Vec<Vec2> = group.iter().map(|&i| level(points[i as usize])).collect();
    let mean = flat.iter().sum::<Vec2>() / flat.len() as f32;
    // The diameter of a stem is seldom more than a twelfth of the tree's height.
    let most = (high.y - low.y) / 24.0;
    let circle = circle::fit(&flat)
        .filter(|c| c.arc >= 0.2 && c.error < 0.25 * c.radius && c.radius < most)
        .filter(|c| c.centre.distance(mean) < 1.2 * c.radius);
    let middle = circle.map_or(mean, |circle| circle.centre);
    let centre = given.unwrap_or(Vec3::new(middle.x, low.y, middle.y));
    Ok(Foot { centre, radius: circle.map(|circle| circle.radius), points: group })
}

/// The points that stand above the ground, if there is ground below the tree.
///
/// Ground is where the lowest points of the cells of a grid lie within a thin layer in most of the
/// cells under the cloud. What lies in that layer or below goes, around the stem too.
pub(crate) fn above_ground(points: &[Vec3]) -> Option<Vec<Vec3>> {
    let (low, high) = bounds(points);
    let side = high - low;
    let cell = CELL * side.max_element();
    let count = |length: f32| (length / cell) as usize + 1;
    let (columns, rows) = (count(side.x), count(side.z));
    let of = |p: Vec3| count(p.x - low.x) - 1 + (count(p.z - low.z) - 1) * columns;
    let mut lowest = vec![f32::INFINITY; columns * rows];
    for &p in points {
        let at = &mut lowest[of(p)];
        *at = at.min(p.y);
    }
    let layer = low.y + 0.08 * side.y;
    let taken = lowest.iter().filter(|y| y.is_finite()).count();
    let flat = lowest.iter().filter(|&&y| y <= layer).count();
    // A stem alone touches a few cells only.
    if columns.min(rows) < 5 || flat < 20 || flat * 2 < taken {
        return None;
    }
    let (ground, thickness) = (smooth(&lowest, columns, layer), 0.01 * side.y);
    let kept: Vec<Vec3> =
        points.iter().copied().filter(|&p| p.y > ground[of(p)] + thickness).collect();
    let (bottom, top) = bounds(&kept);
    (top.y - bottom.y > 0.2 * side.y).then_some(kept)
}

/// The ground's height in each cell: its own lowest point, or the mean of the ground around it.
fn smooth(lowest: &[f32], columns: usize, layer: f32) -> Vec<f32> {
    let rows = lowest.len() / columns;
    let is_ground = |y: f32| y <= layer;
    let at = |i: usize| {
        let (x, z) = (i % columns, i / columns);
        for reach in 1..columns.max(rows) {
            let (xs, zs) = (x.saturating_sub(reach)..=(x + reach).min(columns - 1), z);
            let zs = zs.saturating_sub(reach)..=(z + reach).min(rows - 1);
            let near: Vec<f32> = zs
                .flat_map(|z| xs.clone().map(move |x| lowest[z * columns + x]))
                .filter(|&y| is_ground(y))
                .collect();
            if near.len() >= 3 {
                return near.iter().sum::<f32>() / near.len() as f32;
            }
        }
        layer
    };
    (0..lowest.len()).map(at).collect()
}

/// Of points joined to those within half a slab's height, the most that belong together.
fn largest_group(points: &[Vec3], all: Vec<u32>, slab: f32) -> Vec<u32> {
    let places: Vec<Vec3> = all.iter().map(|&i| points[i as usize]).collect();
    let index = KdTree::new(&places);
    let mut parts = Parts::new(places.len());
    let mut near = Vec::new();
    for (i, &place) in (0..).zip(&places) {
        index.within(place, 0.5 * slab, &mut near);
        near.iter().for_each(|&k| parts.join(i, k));
    }
    let part: Vec<u32> = (0..places.len() as u32).map(|i| parts.of(i)).collect();
    let mut size = vec![0u32; places.len()];
    part.iter().for_each(|&part| size[part as usize] += 1);
    let largest = (0..size.len()).fold(0, |best, i| if size[i] > size[best] { i } else { best });
    all.into_iter().zip(part).filter(|(_, p)| *p as usize == largest).map(|(i, _)| i).collect()
}

/// The lowest and the highest coordinates.
pub(crate) fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let first = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    points.iter().fold(first, |(low, high), &p| (low.min(p), high.max(p)))
}

fn level(p: Vec3) -> Vec2 {
    Vec2::new(p.x, p.z)
}
