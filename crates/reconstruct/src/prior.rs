//! What the networks expect at a joint: where its children are likely to go.
//!
//! A cloud shows where wood is, not what it is. Where the points leave that open, the networks are
//! asked: the joint is told to them as a node of a tree that they know, children are drawn for it
//! again and again, and the directions they take and the tips they bear are the law that its true
//! children are judged by. Networks that also read the points around a node answer the same question
//! better; [`Prior::draw`] is the one place where nodes are told to them.

use deeptree_graph::signature::{TreeConditions, thickness_of};
use deeptree_graph::{
    ChildSignature, CloudIndex, Kin, Lineage, Neighbourhood, Node, Plan, Quat, Seed, Sense,
    TreeInfo, Vec3,
};
use deeptree_infer::{Active, Branchlet, Overflow, Predictor, Root, Workspace};

/// Branchlets drawn for each joint that is asked.
pub(crate) const DRAWS: usize = 16;

/// Nodes that go through the networks together.
const BATCH: usize = 512;

/// Concentration of the directions around a drawn one: a spread of some 17 degrees.
const KAPPA: f32 = 12.0;

/// Spread of a child's part of the cross-section around a drawn one.
const SHARE_SPREAD: f32 = 0.2;

/// Children a steradian where none was drawn, so that nothing is impossible.
const FLOOR: f32 = 0.01;

/// A joint as the networks are told of it; metres of the cloud, the foot at the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Situation {
    pub(crate) position: Vec3,
    /// Unit direction of the wood that ends here.
    pub(crate) front: Vec3,
    pub(crate) order: u16,
    /// Ways from the foot, from the start of the branch and from the last fork.
    pub(crate) root_distance: f32,
    pub(crate) branch_distance: f32,
    pub(crate) fork_distance: f32,
    /// Share of the tree's wood that is beyond, 0 to 1.
    pub(crate) share: f32,
    /// Longest way beyond.
    pub(crate) reach: f32,
    /// Of this joint and no other of the tree: it keys the draws.
    pub(crate) lineage: Lineage,
}

/// A node of the growth space whose children are drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked<'n> {
    pub(crate) node: &'n Node,
    /// What is to grow below it.
    pub(crate) plan: Plan,
    /// Keys the draws.
    pub(crate) lineage: Lineage,
}

/// The networks, told which kind of tree they look at.
pub(crate) struct Prior<'a> {
    model: &'a dyn Predictor,
    conditions: TreeConditions,
    /// Metres of the growth space a metre of the cloud.
    pub(crate) scale: f32,
    seed: Seed,
    sense: Sense,
    neighbourhood: Neighbourhood,
    /// The points, in the growth space; none until they are heard.
    cloud: Option<CloudIndex>,
}

/// What is known of a tree's shape before the networks are asked; metres of the cloud.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) height: f32,
    pub(crate) crown_radius: f32,
}

impl<'a> Prior<'a> {
    /// The networks as they know species number `species`, at the scale and with the conditions of
    /// that of their trees which is shaped most like this one; none for a tree without height.
    pub(crate) fn new(
        model: &'a dyn Predictor,
        species: usize,
        shape: Shape,
        joints: &[Vec3],
        seed: Seed,
    ) -> Option<Self> {
        let root = Root::of_shape(model.roots(species), shape.crown_radius / shape.height)?;
        let conditions = root.conditions(
            species,
            model.tip_radius(species),
            model.kin(species),
            [0.0; Kin::HABITS],
        );
        let scale = root.traits.height / shape.height;
        let is_sound = scale.is_finite() && scale > 0.0;
        if !is_sound {
            return None;
        }
        let mut neighbourhood = Neighbourhood::of_a_tree();
        joints.iter().for_each(|&joint| neighbourhood.add(joint * scale));
        let centre = joints.iter().sum::<Vec3>() / joints.len().max(1) as f32 * scale;
        let sense = Sense { centre, outlook: centre, ..Sense::default() };
        Some(Self { model, conditions, scale, seed, sense, neighbourhood, cloud: None })
    }

    /// Lets networks that have learned to hear of points hear of these, relative to the foot.
    pub(crate) fn hear(&mut self, points: impl Iterator<Item = Vec3>) {
        let points: Vec<Vec3> = points.map(|point| point * self.scale).collect();
        self.cloud = self.model.hears_points().then(|| CloudIndex::new(&points));
    }

    /// Ends it.
    pub(crate) fn hear_nothing(&mut self) {
        self.cloud = None;
    }

    /// An internode of the networks, in metres of the cloud.
    pub(crate) fn internode(&self) -> f32 {
        1.0 / self.scale
    }

    /// What the networks take the tree for.
    pub(crate) fn info(&self) -> TreeInfo {
        let TreeConditions { species, age, gravitropism, .. } = self.conditions;
        let species = self.model.species()[species].clone();
        TreeInfo { species, age: age as u32, gravitropism, seed: self.seed.0 }
    }

    /// The directions in which the networks expect children of each joint.
    pub(crate) fn expect(
        &self,
        situations: &[Situation],
        work: &mut Workspace,
    ) -> Result<Vec<Expectation>, Overflow> {
        let nodes: Vec<(Node, Plan)> =
            situations.iter().map(|situation| self.node(situation)).collect();
        let turned: Vec<Node> = nodes.iter().flat_map(|(node, ..)| rolled(node)).collect();
        let asked: Vec<Asked<'_>> = turned
            .iter()
            .enumerate()
            .map(|(i, node)| {
                let (of, draw) = (i / DRAWS, (i % DRAWS) as u8);
                Asked { node, plan: nodes[of].1, lineage: situations[of].lineage.child(draw) }
            })
            .collect();
        let branchlets = self.draw(&asked, work)?;
        let mut expectations = vec![Expectation { children: Vec::new() }; situations.len()];
        for (i, (branchlet, node)) in branchlets.iter().zip(&turned).enumerate() {
            let area = |child: &ChildSignature| child.thickness * child.thickness;
            let all: f32 = branchlet.children.iter().flatten().map(area).sum();
            for (slot, child) in branchlet.children.iter().enumerate() {
                let Some(child) = child else { continue };
                let front = node.orientation * child.rotation * Vec3::NEG_Z;
                let drawn = Drawn { front, share: area(child) / all, is_apical: slot == 0 };
                expectations[i / DRAWS].children.push(drawn);
            }
        }
        Ok(expectations)
    }

    /// The branchlets drawn for nodes of the growth space.
    pub(crate) fn draw(
        &self,
        asked: &[Asked<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<Branchlet>, Overflow> {
        let (mut all, mut branchlets) = (Vec::with_capacity(asked.len()), Vec::new());
        for batch in asked.chunks(BATCH) {
            let frontier: Vec<Active<'_>> = batch.iter().map(|asked| self.active(asked)).collect();
            self.model.branchlets(&frontier, work, &mut branchlets)?;
            all.append(&mut branchlets);
        }
        Ok(all)
    }

    fn active<'n>(&'n self, asked: &Asked<'n>) -> Active<'n> {
        let Asked { node, plan, lineage } = *asked;
        Active {
            node,
            parent: None,
            lineage,
            seed: self.seed,
            tree: self.conditions,
            plan,
            sense: self.sense(node.position),
            settled: None,
            room: None,
            points: self.cloud.as_ref(),
        }
    }

    /// What a node at a place of the growth space sees of the tree.
    fn sense(&self, position: Vec3) -> Sense {
        let [near, wide] = self.neighbourhood.around(position);
        Sense { near, wide, ..self.sense }
    }

    /// How many internodes a tree of this shape has.
    pub(crate) fn nodes(&self) -> f32 {
        self.conditions.traits.nodes
    }

    /// From the growth space into the cloud's metres.
    pub(crate) fn in_cloud(&self, position: Vec3) -> Vec3 {
        position / self.scale
    }

    /// The joint as a node of the growth space, with what is to grow below it.
    pub(crate) fn node(&self, of: &Situation) -> (Node, Plan) {
        let conditions = &self.conditions;
        let position = of.position * self.scale;
        let metres = |distance: f32| distance * self.scale;
        let (tips, plan) = Plan::guessed(conditions, of.share, metres(of.reach));
        let orientation = Quat::from_rotation_arc(Vec3::NEG_Z, of.front);
        let node = Node {
            parent: None,
            children: [None; 3],
            slot: 0,
            order: of.order,
            sibling_count: 1,
            position,
            thickness: thickness_of(tips, conditions.tip_radius),
            root_distance: metres(of.root_distance),
            branch_distance: metres(of.branch_distance),
            fork_distance: metres(of.fork_distance),
            rotation: Quat::IDENTITY,
            orientation,
            length: 1.0,
        };
        (node, plan)
    }
}

/// The node turned about its front, once for each draw: which way a bud looks does not show in a
/// cloud.
fn rolled(node: &Node) -> impl Iterator<Item = Node> + '_ {
    (0..DRAWS).map(move |draw| {
        let roll = core::f32::consts::TAU * draw as f32 / DRAWS as f32;
        let orientation = (node.orientation * Quat::from_rotation_z(roll)).normalize();
        Node { orientation, ..node.clone() }
    })
}

/// A child that was drawn.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    /// Unit direction.
    front: Vec3,
    /// Its part of the cross-section of all children.
    share: f32,
    is_apical: bool,
}

/// The logarithm of how well a direction is that of one of some children: see [`KAPPA`].
pub(crate) fn ln_agreement(children: &[Vec3], direction: Vec3) -> f32 {
    let near = |child: &Vec3| libm::expf(KAPPA * (child.dot(direction) - 1.0));
    libm::logf(children.iter().map(near).sum::<f32>() + FLOOR)
}

/// Where children are expected.
#[derive(Clone, Debug)]
pub(crate) struct Expectation {
    children: Vec<Drawn>,
}

impl Expectation {
    /// The logarithm of how many children a steradian are expected in a direction: existence and
    /// direction in one, smoothed by a von Mises–Fisher law around each drawn child.
    pub(crate) fn ln_density(&self, direction: Vec3) -> f32 {
        let peak = KAPPA / core::f32::consts::TAU;
        let near = |child: &Drawn| libm::expf(KAPPA * (child.front.dot(direction) - 1.0));
        let mean = self.children.iter().map(near).sum::<f32>() * peak / DRAWS as f32;
        libm::logf(mean + FLOOR)
    }

    /// The logarithm of how much likelier a child of this direction and part of the cross-section is
    /// to be the apical one than a lateral.
    pub(crate) fn ln_apical_odds(&self, direction: Vec3, share: f32) -> f32 {
        let mut odds = [1e-4; 2];
        for child in &self.children {
            let off = (child.share - share) / SHARE_SPREAD;
            let near = KAPPA * (child.front.dot(direction) - 1.0) - 0.5 * off * off;
            odds[usize::from(child.is_apical)] += libm::expf(near) / DRAWS as f32;
        }
        libm::logf(odds[1] / odds[0])
    }
}
