//! Which child of a fork its branch goes on with, and of which species the forks are: questions that
//! points do not answer.

use deeptree_graph::{Lineage, Vec3};
use deeptree_infer::{Overflow, Workspace};

use crate::prior::{Expectation, Prior, Situation};
use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// Children shorter than this share of an internode are no choice.
const SHORT: f32 = 0.3;

/// Forks that a species is judged by at most: the ones that carry the most.
const WITNESSES: usize = 48;

/// For each joint the child that its branch goes on with: of a fork, the one that the networks find
/// likeliest to be the apical one by where it goes and how much it carries.
///
/// # Errors
///
/// When the model's numbers overflow.
pub(crate) fn apical(
    skeleton: &Skeleton,
    prior: &Prior<'_>,
    work: &mut Workspace,
) -> Result<Vec<u32>, Overflow> {
    let view = View::new(skeleton, prior.internode());
    let forks = view.forks(skeleton);
    let expected = view.expect(&forks, prior, work)?;
    let mut heirs = view.heirs.clone();
    for (fork, expected) in forks.iter().zip(&expected) {
        let all: f32 = fork.children.iter().map(|&i| view.beyond[i as usize]).sum();
        let odds = |i: u32| {
            let share = view.beyond[i as usize] / all;
            expected.ln_apical_odds(view.towards(fork.joint, i), share)
        };
        let offers = fork.children.iter().map(|&i| (odds(i), i));
        if let Some((_, heir)) = offers.reduce(|a, b| if b.0 > a.0 { b } else { a }) {
            heirs[fork.joint as usize] = heir;
        }
    }
    Ok(heirs)
}

/// How well the networks of a species expect the forks of a skeleton: the mean logarithm of the
/// children a steradian that they expect where there is one.
///
/// # Errors
///
/// When the model's numbers overflow.
pub(crate) fn ln_likelihood(
    skeleton: &Skeleton,
    prior: &Prior<'_>,
    work: &mut Workspace,
) -> Result<f32, Overflow> {
    let view = View::new(skeleton, prior.internode());
    let mut forks = view.forks(skeleton);
    let carried = |fork: &Fork| view.beyond[fork.joint as usize];
    forks.sort_by(|a, b| carried(b).total_cmp(&carried(a)).then(a.joint.cmp(&b.joint)));
    forks.truncate(WITNESSES);
    let expected = view.expect(&forks, prior, work)?;
    let (mut sum, mut count) = (0.0, 0.0);
    for (fork, expected) in forks.iter().zip(&expected) {
        for &child in &fork.children {
            sum += expected.ln_density(view.towards(fork.joint, child));
            count += 1.0;
        }
    }
    Ok(if count > 0.0 { sum / count } else { 0.0 })
}

/// A joint with two or more children that are no stubs.
pub(crate) struct Fork {
    pub(crate) joint: u32,
    pub(crate) children: Vec<u32>,
}

/// A skeleton with what the networks are told of its joints.
pub(crate) struct View<'a> {
    joints: &'a [Joint],
    heirs: Vec<u32>,
    beyond: Vec<f32>,
    reach: Vec<f32>,
    /// Order, and ways from the foot, the start of the branch and the last fork.
    order: Vec<u16>,
    root: Vec<f32>,
    branch: Vec<f32>,
    fork: Vec<f32>,
    internode: f32,
}

impl<'a> View<'a> {
    pub(crate) fn new(skeleton: &'a Skeleton, internode: f32) -> Self {
        let joints = &skeleton.joints[..];
        let (heirs, children) = (skeleton.heirs(), skeleton.children());
        let n = joints.len();
        let (mut order, mut root) = (vec![0u16; n], vec![0.0; n]);
        let (mut branch, mut fork) = (vec![0.0; n], vec![0.0; n]);
        let mut reach = vec![0.0f32; n];
        let edge = |i: usize| {
            let parent = joints[i].parent as usize;
            (parent, joints[i].position.distance(joints[parent].position))
        };
        for i in 1..n {
            let (up, length) = edge(i);
            let is_heir = heirs[up] == i as u32;
            order[i] = order[up].saturating_add(u16::from(!is_heir));
            root[i] = root[up] + length;
            branch[i] = length + if is_heir { branch[up] } else { 0.0 };
            fork[i] = length + if children[up].len() > 1 { 0.0 } else { fork[up] };
        }
        for i in (1..n).rev() {
            let (up, length) = edge(i);
            reach[up] = reach[up].max(reach[i] + length);
        }
        let beyond = skeleton.lengths_beyond();
        Self { joints, heirs, beyond, reach, order, root, branch, fork, internode }
    }

    fn position(&self, i: u32) -> Vec3 {
        self.joints[i as usize].position
    }

    /// The joint an internode along a chain, or its last.
    fn along(&self, from: u32, next: impl Fn(u32) -> u32) -> u32 {
        let (mut at, mut way) = (from, 0.0);
        while next(at) != NONE && way < self.internode {
            let to = next(at);
            way += self.position(at).distance(self.position(to));
            at = to;
        }
        at
    }

    fn below(&self, i: u32) -> u32 {
        self.along(i, |i| self.joints[i as usize].parent)
    }

    fn above(&self, i: u32) -> u32 {
        self.along(i, |i| self.heirs[i as usize])
    }

    /// Direction of the wood that ends at a joint.
    fn front(&self, i: u32) -> Vec3 {
        let from = self.position(self.below(i));
        (self.position(i) - from).try_normalize().unwrap_or(Vec3::Y)
    }

    pub(crate) fn situation(&self, i: u32) -> Situation {
        let at = i as usize;
        Situation {
            position: self.position(i) - self.position(0),
            front: self.front(i),
            order: self.order[at],
            root_distance: self.root[at],
            branch_distance: self.branch[at],
            fork_distance: self.fork[at],
            share: self.beyond[at] / self.beyond[0].max(f32::MIN_POSITIVE),
            reach: self.reach[at],
            lineage: lineage(i),
        }
    }

    /// The forks of the skeleton.
    pub(crate) fn forks(&self, skeleton: &Skeleton) -> Vec<Fork> {
        let long = |i: &u32| self.reach[*i as usize] > SHORT * self.internode;
        let fork = |(joint, children): (u32, Vec<u32>)| Fork {
            joint,
            children: children.into_iter().filter(long).collect(),
        };
        (0..).zip(skeleton.children()).map(fork).filter(|fork| fork.children.len() > 1).collect()
    }

    /// What the networks expect at some forks.
    fn expect(
        &self,
        forks: &[Fork],
        prior: &Prior<'_>,
        work: &mut Workspace,
    ) -> Result<Vec<Expectation>, Overflow> {
        let situations: Vec<Situation> =
            forks.iter().map(|fork| self.situation(fork.joint)).collect();
        prior.expect(&situations, work)
    }

    /// Direction from a joint to an internode into one of its children.
    pub(crate) fn towards(&self, joint: u32, child: u32) -> Vec3 {
        let ahead = self.position(self.above(child)) - self.position(joint);
        ahead.try_normalize().unwrap_or(Vec3::Y)
    }
}

/// The lineage that keys the draws of a joint: its number, byte by byte.
pub(crate) fn lineage(i: u32) -> Lineage {
    i.to_le_bytes().into_iter().fold(Lineage::ROOT, Lineage::child)
}
