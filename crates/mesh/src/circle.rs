//! The unit circle, and directions carried along a curve.

use deeptree_graph::Vec3;

/// The unit circle in `sides` steps, the start repeated at the end: (cos, sin).
pub(crate) fn circle(sides: u32) -> Vec<[f32; 2]> {
    let step = core::f64::consts::TAU / f64::from(sides);
    (0..=sides)
        .map(|k| f64::from(k % sides) * step)
        .map(|angle| [libm::cos(angle) as f32, libm::sin(angle) as f32])
        .collect()
}

/// Turns `vector`, which is square to `from`, by the smallest rotation of `from` into `to`.
///
/// # Source
///
/// The rotation of Möller and Hughes 1999 applied to a vector square to its start.
pub(crate) fn turn(vector: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    vector - (from + to) * (vector.dot(to) / (1.0 + from.dot(to)))
}

/// As [`turn`], for any two directions, and without rounding that adds up over many turns.
///
/// What is square to a direction is square to its opposite: straight back, nothing turns.
pub(crate) fn carry(vector: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let turned = if from.dot(to) > -0.999 { turn(vector, from, to) } else { vector };
    square(turned, to)
}

/// The unit vector square to `to` that is nearest to `vector`, or any if they are parallel.
pub(crate) fn square(vector: Vec3, to: Vec3) -> Vec3 {
    let flat = vector - to * vector.dot(to);
    let squared = flat.length_squared();
    if squared > 1e-12 { flat / libm::sqrtf(squared) } else { to.any_orthonormal_vector() }
}
