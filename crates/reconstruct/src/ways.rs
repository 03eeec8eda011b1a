//! The way from each point of a cloud to the foot of the tree.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use deeptree_graph::Vec3;

use crate::kdtree::KdTree;

/// Neighbours that each point is joined to.
const NEIGHBOURS: usize = 10;

/// No point.
pub(crate) const NONE: u32 = u32::MAX;

/// Points joined to those around them.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    starts: Vec<u32>,
    edges: Vec<(u32, f32)>,
    /// Median distance of a point from the one next to it, in metres.
    pub(crate) spacing: f32,
}

impl Neighbours {
    /// Joins each point to those nearest to it, and parts that would stay alone across the smallest
    /// gaps there are.
    pub(crate) fn new(points: &[Vec3], index: &KdTree) -> Self {
        let mut links = Vec::with_capacity(points.len() * NEIGHBOURS);
        let mut nearest = Vec::new();
        let mut next = Vec::with_capacity(points.len());
        for (i, &point) in (0..).zip(points) {
            index.nearest_k(point, NEIGHBOURS + 1, &mut nearest);
            let others = nearest.iter().filter(|(k, _)| *k != i);
            links.extend(others.clone().map(|&(k, squared)| (i, k, libm::sqrtf(squared))));
            next.extend(others.map(|&(_, squared)| squared).next());
        }
        next.sort_unstable_by(f32::total_cmp);
        let spacing = next.get(next.len() / 2).map_or(0.0, |&squared| libm::sqrtf(squared));
        bridge(points, index, &mut links);
        let (starts, edges) = adjacency(points.len(), &links);
        Self { starts, edges, spacing }
    }

    /// The neighbours of a point with their distances in metres.
    pub(crate) fn of(&self, point: u32) -> &[(u32, f32)] {
        let [from, to] = [0, 1].map(|i| self.starts[point as usize + i] as usize);
        &self.edges[from..to]
    }
}

/// Links that make parts one: in each round every part but the largest is joined to the point
/// nearest to it outside (Borůvka).
fn bridge(points: &[Vec3], index: &KdTree, links: &mut Vec<(u32, u32, f32)>) {
    let mut parts = Parts::new(points.len());
    links.iter().for_each(|&(a, b, _)| parts.join(a, b));
    loop {
        let part: Vec<u32> = (0..points.len() as u32).map(|i| parts.of(i)).collect();
        let mut size = vec![0u32; points.len()];
        part.iter().for_each(|&part| size[part as usize] += 1);
        let largest =
            (0..size.len()).fold(0, |best, i| if size[i] > size[best] { i } else { best });
        let mut best = vec![(f32::INFINITY, NONE, NONE); points.len()];
        for (i, &point) in (0..).zip(points) {
            let own = part[i as usize];
            if own as usize == largest {
                continue;
            }
            let so_far = best[own as usize].0;
            let found = index.nearest_where(point, so_far, |k| part[k as usize] != own);
            if let Some((k, squared)) = found {
                let distance = libm::sqrtf(squared);
                if distance < so_far {
                    best[own as usize] = (distance, i, k);
                }
            }
        }
        let mut any = false;
        for (distance, a, b) in best.into_iter().filter(|&(_, a, _)| a != NONE) {
            if parts.of(a) != parts.of(b) {
                parts.join(a, b);
                links.push((a, b, distance));
                any = true;
            }
        }
        if !any {
            return;
        }
    }
}

/// Both directions of each link, by the point they start from, none twice.
fn adjacency(points: usize, links: &[(u32, u32, f32)]) -> (Vec<u32>, Vec<(u32, f32)>) {
    let mut both: Vec<(u32, u32, f32)> =
        links.iter().flat_map(|&(a, b, d)| [(a, b, d), (b, a, d)]).collect();
    both.sort_unstable_by_key(|&(a, b, _)| (a, b));
    both.dedup_by_key(|&mut (a, b, _)| (a, b));
    let mut starts = vec![0; points + 1];
    both.iter().for_each(|&(a, ..)| starts[a as usize + 1] += 1);
    for i in 0..points {
        starts[i + 1] += starts[i];
    }
    (starts, both.into_iter().map(|(_, b, d)| (b, d)).collect())
}

/// Which things belong together.
pub(crate) struct Parts {
    parents: Vec<u32>,
}

impl Parts {
    pub(crate) fn new(things: usize) -> Self {
        Self { parents: (0..things as u32).collect() }
    }

    pub(crate) fn of(&mut self, thing: u32) -> u32 {
        let mut at = thing;
        while self.parents[at as usize] != at {
            let up = self.parents[self.parents[at as usize] as usize];
            self.parents[at as usize] = up;
            at = up;
        }
        at
    }

    /// The lower number leads.
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

/// The cheapest way from each point to the nearest of some sources.
///
/// A step costs its length to some power: above 1, ways follow rows of points instead of jumping.
#[derive(Clone, Debug)]
pub(crate) struct Ways {
    /// The next point on the way; none at a source and where no way leads.
    pub(crate) next: Vec<u32>,
    /// Length of the way in metres.
    pub(crate) length: Vec<f32>,
    /// The points that a way leads from, sources first, each after the next on its way.
    pub(crate) order: Vec<u32>,
}

/// Dijkstra's algorithm from the sources.
pub(crate) fn ways(neighbours: &Neighbours, count: usize, sources: &[u32], power: f32) -> Ways {
    let mut cost = vec![f32::INFINITY; count];
    let mut next = vec![NONE; count];
    let mut length = vec![0.0f32; count];
    let mut order = Vec::with_capacity(count);
    let mut done = vec![false; count];
    let mut heap = BinaryHeap::new();
    for &source in sources {
        cost[source as usize] = 0.0;
        heap.push(Front { cost: 0.0, point: source });
    }
    while let Some(Front { cost: at_cost, point }) = heap.pop() {
        let at = point as usize;
        if std::mem::replace(&mut done[at], true) {
            continue;
        }
        order.push(point);
        for &(other, distance) in neighbours.of(point) {
            let there = at_cost + libm::powf(distance, power);
            let to = other as usize;
            if !done[to] && there < cost[to] {
                (cost[to], next[to], length[to]) = (there, point, length[at] + distance);
                heap.push(Front { cost: there, point: other });
            }
        }
    }
    Ways { next, length, order }
}

/// A point on the front; the cheapest is the greatest.
#[derive(PartialEq)]
struct Front {
    cost: f32,
    point: u32,
}

impl Eq for Front {}

impl Ord for Front {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.point.cmp(&self.point))
    }
}

impl PartialOrd for Front {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
