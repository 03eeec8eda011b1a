//! Cross-sections: fluted and a little flat where wood is thick and low in the tree, else round.

use deeptree_graph::{Draws, Vec3};

use super::axis::Sample;
use super::bark::{BARKED, fissure};
use crate::options::WoodOptions;

/// Thinner wood is round.
const ROUND: Growing = Growing(0.03, 0.15);

/// Lobes of a trunk.
const LOBES: [u32; 3] = [5, 6, 7];

/// Radii in metres between which something grows from nothing to all of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Growing(pub(crate) f32, pub(crate) f32);

impl Growing {
    /// How much of it there is at a radius, 0 to 1.
    pub(crate) fn share(self, radius: f32) -> f32 {
        ((radius - self.0) / (self.1 - self.0)).clamp(0.0, 1.0)
    }
}

/// The cross-sections of a limb: a closed curve `r (1 + e cos 2(θ−a) + f cos k(θ−b))`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    /// Depth of the flutes for thick wood, as a share of the radius; 0 for a round limb.
    depth: f32,
    /// How many flutes.
    lobes: f32,
    /// Angles of the long side and of a flute at the start of the limb.
    phases: (f32, f32),
    /// More depth of the lobes at the foot of the trunk, and how far up it reaches, in metres.
    foot: (f32, f32),
    /// Depth of the bark's fissures in metres.
    bark: f32,
}

/// A cross-section at one place of a limb.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    ellipse: (f32, f32),
    flute: (f32, f32),
    lobes: f32,
    /// Depth of the fissures as a share of the radius, the radius, and the place along the limb.
    bark: (f32, f32, f32),
}

impl Section {
    /// The cross-sections of a limb of this order; `foot` is the radius of a trunk at the ground.
    pub(crate) fn new(
        options: &WoodOptions,
        order: u16,
        foot: Option<f32>,
        mut draws: Draws,
    ) -> Self {
        let depth = options.fluting;
        let order = f32::from(order) + 1.0;
        let tau = core::f32::consts::TAU;
        Self {
            depth: depth / (order * order),
            lobes: LOBES[draws.index(LOBES.len())] as f32,
            phases: (tau * draws.uniform() as f32, tau * draws.uniform() as f32),
            foot: foot.map_or((0.0, 1.0), |radius| (1.5 * depth, 1.5 * radius)),
            bark: options.bark,
        }
    }

    /// The cross-section at a point of the axis.
    pub(crate) fn at(&self, sample: &Sample) -> Outline {
        let thick = ROUND.share(sample.radius);
        let depth = self.depth * thick;
        let mut flute = 0.6 * depth;
        if self.foot.0 > 0.0 {
            flute += self.foot.0 * thick * libm::expf(-sample.s / self.foot.1);
        }
        // Flutes wind slowly around the limb.
        let turn = 0.07 * sample.s;
        Outline {
            ellipse: (depth, self.phases.0 + turn),
            flute: (flute, self.phases.1 + turn),
            lobes: self.lobes,
            bark: (
                self.bark * BARKED.share(sample.radius) / sample.radius,
                sample.radius,
                sample.s,
            ),
        }
    }
}

impl Outline {
    /// Whether the cross-section is a circle.
    pub(crate) fn is_round(&self) -> bool {
        self.ellipse.0 < 1e-3 && self.flute.0 < 1e-3 && self.bark.0 <= 0.0
    }

    /// Radius at an angle as a share of the ring's, and its derivative by the angle.
    pub(crate) fn radius(&self, angle: f32) -> (f32, f32) {
        if self.is_round() {
            return (1.0, 0.0);
        }
        let (sin2, cos2) = libm::sincosf(2.0 * (angle - self.ellipse.1));
        let (sink, cosk) = libm::sincosf(self.lobes * (angle - self.flute.1));
        let mut radius = 1.0 + self.ellipse.0 * cos2 + self.flute.0 * cosk;
        let (depth, size, s) = self.bark;
        if depth > 0.0 {
            // Normals of rough bark are those of its faces: the slope leaves the fissures out.
            let (sin, cos) = libm::sincosf(angle);
            radius -= depth * fissure(size * cos, size * sin, s);
        }
        let slope = -2.0 * self.ellipse.0 * sin2 - self.lobes * self.flute.0 * sink;
        (radius, slope)
    }

    /// Position and normal, in units of the radius, at an angle given by its cosine and sine: in
    /// the plane of the directions `x` and `y`.
    pub(crate) fn point(&self, angle: f32, [cos, sin]: [f32; 2], x: Vec3, y: Vec3) -> (Vec3, Vec3) {
        let out = x * cos + y * sin;
        if self.is_round() {
            return (out, out);
        }
        let (radius, slope) = self.radius(angle);
        let around = y * cos - x * sin;
        ((out * radius), (out * radius - around * slope).normalize())
    }
}
