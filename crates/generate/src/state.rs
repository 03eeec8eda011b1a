//! A root and its traits as a vector that linear laws are fitted to.

use deeptree_graph::TreeTraits;
use deeptree_graph::signature::{thickness_of, tip_count};
use deeptree_infer::Root;

/// ln of the tips, then the seven traits; counts as logarithms.
pub(crate) const STATES: usize = TreeTraits::STATES;

/// Where the numbers of [`TreeTraits::state`] stand.
pub(crate) const TIPS: usize = 0;
pub(crate) const NODES: usize = 1;
pub(crate) const LONGEST_PATH: usize = 2;
pub(crate) const BRANCHES: usize = 3;
pub(crate) const MEAN_PATH: usize = 4;
pub(crate) const CROWN_RADIUS: usize = 5;
pub(crate) const HEIGHT: usize = 6;
pub(crate) const TRUNK_LENGTH: usize = 7;

/// Lengths, in metres; the others are logarithms of counts.
pub(crate) const LENGTHS: [usize; 5] =
    [LONGEST_PATH, MEAN_PATH, CROWN_RADIUS, HEIGHT, TRUNK_LENGTH];

/// The state of a root.
pub(crate) type State = [f64; STATES];

/// The state of a root.
pub(crate) fn state(root: &Root, tip_radius: f32) -> State {
    root.traits.state(tip_count(root.signature.thickness, tip_radius))
}

/// The root with this state.
pub(crate) fn with_state(mut root: Root, tip_radius: f32, state: &State) -> Root {
    let tips = libm::round(libm::exp(state[TIPS])).clamp(1.0, 1e7) as u32;
    root.signature.thickness = thickness_of(tips, tip_radius);
    root.traits = TreeTraits {
        nodes: libm::exp(state[NODES]) as f32,
        branches: libm::exp(state[BRANCHES]) as f32,
        longest_path: state[LONGEST_PATH] as f32,
        mean_path: state[MEAN_PATH] as f32,
        crown_radius: state[CROWN_RADIUS] as f32,
        height: state[HEIGHT] as f32,
        trunk_length: state[TRUNK_LENGTH] as f32,
    };
    root
}
