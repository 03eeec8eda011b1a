//! The points of a cloud, by place: what stands near a node.

use glam::{IVec3, Vec3};

use crate::signature::points::{MOST_POINTS, RADIUS};

/// Side of the cells that points are sorted into, in metres.
const CELL: f32 = RADIUS;

/// A cloud in the frame of a tree: metres of the growth space, y up.
///
/// The order in which points are given changes nothing.
#[derive(Clone, Debug)]
pub struct CloudIndex {
    /// Sorted by cell, then by coordinates.
    points: Vec<Vec3>,
    /// Cells that hold points, by y, z and x, each with the number of its first point; then one past
    /// the last point.
    cells: Vec<([i32; 3], u32)>,
}

impl CloudIndex {
    /// The index of some points. Those without finite coordinates are left out.
    #[must_use]
    pub fn new(points: &[Vec3]) -> Self {
        let key = |point: &Vec3| (cell(*point), point.to_array().map(ordered));
        let mut points: Vec<Vec3> = points.iter().copied().filter(|p| p.is_finite()).collect();
        points.sort_unstable_by_key(key);
        let mut cells: Vec<([i32; 3], u32)> = Vec::new();
        for (i, point) in (0..).zip(&points) {
            let cell = cell(*point);
            if cells.last().is_none_or(|(last, _)| *last != cell) {
                cells.push((cell, i));
            }
        }
        Self { points, cells }
    }

    /// How many points there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Is there no point?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The points within [`RADIUS`] of a place, at most [`MOST_POINTS`] of them: of more, some
    /// evenly spread over them in the order of cells. Replaces what `out` holds.
    pub fn around(&self, place: Vec3, out: &mut Vec<Vec3>) {
        out.clear();
        let [y, z, x] = cell(place);
        for y in [y - 1, y, y + 1] {
            for z in [z - 1, z, z + 1] {
                let span = self.span([y, z, x - 1], [y, z, x + 1]);
                let near = |point: &&Vec3| point.distance_squared(place) <= RADIUS * RADIUS;
                out.extend(self.points[span].iter().filter(near));
            }
        }
        let found = out.len();
        if found > MOST_POINTS {
            for i in 0..MOST_POINTS {
                out[i] = out[i * found / MOST_POINTS];
            }
            out.truncate(MOST_POINTS);
        }
    }

    /// The points of the cells from one to another, both included.
    fn span(&self, from: [i32; 3], to: [i32; 3]) -> core::ops::Range<usize> {
        let start =
            |at: usize| self.cells.get(at).map_or(self.points.len(), |cell| cell.1 as usize);
        let first = self.cells.partition_point(|(cell, _)| *cell < from);
        let last = self.cells.partition_point(|(cell, _)| *cell <= to);
        start(first)..start(last)
    }
}

/// The cell of a place by y, z and x, so that the cells of a row stand side by side. What is beyond
/// a billion cells shares the last, so that every cell has others on both sides.
fn cell(place: Vec3) -> [i32; 3] {
    let most = Vec3::splat(1e9);
    let IVec3 { x, y, z } = (place / CELL).floor().clamp(-most, most).as_ivec3();
    [y, z, x]
}

/// A key that sorts finite numbers as their values are.
fn ordered(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    bits ^ (((bits >> 31) as u32) >> 1) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Draws, Lineage, Purpose, Seed};

    fn random(draws: &mut Draws, side: f64) -> Vec3 {
        let mut axis = || (side * (draws.uniform() - 0.5)) as f32;
        Vec3::new(axis(), axis(), axis())
    }

    fn cloud(points: usize, side: f64) -> Vec<Vec3> {
        let mut draws = Seed(3).draws(Lineage::ROOT, Purpose::Evaluation);
        (0..points).map(|_| random(&mut draws, side)).collect()
    }

    #[test]
    fn what_is_near_is_what_a_search_of_all_points_finds() {
        let points = cloud(2000, 20.0);
        let index = CloudIndex::new(&points);
        let mut draws = Seed(4).draws(Lineage::ROOT, Purpose::Evaluation);
        let mut found = Vec::new();
        for _ in 0..200 {
            let place = random(&mut draws, 24.0);
            index.around(place, &mut found);
            let near = |point: &&Vec3| point.distance_squared(place) <= RADIUS * RADIUS;
            assert_eq!(found.len(), points.iter().filter(near).count());
            assert!(found.iter().all(|point| near(&point) && points.contains(point)));
        }
    }

    #[test]
    fn neither_order_nor_points_that_are_none_change_what_is_near() {
        let mut points = cloud(5000, 6.0);
        let (mut a, mut b) = (Vec::new(), Vec::new());
        CloudIndex::new(&points).around(Vec3::ZERO, &mut a);
        points.reverse();
        points.insert(17, Vec3::new(0.0, f32::NAN, 0.0));
        points.push(Vec3::splat(f32::INFINITY));
        CloudIndex::new(&points).around(Vec3::ZERO, &mut b);
        assert_eq!(a.len(), MOST_POINTS);
        assert_eq!(a, b);
    }

    #[test]
    fn places_and_points_far_outside_are_no_trouble() {
        let far = Vec3::splat(3e38);
        let index = CloudIndex::new(&[far, Vec3::ZERO, -far]);
        let mut found = Vec::new();
        index.around(Vec3::ONE, &mut found);
        assert_eq!(found, [Vec3::ZERO]);
        index.around(-far, &mut found);
        assert!(found.len() <= 1);
        assert_eq!((index.len(), index.is_empty()), (3, false));
        CloudIndex::new(&[]).around(Vec3::ZERO, &mut found);
        assert!(found.is_empty());
    }
}
