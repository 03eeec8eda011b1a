//! Pictures as PNG.

use std::borrow::Cow;

use deeptree_mesh::Image;
use png::{BitDepth, ColorType, EncodingError};

/// Why a picture was not encoded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The fields of the picture contradict each other.
    #[error(
        "a picture of {width} × {height} pixels and {channels} channels has {bytes} bytes; it needs \
         at least a pixel, 1, 3 or 4 channels, and their product in bytes"
    )]
    Shape {
        /// Pixels of a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Channels a pixel.
        channels: u8,
        /// How many bytes there are.
        bytes: usize,
    },
    /// The encoder failed.
    #[error("a picture could not be encoded as PNG")]
    Encode(#[from] EncodingError),
}

/// What a picture says, which decides how its numbers are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    /// sRGB colour, perhaps with alpha.
    Color,
    /// Directions, linear.
    Normal,
    /// Roughness, linear.
    Roughness,
}

impl Use {
    /// The last part of a file's name.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Normal => "normal",
            Self::Roughness => "roughness",
        }
    }
}

/// A picture of one channel as occlusion (none), roughness and metal (none) in red, green, blue.
pub(crate) fn as_occlusion_roughness_metal(image: &Image) -> Cow<'_, Image> {
    if image.channels != 1 {
        return Cow::Borrowed(image);
    }
    let pixels = image.pixels.iter().flat_map(|&rough| [255, rough, 0]).collect();
    Cow::Owned(Image { channels: 3, pixels, ..*image })
}

/// Encodes a picture.
///
/// # Errors
///
/// When its fields contradict each other.
pub(crate) fn png(image: &Image) -> Result<Vec<u8>, ImageError> {
    let &Image { width, height, channels, .. } = image;
    let shape = || ImageError::Shape { width, height, channels, bytes: image.pixels.len() };
    let color = match channels {
        1 => ColorType::Grayscale,
        3 => ColorType::Rgb,
        4 => ColorType::Rgba,
        _ => return Err(shape()),
    };
    let needed = u64::from(width) * u64::from(height) * u64::from(channels);
    if needed == 0 || needed != image.pixels.len() as u64 {
        return Err(shape());
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&image.pixels)?;
    writer.finish()?;
    Ok(bytes)
}
