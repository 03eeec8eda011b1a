//! One ring of a limb, and the rows of vertices along it.

use deeptree_graph::{NodeId, Vec3};

use super::axis::Sample;
use super::section::{Outline, Section};
use crate::circle::{carry, square};
use crate::mesh::Mesh;
use crate::options::WoodOptions;

/// How the texture lies around a limb.
///
/// It has a whole number of repeats around, so that it goes on across the seam, and the same
/// number all along: where the limb is thinner, the texture is finer, and v grows faster for it to
/// keep its shape, up to [`FINEST`]. With even texels both u and v are distances in textures, and the
/// edges of the seam do not continue each other.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Wrap {
    Seamless {
        repeats: f32,
        /// Most of v in a metre.
        finest: f32,
    },
    Even {
        /// Side of the texture in metres.
        size: f32,
    },
}

/// Most repeats along a limb on one side of the texture: on thinner wood its shape is drawn out
/// along the limb, as bark is on twigs, and does not get too fine to be seen.
const FINEST: f32 = 4.0;

impl Wrap {
    /// Around a limb of this radius at its start.
    pub(crate) fn new(radius: f32, options: &WoodOptions) -> Self {
        let size = options.texture_size;
        if options.even_texels {
            return Self::Even { size };
        }
        Self::Seamless { repeats: options.repeats(radius), finest: FINEST / size }
    }

    /// How much v grows in a metre along wood of this radius.
    pub(crate) fn along(self, radius: f32) -> f32 {
        match self {
            Self::Seamless { repeats, finest } => {
                (repeats / (core::f32::consts::TAU * radius)).min(finest)
            }
            Self::Even { size } => 1.0 / size,
        }
    }

    /// Texture coordinates at an angle from the middle line, opposite the seam at the start, of wood of
    /// this radius.
    pub(crate) fn texture(self, angle: f32, radius: f32, v: f32) -> [f32; 2] {
        match self {
            Self::Seamless { repeats, .. } => [angle * repeats / core::f32::consts::TAU, v],
            Self::Even { size } => [angle * radius / size, v],
        }
    }
}

/// Where and how a ring stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring {
    pub(crate) s: f32,
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    /// Normal of the ring's plane, towards the tip.
    pub(crate) along: Vec3,
    /// Directions at no turn and a quarter.
    pub(crate) x: Vec3,
    pub(crate) y: Vec3,
    /// How far `x` has been turned about the limb since its start, for the next rings' vertices to
    /// stand behind those of a band; texture and outline are not turned.
    pub(crate) turn: f32,
    /// How far normals lean towards the tip: loss of radius along the limb.
    pub(crate) lean: f32,
    pub(crate) outline: Outline,
    pub(crate) wrap: Wrap,
    /// How far along the limb the texture is, in repeats.
    pub(crate) v: f32,
    pub(crate) node: NodeId,
}

impl Ring {
    /// The ring at a point of the axis; `x` is carried there by who knows the ring before.
    pub(crate) fn new(sample: &Sample, section: &Section, x: Vec3, wrap: Wrap, v: f32) -> Self {
        let x = square(x, sample.tangent);
        Self {
            s: sample.s,
            center: sample.position,
            radius: sample.radius,
            along: sample.tangent,
            x,
            y: sample.tangent.cross(x),
            turn: -core::f32::consts::PI,
            lean: -sample.slope,
            outline: section.at(sample),
            wrap,
            v,
            node: sample.node,
        }
    }

    /// The next ring, turned against this one as little as possible.
    pub(crate) fn next(&self, sample: &Sample, section: &Section) -> Self {
        let x = carry(self.x, self.along, sample.tangent);
        let growth = 0.5 * (self.wrap.along(self.radius) + self.wrap.along(sample.radius));
        let v = self.v + growth * sample.position.distance(self.center);
        Self { turn: self.turn, ..Self::new(sample, section, x, self.wrap, v) }
    }

    /// Position and normal at an angle given with its cosine and sine.
    pub(crate) fn point(&self, angle: f32, turn: [f32; 2]) -> (Vec3, Vec3) {
        let (out, normal) = self.outline.point(angle + self.turn, turn, self.x, self.y);
        let normal = normal + self.along * self.lean;
        (self.center + out * self.radius, normal)
    }

    /// Texture coordinates at an angle.
    pub(crate) fn texture(&self, angle: f32) -> [f32; 2] {
        self.wrap.texture(angle + self.turn, self.radius, self.v)
    }

    /// Whether the cross-section is a circle.
    pub(crate) fn is_round(&self) -> bool {
        self.outline.is_round()
    }
}

/// A ring whose vertices are written: its first again at the end, with the texture's other edge.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) ring: Ring,
    pub(crate) first: u32,
    pub(crate) sides: u32,
    /// Angles of the vertices; empty where they stand evenly.
    pub(crate) angles: Vec<f32>,
}

impl Row {
    /// Turns the ring's directions so that its vertices stand, on the whole, as if evenly.
    pub(crate) fn turn_columns(&mut self) {
        let step = core::f32::consts::TAU / self.sides as f32;
        let columns = self.angles[..self.sides as usize].iter().enumerate();
        let drift: f32 = columns.map(|(k, angle)| angle - k as f32 * step).sum();
        let turn = drift / self.sides as f32;
        let (sin, cos) = libm::sincosf(turn);
        let Ring { x, y, .. } = self.ring;
        (self.ring.x, self.ring.y) = (x * cos + y * sin, y * cos - x * sin);
        self.ring.turn += turn;
        self.angles.iter_mut().for_each(|angle| *angle -= turn);
    }

    /// The angle of each vertex, the last a turn after the first.
    pub(crate) fn fill_angles(&self, out: &mut Vec<f32>) {
        out.clear();
        if self.angles.is_empty() {
            let step = core::f32::consts::TAU / self.sides as f32;
            out.extend((0..=self.sides).map(|k| k as f32 * step));
        } else {
            out.extend_from_slice(&self.angles);
        }
    }
}

impl Mesh {
    /// Adds a vertex.
    pub(crate) fn vertex(&mut self, position: Vec3, normal: Vec3, uv: [f32; 2], node: NodeId) {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        self.nodes.push(node);
    }

    /// Adds a vertex at the place of another, with other texture coordinates.
    pub(crate) fn copy(&mut self, original: u32, uv: [f32; 2]) -> u32 {
        let i = original as usize;
        self.vertex(self.positions[i], self.normals[i], uv, self.nodes[i]);
        self.positions.len() as u32 - 1
    }

    /// Where the next vertex and the next index go.
    pub(crate) fn ends(&self) -> (u32, u32) {
        let indices = u32::try_from(self.indices.len());
        let vertices = self.positions.len() as u32;
        (vertices, indices.unwrap_or_else(|_| panic!("more than 2³² indices: too many")))
    }

    /// Adds the triangles between two rows of equally many vertices.
    pub(crate) fn quads(&mut self, low: u32, high: u32, sides: u32) {
        self.indices.extend((0..sides).flat_map(|k| {
            let (a, b) = (low + k, high + k);
            [a, a + 1, b + 1, a, b + 1, b]
        }));
    }
}
