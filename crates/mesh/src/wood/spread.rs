//! Intervals moved apart until none overlap.

/// An interval that wants to lie around `center`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) center: f32,
    pub(crate) half: f32,
}

/// Moves intervals, sorted by their centres, apart and into `low..high` by the least squared way.
///
/// Keeps their order. They must fit: their lengths add up to at most `high − low`.
///
/// # Source
///
/// Isotonic regression by pooling adjacent violators (Barlow et al. 1972), of the centres less the
/// room that the intervals before need.
pub(crate) fn spread(intervals: &mut [Interval], low: f32, high: f32) {
    // Pools: how many intervals, and the sum of their centres less the room before them.
    let mut pools: Vec<(usize, f32)> = Vec::with_capacity(intervals.len());
    let mut room = 0.0;
    for interval in &*intervals {
        let mut pool = (1, interval.center - (room + interval.half));
        room += 2.0 * interval.half;
        while let Some(&(n, sum)) = pools.last()
            && sum / n as f32 >= pool.1 / pool.0 as f32
        {
            pools.pop();
            pool = (pool.0 + n, pool.1 + sum);
        }
        pools.push(pool);
    }
    let (mut i, mut before) = (0, 0.0);
    for (n, sum) in pools {
        let start = (sum / n as f32).min(high - room).max(low);
        for interval in &mut intervals[i..i + n] {
            interval.center = start + before + interval.half;
            before += 2.0 * interval.half;
        }
        i += n;
    }
}

/// As [`spread`], on a circle: centres are angles in radians, sorted.
///
/// The circle is cut in the widest gap. Centres stay sorted, and lie within a turn: for that, the
/// intervals are rotated to the left by the number of places that is returned.
pub(crate) fn spread_around(intervals: &mut [Interval]) -> usize {
    let n = intervals.len();
    if n < 2 {
        return 0;
    }
    let tau = core::f32::consts::TAU;
    let gap = |i: usize| {
        let (a, b) = (intervals[i], intervals[(i + 1) % n]);
        let turn = if i + 1 == n { tau } else { 0.0 };
        (b.center + turn - b.half) - (a.center + a.half)
    };
    let widest = (0..n).reduce(|best, i| if gap(i) > gap(best) { i } else { best }).unwrap_or(0);
    // The cut lies in the middle of the gap, behind interval `widest`.
    let cut = intervals[widest].center + intervals[widest].half + 0.5 * gap(widest);
    let first = (widest + 1) % n;
    intervals.rotate_left(first);
    for interval in intervals.iter_mut() {
        while interval.center < cut - tau {
            interval.center += tau;
        }
        while interval.center > cut {
            interval.center -= tau;
        }
    }
    spread(intervals, cut - tau, cut);
    first
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at(center: f32, half: f32) -> Interval {
        Interval { center, half }
    }

    #[test]
    fn intervals_that_do_not_overlap_stay() {
        let mut all = [at(1.0, 0.5), at(3.0, 1.0), at(6.0, 0.1)];
        let before = all;
        spread(&mut all, 0.0, 10.0);
        for (a, b) in all.iter().zip(before) {
            assert!((a.center - b.center).abs() < 1e-6);
        }
    }

    #[test]
    fn two_at_one_place_go_half_the_way_each() {
        let mut all = [at(5.0, 1.0), at(5.0, 1.0)];
        spread(&mut all, 0.0, 10.0);
        assert_eq!(all, [at(4.0, 1.0), at(6.0, 1.0)]);
        let mut all = [at(0.5, 1.0), at(0.5, 1.0)];
        spread(&mut all, 0.0, 10.0);
        assert_eq!(all, [at(1.0, 1.0), at(3.0, 1.0)]);
    }

    #[test]
    fn across_the_cut_of_the_circle_angles_are_near_too() {
        let mut all = [at(0.1, 0.3), at(3.0, 0.3), at(6.1, 0.3)];
        spread_around(&mut all);
        // 6.1 and 0.1 are 0.283 apart and need 0.6: each gives way by 0.158.
        let moved = 0.5 * (0.6 - (0.1 + core::f32::consts::TAU - 6.1));
        let mut angles = all.map(|i| i.center.rem_euclid(core::f32::consts::TAU));
        angles.sort_by(f32::total_cmp);
        for (a, b) in angles.into_iter().zip([0.1 + moved, 3.0, 6.1 - moved]) {
            assert!((a - b).abs() < 1e-5, "{all:?}");
        }
    }

    proptest! {
        #[test]
        fn none_overlap_and_all_lie_within(
            mut rows in proptest::collection::vec((0.0f32..6.0, 0.01f32..0.3), 1..10),
            around: bool,
        ) {
            rows.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut all: Vec<_> = rows.iter().map(|&(center, half)| at(center, half)).collect();
            let turn = core::f32::consts::TAU;
            if around {
                spread_around(&mut all);
            } else {
                spread(&mut all, 0.0, turn);
            }
            for pair in all.windows(2) {
                let gap = pair[1].center - pair[1].half - pair[0].center - pair[0].half;
                prop_assert!(gap > -1e-5, "{all:?}");
            }
            let (first, last) = (all[0], all[all.len() - 1]);
            let length = last.center + last.half - first.center + first.half;
            prop_assert!(length < turn + 1e-5, "{all:?}");
            if !around {
                prop_assert!(first.center - first.half > -1e-5);
                prop_assert!(last.center + last.half < turn + 1e-5);
            }
        }
    }
}
