//! Small trees worked out by hand, and what holds for all trees.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2};

use deeptree_graph::{BranchGraph, Row, Seed, TreeInfo, Vec3};

use super::*;

/// Wider than the angle of a short direction with itself, which rounding makes about 7e-4.
const TOLERANCE: f32 = 2e-3;

/// A tree from (parent, x, y, radius) a node, in the plane z = 0; the slots follow the order.
fn tree(nodes: &[(i64, f32, f32, f32)]) -> BranchGraph {
    let info = TreeInfo { species: "oak".into(), age: 1, gravitropism: 0.0, seed: 0 };
    let row = |(id, &(parent, x, y, radius)): (usize, &(i64, f32, f32, f32))| Row {
        id: id as i64,
        parent,
        slot: None,
        position: Vec3::new(x, y, 0.0),
        radius,
        edge: None,
    };
    let rows: Vec<Row> = nodes.iter().enumerate().map(row).collect();
    BranchGraph::from_rows(info, &rows).unwrap()
}

fn of(nodes: &[(i64, f32, f32, f32)]) -> Variables {
    Variables::of(&tree(nodes))
}

#[track_caller]
fn check(variables: &Variables, variable: Variable, expected: &[f32]) {
    let samples = variables.values(variable);
    let is_close = |(a, b): (&f32, &f32)| (a - b).abs() < TOLERANCE;
    assert!(
        samples.len() == expected.len() && samples.iter().zip(expected).all(is_close),
        "{} is {samples:?}, by hand {expected:?}",
        variable.name(),
    );
}

/// A trunk of two segments of 2 m, 0.2 m thick at the foot and 0.1 m above.
const STRAIGHT: [(i64, f32, f32, f32); 3] =
    [(-1, 0.0, 0.0, 0.2), (0, 0.0, 2.0, 0.1), (1, 0.0, 4.0, 0.1)];

/// A trunk of 2 m with two branches of √8 m, 45° to either side.
const Y_FORK: [(i64, f32, f32, f32); 4] =
    [(-1, 0.0, 0.0, 0.2), (0, 0.0, 2.0, 0.1), (1, 2.0, 4.0, 0.1), (1, -2.0, 4.0, 0.1)];

/// A trunk of 3 m with three branches of 3 m: 60° from the vertical (chain 1), level to the right
/// (chain 2) and to the left (chain 3). The second forks into one that goes up (chain 4) and one
/// that goes down (chain 5).
const THREE_WAY: [(i64, f32, f32, f32); 7] = [
    (-1, 0.0, 0.0, 0.1),
    (0, 0.0, 3.0, 0.1),
    (1, 2.598_076, 4.5, 0.1),
    (1, 3.0, 3.0, 0.1),
    (1, -3.0, 3.0, 0.1),
    (3, 3.0, 6.0, 0.1),
    (3, 3.0, 0.0, 0.1),
];

#[test]
fn a_straight_trunk_is_one_chain() {
    let variables = of(&STRAIGHT);
    check(&variables, Variable::SegmentThickness, &[0.1, 0.1]);
    check(&variables, Variable::SegmentsPerChain, &[2.0]);
    check(&variables, Variable::ChainsPerDepth, &[0.0]);
    check(&variables, Variable::ChainLength, &[4.0]);
    check(&variables, Variable::ChainTotalLength, &[4.0]);
    check(&variables, Variable::ChainDeformation, &[0.0]);
    check(&variables, Variable::ChainStraightness, &[1.0]);
    check(&variables, Variable::ChainSlope, &[0.0]);
    check(&variables, Variable::ChainMinThickness, &[0.1]);
    check(&variables, Variable::ChainMaxThickness, &[0.2]);
    check(&variables, Variable::ChainMinMaxThicknessRatio, &[0.5]);
    // π 2/3 (0.04 + 0.02 + 0.01) = 0.1466 and π 2/3 (0.01 + 0.01 + 0.01) = 0.0628, each twice.
    let volumes: Vec<(f32, f32)> = variables.get(Variable::SegmentVolume).weighted().collect();
    let expected = [(0.2, 0.146_608), (0.1, 0.146_608), (0.1, 0.062_832), (0.1, 0.062_832)];
    assert_eq!(volumes.len(), 4);
    for (a, b) in volumes.iter().zip(expected) {
        assert!((a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-6, "{a:?}, by hand {b:?}");
    }
    // Neither a parent nor a fork: the other variables have no samples.
    for variable in &Variable::ALL[Variable::ChainTropismBranch as usize..] {
        assert!(variables.get(*variable).is_empty(), "{}", variable.name());
    }
    assert_eq!(variables.common().values(), [4.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn angles_and_lengths_of_a_y_fork() {
    let variables = of(&Y_FORK);
    check(&variables, Variable::ChainsPerDepth, &[0.0, 1.0, 1.0]);
    check(&variables, Variable::ChainLengthRatio, &[SQRT_2, SQRT_2]);
    check(&variables, Variable::ChainStraightness, &[]);
    check(&variables, Variable::ChainParentChildAngle, &[FRAC_PI_4; 2]);
    check(&variables, Variable::ChainSlope, &[0.0, FRAC_PI_4, FRAC_PI_4]);
    // The span (±2, 2) less the direction (±0.71, 0.71) still points up at 45°.
    check(&variables, Variable::ChainTropismBranch, &[0.5f32.sqrt(); 2]);
    check(&variables, Variable::ChainTropismHorizon, &[0.5f32.sqrt(); 2]);
    check(&variables, Variable::ChainTropismParent, &[0.5f32.sqrt(); 2]);
    check(&variables, Variable::ChainParentAngle, &[FRAC_PI_4; 2]);
    check(&variables, Variable::ChainMinParentAngle, &[FRAC_PI_4]);
    check(&variables, Variable::ChainMaxParentAngleTotal, &[FRAC_PI_4]);
    // At the second child the sibling angle of the first, 90°, is wider than 45°.
    check(&variables, Variable::ChainMaxParentAngle, &[FRAC_PI_2]);
    let siblings = [0.0, FRAC_PI_2, FRAC_PI_2, 0.0];
    check(&variables, Variable::ChainSiblingAngle, &siblings);
    check(&variables, Variable::ChainSiblingAngleTotal, &siblings);
    check(&variables, Variable::ChainMinSiblingAngle, &[0.0; 2]);
    check(&variables, Variable::ChainMaxSiblingAngle, &[FRAC_PI_2; 2]);
    check(&variables, Variable::ChainMinChildAngle, &[0.0]);
    check(&variables, Variable::ChainMaxChildAngleTotal, &[FRAC_PI_2]);
    check(&variables, Variable::ChainAsymmetryLeaf, &[0.0; 4]);
}

#[test]
fn a_direction_with_itself_is_not_quite_zero() {
    // 1 m: 1 / (1 + 2⁻²³) = 1 − 2⁻²³, so that the cosine is 1 − 2⁻²² and the angle √(2 · 2⁻²²).
    let variables = of(&[(-1, 0.0, 0.0, 0.1), (0, 0.0, 1.0, 0.1)]);
    let itself = variables.values(Variable::ChainDeformation)[0];
    assert!((itself - 6.905e-4).abs() < 1e-6, "{itself}");
}

#[test]
fn fitness_and_scalars_of_a_y_fork() {
    let variables = of(&Y_FORK);
    // Lengths but for the trunk: 2 · 2.8284 over 3; variance (2 · 0.9428²) / 3. The trunk has
    // 2 / 1.8856 = 1.0607 internodes, which makes 2 of age above a fork at depth 0.
    let common = variables.common().values();
    let expected = [2.0, 1.885_618, 0.592_593, 2.0, 2.0, 2.0, 0.0];
    assert!(common.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{common:?}");
    check(&variables, Variable::ChainInternodeCount, &[1.060_66]);
    // Equal sizes: all as straight, (0.7071 + 1) / 2 = 0.8536; one other child counts half.
    check(&variables, Variable::ChainMonopodialBranchingFitness, &[0.426_777]);
    check(&variables, Variable::ChainSympodialMonochasialBranchingFitness, &[0.853_553]);
    check(&variables, Variable::ChainSympodialDichasialBranchingFitness, &[1.0]);
    // The mean is 1.0607 / 2, with x² (3 − 2 x) of 0.9393, of 0.4697 and 0.0607, and of 0.5303.
    check(&variables, Variable::ChainContinuousRamificationFitness, &[0.989_407]);
    check(&variables, Variable::ChainRhythmicRamificationFitness, &[0.454_561 * 0.010_593]);
    check(&variables, Variable::ChainDiffuseRamificationFitness, &[0.545_439]);
    let kinds: Vec<f32> = variables.get(Variable::AggregateBranchingFitness).positions().collect();
    assert_eq!(kinds, [0.0, 1.0, 2.0]);
}

#[test]
fn internodes_count_every_node_from_the_first() {
    // A trunk of two segments of 2 m is 2 + 4 m long here: 6 / 1.8856.
    let variables = of(&[
        (-1, 0.0, 0.0, 0.1),
        (0, 0.0, 2.0, 0.1),
        (1, 0.0, 4.0, 0.1),
        (2, 2.0, 6.0, 0.1),
        (2, -2.0, 6.0, 0.1),
    ]);
    check(&variables, Variable::ChainLength, &[4.0, 8f32.sqrt(), 8f32.sqrt()]);
    check(&variables, Variable::ChainInternodeCount, &[3.181_98]);
}

#[test]
fn asymmetries_of_a_three_way_fork_are_signed_and_count_leaf_chains_only() {
    let variables = of(&THREE_WAY);
    // Leaves 1, 2, 1 of 4, then 1, 1 of 2. Lengths 3, 6, 3 of 12: the second's own 3 m are not in.
    let expected =
        [0.0, -0.25, 0.0, 0.25, 0.0, 0.25, 0.0, -0.25, 0.0, /* fork */ 0.0, 0.0, 0.0, 0.0];
    check(&variables, Variable::ChainAsymmetryLeaf, &expected);
    check(&variables, Variable::ChainAsymmetryLength, &expected);
    check(&variables, Variable::ChainAsymmetryVolume, &expected);
    check(&variables, Variable::ChainsPerDepth, &[0.0, 1.0, 1.0, 1.0, 2.0, 2.0]);
    // From the trunk 60°, 90°, 90°; from the second branch 90° up and 90° down.
    let sixty = PI / 3.0;
    let expected = [sixty, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2];
    check(&variables, Variable::ChainParentAngle, &expected);
    check(&variables, Variable::ChainMinParentAngle, &[sixty, FRAC_PI_2]);
    // Before the third child the widest sibling angle is 180°, of the second with the third; of
    // the second fork it is 180°, of up with down.
    check(&variables, Variable::ChainMaxParentAngle, &[PI, PI]);
    check(&variables, Variable::ChainMaxSiblingAngle, &[5.0 * PI / 6.0, PI, PI, PI, PI]);
}

#[test]
fn children_of_a_fork_are_looked_up_by_their_compact_numbers() {
    let variables = of(&THREE_WAY);
    // Depth first the chains are 0, 1, 2, 4, 5, 3, so that the trunk's children 1, 2, 3 bear the
    // numbers 1, 2, 5: sizes 1, 2, 1 with cosines 0.5, 0 and (of chain 5, which goes down) −1.
    //   monopodial: (2 − 1) / 1 · (0 + 1) / 2 = 0.5, times two equal others, 1
    //   monochasial: 0.5 · (1 − 1)
    //   dichasial, with the last of the smallest: 1/2 · (1 − 1/2) · (1 − 0.75)
    // Chain 2's children 4, 5 bear the numbers 3, 4: sizes 1, 1, cosines −1 and 0.
    //   monopodial: (0 + 1) / 2 · 1/2; monochasial: 0.5; dichasial: 1 · (1 − 1/2)
    check(&variables, Variable::ChainMonopodialBranchingFitness, &[0.5, 0.25]);
    check(&variables, Variable::ChainSympodialMonochasialBranchingFitness, &[0.0, 0.5]);
    check(&variables, Variable::ChainSympodialDichasialBranchingFitness, &[0.0625, 0.5]);
}

#[test]
fn the_root_goes_on_into_its_first_child() {
    // The other child of the root branches off the first child's tip: from (0, 2) to (2, 0).
    let variables = of(&[(-1, 0.0, 0.0, 0.1), (0, 0.0, 2.0, 0.1), (0, 2.0, 0.0, 0.1)]);
    check(&variables, Variable::ChainLength, &[2.0, 8f32.sqrt()]);
    check(&variables, Variable::ChainsPerDepth, &[0.0, 1.0]);
    assert_eq!(variables.common().leaf_count, 2.0);
    // One child is no fork, yet it has fitness: its cosine is −0.7071, and no others means
    // monopodial 0, monochasial (1 − 0.7071) / 2 and dichasial 0.
    check(&variables, Variable::ChainParentAngle, &[]);
    check(&variables, Variable::ChainMonopodialBranchingFitness, &[0.0]);
    check(&variables, Variable::ChainSympodialMonochasialBranchingFitness, &[0.146_447]);
    check(&variables, Variable::ChainSympodialDichasialBranchingFitness, &[0.0]);
}

#[test]
fn other_children_of_the_root_come_after_those_of_the_fork() {
    let variables = of(&[
        (-1, 0.0, 0.0, 0.1),
        (0, 0.0, 2.0, 0.1),
        (0, 3.0, 2.0, 0.1),
        (1, 0.0, 6.0, 0.1),
        (1, -5.0, 2.0, 0.1),
    ]);
    check(&variables, Variable::ChainLength, &[2.0, 4.0, 5.0, 3.0]);
    check(&variables, Variable::ChainParentAngle, &[0.0, FRAC_PI_2, FRAC_PI_2]);
}

#[test]
fn a_tiny_chain_is_merged_into_the_fork_below_it() {
    // A trunk of 10 m; a branch of 10 m up (chain 1); a chain of 1 mm to the right (chain 2) that
    // forks into 10 m to the left and to the right (chains 3 and 4).
    let nodes = [
        (-1, 0.0, 0.0, 0.1),
        (0, 0.0, 10.0, 0.1),
        (1, 0.0, 20.0, 0.1),
        (1, 0.001, 10.0, 0.1),
        (3, -9.999, 10.0, 0.1),
        (3, 10.001, 10.0, 0.1),
    ];
    let variables = of(&nodes);
    // Internode 30.001 / 5 = 6.0002 m: 1 mm is less than a thousandth of it. One fork is left.
    check(&variables, Variable::ChainInternodeCount, &[10.0 / 6.0002]);
    // Its children 1, 3, 4 bear the numbers 1, 2, 3: sizes 1, 2, 1; the first against the trunk,
    // the others against the tiny chain: cosines 1, 1 (of the tiny chain itself) and −1.
    //   monopodial: 1 · 1 · 1; monochasial: 1 · (1 − 1); dichasial: 1/2 · (1 − 1) · …
    check(&variables, Variable::ChainMonopodialBranchingFitness, &[1.0]);
    check(&variables, Variable::ChainSympodialMonochasialBranchingFitness, &[0.0]);
    check(&variables, Variable::ChainSympodialDichasialBranchingFitness, &[0.0]);
    // Ten times as long it stays a chain of its own.
    let mut longer = nodes;
    longer[3].1 = 0.01;
    check(&of(&longer), Variable::ChainInternodeCount, &[1.6664, 0.01 / 6.002]);
}

#[test]
fn statistics_of_a_straight_trunk() {
    let variables = of(&STRAIGHT);
    let statistics = variables.statistics();
    assert_eq!(statistics.len(), STATISTICS_LEN);
    assert_eq!(statistics[..5], [2.0, 0.1, 0.1, 0.1, 0.0]);
    // Eight numbers: 0.2, 0.1, 0.1, 0.1, and volumes twice each: mean (0.5 + 0.41888) / 8.
    let volume = &statistics[5..10];
    assert_eq!(volume[0], 4.0);
    assert!((volume[1] - 0.062_832).abs() < 1e-6 && volume[2] == 0.2);
    assert!((volume[3] - 0.114_860).abs() < 1e-5);
    // All statistics of a variable without samples are 0.
    let at = 5 * Variable::ChainParentAngle as usize;
    assert_eq!(statistics[at..at + 5], [0.0; 5]);
}

#[test]
fn samples_that_are_not_finite_are_dropped() {
    let samples = Samples::Pairs(vec![(1.0, f32::NAN), (f32::INFINITY, 1.0), (2.0, 3.0)]);
    assert_eq!(samples.len(), 3);
    assert_eq!(samples.weighted().collect::<Vec<_>>(), [(2.0, 3.0)]);
}

#[test]
fn outer_bins_reach_to_the_extremes_of_the_reference() {
    // Trunks of 1, 2, …, 2001 m: quantiles at 3 and 1999, six bins of 1996 / 6 m between.
    let trunk = |length: f32| of(&[(-1, 0.0, 0.0, 0.1), (0, 0.0, length, 0.1)]);
    let reference: Vec<Variables> = (1..=2001).map(|i| trunk(i as f32)).collect();
    let edges = BinEdges::fit(&reference);
    let lengths = edges.get(Variable::ChainLength);
    let expected: [f64; 9] = std::array::from_fn(|i| match i {
        0 => 1.0,
        8 => 2001.0,
        i => 3.0 + (i - 1) as f64 * 1996.0 / 6.0,
    });
    assert!(lengths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{lengths:?}");

    // A single sample: density one over the width of its bin; the last bin has its upper edge.
    let at = BINS * Variable::ChainLength as usize;
    let bins = |length| edges.histograms(&trunk(length))[at..at + BINS].to_vec();
    for (length, bin) in [(1.0, 0), (2.0, 0), (2000.0, 7), (2001.0, 7)] {
        let bins = bins(length);
        assert!((bins[bin] - 0.5).abs() < 1e-5, "{length}: {bins:?}");
        assert_eq!(bins.iter().filter(|&&density| density > 0.0).count(), 1);
    }
    assert_eq!(bins(3000.0), [0.0; BINS]);
    assert_eq!(edges.histograms(&reference[0]).len(), HISTOGRAMS_LEN);
}

#[test]
fn histograms_of_pairs_sum_weights() {
    // Bins of 0.0125 m from 0.1 to 0.2 m: only the first and the last have samples. Of the weights
    // 0.1466 is at 0.2 m, and 0.1466 + 2 · 0.0628 = 0.2723 at 0.1 m.
    let variables = of(&STRAIGHT);
    let reference = [variables.clone()];
    let edges = BinEdges::fit(&reference);
    let at = BINS * Variable::SegmentVolume as usize;
    let bins = &edges.histograms(&variables)[at..at + BINS];
    let mass: f64 = edges
        .get(Variable::SegmentVolume)
        .windows(2)
        .zip(bins)
        .map(|(ends, &density)| (ends[1] - ends[0]) * f64::from(density))
        .sum();
    assert!((mass - 1.0).abs() < 1e-6, "{mass}");
    let widths = edges.get(Variable::SegmentVolume);
    let first = f64::from(bins[0]) * (widths[1] - widths[0]);
    assert!((first - 0.2723 / 0.4189).abs() < 1e-3, "{first}");
}

#[test]
fn names_are_those_published() {
    assert_eq!(Variable::ALL.len(), VARIABLES);
    let mut names: Vec<&str> = Variable::ALL.iter().map(|variable| variable.name()).collect();
    assert_eq!((names[0], names[45]), ("segmentThickness", "aggregateRamificationFitness"));
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), VARIABLES);
}

#[test]
fn invariants_hold_for_grown_trees() {
    let species = deeptree_growth::Species::named("oak").unwrap();
    let parameters = species.parameters(deeptree_growth::Profile::Reference);
    for seed in 0..4 {
        let tree = deeptree_growth::grow("oak", parameters, Seed(seed)).unwrap().tree;
        check_invariants(&tree, &Variables::of(&tree));
    }
}

fn check_invariants(tree: &BranchGraph, variables: &Variables) {
    for variable in Variable::ALL.into_iter().filter(|v| v.name().contains("Angle")) {
        // The first differs from an angle between two directions: a difference of sums.
        let is_angle = variable != Variable::ChainAngleSumDelta;
        let range = if is_angle { 0.0..=PI } else { f32::MIN..=f32::MAX };
        assert!(variables.values(variable).iter().all(|x| range.contains(x)));
    }
    let straightness = variables.values(Variable::ChainStraightness);
    assert!(straightness.iter().all(|x| (0.0..=1.0 + 1e-5).contains(x)));

    let count = |variable: Variable| variables.get(variable).len();
    let segments: f32 = variables.values(Variable::SegmentsPerChain).iter().sum();
    assert_eq!(segments as usize, tree.len() - 1);
    assert_eq!(count(Variable::SegmentThickness), tree.len() - 1);
    assert_eq!(count(Variable::SegmentVolume), 2 * (tree.len() - 1));
    assert_eq!(count(Variable::ChainTropismParent) + 1, count(Variable::ChainsPerDepth));
    assert_eq!(
        count(Variable::AggregateBranchingFitness),
        3 * count(Variable::ChainInternodeCount)
    );
    let leaves = tree.nodes().iter().filter(|node| node.child_count() == 0).count();
    assert_eq!(variables.common().leaf_count as usize, leaves);
    let statistics = variables.statistics();
    assert!(statistics.iter().all(|x| x.is_finite()));
    for variable in ZERO_MEAN {
        assert!(statistics[5 * variable as usize + 3].abs() < 1e-5, "{}", variable.name());
    }
}
