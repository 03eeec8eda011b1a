//! Which wood carries which: links that the networks find unlikely are replaced by likelier ones.

use std::collections::VecDeque;

use deeptree_graph::{Lineage, Vec3};
use deeptree_infer::{Overflow, Workspace};

use crate::kdtree::KdTree;
use crate::prior::{Prior, Situation};
use crate::skeleton::{Joint, Skeleton};
use crate::ways::NONE;

/// Other parents that a part of the tree is offered.
const OFFERS: usize = 8;

/// A bend of more than this, in radians over an internode, may be where two branches were taken for
/// one.
const SHARP: f32 = 1.0;

/// A link from a joint to the part of the tree that starts at another.
#[derive(Clone, Copy, Debug)]
struct Link {
    parent: u32,
    /// The joint that the part would start with: its start, or the end of its branch.
    start: u32,
    /// From the parent to an internode into the part.
    direction: Vec3,
    /// Metres without points that it crosses.
    gap: f32,
}

/// A part of the tree, the link it has, and those it could have.
#[derive(Clone, Debug)]
struct Choice {
    part: u32,
    links: Vec<Link>,
}

/// Gives the parts of a skeleton that hang unlikely, or bend sharply, the likeliest of the parents
/// near them: `ln ρ(direction) − gap / g`, where ρ is what the networks expect at the parent, children
/// a steradian, and g half an internode.
///
/// Returns how many parts have another parent now.
///
/// # Errors
///
/// When the model's numbers overflow.
pub(crate) fn relink(
    skeleton: &mut Skeleton,
    prior: &Prior<'_>,
    work: &mut Workspace,
) -> Result<usize, Overflow> {
    let view = View::new(skeleton, prior.internode());
    let choices = view.choices();
    let mut parents: Vec<u32> =
        choices.iter().flat_map(|choice| choice.links.iter().map(|link| link.parent)).collect();
    parents.sort_unstable();
    parents.dedup();
    let situations: Vec<Situation> = parents.iter().map(|&i| view.situation(i)).collect();
    let expected = prior.expect(&situations, work)?;
    let half = std::env::var("HALF").map_or(0.5, |v| v.parse().unwrap()) * prior.internode();
    let value = |link: &Link| {
        let at = parents.partition_point(|&parent| parent < link.parent);
        expected[at].ln_density(link.direction) - link.gap / half
    };
    let mut changes: Vec<(f32, u32, Link)> = Vec::new();
    for Choice { part, links } in &choices {
        let now = value(&links[0]);
        let best = links[1..].iter().map(|link| (value(link), link));
        let best = best.reduce(|best, other| if other.0 > best.0 { other } else { best });
        // Two nats: what is there is kept unless another is clearly likelier.
        if let Some((value, link)) = best.filter(|(value, _)| *value > now + std::env::var("NATS").map_or(2.0, |v| v.parse().unwrap())) {
            changes.push((now - value, *part, *link));
        }
    }
    changes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut parent: Vec<u32> = skeleton.joints.iter().map(|joint| joint.parent).collect();
    let changed = changes.iter().filter(|(_, part, link)| hang(&mut parent, *part, link)).count();
    if changed > 0 {
        reorder(skeleton, &parent);
    }
    Ok(changed)
}

/// Hangs a part onto another parent, turning the way from its start to its new start around; false
/// where earlier changes have made that a circle.
fn hang(parent: &mut [u32], part: u32, link: &Link) -> bool {
    let mut at = link.parent;
    while at != NONE {
        if at == part {
            return false;
        }
        at = parent[at as usize];
    }
    let mut way = vec![link.start];
    while way[way.len() - 1] != part {
        let up = parent[way[way.len() - 1] as usize];
        if up == NONE {
            return false;
        }
        way.push(up);
    }
    for pair in way.windows(2).rev() {
        parent[pair[1] as usize] = pair[0];
    }
    parent[link.start as usize] = link.parent;
    true
}

/// Puts parents before children again.
fn reorder(skeleton: &mut Skeleton, parent: &[u32]) {
    let mut children = vec![Vec::new(); parent.len()];
    for (i, &up) in (0u32..).zip(parent) {
        if up != NONE {
            children[up as usize].push(i);
        }
    }
    let mut number = vec![NONE; parent.len()];
    let mut joints = Vec::with_capacity(parent.len());
    let mut queue = VecDeque::from([0u32]);
    while let Some(i) = queue.pop_front() {
        number[i as usize] = joints.len() as u32;
        let up = parent[i as usize];
        let parent = if up == NONE { NONE } else { number[up as usize] };
        joints.push(Joint { parent, ..skeleton.joints[i as usize] });
        queue.extend(&children[i as usize]);
    }
    skeleton.joints = joints;
    for owner in skeleton.owner.iter_mut().filter(|owner| **owner != NONE) {
        *owner = number[*owner as usize];
    }
}

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
    let children = skeleton.children();
    let long = |i: &u32| view.reach[*i as usize] > 0.3 * prior.internode();
    let forks: Vec<u32> = (0..skeleton.joints.len() as u32)
        .filter(|&i| children[i as usize].iter().filter(|child| long(child)).count() > 1)
        .collect();
    let situations: Vec<Situation> = forks.iter().map(|&i| view.situation(i)).collect();
    let expected = prior.expect(&situations, work)?;
    let mut heirs = view.heirs.clone();
    for (&fork, expected) in forks.iter().zip(&expected) {
        let offers = || children[fork as usize].iter().filter(|child| long(child));
        let all: f32 = offers().map(|&i| view.beyond[i as usize]).sum();
        let odds = |&i: &u32| {
            let ahead = view.position(view.above(i)) - view.position(fork);
            let direction = ahead.try_normalize().unwrap_or(Vec3::Y);
            expected.ln_apical_odds(direction, view.beyond[i as usize] / all)
        };
        let best = offers().map(|i| (odds(i), *i)).reduce(|a, b| if b.0 > a.0 { b } else { a });
        heirs[fork as usize] = best.map_or(heirs[fork as usize], |(_, i)| i);
    }
    Ok(heirs)
}

/// A skeleton with what links are judged by.
pub(crate) struct View<'a> {
    joints: &'a [Joint],
    heirs: Vec<u32>,
    index: KdTree,
    beyond: Vec<f32>,
    reach: Vec<f32>,
    /// Order, and ways from the foot, the start of the branch and the last fork.
    order: Vec<u16>,
    root: Vec<f32>,
    branch: Vec<f32>,
    fork: Vec<f32>,
    /// When a joint and its last descendant are met in a walk that goes deep first.
    span: Vec<(u32, u32)>,
    internode: f32,
}

impl<'a> View<'a> {
    pub(crate) fn new(skeleton: &'a Skeleton, internode: f32) -> Self {
        let joints = &skeleton.joints[..];
        let (heirs, children) = (skeleton.heirs(), skeleton.children());
        let places: Vec<Vec3> = joints.iter().map(|joint| joint.position).collect();
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
        let span = spans(&children);
        let (index, beyond) = (KdTree::new(&places), skeleton.lengths_beyond());
        Self { joints, heirs, index, beyond, reach, order, root, branch, fork, span, internode }
    }

    fn position(&self, i: u32) -> Vec3 {
        self.joints[i as usize].position
    }

    /// Does a part hold a joint?
    fn holds(&self, part: u32, joint: u32) -> bool {
        let (first, last) = self.span[part as usize];
        (first..=last).contains(&self.span[joint as usize].0)
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

    /// The parts whose link is open: branches, and what follows a sharp bend.
    fn choices(&self) -> Vec<Choice> {
        let starts = (1..self.joints.len() as u32).filter(|&i| {
            let parent = self.joints[i as usize].parent;
            let is_branch = self.heirs[parent as usize] != i;
            let is_long = self.reach[i as usize] > 0.5 * self.internode;
            is_long && (is_branch || self.is_sharpest(i))
        });
        starts.map(|part| self.choice(part)).filter(|choice| choice.links.len() > 1).collect()
    }

    /// Angle between the wood before and after a joint.
    fn bend(&self, i: u32) -> f32 {
        let ahead = (self.position(self.above(i)) - self.position(i)).try_normalize();
        ahead.map_or(0.0, |ahead| libm::acosf(ahead.dot(self.front(i)).clamp(-1.0, 1.0)))
    }

    /// Does the branch bend sharply here, and more than an internode around?
    fn is_sharpest(&self, i: u32) -> bool {
        let bend = self.bend(i);
        let up = self.joints[i as usize].parent;
        let heir = self.heirs[i as usize];
        bend > SHARP
            && self.bend(up) <= bend
            && (heir == NONE || self.bend(heir) < bend)
    }

    /// The link of a part, and others: of its start, and of the end of its branch.
    fn choice(&self, part: u32) -> Choice {
        let now = self.joints[part as usize].parent;
        let mut links = vec![self.link(now, part, part)];
        let gap = self.position(now).distance(self.position(part));
        let end = std::iter::successors(Some(part), |&i| {
            Some(self.heirs[i as usize]).filter(|&heir| heir != NONE)
        });
        let end = end.last().unwrap_or(part);
        for start in [part, end] {
            self.offer(part, start, gap.max(1.5 * self.internode), &mut links);
        }
        Choice { part, links }
    }

    /// Parents near a start, no two of them closer to each other than a third of an internode.
    fn offer(&self, part: u32, start: u32, within: f32, links: &mut Vec<Link>) {
        let at = self.position(start);
        let mut near = Vec::new();
        self.index.within(at, within, &mut near);
        let mut others: Vec<(u32, f32)> = near
            .into_iter()
            .filter(|&i| !self.holds(part, i))
            .map(|i| (i, self.position(i).distance_squared(at)))
            .collect();
        others.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let mut offered: Vec<Vec3> = Vec::new();
        for (parent, _) in others {
            let place = self.position(parent);
            if offered.iter().all(|other| other.distance(place) > self.internode / 3.0) {
                offered.push(place);
                links.push(self.link(parent, part, start));
            }
            if offered.len() == OFFERS {
                return;
            }
        }
    }

    fn link(&self, parent: u32, part: u32, start: u32) -> Link {
        let into = if start == part {
            self.above(start)
        } else {
            self.along(start, |i| if i == part { NONE } else { self.joints[i as usize].parent })
        };
        let from = self.position(parent);
        let direction = (self.position(into) - from).try_normalize().unwrap_or(Vec3::Y);
        Link { parent, start, direction, gap: from.distance(self.position(start)) }
    }
}

/// The lineage that keys the draws of a joint: its number, byte by byte.
pub(crate) fn lineage(i: u32) -> Lineage {
    i.to_le_bytes().into_iter().fold(Lineage::ROOT, Lineage::child)
}

/// When each joint and its last descendant are met in a walk that goes deep first.
fn spans(children: &[Vec<u32>]) -> Vec<(u32, u32)> {
    let mut span = vec![(0, 0); children.len()];
    let mut size = vec![1u32; children.len()];
    for i in (0..children.len()).rev() {
        size[i] += children[i].iter().map(|&c| size[c as usize]).sum::<u32>();
    }
    for i in 0..children.len() {
        let first = span[i].0;
        span[i].1 = first + size[i] - 1;
        let mut next = first + 1;
        for &child in &children[i] {
            span[child as usize].0 = next;
            next += size[child as usize];
        }
    }
    span
}
