//! Cards that stand in for a tree from afar.

use std::f32::consts::PI;

use deeptree_graph::Seed;
use deeptree_mesh::{Blade, Dressed, Foliage, Image, Internode, Leaf, Material, Mesh};
use glam::{Quat, Vec3};

use crate::aov::{Kind, Mark, marks};
use crate::bark::plain_bark;
use crate::camera::Camera;
use crate::error::RenderError;
use crate::film::{MAX_SIZE, Options, Picture, render};
use crate::ground::Ground;
use crate::light::Light;
use crate::scene::{Scene, points};
use crate::tone::srgb_byte;

/// Rounds in which colours spread into what is transparent, so that coarser levels of the texture
/// get no dark fringe.
const BLEED: u32 = 16;
/// Rays a pixel and axis for normals.
const NORMALS: u32 = 3;

/// Cards that cross each other in the axis of the root, and their pictures side by side.
///
/// The light is the same from everywhere: what is left of it is the surface's own colour, darker
/// where the crown is dense. So an engine can light the cards itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Impostor {
    /// The cards, in the order of the pictures.
    pub cards: Vec<Card>,
    /// Colour in sRGB with alpha, straight.
    pub color: Image,
    /// Normals in each card's frame: red right, green up, blue towards who looks.
    pub normal: Image,
}

/// A rectangle that shows the tree from one side; from behind it is seen mirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Card {
    /// Lower left, lower right, upper right and upper left corner in metres, seen from the front.
    pub corners: [Vec3; 4],
    /// Unit normal of the front.
    pub normal: Vec3,
    /// Left, lower, right and upper edge in the pictures; v = 1 is the upper edge.
    pub uv: [f32; 4],
}

/// Paints `count` cards of a tree, evenly turned, each `height` pixels high, with `samples` light
/// paths a pixel. All have the same size: that of the tree and its widest side.
///
/// # Errors
///
/// When the tree has no surface, or a picture would have no pixel or too many.
pub fn impostor(
    tree: &Dressed,
    count: u32,
    height: u32,
    samples: u32,
    seed: Seed,
) -> Result<Impostor, RenderError> {
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    let azimuths: Vec<f32> = (0..count).map(|i| PI * i as f32 / count as f32).collect();
    let rights: Vec<Vec3> = azimuths
        .iter()
        .map(|&a| Camera::orthographic(Vec3::ZERO, a, 0.0, [1.0; 2]).axes()[0])
        .collect();
    let mut half = 0.0f32;
    for p in points(tree) {
        (low, high) = (low.min(p.y), high.max(p.y));
        half = rights.iter().map(|right| right.dot(p).abs()).fold(half, f32::max);
    }
    if low > high {
        return Err(RenderError::Empty);
    }
    // A pixel of air around, so that edges are transparent.
    let tall = (high - low).max(1e-3) * height as f32 / height.saturating_sub(2).max(1) as f32;
    let pixel = tall / height.max(1) as f32;
    let width = (2.0 * half / pixel).ceil() as u32 + 2;
    if count == 0 || width.saturating_mul(count) > MAX_SIZE {
        return Err(RenderError::Size { width: width.saturating_mul(count), height });
    }
    let middle = Vec3::Y * ((low + high) / 2.0);
    let size = [width as f32 * pixel, tall];
    let scene = Scene::new(tree, Light::uniform(), Ground::None)?;
    let options =
        Options { size: [width, height], samples, surroundings: false, seed, ..Options::default() };

    let mut atlas = Atlas::new(count, options.size);
    let mut cards = Vec::new();
    for (i, &azimuth) in (0u32..).zip(&azimuths) {
        let camera = Camera::orthographic(middle, azimuth, 0.0, size);
        let picture = render(&scene, &camera, &options, |_| ())?;
        let fine = Options { size: options.size.map(|side| side * NORMALS), ..options };
        atlas.paint(i, &picture, &marks(&scene, &camera, &fine)?, &camera);
        let [right, up, forward] = camera.axes();
        let (x, y) = (right * size[0] / 2.0, up * size[1] / 2.0);
        let edge = |k: u32| k as f32 / count as f32;
        cards.push(Card {
            corners: [middle - x - y, middle + x - y, middle + x + y, middle - x + y],
            normal: -forward,
            uv: [edge(i), 0.0, edge(i + 1), 1.0],
        });
    }
    let (color, normal) = atlas.images();
    Ok(Impostor { cards, color, normal })
}

impl Impostor {
    /// The cards as the leaves of a tree without wood, for files and scenes; they stand on the root,
    /// the first of `internodes`.
    ///
    /// Cards are looked at when they are small: the cutoff of alpha is such that at a quarter of the
    /// picture's size they cover what the tree covers, however thin its twigs, in programs that
    /// take two thirds of it as files do.
    #[must_use]
    pub fn into_dressed(self, species: &str, internodes: Vec<Internode>) -> Dressed {
        let mut blade = Blade::default();
        for card in &self.cards {
            let [left, low, right, high] = card.uv;
            let first = blade.positions.len() as u32;
            blade.positions.extend(card.corners);
            blade.normals.extend([card.normal; 4]);
            blade.uvs.extend([[left, low], [right, low], [right, high], [left, high]]);
            blade.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        }
        let material = Material {
            name: format!("{species} impostor"),
            color: [1.0; 4],
            alpha_cutoff: Some(1.5 * equal_cover(&self.color, SEEN)),
            color_image: Some(self.color.into()),
            normal_image: Some(self.normal.into()),
            roughness: 0.8,
            roughness_image: None,
            translucency: 0.0,
            double_sided: true,
        };
        let leaf = Leaf { position: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0, node: 0 };
        let foliage = Foliage { blade, leaves: vec![leaf], material, woody: false };
        let wood = Mesh { internodes, ..Mesh::default() };
        Dressed { wood, bark: plain_bark(), foliage: vec![foliage] }
    }
}

/// How many times smaller cards are looked at.
const SEEN: usize = 4;

/// The alpha that as large a part of a picture has, made `smaller` times smaller, as its alpha is on
/// average.
fn equal_cover(image: &Image, smaller: usize) -> f32 {
    let (width, height) = (image.width as usize / smaller, image.height as usize / smaller);
    let alpha = |x: usize, y: usize| {
        let block = (0..smaller * smaller).map(|i| {
            let (column, row) = (x * smaller + i % smaller, y * smaller + i / smaller);
            f32::from(image.pixels[(row * image.width as usize + column) * 4 + 3])
        });
        block.sum::<f32>() / (255 * smaller * smaller) as f32
    };
    let mut all: Vec<f32> =
        (0..width * height).map(|i| alpha(i % width, i / width)).filter(|&a| a > 0.0).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    let covered = all.iter().sum::<f32>() as usize;
    all.get(covered).map_or(0.5, |&cutoff| cutoff.clamp(0.02, 0.6))
}

/// The pictures of all cards, side by side.
struct Atlas {
    cell: [u32; 2],
    width: u32,
    color: Vec<Vec3>,
    alpha: Vec<f32>,
    normal: Vec<Vec3>,
}

impl Atlas {
    fn new(count: u32, cell: [u32; 2]) -> Self {
        let width = cell[0] * count;
        let pixels = width as usize * cell[1] as usize;
        Self {
            cell,
            width,
            color: vec![Vec3::ZERO; pixels],
            alpha: vec![0.0; pixels],
            normal: vec![Vec3::ZERO; pixels],
        }
    }

    fn paint(&mut self, card: u32, picture: &Picture, marks: &[Mark], camera: &Camera) {
        let [width, height] = self.cell;
        let [right, up, forward] = camera.axes();
        for y in 0..height {
            for x in 0..width {
                let at = (y * self.width + card * width + x) as usize;
                let [r, g, b, alpha] = picture.pixels[(y * width + x) as usize];
                self.alpha[at] = alpha;
                if alpha > 0.0 {
                    self.color[at] = Vec3::new(r, g, b) / alpha;
                }
                let mut sum = Vec3::ZERO;
                for i in 0..NORMALS * NORMALS {
                    let (dx, dy) = (i % NORMALS, i / NORMALS);
                    let row = (y * NORMALS + dy) * width * NORMALS;
                    let mark = &marks[(row + x * NORMALS + dx) as usize];
                    if mark.kind != Kind::Nothing {
                        sum += Vec3::from(mark.normal);
                    }
                }
                self.normal[at] = Vec3::new(right.dot(sum), up.dot(sum), -forward.dot(sum));
            }
        }
        self.bleed(card);
    }

    /// Lets colours and normals spread into transparent neighbours.
    fn bleed(&mut self, card: u32) {
        let [width, height] = self.cell;
        let at = |x: u32, y: u32| (y * self.width + card * width + x) as usize;
        let mut known: Vec<bool> = self.alpha.iter().map(|&alpha| alpha > 0.0).collect();
        for _ in 0..BLEED {
            let before = known.clone();
            for y in 0..height {
                for x in 0..width {
                    if before[at(x, y)] {
                        continue;
                    }
                    let around = [
                        (x > 0).then(|| at(x - 1, y)),
                        (x + 1 < width).then(|| at(x + 1, y)),
                        (y > 0).then(|| at(x, y - 1)),
                        (y + 1 < height).then(|| at(x, y + 1)),
                    ];
                    let around: Vec<usize> =
                        around.into_iter().flatten().filter(|&i| before[i]).collect();
                    if !around.is_empty() {
                        let sum = |of: &[Vec3]| around.iter().map(|&i| of[i]).sum::<Vec3>();
                        let (color, normal) = (sum(&self.color), sum(&self.normal));
                        self.color[at(x, y)] = color / around.len() as f32;
                        self.normal[at(x, y)] = normal;
                        known[at(x, y)] = true;
                    }
                }
            }
        }
    }

    fn images(self) -> (Image, Image) {
        let (width, height) = (self.width, self.cell[1]);
        let colored = self.color.iter().zip(&self.alpha).flat_map(|(color, alpha)| {
            let [r, g, b] = color.to_array().map(srgb_byte);
            [r, g, b, (alpha.clamp(0.0, 1.0) * 255.0 + 0.5) as u8]
        });
        let bent = self.normal.iter().flat_map(|normal| {
            let unit = normal.try_normalize().unwrap_or(Vec3::Z);
            unit.to_array().map(|x| (128.0 + 127.0 * x + 0.5) as u8)
        });
        (
            Image { width, height, channels: 4, pixels: colored.collect() },
            Image { width, height, channels: 3, pixels: bent.collect() },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crown_of_thin_twigs_covers_as_much_as_it_did() {
        // A disc whose cover falls from 0.4 in its middle to 0 at its rim: a cone of 0.4 π r² / 3.
        let (side, radius) = (256u32, 120.0f32);
        let pixels = (0..side * side).flat_map(|i| {
            let [x, y] = [i % side, i / side].map(|k| k as f32 + 0.5 - side as f32 / 2.0);
            let cover = 0.4 * (1.0 - (x * x + y * y).sqrt() / radius).max(0.0);
            [0, 0, 0, (255.0 * cover + 0.5) as u8]
        });
        let image = Image { width: side, height: side, channels: 4, pixels: pixels.collect() };
        let cutoff = equal_cover(&image, 4);
        // The part above the cutoff is a disc of a third of the area.
        let expected = 0.4 * (1.0 - (1.0f32 / 3.0 * 0.4).sqrt());
        assert!((cutoff - expected).abs() < 0.01, "{cutoff} {expected}");
    }
}
