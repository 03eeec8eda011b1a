//! Branches that grow through each other.

use deeptree_graph::{BranchGraph, Node, Vec3};

/// Side of the cells that capsules are sorted into, in metres: about an internode.
const CELL: f32 = 1.0;

/// A cell by its column, layer and row.
type Cell = [i32; 3];

/// The wood of a node: all points within its radius of its edge.
struct Capsule {
    from: Vec3,
    to: Vec3,
    radius: f32,
    low: Cell,
    high: Cell,
}

impl Capsule {
    fn of(node: &Node) -> Self {
        let (from, to, radius) = (node.base(), node.position, node.thickness);
        let cell = |p: Vec3| (p / CELL).to_array().map(|x| libm::floorf(x) as i32);
        let (low, high) = (cell(from.min(to) - radius), cell(from.max(to) + radius));
        Self { from, to, radius, low, high }
    }

    fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        let range = |axis: usize| self.low[axis]..=self.high[axis];
        range(0).flat_map(move |x| range(1).flat_map(move |y| range(2).map(move |z| [x, y, z])))
    }

    fn meets(&self, other: &Self) -> bool {
        let reach = self.radius + other.radius;
        distance_squared([self.from, self.to], [other.from, other.to]) < reach * reach
    }

    /// Is this the first of the cells that both are in? So each pair is looked at once.
    fn meet_first_in(&self, other: &Self, cell: Cell) -> bool {
        (0..3).all(|axis| cell[axis] == self.low[axis].max(other.low[axis]))
    }
}

/// How many pairs of internodes of a tree share space: capsules around their edges, of the nodes'
/// radii, that come closer than the sum of both. Parent and child do not count, nor do siblings,
/// which meet by construction.
#[must_use]
pub fn intersections(tree: &BranchGraph) -> u64 {
    let capsules: Vec<Capsule> = tree.nodes().iter().map(Capsule::of).collect();
    count(&capsules, |a, b| {
        let (parent, other_parent) = (tree.node(a).parent, tree.node(b).parent);
        parent != Some(b) && other_parent != Some(a) && parent != other_parent
    })
}

/// How many pairs of internodes of different trees share space: as [`intersections`], of trees that
/// stand at their places.
#[must_use]
pub fn intersections_between(trees: &[BranchGraph]) -> u64 {
    let of = |(number, tree): (usize, &BranchGraph)| vec![number; tree.len()];
    let owners: Vec<usize> = trees.iter().enumerate().flat_map(of).collect();
    let capsules: Vec<Capsule> =
        trees.iter().flat_map(|tree| tree.nodes().iter().map(Capsule::of)).collect();
    count(&capsules, |a, b| owners[a as usize] != owners[b as usize])
}

/// The pairs of capsules that share space, of those that count.
fn count(capsules: &[Capsule], counts: impl Fn(u32, u32) -> bool) -> u64 {
    let mut places: Vec<(Cell, u32)> = Vec::new();
    for (id, capsule) in (0..).zip(capsules) {
        places.extend(capsule.cells().map(|cell| (cell, id)));
    }
    places.sort_unstable();
    let mut count = 0;
    for here in places.chunk_by(|a, b| a.0 == b.0) {
        for (i, &(cell, a)) in here.iter().enumerate() {
            let capsule = &capsules[a as usize];
            for &(_, b) in &here[i + 1..] {
                let other = &capsules[b as usize];
                let is_new = counts(a, b) && capsule.meet_first_in(other, cell);
                count += u64::from(is_new && capsule.meets(other));
            }
        }
    }
    count
}

/// The square of the least distance between two segments.
///
/// At the nearest points of the two lines where both lie within the segments; else one of the
/// four ends is nearest to the other segment.
fn distance_squared(a: [Vec3; 2], b: [Vec3; 2]) -> f32 {
    let (along_a, along_b, between) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, bb, ab) = (along_a.length_squared(), along_b.length_squared(), along_a.dot(along_b));
    let (a_between, b_between) = (along_a.dot(between), along_b.dot(between));
    let determinant = aa * bb - ab * ab;
    if determinant > 1e-9 * aa * bb {
        let s = (ab * b_between - bb * a_between) / determinant;
        let t = (aa * b_between - ab * a_between) / determinant;
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            return (between + s * along_a - t * along_b).length_squared();
        }
    }
    let ends = [to_segment(a[0], b), to_segment(a[1], b), to_segment(b[0], a), to_segment(b[1], a)];
    ends.into_iter().fold(f32::INFINITY, f32::min)
}

/// The square of the distance from a point to a segment.
fn to_segment(point: Vec3, [from, to]: [Vec3; 2]) -> f32 {
    let along = to - from;
    let at = (point - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    (point - from - at.clamp(0.0, 1.0) * along).length_squared()
}

#[cfg(test)]
mod tests {
    use deeptree_graph::{ChildSignature, Quat, Seed, TreeInfo};
    use deeptree_growth::{Profile, Species, grow};

    use super::*;

    const THIN: f32 = 0.05;

    /// A chain of edges in these directions, of their lengths, and this radius.
    fn chain(way: &[Vec3], radius: f32) -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let mut frame = Quat::IDENTITY;
        let mut edge = |v: &Vec3| {
            let target = Quat::from_rotation_arc(Vec3::NEG_Z, v.normalize());
            let rotation = frame.inverse() * target;
            frame = target;
            ChildSignature { rotation, thickness: radius, length: v.length() }
        };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(&way[0]));
        for (id, v) in (0..).zip(&way[1..]) {
            tree.grow(id, [Some(edge(v)), None, None]);
        }
        tree
    }

    /// Up 2 m, right 1 m, down 1 m, then left past the first edge at this depth behind it.
    fn loop_behind(depth: f32, radius: f32) -> BranchGraph {
        let out = Vec3::new(1.0, 0.0, -depth);
        chain(&[2.0 * Vec3::Y, out, Vec3::NEG_Y, 2.0 * Vec3::NEG_X], radius)
    }

    #[test]
    fn a_chain_that_loops_through_its_start_meets_it_once() {
        assert_eq!(intersections(&loop_behind(0.01, THIN)), 1);
        // Two radii apart, and a little more or less.
        assert_eq!(intersections(&loop_behind(0.099, THIN)), 1);
        assert_eq!(intersections(&loop_behind(0.101, THIN)), 0);
        // So thick, all four meet: three pairs that are not parent and child.
        assert_eq!(intersections(&loop_behind(0.01, 0.6)), 3);
    }

    #[test]
    fn parents_children_and_siblings_do_not_count() {
        let mut tree = chain(&[Vec3::Y], THIN);
        let child = ChildSignature { rotation: Quat::IDENTITY, thickness: THIN, length: 1.0 };
        tree.grow(0, [Some(child); 3]);
        assert_eq!(intersections(&tree), 0, "three on the same place, all siblings");
        // Cousins on the same place: each of three with each, and with the two uncles that are no
        // parents, at whose ends they begin.
        for id in 1..=3 {
            tree.grow(id, [Some(child), None, None]);
        }
        assert_eq!(intersections(&tree), 3 + 6);
    }

    #[test]
    fn only_internodes_of_different_trees_count_between_trees() {
        let post = |x: f32| chain(&[2.0 * Vec3::Y, Vec3::Y], THIN).moved(Vec3::new(x, 0.0, 0.0));
        // Both internodes of one are within two radii of both of the other; the third is too far.
        assert_eq!(intersections_between(&[post(0.0), post(0.09), post(0.3)]), 4);
        assert_eq!(intersections_between(&[loop_behind(0.01, THIN)]), 0);
    }

    #[test]
    fn long_edges_meet_once_though_they_share_many_cells() {
        // Down again beside the trunk, within both radii over all its 8 m.
        let way = [8.0 * Vec3::Y, Vec3::X, Vec3::new(-0.95, 0.0, 0.0), 8.0 * Vec3::NEG_Y];
        // The trunk with the third edge, whose end it meets, and with the fourth; the second with
        // the fourth, which starts 0.05 m off it.
        assert_eq!(intersections(&chain(&way, THIN)), 3);
    }

    #[test]
    fn distances_of_segments_are_those_of_geometry() {
        let p = |x, y, z| Vec3::new(x, y, z);
        let of = |a, b| distance_squared(a, b).sqrt();
        let bar = [p(0.0, 0.0, 0.0), p(4.0, 0.0, 0.0)];
        assert_eq!(of(bar, [p(1.0, -1.0, 2.0), p(1.0, 1.0, 2.0)]), 2.0, "crossing");
        assert_eq!(of(bar, [p(7.0, 4.0, 0.0), p(7.0, 8.0, 0.0)]), 5.0, "end to end");
        assert_eq!(of(bar, [p(3.0, 3.0, 0.0), p(9.0, 3.0, 0.0)]), 3.0, "side by side");
        assert_eq!(of(bar, [p(6.0, 0.0, 0.0), p(9.0, 0.0, 0.0)]), 2.0, "in one line");
        assert_eq!(of(bar, [p(2.0, 1.0, 0.0), p(2.0, 1.0, 0.0)]), 1.0, "a point");
    }

    #[test]
    fn the_grid_finds_what_looking_at_all_pairs_finds() {
        let maple = Species::named("maple").unwrap();
        let tree = grow("maple", maple.parameters(Profile::Reference), Seed(3)).unwrap().tree;
        let capsules: Vec<Capsule> = tree.nodes().iter().map(Capsule::of).collect();
        let mut count = 0;
        for (a, one) in tree.nodes().iter().enumerate() {
            for (b, other) in tree.nodes().iter().enumerate().take(a) {
                let are_kin = one.parent == Some(b as u32) || one.parent == other.parent;
                count += u64::from(!are_kin && capsules[a].meets(&capsules[b]));
            }
        }
        assert!(count > 0);
        assert_eq!(intersections(&tree), count);
    }
}
