//! How thick the wood at each point may be, told from how much of the cloud is beyond it.

use crate::ways::{NONE, Neighbours, Parts, Ways};

/// For each point the share of the cloud that is beyond it, 0 to 1.
///
/// Points whose ways to the foot are about equally long, to within `width` metres, and that are
/// joined among each other make one level, as the points around a stem do; a level's share is its own
/// points with those of all levels whose ways lead through it.
///
/// # Source
///
/// Verroust and Lazarus 2000, "Extracting skeletal curves from 3D scattered data": level sets of
/// geodesic distance.
pub(crate) fn shares_beyond(neighbours: &Neighbours, ways: &Ways, width: f32) -> Vec<f32> {
    let count = ways.next.len();
    let bin = |i: u32| (ways.length[i as usize] / width) as u32;
    let mut parts = Parts::new(count);
    for i in 0..count as u32 {
        for &(k, _) in neighbours.of(i) {
            if bin(i) == bin(k) {
                parts.join(i, k);
            }
        }
    }
    let part: Vec<u32> = (0..count as u32).map(|i| parts.of(i)).collect();
    let below = below(&part, ways);
    let mut beyond = vec![0.0f32; count];
    part.iter().for_each(|&part| beyond[part as usize] += 1.0);
    // Levels stand for their leading points; those further from the foot come first.
    let mut levels: Vec<u32> = (0..count as u32).filter(|&i| part[i as usize] == i).collect();
    levels.sort_by_key(|&i| (core::cmp::Reverse(bin(i)), i));
    for level in levels {
        let to = below[level as usize];
        if to != NONE {
            beyond[to as usize] += beyond[level as usize];
        }
    }
    let all = count.max(1) as f32;
    part.iter().map(|&part| (beyond[part as usize] / all).min(1.0)).collect()
}

/// For each level, by its leading point, the level below that most of its ways lead to.
fn below(part: &[u32], ways: &Ways) -> Vec<u32> {
    let crossing = |(i, &next): (usize, &u32)| {
        let to = *part.get(next as usize)?;
        (to != part[i]).then_some((part[i], to))
    };
    let mut crossings: Vec<(u32, u32)> =
        ways.next.iter().enumerate().filter_map(crossing).collect();
    crossings.sort_unstable();
    let mut below = vec![NONE; part.len()];
    let mut most = vec![0; part.len()];
    for same in crossings.chunk_by(|a, b| a == b) {
        let (from, to) = same[0];
        if same.len() > most[from as usize] {
            (most[from as usize], below[from as usize]) = (same.len(), to);
        }
    }
    below
}
