//! Limbs as tubes of rings, with the patches in them that laterals grow out of.

use deeptree_graph::{BranchGraph, Lineage, NodeId, Purpose, Seed, Vec3};

use super::axis::{Axis, Flare, Sample};
use super::bark::{BARKED, GRAIN};
use super::collar::Joint;
use super::joint::{Band, Exit, LEAST_RISE, Lateral, Patch};
use super::limbs::Limbs;
use super::ring::{Ring, Row, Wrap};
use super::section::Section;
use super::{joint, zip};
use crate::circle::circle;
use crate::internode::Internode;
use crate::mesh::{Mesh, Tube};
use crate::options::WoodOptions;
use crate::tubes::{MIN_EDGE, MIN_RADIUS};

/// Tips from this radius on are rounded; thinner ones taper and end in a cone, in metres.
const ROUND_TIP: f32 = 0.02;

/// The radius of a thin tip as a share of its node's.
const TAPER: f32 = 0.5;

/// Nodes of one limb keep this distance, in radii: closer ones share a station.
const SPACING: f32 = 0.5;

/// Vertices of a ring keep this distance from those below them of the ring before, where it has as many;
/// in radii.
const NEAREST: f32 = 1e-4;

/// Rings keep this distance from those that a band or an end needs, in radii.
const CLOSE: f32 = 0.3;

/// Radius in metres from which wood counts as thick.
const THICK: f32 = 0.04;

/// Thick wood has a ring before its radius falls by this factor: between two rings triangles bend the
/// texture, which narrows with the limb.
const TAPERED: f32 = 1.3;

/// How often an internode is halved for its bend.
const HALVINGS: u32 = 4;

/// At most this many rings an internode for its bark.
const MAX_PIECES: f32 = 1000.0;

/// What a limb is built from, and room to work in; the limb's parts are taken out while in use.
pub(crate) struct Sweep<'a> {
    tree: &'a BranchGraph,
    pub(crate) options: &'a WoodOptions,
    limbs: Limbs,
    /// Where each limb leaves its parent; none for the trunk.
    joints: Vec<Option<Joint>>,
    pub(crate) mesh: Mesh,
    /// Unit circles by their sides.
    circles: Vec<Vec<[f32; 2]>>,
    axis: Axis,
    laterals: Vec<Lateral>,
    exits: Vec<Exit>,
    bands: Vec<Band>,
    patches: Vec<Patch>,
    rows: Vec<Row>,
    samples: Vec<Sample>,
    angles: [Vec<f32>; 2],
    loops: (Vec<u32>, Vec<[f32; 2]>),
    taken: Vec<bool>,
}

impl<'a> Sweep<'a> {
    pub(crate) fn new(tree: &'a BranchGraph, options: &'a WoodOptions) -> Self {
        let limbs = Limbs::of(tree, options.min_radius);
        // About what trees of eight species take at the finest level.
        let room = 16 * tree.len();
        let mesh = Mesh {
            positions: Vec::with_capacity(room),
            normals: Vec::with_capacity(room),
            uvs: Vec::with_capacity(room),
            nodes: Vec::with_capacity(room),
            indices: Vec::with_capacity(4 * room),
            internodes: Internode::all(tree),
            ..Mesh::default()
        };
        Self {
            tree,
            options,
            joints: vec![None; limbs.starts.len()],
            limbs,
            mesh,
            circles: Vec::new(),
            axis: Axis::default(),
            laterals: Vec::new(),
            exits: Vec::new(),
            bands: Vec::new(),
            patches: Vec::new(),
            rows: Vec::new(),
            samples: Vec::new(),
            angles: [Vec::new(), Vec::new()],
            loops: (Vec::new(), Vec::new()),
            taken: Vec::new(),
        }
    }

    /// Builds all limbs, parents first.
    pub(crate) fn run(mut self) -> Mesh {
        for limb in 0..self.limbs.starts.len() {
            let (vertices, indices) = self.mesh.ends();
            self.limb(limb);
            let (vertices_end, indices_end) = self.mesh.ends();
            let start = self.limbs.starts[limb];
            let Internode { branch, order, .. } = self.mesh.internodes[start as usize];
            self.mesh.tubes.push(Tube {
                branch,
                order,
                vertices: vertices..vertices_end,
                indices: indices..indices_end,
            });
        }
        self.mesh
    }

    /// Builds one limb, and the rims of the collars on it.
    fn limb(&mut self, limb: usize) {
        let start = self.limbs.starts[limb];
        let joint = self.joints[limb].take();
        let order = self.tree.node(start).order;
        let foot = joint.is_none().then(|| self.axis_start(start).1);
        let (low, high) = self.lay(start, joint.as_ref());
        let draws = Seed(self.tree.info.seed)
            .draws(Lineage::ROOT, Purpose::CrossSection)
            .at(u64::from(start));
        let section = Section::new(self.options, order, foot, draws);

        let mut exits = core::mem::take(&mut self.exits);
        let mut bands = core::mem::take(&mut self.bands);
        exits.clear();
        for &lateral in &self.laterals {
            exits.push(joint::exit(self.tree, &self.limbs, &self.axis, lateral, self.options));
        }
        joint::bands(&mut exits, low, high, &mut bands);

        let mut row = match &joint {
            Some(joint) => {
                let end = self.axis.at(low);
                self.collar(joint, &end, &section)
            }
            None => self.foot(&section),
        };
        for band in &bands {
            row = self.plain(row, band.low, &section);
            row = self.band(row, band, &exits, &section);
        }
        let length = self.axis.len();
        row = self.plain(row, length, &section);
        self.tip(row, &section);
        (self.exits, self.bands) = (exits, bands);
    }

    /// Where the axis of a limb without a joint starts, and the radius there.
    fn axis_start(&self, start: NodeId) -> (Vec3, f32) {
        let node = self.tree.node(start);
        (node.base(), node.thickness.max(MIN_RADIUS))
    }

    /// Lays the axis of a limb and finds its laterals; returns the stretch that is free for them.
    fn lay(&mut self, start: NodeId, joint: Option<&Joint>) -> (f32, f32) {
        let (tree, axis) = (self.tree, &mut self.axis);
        self.laterals.clear();
        let node = tree.node(start);
        let (position, radius) = match joint {
            Some(joint) => (joint.center, joint.radius),
            None => (node.base(), node.thickness.max(MIN_RADIUS)),
        };
        axis.restart(position, radius, start);
        let mut outside = joint.is_none();
        for id in self.limbs.nodes(start) {
            let node = tree.node(id);
            outside = outside || joint.is_some_and(|joint| joint.outside == Some(id));
            if outside {
                let thickness = node.thickness.max(MIN_RADIUS);
                let first = axis.stations.len() == 1 && joint.is_some();
                let spacing = if first { radius } else { SPACING * thickness };
                if !axis.push(node.position, thickness, id, spacing) && node.child_count() == 0 {
                    axis.end_at(node.position, thickness, id);
                }
            }
            let near = axis.len();
            self.laterals.extend(self.limbs.leaving(node).map(|limb| Lateral { limb, near }));
        }

        let starts = &self.limbs.starts;
        let radii = self.laterals.iter().map(|l| tree.node(starts[l.limb as usize]).thickness);
        let thickest = axis.stations.iter().map(|s| s.radius).fold(0.0, f32::max);
        let room = joint::least_room(radii.map(|r| r.min(thickest)));
        let tip = axis.stations[axis.stations.len() - 1].radius;
        let tip_zone = (0.5 * tip).max(MIN_EDGE);
        let (least, wanted) = match joint {
            Some(joint) => ((0.6 * radius).max(2.0 * MIN_EDGE), joint.reach()),
            None => ((0.1 * radius).max(MIN_EDGE), 0.0),
        };
        let front = || Some(node.front()).filter(|front| front.is_normalized());
        let direction = joint.map(|joint| joint.rise).or_else(front).unwrap_or(Vec3::Y);
        axis.lengthen(least + room + tip_zone, direction);
        if tip <= ROUND_TIP {
            axis.taper((TAPER).max(MIN_RADIUS / tip).min(1.0));
        }
        let flare = joint
            .is_none()
            .then_some(Flare { amount: self.options.foot_flare - 1.0, length: 1.8 * radius });
        axis.finish(joint.map(|joint| joint.rise), flare);
        let high = axis.len() - tip_zone;
        (wanted.min(high - room).max(least), high)
    }

    /// How many sides a ring gets after one of `sides`.
    fn sides(&self, sides: u32, radius: f32) -> u32 {
        let wanted = self.options.sides(radius);
        // A change of sides takes triangles of its own: not for a few.
        if wanted > sides || 4 * wanted <= 3 * sides { wanted } else { sides }
    }

    /// The unit circle in so many sides.
    pub(crate) fn circle(&mut self, sides: u32) {
        let sides = sides as usize;
        if self.circles.len() <= sides {
            self.circles.resize(sides + 1, Vec::new());
        }
        if self.circles[sides].is_empty() {
            self.circles[sides] = circle(sides as u32);
        }
    }

    /// The unit circles by their sides: those asked for.
    pub(crate) fn circles(&self) -> &[Vec<[f32; 2]>] {
        &self.circles
    }

    /// Writes the vertices of a ring; even angles are given by an empty list.
    pub(crate) fn row(&mut self, ring: Ring, sides: u32, angles: Vec<f32>) -> Row {
        let first = self.mesh.positions.len() as u32;
        let outward =
            if ring.is_round() { 1.0 / libm::sqrtf(1.0 + ring.lean * ring.lean) } else { 0.0 };
        if angles.is_empty() {
            self.circle(sides);
            let step = core::f32::consts::TAU / sides as f32;
            for (k, &turn) in self.circles[sides as usize].iter().enumerate() {
                let angle = k as f32 * step;
                // The seam's other edge stands at the same bits.
                let (position, normal) =
                    ring.point(if k as u32 == sides { 0.0 } else { angle }, turn);
                let normal = if outward > 0.0 { normal * outward } else { normal.normalize() };
                let uv = ring.texture(angle);
                self.mesh.vertex(position, normal, uv, ring.node);
            }
        } else {
            for &angle in &angles[..sides as usize] {
                let (sin, cos) = libm::sincosf(angle);
                let (position, normal) = ring.point(angle, [cos, sin]);
                let normal = if outward > 0.0 { normal * outward } else { normal.normalize() };
                let uv = ring.texture(angle);
                self.mesh.vertex(position, normal, uv, ring.node);
            }
            let uv = ring.texture(angles[sides as usize]);
            self.mesh.copy(first, uv);
        }
        self.mesh.seams.push([first + sides, first]);
        Row { ring, first, sides, angles }
    }

    /// Writes the triangles between two rows.
    fn join(&mut self, low: &Row, high: &Row) {
        self.part(low, high);
        let even = |row: &Row| row.angles.is_empty();
        let [from, to] = &mut self.angles;
        if !(even(low) && even(high)) || low.sides != high.sides {
            low.fill_angles(from);
            high.fill_angles(to);
        }
        if low.sides == high.sides {
            let side = core::f32::consts::TAU / low.sides as f32;
            let twist = |(a, b): (&f32, &f32)| (a - b).abs() > 0.4 * side;
            if even(low) && even(high) || !from.iter().zip(&*to).any(twist) {
                self.mesh.quads(low.first, high.first, low.sides);
                return;
            }
        }
        let indices = &mut self.mesh.indices;
        zip::strip(from, to, |corners| {
            let vertex =
                |(upper, k): (bool, usize)| k as u32 + if upper { high.first } else { low.first };
            indices.extend(corners.map(vertex));
        });
    }

    /// Writes the next row and what joins it to the one before.
    fn go_on(&mut self, row: &Row, sample: &Sample, section: &Section, angles: Vec<f32>) -> Row {
        let sides = match angles.len() {
            0 => self.sides(row.sides, sample.radius),
            n => n as u32 - 1,
        };
        let next = self.row(row.ring.next(sample, section), sides, angles);
        self.join(row, &next);
        next
    }

    /// Moves the vertices of a row out that stand where those of the row before stand: where the axis
    /// turns sharply on the spot, rings cross each other, and a triangle could be none.
    fn part(&mut self, low: &Row, high: &Row) {
        if low.sides != high.sides {
            return;
        }
        let Ring { center, radius, .. } = high.ring;
        for k in 0..=high.sides {
            let before = self.mesh.positions[(low.first + k) as usize];
            let place = &mut self.mesh.positions[(high.first + k) as usize];
            if place.distance(before) < NEAREST * radius {
                let digits = 8.0 * f32::EPSILON * place.abs().max_element();
                let out = (*place - center).normalize_or(high.ring.along);
                *place += out * (10.0 * NEAREST * radius).max(digits);
            }
        }
    }

    /// Rings after `row` up to, but not at, the point `end` of the axis: as many as the bends take.
    fn plain(&mut self, mut row: Row, end: f32, section: &Section) -> Row {
        let mut samples = core::mem::take(&mut self.samples);
        self.candidates(&row, end, &mut samples);
        let last = self.axis.at(end);
        let mut from =
            Sample { position: row.ring.center, radius: row.ring.radius, s: row.ring.s, ..last };
        let mut skipped = 0;
        for i in 0..samples.len() {
            let to = samples.get(i + 1).unwrap_or(&last);
            if samples[skipped..=i].iter().all(|sample| self.is_spare(&from, sample, to)) {
                continue;
            }
            skipped = i + 1;
            from = samples[i];
            row = self.go_on(&row, &samples[i], section, Vec::new());
        }
        self.samples = samples;
        row
    }

    /// Whether a tube between two points is near enough to the limb at `sample`.
    fn is_spare(&self, from: &Sample, sample: &Sample, to: &Sample) -> bool {
        let share = (sample.s - from.s) / (to.s - from.s);
        let off = sample.position.distance_squared(from.position.lerp(to.position, share));
        let thinner = (from.radius + (to.radius - from.radius) * share - sample.radius).abs();
        let limit = self.options.axis_tolerance;
        let (way, on) = (sample.position - from.position, to.position - sample.position);
        // A tube without it has half of the bend from end to end as corners.
        let corner = 0.5 * self.most_bend(sample.radius);
        off < limit * limit
            && thinner < 0.5 * self.options.tolerance
            && way.dot(on) > (1.0 - 0.5 * corner * corner) * way.length() * on.length()
            && !self.is_barked(sample.radius)
            && (sample.radius < THICK
                || from.radius.max(to.radius) < TAPERED * from.radius.min(to.radius))
    }

    /// The most that a limb may bend between two rings, in radians: thick wood shows its corners.
    fn most_bend(&self, radius: f32) -> f32 {
        let coarse = libm::sqrtf(self.options.axis_tolerance / 0.02);
        (0.12 + 0.0015 / radius) * coarse
    }

    /// Whether wood of this radius gets rings for its fissures.
    fn is_barked(&self, radius: f32) -> bool {
        self.options.bark > 0.0 && radius > BARKED.0
    }

    /// Points between a row and `end` where rings may stand: at stations, between them where the
    /// axis bends, and along the flare.
    fn candidates(&self, row: &Row, end: f32, out: &mut Vec<Sample>) {
        out.clear();
        let axis = &self.axis;
        let close = |radius: f32| if self.is_barked(radius) { 0.5 * GRAIN } else { CLOSE * radius };
        let begin = row.ring.s + close(row.ring.radius);
        let push = |s: f32, out: &mut Vec<Sample>| {
            let sample = axis.at(s);
            let last = out.last().map_or(begin, |last| last.s + close(last.radius));
            if s > last && s < end - close(sample.radius) {
                out.push(sample);
            }
        };
        if let Some(length) = axis.flare_length().filter(|_| self.options.bark <= 0.0) {
            for share in [0.12, 0.3, 0.55, 0.9, 1.4, 2.2, 3.2] {
                push(share * length, out);
            }
        }
        let first = axis.stations.partition_point(|station| station.s <= row.ring.s).max(1);
        for pair in axis.stations[first - 1..].windows(2) {
            if pair[0].s >= end {
                break;
            }
            let length = pair[1].s - pair[0].s;
            if self.is_barked(pair[0].radius) {
                let pieces = libm::ceilf(length / GRAIN).clamp(1.0, MAX_PIECES) as u32;
                for k in 1..=pieces {
                    push(pair[0].s + length * k as f32 / pieces as f32, out);
                }
            } else {
                let (a, b) = (axis.at(pair[0].s), axis.at(pair[1].s));
                self.halve(&a, &b, HALVINGS, &mut |s| push(s, out));
                push(b.s, out);
            }
        }
    }

    /// Calls `push` for points between two of the axis: their middle and so on, until the axis does
    /// not bend much between neighbours.
    fn halve(&self, a: &Sample, b: &Sample, halvings: u32, push: &mut impl FnMut(f32)) {
        let turn = a.turn(b);
        // The arrow of an arc with this turn.
        let arrow = turn * (b.s - a.s) / 8.0;
        if halvings == 0 || turn < self.most_bend(b.radius) && arrow < self.options.axis_tolerance {
            return;
        }
        let middle = self.axis.at(0.5 * (a.s + b.s));
        self.halve(a, &middle, halvings - 1, push);
        push(middle.s);
        self.halve(&middle, b, halvings - 1, push);
    }

    /// The lowest ring of the trunk, and the disc below it.
    fn foot(&mut self, section: &Section) -> Row {
        let sample = self.axis.at(0.0);
        let size = self.options.texture_size;
        let x = sample.tangent.any_orthonormal_vector();
        let wrap = Wrap::new(self.axis.stations[0].radius, self.options);
        let ring = Ring::new(&sample, section, x, wrap, 0.0);
        let row = self.row(ring, self.options.sides(ring.radius), Vec::new());
        let start = self.mesh.positions.len() as u32;
        for k in 0..row.sides {
            let original = row.first + k;
            let out = (self.mesh.positions[original as usize] - ring.center) / size;
            let uv = [-out.dot(ring.x), out.dot(ring.y)];
            let copy = self.mesh.copy(original, uv);
            self.mesh.normals[copy as usize] = -ring.along;
            self.mesh.seams.push([copy, original]);
        }
        // From the middle: seen from there, no flute hides another.
        let middle = start + row.sides;
        self.mesh.vertex(ring.center, -ring.along, [0.0, 0.0], ring.node);
        let next = |k: u32| start + (k + 1) % row.sides;
        self.mesh.indices.extend((0..row.sides).flat_map(|k| [middle, next(k), start + k]));
        row
    }

    /// The last ring and what closes it: a cone, or a dome of one more ring.
    fn tip(&mut self, row: Row, section: &Section) {
        /// Height of a cone in radii.
        const CONE: f32 = 1.5;
        let sample = self.axis.at(self.axis.len());
        let mut row = self.go_on(&row, &sample, section, Vec::new());
        let ring = row.ring;
        let round = ring.radius > ROUND_TIP;
        let height = if round { ring.radius } else { CONE * ring.radius };
        if round {
            let half = core::f32::consts::FRAC_1_SQRT_2;
            let dome = Ring {
                center: ring.center + ring.along * (half * ring.radius),
                radius: half * ring.radius,
                lean: 1.0,
                v: ring.v + 0.8 * ring.radius * ring.wrap.along(ring.radius),
                ..ring
            };
            let next = self.row(dome, row.sides, Vec::new());
            self.join(&row, &next);
            row = next;
        }
        let apex = self.mesh.positions.len() as u32;
        let v = ring.v + 1.5 * ring.radius * ring.wrap.along(ring.radius);
        let uv = ring.wrap.texture(core::f32::consts::PI + ring.turn, 0.0, v);
        self.mesh.vertex(ring.center + ring.along * height, ring.along, uv, ring.node);
        let fan = (row.first..row.first + row.sides).flat_map(|low| [low, low + 1, apex]);
        self.mesh.indices.extend(fan);
    }

    /// Two rings with the laterals between them.
    fn band(&mut self, row: Row, band: &Band, exits: &[Exit], section: &Section) -> Row {
        let sample = self.axis.at(band.low);
        let ring = row.ring.next(&sample, section);
        let count = band.exits.len() as u32;
        let sides = self.sides(row.sides, sample.radius).max(if count > 1 { 3 * count } else { 3 });
        let mut patches = core::mem::take(&mut self.patches);
        let mut angles = Vec::new();
        joint::patches(exits, band, sides, &ring, &mut patches);
        joint::angles(&mut patches, sides, &mut angles);

        let mut rows = core::mem::take(&mut self.rows);
        rows.clear();
        rows.push(self.go_on(&row, &sample, section, angles));
        for sample in self.within(band) {
            let before = &rows[rows.len() - 1];
            let (ring, angles) = (before.ring.next(&sample, section), before.angles.clone());
            let next = self.row(ring, sides, angles);
            self.part(before, &next);
            rows.push(next);
        }

        self.taken.clear();
        self.taken.resize(sides as usize, false);
        for patch in &patches {
            for column in patch.columns.0..patch.columns.1 {
                self.taken[column.rem_euclid(sides as i32) as usize] = true;
            }
        }
        for pair in rows.windows(2) {
            for column in (0..sides).filter(|&column| !self.taken[column as usize]) {
                self.mesh.quads(pair[0].first + column, pair[1].first + column, 1);
            }
        }
        for patch in &patches {
            self.patch(&rows, patch, &exits[patch.exit]);
        }
        self.patches = patches;
        let mut high = rows[rows.len() - 1].clone();
        high.turn_columns();
        self.rows = rows;
        high
    }

    /// The points of the axis where a band has its rings, after its lowest.
    fn within(&self, band: &Band) -> Vec<Sample> {
        let (low, high) = (self.axis.at(band.low), self.axis.at(band.high));
        let length = band.high - band.low;
        let bend = low.tangent.distance(high.tangent) / self.most_bend(low.radius);
        let barked = if self.is_barked(low.radius) { length / GRAIN } else { 1.0 };
        // Not so many that rings cross at the bend.
        let most = (length / (CLOSE * low.radius)).max(barked);
        let pieces = libm::ceilf(bend.max(barked).min(most).clamp(1.0, MAX_PIECES)) as u32;
        let at = |k: u32| self.axis.at(band.low + length * k as f32 / pieces as f32);
        (1..=pieces).map(at).collect()
    }

    /// The rim of a collar, and the triangles between it and the sides around it.
    fn patch(&mut self, rows: &[Row], patch: &Patch, exit: &Exit) {
        let (low, high) = (&rows[0], &rows[rows.len() - 1]);
        let length = high.ring.s - low.ring.s;
        let middle = exit.s - low.ring.s;
        let half = exit.half.min(0.85 * middle.min(length - middle));
        let half_angle = patch.half_angle.min(0.85 * patch.half);

        let lateral = exit.radius.min(low.ring.radius);
        let sides = self.options.sides(lateral);
        self.circle(sides);
        let rim = self.mesh.positions.len() as u32;
        for k in 0..sides as usize {
            let [cos, sin] = self.circles[sides as usize][k];
            let (s, angle) = (exit.s - half * cos, patch.center + half_angle * sin);
            let (a, b, share) = around(rows, s);
            let at = between(a, b, share, angle);
            let mix = |a: f32, b: f32| a + (b - a) * share;
            let uv = a.wrap.texture(angle + a.turn, mix(a.radius, b.radius), mix(a.v, b.v));
            self.mesh.vertex(at.0, at.1, uv, b.node);
        }

        let (mut vertices, mut places) = core::mem::take(&mut self.loops);
        vertices.clear();
        places.clear();
        let (first, last) = patch.columns;
        let mut side = |row: &Row, column: i32| {
            let n = row.sides as i32;
            let turned = column > n;
            let within = if turned { column - n } else { column };
            let turn = if turned { core::f32::consts::TAU } else { 0.0 };
            let angle = row.angles[within as usize] + turn;
            let mut vertex = row.first + within as u32;
            if turned {
                // Beyond the seam: the texture goes on, so the vertex stands there once more.
                let uv = row.ring.texture(angle);
                let copy = self.mesh.copy(vertex, uv);
                self.mesh.seams.push([copy, vertex]);
                vertex = copy;
            }
            vertices.push(vertex);
            places.push([(angle - patch.center) / half_angle, (row.ring.s - exit.s) / half]);
        };
        let between_ends = &rows[1..rows.len() - 1];
        (first..=last).for_each(|column| side(low, column));
        between_ends.iter().for_each(|row| side(row, last));
        (first..=last).rev().for_each(|column| side(high, column));
        between_ends.iter().rev().for_each(|row| side(row, first));
        let indices = &mut self.mesh.indices;
        zip::ring(&places, &self.circles[sides as usize], |corners| {
            let vertex =
                |(outer, k): (bool, usize)| if outer { vertices[k] } else { rim + k as u32 };
            indices.extend(corners.map(vertex));
        });
        self.loops = (vertices, places);

        let (a, b, share) = around(rows, exit.s);
        let (center, normal) = between(a, b, share, patch.center);
        let up = (high.ring.center - low.ring.center).normalize();
        let to = exit.outside.map_or(normal, |id| self.tree.node(id).position - center);
        self.joints[exit.limb as usize] = Some(Joint {
            rim,
            sides,
            center,
            foot: -up,
            rise: rise(to.try_normalize().unwrap_or(normal), normal, up),
            normal,
            radius: lateral,
            rim_radius: 0.5 * (half + half_angle * low.ring.radius),
            outside: exit.outside,
        });
    }
}

/// The rings of a band below and above a place on the axis, and the share of the way between.
fn around(rows: &[Row], s: f32) -> (&Ring, &Ring, f32) {
    let k = rows[1..rows.len() - 1].partition_point(|row| row.ring.s < s);
    let (a, b) = (&rows[k].ring, &rows[k + 1].ring);
    (a, b, (s - a.s) / (b.s - a.s))
}

/// Position and normal of the straight surface between two rings.
fn between(low: &Ring, high: &Ring, share: f32, angle: f32) -> (Vec3, Vec3) {
    let (sin, cos) = libm::sincosf(angle);
    let (a, b) = (low.point(angle, [cos, sin]), high.point(angle, [cos, sin]));
    let normal = a.1.lerp(b.1, share).try_normalize().unwrap_or(low.along);
    (a.0.lerp(b.0, share), normal)
}

/// The direction in which a lateral leaves the surface: `way`, but steep enough.
fn rise(way: Vec3, normal: Vec3, up: Vec3) -> Vec3 {
    let steep = way.dot(normal);
    if steep >= LEAST_RISE {
        return way;
    }
    let flat = (way - normal * steep).try_normalize().unwrap_or(up);
    (normal * LEAST_RISE + flat * libm::sqrtf(1.0 - LEAST_RISE * LEAST_RISE)).normalize()
}
