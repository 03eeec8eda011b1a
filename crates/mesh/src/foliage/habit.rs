//! How each species bears its leaves, and what they and its bark look like.
//!
//! # Sources
//!
//! Phyllotaxis, leaf sizes and shapes, autumn colours and bark as floras describe them: Stace, "New
//! Flora of the British Isles" (4th ed., 2019) for Fagus sylvatica, Quercus robur, Acer platanoides,
//! Juglans regia, Salix and Pinus sylvestris; "Flora of North America" vol. 3 (1997) for
//! Liriodendron tulipifera. Reflectance of leaves: Jacquemoud and Baret 1990, "PROSPECT" (a green
//! leaf reflects and transmits each about a tenth of the green light and a twentieth of the red).

use crate::look::Season;
use crate::texture::bark::{Bark, Relief};
use crate::texture::canvas::Rgb;
use crate::texture::frond::{Frond, Spray};
use crate::texture::outline::Form;

/// How leaves, and the shoots from their axils, stand around the axis that bears them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phyllotaxis {
    /// One at a node, each turned by the golden angle against the one before.
    Spiral,
    /// One at a node, in two opposite rows.
    Distichous,
    /// Two opposite ones at a node, square to the pair before.
    Decussate,
    /// Several at a node, in the gaps of those before.
    Whorled(u32),
}

impl Phyllotaxis {
    /// How many stand at one node.
    #[must_use]
    pub const fn at_a_node(self) -> u32 {
        match self {
            Self::Spiral | Self::Distichous => 1,
            Self::Decussate => 2,
            Self::Whorled(many) => many,
        }
    }

    /// The angle around the axis of the one with this number, in radians; the first has 0.
    ///
    /// Divergence from node to node is 137.5° (spiral), 180° (distichous) or half of the angle
    /// between neighbours at a node: 90° (decussate).
    #[must_use]
    pub fn angle(self, number: u32) -> f32 {
        use core::f32::consts::{PI, TAU};
        // 360° (1 − 1/φ), the golden angle.
        const GOLDEN: f32 = 2.399_963_2;
        match self {
            Self::Spiral => number as f32 * GOLDEN,
            Self::Distichous => number as f32 * PI,
            Self::Decussate | Self::Whorled(_) => {
                let many = self.at_a_node().max(1);
                let between = TAU / many as f32;
                (number % many) as f32 * between + (number / many) as f32 * between / 2.0
            }
        }
    }
}

/// How the cards of a shoot stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cards {
    /// One a leaf, along the shoot: how many, the length of each in metres, and their angle to the
    /// shoot in radians.
    Along { leaves: u32, length: f32, angle: f32 },
    /// So many that show the whole shoot, evenly around it.
    Around(u32),
}

/// Colours of leaves in one season.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tints {
    pub(crate) blade: Rgb,
    pub(crate) mottle: Rgb,
    pub(crate) vein: Rgb,
}

/// What is left of a shoot in winter: side twigs on it, and how it grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bare {
    /// Side twigs of one shoot.
    pub(crate) sides: u32,
    /// Length of the longest as a share of the shoot's.
    pub(crate) length: f32,
    /// Their angle to the shoot in radians.
    pub(crate) angle: f32,
    /// How far it winds to the sides, as a share of its length.
    pub(crate) wind: f32,
    /// Thickness as a multiple of the leafy shoot's.
    pub(crate) thickness: f32,
}

/// How a species bears its leaves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Habit {
    pub(crate) species: &'static str,
    pub(crate) phyllotaxis: Phyllotaxis,
    /// How many internodes from the tips bear shoots.
    pub(crate) depth: u16,
    /// Shoots a metre of these.
    pub(crate) shoots: f32,
    /// Length of the twigs of shoots in metres.
    pub(crate) length: f32,
    /// Their angle to the branch in radians.
    pub(crate) angle: f32,
    /// How much they turn upwards to the light, 0 to 1; below 0 they hang.
    pub(crate) light: f32,
    /// How flat shoots spread their leaves: 0 in one plane, 1 all around.
    pub(crate) round: f32,
    pub(crate) cards: Cards,
    pub(crate) frond: Frond,
    pub(crate) evergreen: bool,
    pub(crate) bare: Bare,
    pub(crate) spring: Tints,
    pub(crate) summer: Tints,
    /// What leaves turn to in autumn, one for each part of the crown.
    pub(crate) autumn: [Rgb; 2],
    pub(crate) twig: Rgb,
    pub(crate) leaf_roughness: f32,
    pub(crate) bark: Bark,
}

/// A colour given as bytes of sRGB, made linear.
fn srgb(hex: u32) -> Rgb {
    [16, 8, 0].map(|shift| {
        let x = (hex >> shift & 255) as f32 / 255.0;
        if x <= 0.04045 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
    })
}

fn tints(blade: u32, mottle: u32, vein: u32) -> Tints {
    Tints { blade: srgb(blade), mottle: srgb(mottle), vein: srgb(vein) }
}

/// The habit of a species by its name; of a blend, such as `oak:0.7,willow:0.3`, that of its
/// greatest share; of an unknown species, that of the beech.
pub(crate) fn habit(species: &str) -> Habit {
    let share = |part: &str| {
        let (name, share) = part.split_once(':').unwrap_or((part, "1"));
        (name.trim().to_lowercase(), share.trim().parse::<f32>().unwrap_or(0.0))
    };
    // The first of equal shares.
    let name = species
        .split(',')
        .map(share)
        .reduce(|best, next| if next.1 > best.1 { next } else { best })
        .map_or(String::new(), |(name, _)| name);
    match name.as_str() {
        "corkscrew" => corkscrew(),
        "maple" => maple(),
        "oak" => oak(),
        "pine" => pine(),
        "tulip" => tulip(),
        "walnut" => walnut(),
        "willow" => willow(),
        _ => beech(),
    }
}

/// Fagus sylvatica: distichous, ovate, wavy; smooth grey bark.
fn beech() -> Habit {
    Habit {
        species: "beech",
        phyllotaxis: Phyllotaxis::Distichous,
        depth: 3,
        shoots: 6.5,
        length: 0.60,
        angle: 0.85,
        light: 0.12,
        round: 0.0,
        cards: Cards::Along { leaves: 3, length: 0.42, angle: 0.75 },
        frond: Frond::Twig(Spray {
            form: Form::Beech,
            leaves: 9,
            length: 0.24,
            angle: 0.85,
            twist: 0.0,
            crowd: 0.0,
        }),
        evergreen: false,
        bare: Bare { sides: 6, length: 0.3, angle: 0.8, wind: 0.015, thickness: 0.8 },
        spring: tints(0x9cc04a, 0x86b23e, 0xbcd07a),
        summer: tints(0x64923a, 0x527f31, 0x9db268),
        autumn: [srgb(0xc4761f), srgb(0xd9a12e)],
        twig: srgb(0x5a4a3c),
        leaf_roughness: 0.5,
        bark: Bark {
            relief: Relief::Smooth,
            plate: [0.25, 0.12],
            depth: 0.002,
            face: srgb(0x77766d),
            stain: srgb(0x61625a),
            fissure: srgb(0x47453e),
            roughness: 0.7,
        },
    }
}

/// Salix matsudana 'Tortuosa': twisted twigs, lanceolate and curled leaves.
fn corkscrew() -> Habit {
    Habit {
        species: "corkscrew",
        cards: Cards::Around(3),
        length: 0.75,
        light: 0.15,
        angle: 0.7,
        shoots: 7.0,
        depth: 3,
        frond: Frond::Twig(Spray {
            form: Form::Lance,
            leaves: 15,
            length: 0.26,
            angle: 0.62,
            twist: 0.6,
            crowd: 0.0,
        }),
        bare: Bare { sides: 5, length: 0.4, angle: 0.7, wind: 0.07, thickness: 0.7 },
        summer: tints(0x7da04a, 0x69903f, 0xb0c27a),
        twig: srgb(0x7a6a35),
        bark: Bark {
            relief: Relief::Interlaced { gap: 0.45, cracks: 0.0 },
            depth: 0.012,
            ..willow().bark
        },
        ..willow()
    }
}

/// Acer platanoides: decussate, five pointed lobes; shallow plates of bark.
fn maple() -> Habit {
    Habit {
        species: "maple",
        phyllotaxis: Phyllotaxis::Decussate,
        depth: 3,
        shoots: 4.5,
        length: 0.50,
        angle: 0.75,
        light: 0.35,
        round: 0.35,
        cards: Cards::Along { leaves: 8, length: 0.20, angle: 1.0 },
        frond: Frond::Leaf { form: Form::Maple, petiole: 0.30 },
        evergreen: false,
        bare: Bare { sides: 4, length: 0.28, angle: 0.75, wind: 0.006, thickness: 1.0 },
        spring: tints(0xa3bf45, 0x93b03c, 0xc0a060),
        summer: tints(0x639438, 0x528331, 0xa3b66c),
        autumn: [srgb(0xe0a51c), srgb(0xd2561b)],
        twig: srgb(0x6a5040),
        leaf_roughness: 0.5,
        bark: Bark {
            relief: Relief::Ridges,
            plate: [0.035, 0.18],
            depth: 0.008,
            face: srgb(0x7b7165),
            stain: srgb(0x675f55),
            fissure: srgb(0x3b342d),
            roughness: 0.85,
        },
    }
}

/// Quercus robur: spiral and crowded towards the tip of the shoot, lobed; deep fissures.
fn oak() -> Habit {
    Habit {
        species: "oak",
        phyllotaxis: Phyllotaxis::Spiral,
        depth: 3,
        shoots: 3.6,
        length: 0.45,
        angle: 0.85,
        light: 0.3,
        round: 0.6,
        cards: Cards::Along { leaves: 4, length: 0.36, angle: 0.8 },
        frond: Frond::Twig(Spray {
            form: Form::Oak,
            leaves: 6,
            length: 0.40,
            angle: 0.95,
            twist: 0.0,
            crowd: 0.8,
        }),
        evergreen: false,
        bare: Bare { sides: 6, length: 0.32, angle: 0.95, wind: 0.025, thickness: 1.1 },
        spring: tints(0x9fb248, 0x94a33a, 0xc3c27c),
        summer: tints(0x608936, 0x4e762d, 0xa8b570),
        autumn: [srgb(0xa9691f), srgb(0xb98a2c)],
        twig: srgb(0x5e5142),
        leaf_roughness: 0.45,
        bark: Bark {
            relief: Relief::Interlaced { gap: 0.55, cracks: 0.5 },
            plate: [0.0278, 0.25],
            depth: 0.026,
            face: srgb(0x736a5e),
            stain: srgb(0x5a5147),
            fissure: srgb(0x17120e),
            roughness: 0.9,
        },
    }
}

/// Pinus sylvestris: needles in pairs all along the shoots, which stand in whorls; plates of bark.
fn pine() -> Habit {
    Habit {
        species: "pine",
        phyllotaxis: Phyllotaxis::Whorled(4),
        depth: 5,
        shoots: 11.0,
        length: 0.42,
        angle: 0.65,
        light: 0.35,
        round: 1.0,
        cards: Cards::Around(3),
        frond: Frond::Needles { fascicles: 120, length: 0.26 },
        evergreen: true,
        bare: Bare { sides: 0, length: 0.0, angle: 0.0, wind: 0.0, thickness: 1.0 },
        spring: tints(0x86a55e, 0x6f9253, 0x8d7a54),
        summer: tints(0x7a9858, 0x65884f, 0x8d7a54),
        autumn: [srgb(0x9a8a3c), srgb(0x8a7a38)],
        twig: srgb(0x8a6a42),
        leaf_roughness: 0.5,
        bark: Bark {
            relief: Relief::Plates,
            plate: [0.09, 0.16],
            depth: 0.018,
            face: srgb(0x8f6a50),
            stain: srgb(0x857a70),
            fissure: srgb(0x3a271d),
            roughness: 0.85,
        },
    }
}

/// Liriodendron tulipifera: spiral, four lobes, truncate; interlacing ridges.
fn tulip() -> Habit {
    Habit {
        species: "tulip",
        phyllotaxis: Phyllotaxis::Spiral,
        depth: 3,
        shoots: 3.6,
        length: 0.50,
        angle: 0.8,
        light: 0.3,
        round: 0.4,
        cards: Cards::Along { leaves: 7, length: 0.21, angle: 1.0 },
        frond: Frond::Leaf { form: Form::Tulip, petiole: 0.34 },
        evergreen: false,
        bare: Bare { sides: 3, length: 0.25, angle: 0.8, wind: 0.006, thickness: 1.1 },
        spring: tints(0xa8c552, 0x98b848, 0xc6d287),
        summer: tints(0x72a041, 0x608f38, 0xb0c374),
        autumn: [srgb(0xe2b62a), srgb(0xcf9a22)],
        twig: srgb(0x66503c),
        leaf_roughness: 0.45,
        bark: Bark {
            relief: Relief::Interlaced { gap: 0.46, cracks: 0.0 },
            plate: [0.042, 0.25],
            depth: 0.014,
            face: srgb(0x7c7468),
            stain: srgb(0x686154),
            fissure: srgb(0x2c251e),
            roughness: 0.85,
        },
    }
}

/// Juglans regia: spiral, pinnate; ridges around lozenges.
fn walnut() -> Habit {
    Habit {
        species: "walnut",
        phyllotaxis: Phyllotaxis::Spiral,
        depth: 3,
        shoots: 5.2,
        length: 0.45,
        angle: 0.75,
        light: 0.35,
        round: 0.5,
        cards: Cards::Along { leaves: 5, length: 0.36, angle: 0.95 },
        frond: Frond::Pinnate { form: Form::Leaflet, pairs: 3 },
        evergreen: false,
        bare: Bare { sides: 2, length: 0.25, angle: 0.75, wind: 0.006, thickness: 1.5 },
        spring: tints(0xa09a4a, 0xa8783f, 0xb9a36a),
        summer: tints(0x6f9a40, 0x5e8837, 0xb2c079),
        autumn: [srgb(0xc9a42e), srgb(0xa8842c)],
        twig: srgb(0x5b4c3d),
        leaf_roughness: 0.5,
        bark: Bark {
            relief: Relief::Interlaced { gap: 0.5, cracks: 0.0 },
            plate: [0.0625, 0.1667],
            depth: 0.020,
            face: srgb(0x7f786c),
            stain: srgb(0x685e52),
            fissure: srgb(0x211a14),
            roughness: 0.88,
        },
    }
}

/// Salix babylonica and alba: spiral on long hanging twigs, lanceolate; crossing fissures.
fn willow() -> Habit {
    Habit {
        species: "willow",
        phyllotaxis: Phyllotaxis::Spiral,
        depth: 4,
        shoots: 5.5,
        length: 0.70,
        angle: 0.5,
        light: -0.9,
        round: 0.5,
        cards: Cards::Around(2),
        frond: Frond::Twig(Spray {
            form: Form::Lance,
            leaves: 17,
            length: 0.24,
            angle: 0.62,
            twist: 0.0,
            crowd: 0.0,
        }),
        evergreen: false,
        bare: Bare { sides: 5, length: 0.35, angle: 0.4, wind: 0.01, thickness: 0.6 },
        spring: tints(0xacc25a, 0x9db54e, 0xcfd491),
        summer: tints(0x88a955, 0x749849, 0xbbca89),
        autumn: [srgb(0xd0b93c), srgb(0xbda638)],
        twig: srgb(0x857438),
        leaf_roughness: 0.5,
        bark: Bark {
            relief: Relief::Interlaced { gap: 0.6, cracks: 0.1 },
            plate: [0.05, 0.1667],
            depth: 0.022,
            face: srgb(0x6f6353),
            stain: srgb(0x584d40),
            fissure: srgb(0x1d1610),
            roughness: 0.88,
        },
    }
}

impl Habit {
    /// Length of shoots with the leaf at their end, in metres.
    pub(crate) fn whole_length(&self) -> f32 {
        match self.cards {
            Cards::Along { length, .. } => self.length + 0.85 * length,
            Cards::Around(_) => self.length,
        }
    }

    /// The share of leaves that hang on the tree in a season.
    pub(crate) const fn hanging(&self, season: Season) -> f32 {
        match season {
            _ if self.evergreen => 1.0,
            Season::Spring => 0.8,
            Season::Summer => 1.0,
            Season::Autumn => 0.75,
            Season::Winter => 0.0,
        }
    }

    /// The size of leaves as a share of what they are in summer.
    pub(crate) const fn unfolded(&self, season: Season) -> f32 {
        match season {
            Season::Spring if !self.evergreen => 0.7,
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::look::SPECIES;

    #[test]
    fn species_and_the_greatest_share_of_a_blend_have_their_own_habit() {
        for species in SPECIES {
            assert_eq!(habit(species).species, species);
            assert_eq!(habit(&format!("beech:0.3,{species}:0.7")).species, species);
        }
        assert_eq!(habit("oak:0.5,willow:0.5").species, "oak");
        assert_eq!(["", "fern", "oak:x", ",:"].map(|name| habit(name).species)[0], "beech");
    }

    #[test]
    fn the_golden_angle_parts_a_turn_by_the_golden_ratio() {
        let turn = core::f64::consts::TAU;
        let golden = f64::from(Phyllotaxis::Spiral.angle(1));
        let ratio = (turn - golden) / golden;
        // The ratio of the greater part to the smaller is that of the turn to the greater part.
        assert!((ratio - turn / (turn - golden)).abs() < 1e-6);
    }
}
