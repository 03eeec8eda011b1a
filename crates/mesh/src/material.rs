//! What a surface looks like: images and the numbers of a physically based material.

use std::sync::Arc;

/// A picture of 8 bits a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels of a row.
    pub width: u32,
    /// Rows; the first is the uppermost.
    pub height: u32,
    /// 1 (grey), 3 (red, green, blue) or 4 (with alpha).
    pub channels: u8,
    /// `width · height · channels` bytes, row by row.
    pub pixels: Vec<u8>,
}

/// A physically based material, as of glTF's metallic-roughness model without metals. Its pictures
/// are shared by all that are made of it.
///
/// # Source
///
/// glTF 2.0 specification, Khronos Group, §3.9 (materials).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Unique within a tree, such as `oak bark`.
    pub name: String,
    /// Linear colour and alpha that the picture's are multiplied by.
    pub color: [f32; 4],
    /// Colour in sRGB, with alpha where there are four channels; v = 1 is the upper edge.
    pub color_image: Option<Arc<Image>>,
    /// Normal in the tangent frame, OpenGL's way: red along u, green along v, blue outward.
    pub normal_image: Option<Arc<Image>>,
    /// Roughness of the surface, 0 (mirror) to 1, that the picture's is multiplied by.
    pub roughness: f32,
    /// Roughness, one channel.
    pub roughness_image: Option<Arc<Image>>,
    /// Share of the light that is not reflected and comes out on the other side, diffusely.
    pub translucency: f32,
    /// Where alpha is below, there is no surface; none for opaque materials.
    pub alpha_cutoff: Option<f32>,
    /// Is it seen from behind as well?
    pub double_sided: bool,
}
