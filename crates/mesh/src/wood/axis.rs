//! The axis of a limb: a smooth curve through its nodes, and the radius along it.

use deeptree_graph::{NodeId, Vec3};

use crate::tubes::MIN_EDGE;

/// A point that the curve goes through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Station {
    pub(crate) position: Vec3,
    /// Unit direction of the curve.
    tangent: Vec3,
    pub(crate) radius: f32,
    /// Change of the radius along the curve.
    slope: f32,
    /// Distance from the start along the chords, in metres.
    pub(crate) s: f32,
    /// The node whose internode ends here.
    pub(crate) node: NodeId,
}

/// A point of the curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) s: f32,
    pub(crate) position: Vec3,
    /// Unit direction of the curve.
    pub(crate) tangent: Vec3,
    pub(crate) radius: f32,
    /// Change of the radius along the curve.
    pub(crate) slope: f32,
    /// The node of the internode.
    pub(crate) node: NodeId,
}

impl Sample {
    /// About how far the curve turns on the way to a later point, in radians: to the chord, and on
    /// from it. Where it bends to and fro, the directions at both ends alone do not tell.
    pub(crate) fn turn(&self, to: &Self) -> f32 {
        let chord = (to.position - self.position).try_normalize().unwrap_or(self.tangent);
        self.tangent.distance(chord) + chord.distance(to.tangent)
    }
}

/// The trunk's foot: the radius is multiplied by `1 + amount · exp(−s / length)`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Flare {
    pub(crate) amount: f32,
    pub(crate) length: f32,
}

/// A cubic Hermite curve through stations: the direction at a station halves the bend there.
#[derive(Debug, Default)]
pub(crate) struct Axis {
    pub(crate) stations: Vec<Station>,
    flare: Option<Flare>,
}

impl Axis {
    /// Starts anew with one station.
    pub(crate) fn restart(&mut self, position: Vec3, radius: f32, node: NodeId) {
        self.stations.clear();
        self.flare = None;
        self.stations.push(Station {
            position,
            tangent: Vec3::Y,
            radius,
            slope: 0.0,
            s: 0.0,
            node,
        });
    }

    /// Adds a station, unless it is within `spacing` or [`MIN_EDGE`] of the last or not finite.
    pub(crate) fn push(&mut self, position: Vec3, radius: f32, node: NodeId, spacing: f32) -> bool {
        let last = self.stations[self.stations.len() - 1];
        let step = last.position.distance(position);
        if !(step > spacing.max(MIN_EDGE) && step < f32::INFINITY) {
            return false;
        }
        let s = last.s + step;
        self.stations.push(Station { position, radius, node, s, ..last });
        true
    }

    /// Makes this the last station, in place of one that stands too close before it.
    pub(crate) fn end_at(&mut self, position: Vec3, radius: f32, node: NodeId) {
        if self.stations.len() > 2
            && let Some(close) = self.stations.pop()
            && !self.push(position, radius, node, 0.0)
        {
            self.stations.push(close);
        }
    }

    /// The length over which the foot flares, if it does.
    pub(crate) fn flare_length(&self) -> Option<f32> {
        self.flare.filter(|flare| flare.amount > 0.0).map(|flare| flare.length)
    }

    /// Length along the chords.
    pub(crate) fn len(&self) -> f32 {
        self.stations[self.stations.len() - 1].s
    }

    /// Goes on straight at the end, or in `direction` if there is no end yet, until the length
    /// is `length`.
    pub(crate) fn lengthen(&mut self, length: f32, direction: Vec3) {
        let by = length - self.len();
        if by <= 0.0 {
            return;
        }
        let tip = self.stations[self.stations.len() - 1];
        let along = match self.stations.len() {
            1 => direction,
            n => (tip.position - self.stations[n - 2].position).normalize(),
        };
        let by = by.max(2.0 * MIN_EDGE);
        self.stations.push(Station { position: tip.position + along * by, s: tip.s + by, ..tip });
    }

    /// Makes the tip as thin as `share` of what it is.
    pub(crate) fn taper(&mut self, share: f32) {
        if let Some(tip) = self.stations.last_mut() {
            tip.radius *= share;
        }
    }

    /// Computes directions and slopes once all stations stand; the curve starts in `direction`.
    pub(crate) fn finish(&mut self, direction: Option<Vec3>, flare: Option<Flare>) {
        self.flare = flare;
        let n = self.stations.len();
        let (mut before, mut slope) = (Vec3::ZERO, 0.0);
        for i in 0..n {
            let (after, next) = if i + 1 < n {
                let (a, b) = (&self.stations[i], &self.stations[i + 1]);
                let length = b.s - a.s;
                ((b.position - a.position) / length, (b.radius - a.radius) / length)
            } else {
                (before, slope)
            };
            if i == 0 {
                (before, slope) = (direction.unwrap_or(after), next);
            }
            let sum = before + after;
            let along = if i == 0 { before } else { sum };
            let station = &mut self.stations[i];
            // Straight back: any direction square to it.
            let back = || after.any_orthonormal_vector();
            station.tangent =
                if along.length_squared() > 1e-6 { along.normalize() } else { back() };
            station.slope = 0.5 * (slope + next);
            (before, slope) = (after, next);
        }
    }

    /// The point at `s`, which is held within the curve.
    pub(crate) fn at(&self, s: f32) -> Sample {
        let last = self.stations.len() - 1;
        let s = s.clamp(0.0, self.stations[last].s);
        let k = self.stations[1..last].partition_point(|station| station.s < s);
        let (a, b) = (&self.stations[k], &self.stations[k + 1]);
        let length = b.s - a.s;
        let t = (s - a.s) / length;
        let (t2, u) = (t * t, 1.0 - t);
        // The Hermite basis and its derivative.
        let rise = t2 * (3.0 - 2.0 * t);
        let (from, to) = (length * t * u * u, length * t2 * u);
        let position =
            a.position + (b.position - a.position) * rise + a.tangent * from - b.tangent * to;
        let speed = (b.position - a.position) * (6.0 * t * u / length)
            + a.tangent * (u * (1.0 - 3.0 * t))
            + b.tangent * (t * (3.0 * t - 2.0));
        let squared = speed.length_squared();
        let tangent = if squared > 1e-6 {
            speed / libm::sqrtf(squared)
        } else {
            (b.position - a.position) / length
        };
        let mut radius = a.radius + (b.radius - a.radius) * t;
        let mut slope = a.slope + (b.slope - a.slope) * t;
        if let Some(Flare { amount, length }) = self.flare {
            let more = amount * libm::expf(-s / length);
            slope += more * (slope - radius / length);
            radius *= 1.0 + more;
        }
        Sample { s, position, tangent, radius, slope, node: b.node }
    }

    /// The point of the curve next to `p`, looked for from `s` on.
    pub(crate) fn nearest(&self, p: Vec3, s: f32) -> Sample {
        let mut sample = self.at(s);
        for _ in 0..3 {
            let step = (p - sample.position).dot(sample.tangent);
            sample = self.at(sample.s + step);
        }
        sample
    }
}
