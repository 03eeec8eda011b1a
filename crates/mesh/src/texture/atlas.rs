//! Where the cards of a species lie in their texture.

use super::frond::{Drawing, Frond};
use super::noise::Noise;

/// A rectangle of texture coordinates: left, lower, right, upper.
pub(crate) type Rect = [f32; 4];

/// The strip of twig bark along the right edge of the texture.
pub(crate) const TWIG: Rect = [0.965, 0.0, 1.0, 1.0];

/// Width of the part that cards lie in.
const ROOM: f32 = 0.95;

/// One card: its drawing, and where its foot lies and how large it is in the texture.
#[derive(Debug)]
pub(crate) struct Card {
    pub(crate) drawing: Drawing,
    /// The foot, in units of the texture.
    pub(crate) foot: [f32; 2],
    /// The length of the card, in units of the texture.
    pub(crate) length: f32,
    /// Half of the width of the card over its length.
    pub(crate) half_width: f32,
}

impl Card {
    /// The smallest upright rectangle around it.
    pub(crate) fn rect(&self) -> Rect {
        let [x, y] = self.foot;
        let half = self.half_width * self.length;
        [x - half, y, x + half, y + self.length]
    }
}

/// The variants of a frond side by side: two, and above these two more where they are broad.
pub(crate) fn cards(frond: Frond, noise: Noise) -> Vec<Card> {
    let rows = match frond {
        Frond::Leaf { .. } => 2,
        Frond::Pinnate { .. } | Frond::Twig(_) | Frond::Needles { .. } => 1,
    };
    let (wide, tall) = (ROOM / 2.0, 1.0 / rows as f32);
    (0..2 * rows)
        .map(|number| {
            let drawing = frond.draw(noise.other(number));
            let half_width = drawing.half_width() + 0.01;
            // A margin keeps neighbours from bleeding into one another.
            let length = (0.96 * tall).min(0.47 * wide / half_width);
            let (column, row) = ((number % 2) as f32, (number / 2) as f32);
            let foot = [(column + 0.5) * wide, row * tall + (tall - length) / 2.0];
            Card { drawing, foot, length, half_width }
        })
        .collect()
}
