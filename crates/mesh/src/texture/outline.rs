//! Outlines of leaf blades: closed curves of a length of 1 from base to apex along y.

use super::noise::Noise;

/// A point of half an outline: how far out, how far up, and whether the margin has a corner there.
type Knot = (f32, f32, bool);

/// The form of a leaf blade.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Obovate with four or five rounded lobes a side, as of Quercus robur.
    Oak,
    /// Five pointed lobes with few large teeth, as of Acer platanoides.
    Maple,
    /// Four lobes and a truncate apex, as of Liriodendron tulipifera.
    Tulip,
    /// Ovate with a wavy margin, as of Fagus sylvatica.
    Beech,
    /// An elliptic leaflet with a smooth margin, as of Juglans regia.
    Leaflet,
    /// Narrow and drawn out to its tip, as of Salix.
    Lance,
}

const OAK: &[Knot] = &[
    (0.0, 0.0, false),
    (0.07, 0.0, false),
    (0.06, 0.08, false),
    (0.15, 0.13, false),
    (0.17, 0.20, false),
    (0.09, 0.235, false),
    (0.10, 0.27, false),
    (0.22, 0.33, false),
    (0.25, 0.41, false),
    (0.13, 0.455, false),
    (0.135, 0.495, false),
    (0.28, 0.55, false),
    (0.32, 0.64, false),
    (0.18, 0.69, false),
    (0.18, 0.725, false),
    (0.27, 0.79, false),
    (0.26, 0.86, false),
    (0.15, 0.865, false),
    (0.14, 0.94, false),
    (0.08, 0.99, false),
    (0.0, 1.0, false),
];

const MAPLE: &[Knot] = &[
    (0.0, 0.13, true),
    (0.06, 0.05, false),
    (0.20, 0.0, false),
    (0.30, 0.03, true),
    (0.44, 0.0, true),
    (0.38, 0.10, false),
    (0.47, 0.17, true),
    (0.36, 0.22, false),
    (0.32, 0.27, false),
    (0.44, 0.33, true),
    (0.48, 0.42, false),
    (0.62, 0.54, true),
    (0.49, 0.55, false),
    (0.46, 0.66, true),
    (0.37, 0.58, false),
    (0.22, 0.53, false),
    (0.15, 0.55, false),
    (0.19, 0.66, false),
    (0.30, 0.77, true),
    (0.18, 0.79, false),
    (0.14, 0.90, true),
    (0.07, 0.89, false),
    (0.0, 1.0, true),
];

const TULIP: &[Knot] = &[
    (0.0, 0.05, false),
    (0.12, 0.0, false),
    (0.30, 0.05, false),
    (0.42, 0.16, false),
    (0.53, 0.31, true),
    (0.42, 0.42, false),
    (0.345, 0.53, false),
    (0.37, 0.66, false),
    (0.45, 0.80, false),
    (0.46, 0.97, true),
    (0.28, 0.95, false),
    (0.10, 0.90, false),
    (0.0, 0.875, true),
];

const BEECH: &[Knot] = &[
    (0.0, 0.0, false),
    (0.10, 0.03, false),
    (0.22, 0.14, false),
    (0.25, 0.19, false),
    (0.285, 0.26, false),
    (0.295, 0.31, false),
    (0.32, 0.38, false),
    (0.315, 0.43, false),
    (0.325, 0.50, false),
    (0.305, 0.55, false),
    (0.30, 0.62, false),
    (0.265, 0.67, false),
    (0.245, 0.73, false),
    (0.20, 0.78, false),
    (0.165, 0.84, false),
    (0.10, 0.91, false),
    (0.03, 0.97, false),
    (0.0, 1.0, true),
];

const LEAFLET: &[Knot] = &[
    (0.0, 0.0, false),
    (0.10, 0.04, false),
    (0.185, 0.18, false),
    (0.225, 0.36, false),
    (0.225, 0.54, false),
    (0.18, 0.74, false),
    (0.09, 0.90, false),
    (0.02, 0.98, false),
    (0.0, 1.0, true),
];

const LANCE: &[Knot] = &[
    (0.0, 0.0, false),
    (0.035, 0.04, false),
    (0.066, 0.16, false),
    (0.078, 0.32, false),
    (0.073, 0.50, false),
    (0.054, 0.70, false),
    (0.026, 0.88, false),
    (0.006, 0.98, false),
    (0.0, 1.0, true),
];

impl Form {
    const fn knots(self) -> &'static [Knot] {
        match self {
            Self::Oak => OAK,
            Self::Maple => MAPLE,
            Self::Tulip => TULIP,
            Self::Beech => BEECH,
            Self::Leaflet => LEAFLET,
            Self::Lance => LANCE,
        }
    }

    /// The outline, counter-clockwise from the base, its two halves and each leaf a little
    /// different.
    pub(crate) fn outline(self, noise: Noise) -> Vec<[f32; 2]> {
        let knots = self.knots();
        let half = |side: u32| -> Vec<Knot> {
            let noise = noise.other(side);
            let wide = 1.0 + 0.08 * (noise.at(0, 0) - 0.5);
            let moved = |(k, &(x, y, corner)): (usize, &Knot)| {
                if k == 0 || k + 1 == knots.len() {
                    return (x, y, corner);
                }
                let by = |axis| 0.022 * (noise.at(k as i32, axis) - 0.5);
                // What is narrow moves little.
                let free = (x * 8.0).min(1.0);
                (x * wide + free * by(1), y + free * by(2), corner)
            };
            knots.iter().enumerate().map(moved).collect()
        };
        let mut outline = curve(&half(1));
        let left = curve(&half(2));
        // Both halves share base and apex.
        outline.extend(left.iter().rev().skip(1).map(|&[x, y]| [-x, y]));
        outline.pop();
        outline
    }

    /// Where the veins start that lead to the lobes, for forms whose lobes come from one point.
    pub(crate) const fn palm(self) -> Option<&'static [[f32; 2]]> {
        match self {
            Self::Maple => {
                Some(&[[0.0, 1.0], [0.62, 0.54], [-0.62, 0.54], [0.44, 0.0], [-0.44, 0.0]])
            }
            _ => None,
        }
    }

    /// Where the midrib starts.
    pub(crate) const fn base(self) -> [f32; 2] {
        [0.0, self.knots()[0].1]
    }
}

/// Points of a smooth curve through knots: Catmull and Rom's, with no tangent at corners.
fn curve(knots: &[Knot]) -> Vec<[f32; 2]> {
    const PIECES: u32 = 6;
    let tangent = |k: usize| {
        if knots[k].2 {
            return [0.0; 2];
        }
        let (a, b) = (knots[k.saturating_sub(1)], knots[(k + 1).min(knots.len() - 1)]);
        [0.5 * (b.0 - a.0), 0.5 * (b.1 - a.1)]
    };
    let mut points = vec![[knots[0].0, knots[0].1]];
    for k in 1..knots.len() {
        let ((a, b), (m, n)) = ((knots[k - 1], knots[k]), (tangent(k - 1), tangent(k)));
        for piece in 1..=PIECES {
            let t = piece as f32 / PIECES as f32;
            let (t2, t3) = (t * t, t * t * t);
            let at = |p: f32, q: f32, m: f32, n: f32| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * p
                    + (t3 - 2.0 * t2 + t) * m
                    + (3.0 * t2 - 2.0 * t3) * q
                    + (t3 - t2) * n
            };
            points.push([at(a.0, b.0, m[0], n[0]), at(a.1, b.1, m[1], n[1])]);
        }
    }
    points
}

/// The area within a closed polygon, positive if it runs counter-clockwise.
#[cfg(test)]
pub(crate) fn area(outline: &[[f32; 2]]) -> f32 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f32>() / 2.0
}

/// Whether a point lies within a closed polygon.
pub(crate) fn within(outline: &[[f32; 2]], p: [f32; 2]) -> bool {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).fold(false, |inside, (a, b)| {
        let crosses = (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]);
        inside != crosses
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Form; 6] =
        [Form::Oak, Form::Maple, Form::Tulip, Form::Beech, Form::Leaflet, Form::Lance];

    #[test]
    fn blades_have_the_length_one_and_contain_their_midrib() {
        for form in ALL {
            let outline = form.outline(Noise::new(3, 0));
            assert!(area(&outline) > 0.0, "{form:?} runs the wrong way");
            let top = outline.iter().map(|p| p[1]).fold(0.0, f32::max);
            assert!((0.9..1.02).contains(&top), "{form:?} {top}");
            for k in 1..8 {
                let y = form.base()[1] + 0.1 * k as f32 * (0.98 - form.base()[1]);
                assert!(within(&outline, [0.0, y]), "{form:?} {y}");
            }
        }
    }

    #[test]
    fn shapes_fill_their_rectangles_as_leaves_do() {
        // Leaf area over length times width is 0.5 to 0.8 for simple leaves (Montgomery 1911 and
        // later tables), less for lobed ones.
        for (form, low, high) in [
            (Form::Beech, 0.6, 0.75),
            (Form::Leaflet, 0.6, 0.78),
            (Form::Lance, 0.55, 0.75),
            (Form::Oak, 0.45, 0.7),
            (Form::Maple, 0.3, 0.55),
            (Form::Tulip, 0.55, 0.8),
        ] {
            let outline = form.outline(Noise::new(1, 0));
            let wide = outline.iter().map(|p| p[0]);
            let (low_x, high_x) = wide.fold((0.0f32, 0.0f32), |(a, b), x| (a.min(x), b.max(x)));
            let share = area(&outline) / (high_x - low_x);
            assert!((low..high).contains(&share), "{form:?} {share}");
        }
    }
}
