//! What a node sees of what has grown so far: how crowded its neighbourhood is, and where the crown
//! has its weight.
//!
//! A tree grows level by level: all nodes of one depth, then their children. While the nodes of a
//! level are asked for their children, *so far* means all nodes of that level and the ones before.
//! The same rule applied to a finished tree tells what each of its nodes saw, so that networks learn
//! from the same numbers that growth gives them. All sums are of integers: neither the order of the
//! nodes nor the number of threads changes a bit.

use glam::{IVec3, Vec3};

use crate::graph::{BranchGraph, Node, NodeId};
use crate::plan::Plan;
use crate::signature::{GROWTH_SPACE, tip_count};
use crate::surround::Surround;

/// Side of the cells of the near neighbourhood in metres: the voxels of the occupancy grid.
const NEAR_CELL: f32 = 2.0;

/// Side of the cells of the wide neighbourhood in metres.
const WIDE_CELL: f32 = 8.0;

/// What a node sees of what has grown so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sense {
    /// Mean position of the tree's nodes so far, in metres: the crown's centre, which shoots of the
    /// growth model turn away from.
    pub centre: Vec3,
    /// Where the tips of the tree will be on average, in metres, if every node bore its tips half
    /// its reach straight ahead.
    pub outlook: Vec3,
    /// The 3³ cells of 2 m around the node.
    pub near: Crowd,
    /// The 3³ cells of 8 m around the node.
    pub wide: Crowd,
    /// What stands around the tree.
    pub surround: Surround,
}

/// The nodes in the cells around a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crowd {
    /// How many they are, of whatever tree.
    pub nodes: u32,
    /// From the place to the mean of their cells' centres, in metres.
    pub towards: Vec3,
}

/// How many nodes stand where: what [`Sense`] is told of the neighbourhood. Each tree has its own, in
/// its own frame; in a stand the nodes of the others are counted in it, too.
#[derive(Clone, Debug)]
pub struct Neighbourhood {
    near: Grid,
    wide: Grid,
}

impl Neighbourhood {
    /// The empty neighbourhood of one tree: the growth space. Nodes outside of it are not counted.
    #[must_use]
    pub fn of_a_tree() -> Self {
        let half = GROWTH_SPACE / 2.0;
        let (low, high) = (Vec3::new(-half, 0.0, -half), Vec3::new(half, GROWTH_SPACE, half));
        Self { near: Grid::new(low, high, NEAR_CELL), wide: Grid::new(low, high, WIDE_CELL) }
    }

    /// Counts a node.
    pub fn add(&mut self, position: Vec3) {
        self.near.add(position);
        self.wide.add(position);
    }

    /// Who is near and who is around.
    #[must_use]
    pub fn around(&self, position: Vec3) -> [Crowd; 2] {
        [self.near.around(position), self.wide.around(position)]
    }
}

/// Counts by cell, with a border of cells that stay empty.
#[derive(Clone, Debug)]
struct Grid {
    cell: f32,
    low: Vec3,
    dims: IVec3,
    counts: Vec<u16>,
}

impl Grid {
    fn new(low: Vec3, high: Vec3, cell: f32) -> Self {
        let dims = ((high - low) / cell).ceil().max(Vec3::ONE).as_ivec3() + 2;
        let cells = dims.x as usize * dims.y as usize * dims.z as usize;
        Self { cell, low, dims, counts: vec![0; cells] }
    }

    /// The cell of a place, counted with the border; places outside are in the border.
    fn cell_of(&self, position: Vec3) -> IVec3 {
        let cell = ((position - self.low) / self.cell).floor() + 1.0;
        cell.clamp(Vec3::ZERO, (self.dims - 1).as_vec3()).as_ivec3()
    }

    fn index(&self, cell: IVec3) -> usize {
        ((cell.y * self.dims.z + cell.z) * self.dims.x + cell.x) as usize
    }

    fn add(&mut self, position: Vec3) {
        let cell = self.cell_of(position);
        let inside = cell.cmpge(IVec3::ONE).all() && cell.cmplt(self.dims - 1).all();
        if inside {
            let index = self.index(cell);
            self.counts[index] = self.counts[index].saturating_add(1);
        }
    }

    fn around(&self, position: Vec3) -> Crowd {
        // The cells around one in the border would reach out of the grid.
        let home = self.cell_of(position).clamp(IVec3::ONE, self.dims - 2);
        let (mut nodes, mut sum) = (0, IVec3::ZERO);
        for y in -1..=1 {
            for z in -1..=1 {
                let row = self.index(home + IVec3::new(-1, y, z));
                let [a, b, c] = [0, 1, 2].map(|x| i32::from(self.counts[row + x]));
                let all = a + b + c;
                nodes += all;
                sum += IVec3::new(c - a, y * all, z * all);
            }
        }
        if nodes == 0 {
            return Crowd::default();
        }
        let centre = self.low + ((home - 1).as_vec3() + 0.5) * self.cell;
        let towards = centre + sum.as_vec3() * (self.cell / nodes as f32) - position;
        Crowd { nodes: nodes as u32, towards }
    }
}

/// Where a tree has its weight so far, and where it will have it.
#[derive(Clone, Debug, Default)]
pub struct Balance {
    nodes: i64,
    /// Σ position of the nodes.
    sum: Moment,
    /// Σ tips · position over the tips that have ended.
    ended: Moment,
    /// Σ tips · position over the tips that the last level bears.
    borne: Moment,
    /// The same where those tips will be.
    ahead: Moment,
    tips: i64,
}

/// A sum of positions in steps of 2⁻¹⁰ m: exact, so its order does not matter.
#[derive(Clone, Copy, Debug, Default)]
struct Moment([i64; 3]);

/// Steps of a metre.
const STEPS: f32 = 1024.0;

impl Moment {
    fn add(&mut self, position: Vec3, times: i64) {
        for (sum, x) in self.0.iter_mut().zip((position * STEPS).round().to_array()) {
            *sum = sum.wrapping_add((x as i64).wrapping_mul(times));
        }
    }

    fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].wrapping_add(other.0[i])))
    }

    /// The mean of `count` positions.
    fn mean(self, count: i64) -> Vec3 {
        let scale = 1.0 / (f64::from(STEPS) * count.max(1) as f64);
        Vec3::from_array(self.0.map(|x| (x as f64 * scale) as f32))
    }
}

impl Balance {
    /// Counts the nodes of the next level.
    ///
    /// `tip_radius` is that of the tree, in metres; `reach` gives the longest path below a node.
    pub fn add_level(
        &mut self,
        tree: &BranchGraph,
        level: &[NodeId],
        tip_radius: f32,
        reach: impl Fn(NodeId) -> u16,
    ) {
        // What the last level bore and this one does not has ended there.
        self.ended = self.ended.plus(self.borne);
        (self.borne, self.ahead) = (Moment::default(), Moment::default());
        for &id in level {
            let node = tree.node(id);
            let tips = i64::from(tip_count(node.thickness, tip_radius));
            if let Some(parent) = node.parent {
                self.ended.add(tree.node(parent).position, -tips);
            } else {
                self.tips = tips;
            }
            self.sum.add(node.position, 1);
            self.borne.add(node.position, tips);
            self.ahead.add(node.position + 0.5 * f32::from(reach(id)) * node.front(), tips);
        }
        self.nodes += level.len() as i64;
    }

    /// Counts so many more tips among those that have ended, at a position: tips that another branch
    /// bears than was counted when its level was.
    pub fn add_ended(&mut self, position: Vec3, tips: i64) {
        self.ended.add(position, tips);
    }

    /// What every node of the last level sees of the tree as a whole: its centre and its outlook.
    #[must_use]
    pub fn centres(&self) -> [Vec3; 2] {
        [self.sum.mean(self.nodes), self.ended.plus(self.ahead).mean(self.tips)]
    }
}

/// What each node of a finished tree saw when it was asked for its children, in the open field.
#[must_use]
pub fn senses(tree: &BranchGraph, tip_radius: f32, plans: &[Plan]) -> Vec<Sense> {
    senses_in(tree, tip_radius, plans, |_| Surround::default())
}

/// As [`senses`], among what stands around.
///
/// `surround` tells what a node sees of what stands around.
#[must_use]
pub fn senses_in(
    tree: &BranchGraph,
    tip_radius: f32,
    plans: &[Plan],
    surround: impl Fn(&Node) -> Surround,
) -> Vec<Sense> {
    let mut neighbourhood = Neighbourhood::of_a_tree();
    let mut balance = Balance::default();
    let mut senses = vec![Sense::default(); tree.len()];
    let mut level: Vec<NodeId> = vec![0];
    while !level.is_empty() {
        for &id in &level {
            neighbourhood.add(tree.node(id).position);
        }
        balance.add_level(tree, &level, tip_radius, |id| plans[id as usize].reach);
        let [centre, outlook] = balance.centres();
        let mut next = Vec::new();
        for &id in &level {
            let [near, wide] = neighbourhood.around(tree.node(id).position);
            let surround = surround(tree.node(id));
            senses[id as usize] = Sense { centre, outlook, near, wide, surround };
            next.extend(tree.node(id).children.into_iter().flatten());
        }
        level = next;
    }
    senses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random_tree;
    use crate::{ChildSignature, Quat, TreeInfo, plans};

    /// A trunk of two nodes, a metre each, that forks into an arm of two along x and a stub along −x.
    fn tee() -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
        let edge = |rotation: Quat, tips: f32| ChildSignature {
            rotation,
            thickness: 0.01 * tips.sqrt(),
            length: 1.0,
        };
        let up = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let side = |sign: f32| Quat::from_rotation_y(sign * std::f32::consts::FRAC_PI_2);
        let straight = Quat::IDENTITY;
        let mut tree = BranchGraph::new(info, Vec3::ZERO, edge(up, 4.0));
        tree.grow(0, [Some(edge(straight, 4.0)), None, None]);
        tree.grow(1, [None, Some(edge(side(-1.0), 3.0)), Some(edge(side(1.0), 1.0))]);
        tree.grow(2, [Some(edge(straight, 3.0)), None, None]);
        tree
    }

    #[test]
    fn a_small_tree_sees_what_was_worked_out_by_hand() {
        let tree = tee();
        let place = |id: usize| tree.nodes()[id].position;
        assert!(place(4).distance(Vec3::new(2.0, 2.0, 0.0)) < 1e-5, "{}", place(4));
        let senses = senses(&tree, 0.01, &plans(&tree));
        let near = |a: Vec3, b: [f32; 3]| assert!(a.distance(b.into()) < 2e-3, "{a} {b:?}");
        // The root alone: four tips, half of its reach of three above it.
        near(senses[0].centre, [0.0, 1.0, 0.0]);
        near(senses[0].outlook, [0.0, 2.5, 0.0]);
        // The level of the fork: (1, 2, 0) with three tips and reach 1, (−1, 2, 0) with one tip.
        near(senses[2].centre, [0.0, 7.0 / 4.0, 0.0]);
        near(senses[2].outlook, [(3.0 * 1.5 - 1.0) / 4.0, 2.0, 0.0]);
        assert_eq!(senses[2].outlook, senses[3].outlook);
        // At the end, the stub's tip has ended where the stub is.
        near(senses[4].outlook, [(3.0 * 2.0 - 1.0) / 4.0, 2.0, 0.0]);
        assert_eq!([0, 1, 2, 3, 4].map(|id| senses[id].wide.nodes), [1, 2, 4, 4, 5]);
    }

    #[test]
    fn the_crowd_is_the_nodes_in_the_27_cells_around() {
        let tree = random_tree(3, 400);
        let mut grid = Grid::new(Vec3::splat(-20.0), Vec3::splat(20.0), 2.0);
        let inside: Vec<Vec3> = tree.nodes().iter().map(|node| node.position).collect();
        inside.iter().for_each(|&p| grid.add(p));
        let cell = |p: Vec3| (p / 2.0).floor();
        for &p in inside.iter().filter(|p| p.abs().max_element() < 17.0) {
            let around = inside.iter().filter(|&&q| (cell(q) - cell(p)).abs().max_element() <= 1.0);
            let centres: Vec<Vec3> = around.map(|&q| (cell(q) + 0.5) * 2.0 - p).collect();
            let crowd = grid.around(p);
            assert_eq!(crowd.nodes as usize, centres.len());
            let mean = centres.iter().sum::<Vec3>() / centres.len() as f32;
            assert!(crowd.towards.distance(mean) < 1e-4, "{crowd:?} {mean}");
        }
    }

    #[test]
    fn places_outside_of_the_grid_are_not_counted_and_see_its_border() {
        let mut grid = Grid::new(Vec3::ZERO, Vec3::splat(8.0), 2.0);
        grid.add(Vec3::new(-0.1, 4.0, 4.0));
        grid.add(Vec3::splat(f32::NAN));
        assert_eq!(grid.around(Vec3::splat(4.0)), Crowd::default());
        grid.add(Vec3::splat(1.0));
        assert_eq!(grid.around(Vec3::splat(-50.0)).nodes, 1);
    }
}
