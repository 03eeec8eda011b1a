//! Random trees and damaged bytes for the tests of this and other crates (feature `testing`).

use glam::{Quat, Vec3};

use crate::graph::{BranchGraph, ChildSignature, NodeId, TreeInfo};
use crate::seed::{Draws, Lineage, Purpose, Seed};

fn draws(seed: u64) -> Draws {
    Seed(seed).draws(Lineage::ROOT, Purpose::Existence)
}

/// A tree of at most `nodes` nodes in level order; all patterns of slots occur, and so do edges
/// without length, tips without thickness and feet off the origin.
///
/// It looks like no plant: what holds for it holds for any branch graph.
#[must_use]
pub fn random_tree(seed: u64, nodes: usize) -> BranchGraph {
    let mut draws = draws(seed);
    let info = TreeInfo {
        species: ["oak", "Weißtanne", ""][draws.index(3)].into(),
        age: draws.index(60) as u32,
        gravitropism: spread(&mut draws),
        seed: draws.bits(),
    };
    let foot = match draws.index(2) {
        0 => Vec3::ZERO,
        _ => Vec3::new(spread(&mut draws), spread(&mut draws), spread(&mut draws)) * 100.0,
    };
    let mut tree = BranchGraph::new(info, foot, signature(&mut draws));
    let mut next: NodeId = 0;
    while (next as usize) < tree.len() {
        // The only open tip always goes on, so that the tree has about as many nodes as asked for.
        let last = next as usize + 1 == tree.len();
        let pattern = usize::from(last) + draws.index(8 - usize::from(last));
        let room = nodes.saturating_sub(tree.len());
        let mut left = room;
        let mut child = |slot: usize| {
            let wanted = pattern >> slot & 1 == 1 && left > 0;
            left -= usize::from(wanted);
            wanted.then(|| signature(&mut draws))
        };
        let children = [child(0), child(1), child(2)];
        tree.grow(next, children);
        next += 1;
    }
    tree
}

/// A number in (−1, 1).
fn spread(draws: &mut Draws) -> f32 {
    (2.0 * draws.open_uniform() - 1.0) as f32
}

fn signature(draws: &mut Draws) -> ChildSignature {
    let mut component = || draws.normal() as f32;
    let q = Quat::from_xyzw(component(), component(), component(), component());
    // One in sixteen is a special value.
    let rare = |draws: &mut Draws, value: f32, special: f32| {
        if draws.index(16) == 0 { special } else { value }
    };
    let unit = if q.length() > 0.0 { q.normalize() } else { Quat::IDENTITY };
    let rotation = if draws.index(16) == 0 { Quat::from_xyzw(-0.0, 0.0, -0.0, 1.0) } else { unit };
    let (thickness, length) = (draws.uniform() as f32, draws.uniform() as f32);
    ChildSignature {
        rotation,
        thickness: rare(draws, thickness, 0.0),
        length: rare(draws, length, 0.0),
    }
}

/// A damaged copy of `bytes`: a few bits flipped, bytes replaced, runs cut out, doubled or the end
/// cut off.
#[must_use]
pub fn mutated(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut draws = draws(seed);
    let mut out = bytes.to_vec();
    for _ in 0..=draws.index(4) {
        let at = draws.index(out.len());
        let run = at..(at + 1 + draws.index(16)).min(out.len());
        match draws.index(5) {
            _ if out.is_empty() => {}
            0 => out[at] ^= 1 << draws.index(8),
            1 => out[at] = draws.bits() as u8,
            2 => drop(out.drain(run)),
            3 => {
                let copy = out[run].to_vec();
                out.splice(at..at, copy);
            }
            _ => out.truncate(at),
        }
    }
    out
}
