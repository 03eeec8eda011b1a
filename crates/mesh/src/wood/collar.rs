//! The collar of a lateral: from its rim on the parent's surface to its first round ring.

use deeptree_graph::{NodeId, Vec3};

use super::axis::Sample;
use super::ring::{Ring, Row, Wrap};
use super::section::Section;
use super::sweep::Sweep;
use crate::circle::{carry, square};

/// How much of the way between rim and ring the directions at both ends rule, of a Hermite curve.
const EASE: f32 = 0.9;

/// Where a lateral leaves its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    /// The first of the rim's vertices on the parent's surface, from the parent's foot around.
    pub(crate) rim: u32,
    pub(crate) sides: u32,
    /// The middle of the rim, on the parent's surface.
    pub(crate) center: Vec3,
    /// The surface's normal there.
    pub(crate) normal: Vec3,
    /// Direction along the parent towards its foot.
    pub(crate) foot: Vec3,
    /// Direction in which the lateral leaves.
    pub(crate) rise: Vec3,
    /// Radius of the lateral.
    pub(crate) radius: f32,
    /// Mean radius of the rim.
    pub(crate) rim_radius: f32,
    /// The lateral's first node outside of its parent.
    pub(crate) outside: Option<NodeId>,
}

impl Joint {
    /// How far along the lateral a ring square to it is clear of the parent's surface, in metres.
    pub(crate) fn reach(&self) -> f32 {
        /// Height of the ring's lowest point above the surface, in radii.
        const CLEAR: f32 = 0.6;
        let steep = self.rise.dot(self.normal).max(0.1);
        let flat = libm::sqrtf((1.0 - steep * steep).max(0.0));
        self.radius * (flat + CLEAR) / steep
    }
}

/// One strand of a collar: from a vertex of the rim to one of the ring, by a Hermite curve.
#[derive(Clone, Copy)]
struct Strand {
    from: (Vec3, Vec3),
    to: (Vec3, Vec3),
}

impl Strand {
    fn at(&self, t: f32) -> Vec3 {
        let u = 1.0 - t;
        let rise = t * t * (3.0 - 2.0 * t);
        self.from.0.lerp(self.to.0, rise) + self.from.1 * (t * u * u) - self.to.1 * (t * t * u)
    }

    fn speed(&self, t: f32) -> Vec3 {
        let u = 1.0 - t;
        (self.to.0 - self.from.0) * (6.0 * t * u)
            + self.from.1 * (u * (1.0 - 3.0 * t))
            + self.to.1 * (t * (3.0 * t - 2.0))
    }
}

/// The normal where the surface goes on with the normal of `face`: smooth, but for sharp creases.
fn crease(normal: Vec3, face: Vec3) -> Vec3 {
    let Some(face) = face.try_normalize() else { return normal };
    let smooth = (2.0 * face.dot(normal)).clamp(0.0, 1.0);
    (face * (1.0 - smooth) + normal * smooth).try_normalize().unwrap_or(normal)
}

impl Sweep<'_> {
    /// Writes the collar of a limb up to its ring at `end`.
    pub(crate) fn collar(&mut self, joint: &Joint, end: &Sample, section: &Section) -> Row {
        let x = carry(square(joint.foot, joint.rise), joint.rise, end.tangent);
        let wrap = Wrap::new(end.radius, self.options);
        let along = wrap.along(end.radius);
        let ring = Ring::new(end, section, x, wrap, end.s * along);
        let sides = joint.sides;
        let n = sides as usize;
        self.circle(sides);
        let circle = &self.circles()[n];

        let step = core::f32::consts::TAU / sides as f32;
        let strands: Vec<Strand> = (0..n)
            .map(|k| {
                let rim = joint.rim as usize + k;
                let (p, normal) = (self.mesh.positions[rim], self.mesh.normals[rim]);
                let (q, _) = ring.point(k as f32 * step, circle[k]);
                let pull = EASE * p.distance(q);
                let inward = square(joint.center - p, normal);
                Strand { from: (p, inward * pull), to: (q, end.tangent * pull) }
            })
            .collect();
        let uv = |k: usize, t: f32| {
            let strand = &strands[k % n];
            let length = strand.from.0.distance(strand.to.0);
            let radius = joint.rim_radius + (ring.radius - joint.rim_radius) * t;
            wrap.texture(k as f32 * step + ring.turn, radius, ring.v - along * length * (1.0 - t))
        };

        let fits = libm::sqrtf(0.25 * joint.radius / self.options.tolerance) as u32;
        let rings = self.options.collar_rings.min(fits);

        // The rim once more, with the lateral's texture.
        let mut before = self.mesh.positions.len() as u32;
        for k in 0..=n {
            let original = joint.rim + (k % n) as u32;
            let (a, b) = (&strands[(k + n - 1) % n], &strands[(k + 1) % n]);
            let next = strands[k % n].at(1.0 / (rings + 1) as f32);
            let face = (b.from.0 - a.from.0).cross(next - strands[k % n].from.0);
            let copy = self.mesh.copy(original, uv(k, 0.0)) as usize;
            self.mesh.normals[copy] = crease(self.mesh.normals[copy], face);
            self.mesh.nodes[copy] = ring.node;
            self.mesh.seams.push([copy as u32, original]);
        }
        for i in 1..=rings {
            let t = i as f32 / (rings + 1) as f32;
            let first = self.mesh.positions.len() as u32;
            for k in 0..n {
                let (a, b) = (&strands[(k + n - 1) % n], &strands[(k + 1) % n]);
                let around = b.at(t) - a.at(t);
                let normal = around.cross(strands[k].speed(t));
                let normal = normal.try_normalize().unwrap_or(joint.normal);
                self.mesh.vertex(strands[k].at(t), normal, uv(k, t), ring.node);
            }
            self.mesh.copy(first, uv(n, t));
            self.mesh.seams.push([first + sides, first]);
            self.mesh.quads(before, first, sides);
            before = first;
        }
        let row = self.row(ring, sides, Vec::new());
        self.mesh.quads(before, row.first, sides);
        row
    }
}
