//! Pictures in files: PNG for the eye, OpenEXR for numbers.

use std::io::{Cursor, Write};

use deeptree_mesh::Image;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, SmallVec, WritableImage,
};

use crate::aov::Mark;
use crate::film::Picture;

/// Why a picture was not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The PNG encoder or the file.
    #[error("the picture cannot be written as PNG")]
    Png(#[from] png::EncodingError),
    /// The OpenEXR encoder.
    #[error("the picture cannot be written as OpenEXR")]
    Exr(#[from] exr::error::Error),
    /// The file.
    #[error("the picture cannot be written")]
    Io(#[from] std::io::Error),
    /// A number beyond what the file can hold.
    #[error("{what} {value} does not fit into a PNG of 16 bits; write an .exr")]
    TooLarge {
        /// What it is.
        what: &'static str,
        /// How much.
        value: u32,
    },
}

/// Writes a PNG of 8 bits a channel, in sRGB; `texts` are keywords and what they say.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write_png(
    out: impl Write,
    image: &Image,
    texts: &[(&str, String)],
) -> Result<(), WriteError> {
    let color = match image.channels {
        1 => png::ColorType::Grayscale,
        3 => png::ColorType::Rgb,
        _ => png::ColorType::Rgba,
    };
    let mut encoder = png::Encoder::new(out, image.width, image.height);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encode(encoder, color, png::BitDepth::Eight, &image.pixels, texts)
}

/// One 16-bit value a pixel, as a grey PNG.
fn write_grey(
    out: impl Write,
    size: [u32; 2],
    values: &[u16],
    meaning: &str,
) -> Result<(), WriteError> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    let encoder = png::Encoder::new(out, size[0], size[1]);
    let texts = [("Description", meaning.to_owned())];
    encode(encoder, png::ColorType::Grayscale, png::BitDepth::Sixteen, &bytes, &texts)
}

fn encode(
    mut encoder: png::Encoder<'_, impl Write>,
    color: png::ColorType,
    depth: png::BitDepth,
    bytes: &[u8],
    texts: &[(&str, String)],
) -> Result<(), WriteError> {
    encoder.set_color(color);
    encoder.set_depth(depth);
    for (keyword, text) in texts {
        encoder.add_text_chunk((*keyword).to_owned(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    Ok(writer.finish()?)
}

/// What of a [`Mark`] becomes a PNG of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Centimetres along the camera's axis, 16 bits; 0 where there is nothing.
    Depth,
    /// `128 + 127 n` in red, green and blue, 8 bits; the space of the tree.
    Normal,
    /// [`Kind`](crate::Kind) as its number, 16 bits.
    Kind,
    /// Branch + 1, 16 bits; 0 where there is no tree.
    Branch,
    /// Order + 1, likewise.
    Order,
    /// Node + 1, likewise.
    Node,
    /// Tree + 1, likewise: of a stand.
    Tree,
}

impl Channel {
    /// Its name, as files and channels are called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Kind => "kind",
            Self::Branch => "branch",
            Self::Order => "order",
            Self::Node => "node",
            Self::Tree => "tree",
        }
    }
}

/// Writes one channel of marks as a PNG.
///
/// # Errors
///
/// When a number does not fit, or the file cannot be written.
pub fn write_channel_png(
    out: impl Write,
    size: [u32; 2],
    marks: &[Mark],
    channel: Channel,
) -> Result<(), WriteError> {
    let (what, meaning) = match channel {
        Channel::Normal => {
            let [width, height] = size;
            let byte = |x: f32| (128.0 + 127.0 * x + 0.5) as u8;
            let pixels = marks.iter().flat_map(|mark| mark.normal.map(byte)).collect();
            let image = Image { width, height, channels: 3, pixels };
            let meaning = "unit normal n of the tree's space (y up) as 128 + 127 n, linear";
            let encoder = png::Encoder::new(out, width, height);
            let texts = [("Description", meaning.to_owned())];
            let (color, depth) = (png::ColorType::Rgb, png::BitDepth::Eight);
            return encode(encoder, color, depth, &image.pixels, &texts);
        }
        Channel::Depth => ("depth", "centimetres along the camera's axis; 0: nothing"),
        Channel::Kind => ("kind", "0 nothing, 1 ground, 2 wood, 3 leaf"),
        Channel::Branch => ("branch", "number of the branch + 1; 0: no tree"),
        Channel::Order => ("order", "Gravelius order + 1; 0: no tree"),
        Channel::Node => ("node", "number of the node + 1; 0: no tree"),
        Channel::Tree => ("tree", "number of the tree + 1; 0: no tree"),
    };
    let values: Result<Vec<u16>, WriteError> = marks
        .iter()
        .map(|mark| {
            let value = number(mark, channel);
            u16::try_from(value).map_err(|_| WriteError::TooLarge { what, value })
        })
        .collect();
    write_grey(out, size, &values?, meaning)
}

fn number(mark: &Mark, channel: Channel) -> u32 {
    let is_tree = u32::from(mark.kind as u8 >= 2);
    match channel {
        Channel::Depth => (mark.depth * 100.0 + 0.5) as u32,
        Channel::Normal | Channel::Kind => u32::from(mark.kind as u8),
        Channel::Branch => is_tree * mark.branch.saturating_add(1),
        Channel::Order => is_tree * (u32::from(mark.order) + 1),
        Channel::Node => is_tree * mark.node.saturating_add(1),
        Channel::Tree => is_tree * mark.tree.saturating_add(1),
    }
}

/// The bytes of an OpenEXR file: `R G B A` in linear sRGB times alpha; with marks also `Z` in
/// metres, `N.X N.Y N.Z`, and the whole numbers `kind`, `branch`, `order`, `node` and
/// `tree` as [`Channel`] counts.
///
/// # Errors
///
/// When the encoder refuses.
pub fn exr_bytes(picture: &Picture, marks: &[(Channel, &[Mark])]) -> Result<Vec<u8>, WriteError> {
    let floats = |name: &str, values: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(values));
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = ["R", "G", "B", "A"]
        .iter()
        .enumerate()
        .map(|(i, name)| floats(name, picture.pixels.iter().map(|pixel| pixel[i]).collect()))
        .collect();
    for &(channel, marks) in marks {
        match channel {
            Channel::Depth => {
                channels.push(floats("Z", marks.iter().map(|mark| mark.depth).collect()));
            }
            Channel::Normal => {
                for (i, name) in ["N.X", "N.Y", "N.Z"].iter().enumerate() {
                    channels.push(floats(name, marks.iter().map(|m| m.normal[i]).collect()));
                }
            }
            _ => {
                let values = marks.iter().map(|mark| number(mark, channel)).collect();
                channels.push(AnyChannel::new(channel.name(), FlatSamples::U32(values)));
            }
        }
    }
    let size = (picture.width as usize, picture.height as usize);
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aov::Kind;
    use exr::prelude::{ReadChannels, ReadLayers};

    fn marks() -> Vec<Mark> {
        let wood = Mark {
            kind: Kind::Wood,
            depth: 12.345,
            normal: [0.0, 1.0, -1.0],
            branch: 7,
            order: 2,
            node: 70_000,
            tree: 3,
        };
        vec![Mark::default(), wood]
    }

    fn picture() -> Picture {
        let pixels = vec![[0.25, 0.5, 2.0, 1.0], [0.0; 4]];
        Picture { width: 2, height: 1, pixels, shadow: vec![0.0; 2], samples: 2 }
    }

    #[test]
    fn pngs_hold_what_their_descriptions_say() {
        let read = |channel| {
            let mut bytes = Vec::new();
            write_channel_png(&mut bytes, [2, 1], &marks(), channel).unwrap();
            let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            pixels
        };
        assert_eq!(read(Channel::Depth), [0, 0, 4, 211], "1235 cm");
        assert_eq!(read(Channel::Branch), [0, 0, 0, 8]);
        assert_eq!(read(Channel::Order), [0, 0, 0, 3]);
        assert_eq!(read(Channel::Tree), [0, 0, 0, 4]);
        assert_eq!(read(Channel::Kind), [0, 0, 0, 2]);
        assert_eq!(read(Channel::Normal), [128, 128, 128, 128, 255, 1]);
        let mut bytes = Vec::new();
        let error = write_channel_png(&mut bytes, [2, 1], &marks(), Channel::Node).unwrap_err();
        assert!(error.to_string().contains("70001"));
    }

    #[test]
    fn an_exr_gives_the_same_numbers_back() {
        let marks = marks();
        let all = [Channel::Depth, Channel::Normal, Channel::Node].map(|c| (c, &marks[..]));
        let bytes = exr_bytes(&picture(), &all).unwrap();
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .unwrap();
        let list = image.layer_data.channel_data.list;
        let channel = |name: &str| {
            let found = list.iter().find(|c| c.name.to_string() == name).unwrap();
            found.sample_data.values_as_f32().collect::<Vec<_>>()
        };
        assert_eq!(channel("B"), [2.0, 0.0]);
        assert_eq!(channel("Z"), [0.0, 12.345]);
        assert_eq!(channel("N.Z"), [0.0, -1.0]);
        assert_eq!(channel("node"), [0.0, 70_001.0]);
    }
}
