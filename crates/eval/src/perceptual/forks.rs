//! Angles and asymmetries at forks.

use deeptree_graph::Vec3;

use super::chains::{Chain, Measures, angle, is_above_epsilon};
use super::samples::Variables;
use super::variable::Variable;

/// The variables of the angles between children, for one choice of what their directions are.
struct Siblings {
    all: Variable,
    min: Variable,
    max: Variable,
    min_of_fork: Variable,
    max_of_fork: Variable,
}

/// Directions are those of the first segments.
const FIRST: Siblings = Siblings {
    all: Variable::ChainSiblingAngle,
    min: Variable::ChainMinSiblingAngle,
    max: Variable::ChainMaxSiblingAngle,
    min_of_fork: Variable::ChainMinChildAngle,
    max_of_fork: Variable::ChainMaxChildAngle,
};

/// Directions are those of the spans.
const SPAN: Siblings = Siblings {
    all: Variable::ChainSiblingAngleTotal,
    min: Variable::ChainMinSiblingAngleTotal,
    max: Variable::ChainMaxSiblingAngleTotal,
    min_of_fork: Variable::ChainMinChildAngleTotal,
    max_of_fork: Variable::ChainMaxChildAngleTotal,
};

/// Adds the samples of a chain with two or more child chains.
pub(super) fn add(to: &mut Variables, chain: &Chain, chains: &[Chain]) {
    let own = &chain.measures;
    let children: Vec<&Measures> =
        chain.children.iter().map(|&child| &chains[child].measures).collect();
    let firsts: Vec<Vec3> = children.iter().map(|child| child.first).collect();
    let spans: Vec<Vec3> = children.iter().map(|child| child.span).collect();

    let parents = parent_angles(own.last, &firsts);
    add_all(to, Variable::ChainParentAngle, &parents);
    add_if_any(to, Variable::ChainMinParentAngle, min(&parents));
    let widest = add_sibling_angles(to, &firsts, &FIRST);
    add_if_any(to, Variable::ChainMaxParentAngle, max_parent_angle(&parents, &widest));

    let parents = parent_angles(own.span, &spans);
    add_all(to, Variable::ChainParentAngleTotal, &parents);
    add_if_any(to, Variable::ChainMinParentAngleTotal, min(&parents));
    add_if_any(to, Variable::ChainMaxParentAngleTotal, max(&parents));
    add_sibling_angles(to, &spans, &SPAN);

    add_asymmetry(to, own, &children);
}

/// The angle of two directions, unless one is zero.
fn angle_if_any(a: Vec3, b: Vec3) -> Option<f32> {
    let is_any = is_above_epsilon(a.length()) && is_above_epsilon(b.length());
    is_any.then(|| angle(a, b))
}

fn parent_angles(parent: Vec3, children: &[Vec3]) -> Vec<Option<f32>> {
    children.iter().map(|&child| angle_if_any(parent, child)).collect()
}

fn min(angles: &[Option<f32>]) -> Option<f32> {
    angles.iter().flatten().copied().reduce(f32::min)
}

fn max(angles: &[Option<f32>]) -> Option<f32> {
    angles.iter().flatten().copied().reduce(f32::max)
}

fn add_if_any(to: &mut Variables, variable: Variable, sample: Option<f32>) {
    if let Some(sample) = sample {
        to.add(variable, sample);
    }
}

fn add_all(to: &mut Variables, variable: Variable, samples: &[Option<f32>]) {
    samples.iter().for_each(|&sample| add_if_any(to, variable, sample));
}

/// The last child's angle to the parent, or the widest sibling angle of the children before it if
/// that is larger.
///
/// Earlier children's parent angles do not count, as they do not in the published implementation,
/// which starts the maximum anew from the sibling angles at each child.
fn max_parent_angle(parents: &[Option<f32>], widest: &[Option<f32>]) -> Option<f32> {
    let last = parents.iter().rposition(Option::is_some)?;
    let before = max(&widest[..last]);
    parents[last].map(|angle| before.map_or(angle, |before| angle.max(before)))
}

/// Adds the angles of all ordered pairs of children, a child with itself included; returns the
/// widest of each child.
fn add_sibling_angles(to: &mut Variables, children: &[Vec3], names: &Siblings) -> Vec<Option<f32>> {
    let (mut narrowest, mut widest) = (Vec::new(), Vec::new());
    for &child in children {
        let angles = parent_angles(child, children);
        add_all(to, names.all, &angles);
        narrowest.push(min(&angles));
        widest.push(max(&angles));
    }
    add_all(to, names.min, &narrowest);
    add_all(to, names.max, &widest);
    add_if_any(to, names.min_of_fork, min(&narrowest));
    add_if_any(to, names.max_of_fork, max(&widest));
    widest
}

/// What can be summed over the leaf chains above.
type Sum = fn(&Measures) -> f32;

/// Adds the signed differences of all ordered pairs of children, relative to the fork.
fn add_asymmetry(to: &mut Variables, own: &Measures, children: &[&Measures]) {
    let sums: [(Variable, Sum); 3] = [
        (Variable::ChainAsymmetryLeaf, |chain| chain.leaves_above),
        (Variable::ChainAsymmetryLength, |chain| chain.length_above),
        (Variable::ChainAsymmetryVolume, |chain| chain.volume_above),
    ];
    for (variable, sum) in sums {
        let total = sum(own);
        if !is_above_epsilon(total) {
            continue;
        }
        for a in children {
            for b in children {
                to.add(variable, (sum(a) - sum(b)) / total);
            }
        }
    }
}
