//! Tones between paper and bark.
//!
//! Pictures are drawn in grey, 1 being paper and 0 the darkest bark, and written with a palette: all
//! colours lie on one line between the two, so that a quarter of the bytes holds a picture.

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError};
use tiny_skia::{Color, Pixmap, Rect, Transform};

const PAPER: [f32; 3] = [255.0, 255.0, 255.0];
const BARK: [f32; 3] = [40.0, 29.0, 20.0];

/// Tones that are told apart; more only make larger files.
const TONES: usize = 64;

/// Lightness of the line of the ground.
const GROUND: f32 = 0.72;

/// The colour of a lightness from 0 (bark) to 1 (paper).
pub(super) fn grey(lightness: f32) -> Color {
    let level = (255.0 * lightness.clamp(0.0, 1.0)) as u8;
    Color::from_rgba8(level, level, level, 255)
}

pub(super) fn clear(pixmap: &mut Pixmap) {
    pixmap.fill(Color::WHITE);
}

/// A line along the whole picture, one pixel high.
pub(super) fn ground(pixmap: &mut Pixmap, y: f32) {
    let mut paint = tiny_skia::Paint::default();
    paint.set_color(grey(GROUND));
    if let Some(line) = Rect::from_xywh(0.0, y.floor(), pixmap.width() as f32, 1.0) {
        pixmap.fill_rect(line, &paint, Transform::identity(), None);
    }
}

/// The picture as a PNG file.
pub(super) fn encode(pixmap: &Pixmap) -> Result<Vec<u8>, EncodingError> {
    let tones = pixmap.pixels().iter().map(|pixel| tone(pixel.red())).collect::<Vec<u8>>();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    encoder.set_palette(palette());
    encoder.write_header()?.write_image_data(&tones)?;
    Ok(bytes)
}

fn tone(level: u8) -> u8 {
    ((usize::from(level) * (TONES - 1) + 127) / 255) as u8
}

fn palette() -> Vec<u8> {
    let mix = |tone: usize, i: usize| {
        let lightness = tone as f32 / (TONES - 1) as f32;
        (BARK[i] + lightness * (PAPER[i] - BARK[i])) as u8
    };
    (0..TONES).flat_map(|tone| (0..3).map(move |i| mix(tone, i))).collect()
}
