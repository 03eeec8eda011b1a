//! Points by where they are: nearest neighbours and balls.
//!
//! A balanced k-d tree over the points' own array. Scans have thousands of points with one equal
//! coordinate and many equal points; splitting by rank, not by value, takes both as they are.

use std::cmp::Ordering;

use deeptree_graph::Vec3;

/// Points a leaf may have.
const LEAF: usize = 8;

/// Points that can be asked for those near a place.
#[derive(Clone, Debug)]
pub struct KdTree {
    /// The points in the order of the tree: the middle of each run is its node.
    points: Vec<Vec3>,
    /// The number that each had.
    numbers: Vec<u32>,
    /// Axis that each node splits.
    axes: Vec<u8>,
}

impl KdTree {
    /// The tree of some finite points.
    #[must_use]
    pub fn new(points: &[Vec3]) -> Self {
        let mut numbers: Vec<u32> = (0..points.len() as u32).collect();
        let mut axes = vec![0; points.len()];
        split(points, &mut numbers, &mut axes);
        Self { points: numbers.iter().map(|&i| points[i as usize]).collect(), numbers, axes }
    }

    /// How many points there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Are there none?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The nearest point for which `admits` holds, within a distance: its number and the square of
    /// its distance. Of points equally far the one with the lowest number.
    pub fn nearest_where(
        &self,
        at: Vec3,
        within: f32,
        mut admits: impl FnMut(u32) -> bool,
    ) -> Option<(u32, f32)> {
        let mut best = (u32::MAX, within * within);
        self.visit(at, best.1, &mut |number, squared| {
            let nearer = (squared, number) < (best.1, best.0) || best.0 == u32::MAX;
            if nearer && squared <= best.1 && admits(number) {
                best = (number, squared);
            }
            best.1
        });
        (best.0 != u32::MAX).then_some(best)
    }

    /// The nearest point, its number and the square of its distance; none without points.
    #[must_use]
    pub fn nearest(&self, at: Vec3) -> Option<(u32, f32)> {
        self.nearest_where(at, f32::INFINITY, |_| true)
    }

    /// The `k` nearest points into `out`, nearest first, as numbers and squares of distances.
    pub fn nearest_k(&self, at: Vec3, k: usize, out: &mut Vec<(u32, f32)>) {
        out.clear();
        if k == 0 {
            return;
        }
        self.visit(at, f32::INFINITY, &mut |number, squared| {
            let place = out.partition_point(|&(n, s)| (s, n) < (squared, number));
            if place < k {
                out.truncate(k - 1);
                out.insert(place, (number, squared));
            }
            if out.len() == k { out[k - 1].1 } else { f32::INFINITY }
        });
    }

    /// The points of a ball into `out`, by number.
    pub fn within(&self, at: Vec3, radius: f32, out: &mut Vec<u32>) {
        out.clear();
        let most = radius * radius;
        self.visit(at, most, &mut |number, squared| {
            if squared <= most {
                out.push(number);
            }
            most
        });
        out.sort_unstable();
    }

    /// Hands the points within a distance to `see`, which says how far it still looks (squares).
    fn visit(&self, at: Vec3, mut most: f32, see: &mut impl FnMut(u32, f32) -> f32) {
        let mut stack = [(0, 0, 0.0); 64];
        stack[0] = (0, self.points.len(), 0.0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (mut low, mut high, bound) = stack[height];
            if bound > most {
                continue;
            }
            while high - low > LEAF {
                let middle = usize::midpoint(low, high);
                let axis = usize::from(self.axes[middle]);
                let aside = at[axis] - self.points[middle][axis];
                most = see(self.numbers[middle], at.distance_squared(self.points[middle]));
                let (near, far) = if aside < 0.0 {
                    ((low, middle), (middle + 1, high))
                } else {
                    ((middle + 1, high), (low, middle))
                };
                stack[height] = (far.0, far.1, aside * aside);
                height += 1;
                (low, high) = near;
            }
            for i in low..high {
                most = see(self.numbers[i], at.distance_squared(self.points[i]));
            }
        }
    }
}

/// Orders a run so that its middle splits it along its longest side, and so on in both halves.
fn split(points: &[Vec3], numbers: &mut [u32], axes: &mut [u8]) {
    if numbers.len() <= LEAF {
        return;
    }
    let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &i in numbers.iter() {
        let point = points[i as usize];
        bounds = (bounds.0.min(point), bounds.1.max(point));
    }
    let side = bounds.1 - bounds.0;
    let axis = (1..3).fold(0, |best, axis| if side[axis] > side[best] { axis } else { best });
    let order = |a: &u32, b: &u32| -> Ordering {
        let (x, y) = (points[*a as usize][axis], points[*b as usize][axis]);
        x.total_cmp(&y).then(a.cmp(b))
    };
    let middle = numbers.len() / 2;
    numbers.select_nth_unstable_by(middle, order);
    axes[middle] = axis as u8;
    let (low, high) = numbers.split_at_mut(middle);
    let (axes_low, axes_high) = axes.split_at_mut(middle);
    split(points, low, axes_low);
    split(points, &mut high[1..], &mut axes_high[1..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::{Lineage, Purpose, Seed};

    fn cloud(n: u64, grid: f32) -> Vec<Vec3> {
        let draw = |i: u64, axis: u64| {
            let x = Seed(i).draws(Lineage::ROOT, Purpose::Evaluation).at(axis).uniform() as f32;
            // On a grid many coordinates and many points are equal.
            if grid > 0.0 { (x / grid).round() * grid } else { x }
        };
        (0..n).map(|i| Vec3::new(draw(i, 0), draw(i, 1), draw(i, 2))).collect()
    }

    #[test]
    fn neighbours_and_balls_are_those_of_looking_at_every_point() {
        for (n, grid) in [(0, 0.0), (1, 0.0), (9, 0.0), (700, 0.0), (700, 0.125), (300, 1.0)] {
            let points = cloud(n, grid);
            let tree = KdTree::new(&points);
            let (mut nearest, mut ball) = (Vec::new(), Vec::new());
            for at in cloud(40, 0.03) {
                let mut all: Vec<(u32, f32)> =
                    (0..).zip(&points).map(|(i, p)| (i, at.distance_squared(*p))).collect();
                all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
                tree.nearest_k(at, 12, &mut nearest);
                assert_eq!(nearest, all[..all.len().min(12)]);
                assert_eq!(tree.nearest(at), all.first().copied());
                let odd = all.iter().find(|(i, _)| i % 7 == 3).copied();
                assert_eq!(tree.nearest_where(at, f32::INFINITY, |i| i % 7 == 3), odd);
                tree.within(at, 0.3, &mut ball);
                let mut inside: Vec<u32> =
                    all.iter().filter(|(_, s)| *s <= 0.3 * 0.3).map(|(i, _)| *i).collect();
                inside.sort_unstable();
                assert_eq!(ball, inside);
            }
        }
    }
}
