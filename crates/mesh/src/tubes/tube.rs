//! One closed tube: rings, walls between them, a rounded tip and a flat base.
//!
//! The frame is carried from ring to ring by the smallest rotation that turns one direction into
//! the next, so tubes do not twist; rings stand in the plane that halves a bend.

use deeptree_graph::{NodeId, Vec3};

use super::stations::Station;
use crate::circle::turn;
use crate::mesh::Mesh;
use crate::options::WoodOptions;

/// Rings at bends are widened to keep the branch's width; at most by this factor, which a bend of
/// about 96° reaches: beyond, the corner would grow a spike.
const MAX_STRETCH: f32 = 1.5;

/// Rings reach at most this share of an edge towards each other, so that they never cross.
const MAX_REACH: f32 = 0.45;

/// Tips from this radius on are rounded; thinner ones are cones, in metres.
const ROUND_RADIUS: f32 = 0.02;

const HALF_SQRT_2: f32 = core::f32::consts::FRAC_1_SQRT_2;

/// What a tube is made of, apart from where its rings stand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Sides of each ring.
    pub(crate) sides: u32,
    /// Repeats of the texture around.
    repeats: f32,
    /// Whether the base is seen and needs normals of its own; inside a parent it does not.
    open_foot: bool,
    /// Whether the tip is a dome; otherwise a cone.
    round: bool,
}

impl Shape {
    /// The shape of the tube along `stations`; `forks` tells whether laterals leave from the tip.
    pub(crate) fn new(
        stations: &[Station],
        options: &WoodOptions,
        is_trunk: bool,
        forks: bool,
    ) -> Self {
        let thickest = stations.iter().map(|s| s.radius).fold(0.0, f32::max);
        let tip = stations[stations.len() - 1].radius;
        Self {
            sides: options.sides(thickest),
            repeats: options.repeats(stations[0].radius),
            open_foot: is_trunk,
            // A dome also covers the bases of the laterals, which lie within its radius.
            round: forks || tip > ROUND_RADIUS,
        }
    }

    /// How many vertices a tube of `stations` stations has.
    pub(crate) fn vertex_count(&self, stations: usize) -> usize {
        let sides = self.sides as usize;
        let foot = if self.open_foot { sides } else { 0 };
        foot + (sides + 1) * (stations + usize::from(self.round)) + 1
    }

    /// How many indices a tube of `stations` stations has.
    pub(crate) fn index_count(&self, stations: usize) -> usize {
        let sides = self.sides as usize;
        6 * sides * (stations - 1 + usize::from(self.round)) + 3 * sides + 3 * (sides - 2)
    }
}

/// An edge of the axis.
#[derive(Clone, Copy)]
struct Edge {
    direction: Vec3,
    length: f32,
    /// How much radius is lost per length.
    taper: f32,
}

impl Edge {
    fn between(a: &Station, b: &Station) -> Self {
        let way = b.position - a.position;
        let length = way.length();
        Self { direction: way / length, length, taper: (a.radius - b.radius) / length }
    }
}

/// Where and how one ring stands.
struct Ring {
    center: Vec3,
    radius: f32,
    /// Normal of the ring's plane, towards the tip.
    along: Vec3,
    /// Direction of the ring's first vertex.
    across: Vec3,
    /// Direction in the ring's plane that is widened, and by how much.
    stretch: (Vec3, f32),
    /// Tangent of the angle at which the normals lean towards the tip.
    lean: f32,
    /// Texture coordinate along the branch.
    v: f32,
    /// The node whose internode the ring belongs to.
    node: NodeId,
}

impl Ring {
    /// The directions of the first vertex and a quarter turn on, as unit vectors.
    fn frame(&self) -> (Vec3, Vec3) {
        (self.across, self.along.cross(self.across))
    }

    /// The ring's half axes: its vertices are `center + x cos + y sin`.
    fn half_axes(&self) -> (Vec3, Vec3) {
        let (direction, factor) = self.stretch;
        let widen =
            |axis: Vec3| self.radius * (axis + direction * ((factor - 1.0) * axis.dot(direction)));
        let (x, y) = self.frame();
        (widen(x), widen(y))
    }
}

/// The plane of the ring between two edges, and the widening that keeps the branch's width there.
fn bend(before: &Edge, after: &Edge, radius: f32, across: Vec3) -> (Vec3, (Vec3, f32)) {
    let sum = before.direction + after.direction;
    let difference = after.direction - before.direction;
    // Lengths of the sum and the difference are 2 cos and 2 sin of half the bend.
    let (cos, sin) = (0.5 * sum.length(), 0.5 * difference.length());
    // Straight back: any plane that holds the axis halves this bend.
    let along = if cos > 1e-3 { sum / (2.0 * cos) } else { across };
    if sin < 1e-3 {
        return (along, (across, 1.0));
    }
    let reach = MAX_REACH * before.length.min(after.length) / (radius * sin);
    let stretch = (1.0 / cos.max(1e-3)).min(MAX_STRETCH).min(reach);
    (along, (difference / (2.0 * sin), stretch))
}

/// Writes tubes into a mesh whose vectors have room for them.
pub(crate) struct Writer<'a> {
    pub(crate) mesh: &'a mut Mesh,
    pub(crate) texture_size: f32,
}

impl Writer<'_> {
    /// Appends the tube along `stations`; `circle` has the sides of `shape`.
    pub(crate) fn tube(&mut self, stations: &[Station], shape: &Shape, circle: &[[f32; 2]]) {
        let tip = stations.len() - 1;
        let mut edge = Edge::between(&stations[0], &stations[1]);
        let mut across = edge.direction.any_orthonormal_vector();
        let mut ring = Ring {
            center: stations[0].position,
            radius: stations[0].radius,
            along: edge.direction,
            across,
            stretch: (across, 1.0),
            lean: edge.taper,
            v: 0.0,
            node: stations[0].node,
        };
        self.base(&ring, shape, circle);
        self.ring(&ring, shape, circle);
        for i in 1..tip {
            let next = Edge::between(&stations[i], &stations[i + 1]);
            let (along, stretch) = bend(&edge, &next, stations[i].radius, across);
            ring = Ring {
                center: stations[i].position,
                radius: stations[i].radius,
                along,
                across: turn(across, edge.direction, along),
                stretch,
                lean: 0.5 * (edge.taper + next.taper),
                v: ring.v + edge.length / self.texture_size,
                node: stations[i].node,
            };
            self.wall(circle);
            self.ring(&ring, shape, circle);
            across = turn(ring.across, along, next.direction);
            // Rounding must not add up over hundreds of rings.
            across = (across - next.direction * across.dot(next.direction)).normalize();
            edge = next;
        }
        ring = Ring {
            center: stations[tip].position,
            radius: stations[tip].radius,
            along: edge.direction,
            across,
            stretch: (across, 1.0),
            lean: edge.taper,
            v: ring.v + edge.length / self.texture_size,
            node: stations[tip].node,
        };
        self.wall(circle);
        self.ring(&ring, shape, circle);
        self.tip(ring, shape, circle);
    }

    /// The flat base, which faces against the branch.
    fn base(&mut self, ring: &Ring, shape: &Shape, circle: &[[f32; 2]]) {
        let start = self.mesh.positions.len() as u32;
        if shape.open_foot {
            let (x, y) = ring.half_axes();
            let scale = ring.radius / self.texture_size;
            for &[cos, sin] in &circle[1..] {
                self.mesh.positions.push(ring.center + x * cos + y * sin);
                self.mesh.normals.push(-ring.along);
                self.mesh.uvs.push([scale * cos, scale * sin]);
                self.mesh.nodes.push(ring.node);
            }
            // The disc's vertices stand at those of the ring above it, which starts a side earlier.
            let ring = start + shape.sides;
            let original = |k: u32| ring + (k + 1) % shape.sides;
            self.mesh.seams.extend((0..shape.sides).map(|k| [start + k, original(k)]));
        }
        let fan = (1..shape.sides - 1).flat_map(|k| [start, start + k + 1, start + k]);
        self.mesh.indices.extend(fan);
    }

    /// The vertices of a ring, its first repeated at the end with the other end's u.
    fn ring(&mut self, ring: &Ring, shape: &Shape, circle: &[[f32; 2]]) {
        let (x, y) = ring.half_axes();
        let first = self.mesh.positions.len() as u32;
        self.mesh.seams.push([first + shape.sides, first]);
        let positions = circle.iter().map(|&[cos, sin]| ring.center + x * cos + y * sin);
        self.mesh.positions.extend(positions);
        self.mesh.nodes.extend(circle.iter().map(|_| ring.node));

        let outward = 1.0 / libm::sqrtf(1.0 + ring.lean * ring.lean);
        let (x, y) = ring.frame();
        let (x, y, up) = (x * outward, y * outward, ring.along * (ring.lean * outward));
        self.mesh.normals.extend(circle.iter().map(|&[cos, sin]| x * cos + y * sin + up));

        let step = shape.repeats / shape.sides as f32;
        self.mesh.uvs.extend((0..circle.len()).map(|k| [k as f32 * step, ring.v]));
    }

    /// The triangles between the last ring written and the next one.
    fn wall(&mut self, circle: &[[f32; 2]]) {
        let stride = circle.len() as u32;
        let next = self.mesh.positions.len() as u32;
        for low in next - stride..next - 1 {
            let high = low + stride;
            self.mesh.indices.extend_from_slice(&[low, low + 1, high + 1, low, high + 1, high]);
        }
    }

    /// Closes the tip above its ring: a cone, or a dome of one more ring.
    fn tip(&mut self, ring: Ring, shape: &Shape, circle: &[[f32; 2]]) {
        let apex = ring.center + ring.along * ring.radius;
        let (along, v_apex) = (ring.along, ring.v + 1.5 * ring.radius / self.texture_size);
        if shape.round {
            let dome = Ring {
                center: ring.center + along * (HALF_SQRT_2 * ring.radius),
                radius: HALF_SQRT_2 * ring.radius,
                lean: 1.0,
                v: 0.5 * (ring.v + v_apex),
                ..ring
            };
            self.wall(circle);
            self.ring(&dome, shape, circle);
        }
        let next = self.mesh.positions.len() as u32;
        self.mesh.positions.push(apex);
        self.mesh.normals.push(along);
        self.mesh.uvs.push([0.5 * shape.repeats, v_apex]);
        self.mesh.nodes.push(ring.node);
        for low in next - circle.len() as u32..next - 1 {
            self.mesh.indices.extend_from_slice(&[low, low + 1, next]);
        }
    }
}
