//! The part of the sphere around a scanner in which its target is.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use deeptree_graph::Vec3;
use glam::DVec3;

/// A range of azimuths and one of elevations, in radians. The azimuth of `(x, z)` is `atan2(z, x)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    pub(crate) azimuths: [f64; 2],
    pub(crate) elevations: [f64; 2],
}

impl Window {
    /// A window that holds all of a box seen from a place.
    pub(crate) fn of_box((low, high): (Vec3, Vec3), from: DVec3) -> Self {
        let (low, high) = (low.as_dvec3() - from, high.as_dvec3() - from);
        let nearest = |low: f64, high: f64| 0.0f64.clamp(low, high);
        let (x, z) = (nearest(low.x, high.x), nearest(low.z, high.z));
        let near = libm::sqrt(x * x + z * z);
        let (x, z) = (low.x.abs().max(high.x.abs()), low.z.abs().max(high.z.abs()));
        let far = libm::sqrt(x * x + z * z);
        let steepest =
            |height: f64, outward: bool| libm::atan2(height, if outward { near } else { far });
        let elevations = [steepest(low.y, low.y < 0.0), steepest(high.y, high.y > 0.0)];
        Self { azimuths: azimuths(low, high, near), elevations }
    }

    /// The direction at these shares of the window, so that equal areas of the sphere have equal
    /// areas of shares (Archimedes: the sine of the elevation is uniform on a sphere).
    pub(crate) fn direction(&self, azimuth: f64, elevation: f64) -> DVec3 {
        let turn = self.azimuths[0] + azimuth * (self.azimuths[1] - self.azimuths[0]);
        let [low, high] = self.elevations.map(libm::sin);
        let sine = low + elevation * (high - low);
        let cosine = libm::sqrt((1.0 - sine * sine).max(0.0));
        DVec3::new(cosine * libm::cos(turn), sine, cosine * libm::sin(turn))
    }
}

/// The azimuths of a box's corners relative to the scanner, `near` from its footprint.
fn azimuths(low: DVec3, high: DVec3, near: f64) -> [f64; 2] {
    if near <= 0.0 {
        return [-PI, PI];
    }
    let middle = libm::atan2((low.z + high.z) / 2.0, (low.x + high.x) / 2.0);
    let corners = [(low.x, low.z), (low.x, high.z), (high.x, low.z), (high.x, high.z)];
    let offsets = corners.map(|(x, z)| wrapped(libm::atan2(z, x) - middle));
    let [a, b, c, d] = offsets;
    let widest = [a.min(b).min(c).min(d), a.max(b).max(c).max(d)];
    // A hair wider than rounding.
    [middle + (widest[0] - 1e-9).max(-FRAC_PI_2), middle + (widest[1] + 1e-9).min(FRAC_PI_2)]
}

/// An angle in [−π, π].
fn wrapped(angle: f64) -> f64 {
    match angle {
        a if a > PI => a - TAU,
        a if a < -PI => a + TAU,
        a => a,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_holds_all_of_a_box() {
        let (low, high) = (Vec3::new(-1.0, 0.0, -2.0), Vec3::new(2.0, 5.0, 1.0));
        for from in
            [DVec3::new(6.0, 1.5, 0.0), DVec3::new(-4.0, 9.0, -7.0), DVec3::new(0.0, 1.0, 3.0)]
        {
            let window = Window::of_box((low, high), from);
            for i in 0..1000 {
                let share = |k: i32| f64::from(i / k % 10) / 9.0;
                let [x, y, z] = [share(1), share(10), share(100)];
                let size = (high - low).as_dvec3();
                let to = low.as_dvec3() + size * DVec3::new(x, y, z) - from;
                let elevation = libm::asin(to.normalize().y);
                let middle = (window.azimuths[0] + window.azimuths[1]) / 2.0;
                let azimuth = middle + wrapped(libm::atan2(to.z, to.x) - middle);
                let within = |range: [f64; 2], a: f64| a > range[0] - 1e-9 && a < range[1] + 1e-9;
                assert!(within(window.azimuths, azimuth), "{window:?} {to}");
                assert!(within(window.elevations, elevation), "{window:?} {to}");
            }
        }
    }
}
