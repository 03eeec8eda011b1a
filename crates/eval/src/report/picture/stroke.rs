//! Internodes as tapered strokes with round ends, lit like cylinders.

use std::f32::consts::TAU;

use deeptree_graph::{BranchGraph, Node, Vec3};
use tiny_skia::{
    FillRule, GradientStop, LinearGradient, Paint, PathBuilder, Pixmap, Point, Shader, SpreadMode,
    Transform,
};

use super::ink;
use super::view::View;

/// No stroke is thinner than this many pixels from axis to edge: thinner ones would vanish.
const MIN_RADIUS: f32 = 0.3;

/// Strokes from this radius on are round; thinner ones have one tone.
const ROUND_RADIUS: f32 = 1.0;

/// Where the light comes from: the upper left, before the tree.
const LIGHT: Vec3 = Vec3::new(-0.62, 0.58, 0.53);

/// Lightness of wood in the shade, and what full light adds.
const SHADE: f32 = 0.02;
const LIT: f32 = 0.44;

/// How far the farthest wood fades into the paper.
const HAZE: f32 = 0.4;

/// Where gradients across a stroke are set, from one edge to the other.
const STOPS: [f32; 7] = [-1.0, -0.8, -0.4, 0.0, 0.4, 0.8, 1.0];

/// An internode as the viewer has it, in pixels; z to the viewer.
struct Stroke {
    from: Vec3,
    to: Vec3,
    from_radius: f32,
    to_radius: f32,
    /// Cut off at its start, as a trunk is by the ground.
    flat: bool,
}

/// Draws a tree and those beside it, the far wood first; `origin` is the pixel of its foot, `scale`
/// pixels a metre.
pub(super) fn trees(
    pixmap: &mut Pixmap,
    tree: &BranchGraph,
    beside: &[BranchGraph],
    view: View,
    scale: f32,
    origin: (f32, f32),
) {
    let axes = view.axes();
    let foot = tree.root().base();
    let place = |p: Vec3| {
        let seen = scale * axes.look(p - foot);
        Vec3::new(origin.0 + seen.x, origin.1 - seen.y, seen.z)
    };
    let stroke = |(tree, node): (&BranchGraph, &Node)| Stroke {
        from: place(node.base()),
        to: place(node.position),
        from_radius: (scale * start_radius(tree, node)).max(MIN_RADIUS),
        to_radius: (scale * node.thickness).max(MIN_RADIUS),
        flat: node.parent.is_none(),
    };
    let all = std::iter::once(tree).chain(beside);
    let nodes = all.flat_map(|tree| tree.nodes().iter().map(move |node| (tree, node)));
    let mut strokes: Vec<Stroke> = nodes.map(stroke).collect();
    strokes.sort_by(|a, b| a.depth().total_cmp(&b.depth()));
    let (Some(far), Some(near)) = (strokes.first(), strokes.last()) else { return };
    let (far, near) = (far.depth(), near.depth());
    for stroke in &strokes {
        let nearness = (stroke.depth() - far) / (near - far).max(1e-6);
        stroke.draw(pixmap, HAZE * (1.0 - nearness));
    }
}

/// An apical child goes on where its parent ends; a lateral one starts as thick as it ends.
fn start_radius(tree: &BranchGraph, node: &Node) -> f32 {
    match node.parent {
        Some(parent) if node.slot == 0 => tree.node(parent).thickness,
        _ => node.thickness,
    }
}

impl Stroke {
    fn depth(&self) -> f32 {
        0.5 * (self.from.z + self.to.z)
    }

    /// `haze`: how much of the paper shows through, 0 to 1.
    fn draw(&self, pixmap: &mut Pixmap, haze: f32) {
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        paint.shader = self.shader(haze);
        if let Some(path) = self.outline() {
            pixmap.fill_path(&path, &paint, FillRule::Winding, Transform::identity(), None);
        }
    }

    /// The hull of the circles at both ends.
    fn outline(&self) -> Option<tiny_skia::Path> {
        let (dx, dy) = (self.to.x - self.from.x, self.to.y - self.from.y);
        let distance = libm::hypotf(dx, dy);
        let taper = self.from_radius - self.to_radius;
        let mut builder = PathBuilder::new();
        if distance <= taper.abs() {
            // One circle hides the other.
            let (centre, radius) =
                if taper > 0.0 { (self.from, self.from_radius) } else { (self.to, self.to_radius) };
            arc(&mut builder, centre, radius, 0.0, TAU, steps(radius, TAU));
        } else {
            let heading = libm::atan2f(dy, dx);
            // The tangents of both circles lean toward the thinner one.
            let lean = libm::acosf(taper / distance);
            let (end, start) = (2.0 * lean, TAU - 2.0 * lean);
            let start_steps = if self.flat { 1 } else { steps(self.from_radius, start) };
            let end_steps = steps(self.to_radius, end);
            arc(&mut builder, self.to, self.to_radius, heading - lean, end, end_steps);
            arc(&mut builder, self.from, self.from_radius, heading + lean, start, start_steps);
        }
        builder.close();
        builder.finish()
    }

    /// Light and shade across the stroke.
    fn shader(&self, haze: f32) -> Shader<'static> {
        let along = self.to - self.from;
        // On the picture y points down, for the light it points up.
        let axis = Vec3::new(along.x, -along.y, along.z).normalize_or(Vec3::Z);
        let across = Vec3::new(axis.y, -axis.x, 0.0).normalize_or(Vec3::X);
        let to_viewer = if axis.z.abs() > 0.999 { Vec3::Z } else { across.cross(axis) };
        let to_viewer = if to_viewer.z < 0.0 { -to_viewer } else { to_viewer };
        let lightness = |s: f32| {
            let normal = s * across + libm::sqrtf(1.0 - s * s) * to_viewer;
            let wood = SHADE + LIT * normal.dot(LIGHT).max(0.0);
            wood + haze * (1.0 - wood)
        };
        let radius = self.from_radius.max(self.to_radius);
        let plain = || {
            let mean = (lightness(-0.6) + lightness(0.0) + lightness(0.6)) / 3.0;
            Shader::SolidColor(ink::grey(mean))
        };
        if radius < ROUND_RADIUS {
            return plain();
        }
        let middle = 0.5 * (self.from + self.to);
        let edge = |s: f32| {
            Point::from_xy(middle.x + s * radius * across.x, middle.y - s * radius * across.y)
        };
        let stops = STOPS.map(|s| GradientStop::new(0.5 * (s + 1.0), ink::grey(lightness(s))));
        LinearGradient::new(
            edge(-1.0),
            edge(1.0),
            stops.to_vec(),
            SpreadMode::Pad,
            Transform::identity(),
        )
        .unwrap_or_else(plain)
    }
}

/// Points along an arc that starts at the angle `start` and sweeps by `sweep`.
fn arc(builder: &mut PathBuilder, centre: Vec3, radius: f32, start: f32, sweep: f32, steps: usize) {
    for i in 0..=steps {
        let (sin, cos) = libm::sincosf(start + sweep * i as f32 / steps as f32);
        let (x, y) = (centre.x + radius * cos, centre.y + radius * sin);
        if builder.is_empty() {
            builder.move_to(x, y);
        } else {
            builder.line_to(x, y);
        }
    }
}

/// Chords of an arc that stay within a tenth of a pixel of the circle.
fn steps(radius: f32, sweep: f32) -> usize {
    let half = libm::acosf(1.0 - (0.1 / radius).min(0.3));
    (sweep / (2.0 * half)).ceil().clamp(1.0, 100.0) as usize
}
